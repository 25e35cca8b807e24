//! Numbers for the vertices of all cells: one number where the same planes meet, and one where cells
//! disagree within the resolution.
//!
//! Where more than three planes pass through one place, rounding decides in every cell anew which
//! three of them meet, so that cells name the place by different keys. Two rules make it one vertex:
//! edges shorter than the resolution are contracted, and where a key is not seen by all cells that it
//! names, the vertices that two cells give their common face and that lie within the resolution are
//! one. Both are transitive.
//!
//! The same key may stand for two places: two planes that nearly coincide, as the bisectors along an
//! edge of a lattice do, cross somewhere on that edge, and every cell has its own opinion where. What
//! lies apart is numbered apart; such vertices end up with two edges and are removed later.
//!
//! The resolution must not be too small: that crossing is known to ε s / w only, w the width of the
//! facet between the planes. Facets narrower than √ε s vanish with their edges, all of them.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::complex::cell_surface::CellSurface;
use crate::complex::loop_corner::LoopCorner;
use crate::complex::shifted_union::{ShiftedNumber, ShiftedUnion};
use crate::complex::vertex_key::{NO_SHIFT, Shift, VertexKey, difference, displacement};
use crate::domain::facet_kind::FacetKind;
use crate::parallel::{for_each, map, map_runs};

/// Edges shorter than this share of the size of the least cell at them are contracted. Relaxed lattices
/// are met to some 1e-9; √ε = 1.5e-8.
pub(crate) const RESOLUTION: f64 = 1e-6;

/// The vertices of all cells by their numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct NumberedVertices {
    /// The place of every number, at shift zero.
    pub(crate) positions: Vec<Point3<f64>>,
    /// Per cell: where its vertices begin in `places`.
    starts: Vec<usize>,
    /// Every vertex of every cell, as the cell sees it.
    places: Vec<LoopCorner>,
}

impl NumberedVertices {
    /// Numbers the vertices of `cells`, which repeat themselves by `periods`.
    #[must_use]
    pub(crate) fn new(cells: &[CellSurface], periods: &Vector3<f64>, resolution: f64) -> Self {
        let reaches = map(cells.len(), &|cell| resolution * cells[cell].size());
        let (mut vertices, numbers) = numbered_by_keys(cells, periods, &reaches);
        let mut classes = ShiftedUnion::new(vertices.positions.len());
        for (one, other) in short_edges(cells, &vertices, &numbers, &reaches) {
            classes.unite(one, other);
        }
        for (one, other) in common_corners(cells, &vertices, &numbers, periods) {
            classes.unite(one, other);
        }
        classes.settle(numbers.walls, &mut vertices.positions, periods);
        vertices.places.par_iter_mut().for_each(|place| {
            let (number, shift) = classes.resolved((place.number(), place.shift()));
            *place = LoopCorner::new(number, shift);
        });
        vertices
    }

    /// A cell's vertex by its number, as the cell sees it.
    #[inline]
    #[must_use]
    pub(crate) fn of(&self, cell: usize, vertex: u32) -> LoopCorner {
        self.places[self.starts[cell] + vertex as usize]
    }

    /// The same as a pair.
    fn pair(&self, cell: usize, vertex: u32) -> ShiftedNumber {
        let place = self.of(cell, vertex);
        (place.number(), place.shift())
    }
}

/// What is known of every number while numbers are united.
#[derive(Default)]
struct Numbers {
    /// The reach (L) within which it is one with others.
    reaches: Vec<f64>,
    /// How many walls meet in it.
    walls: Vec<u8>,
    /// Whether not all cells that its key names see it.
    disputed: Vec<bool>,
}

impl Numbers {
    fn reach(&self, one: ShiftedNumber, other: ShiftedNumber) -> f64 {
        let [one, other] = [one, other].map(|(number, _)| self.reaches[number as usize]);
        one.min(other)
    }
}

/// All vertices of all cells in buckets by the first sites of their keys.
struct VertexBuckets {
    /// Per site: where its bucket ends.
    ends: Vec<AtomicUsize>,
    /// Cell and vertex, in the upper and the lower half; in any order within a bucket.
    entries: Vec<AtomicU64>,
}

impl VertexBuckets {
    fn new(cells: &[CellSurface]) -> Self {
        let mut ends: Vec<AtomicUsize> = cells.iter().map(|_| AtomicUsize::new(0)).collect();
        for_each(cells.len(), &|cell| {
            for vertex in &cells[cell].vertices {
                ends[cells[cell].first_site(vertex)].fetch_add(1, Relaxed);
            }
        });
        let mut total = 0;
        for end in &mut ends {
            let count = std::mem::replace(end.get_mut(), total);
            total += count;
        }
        // Here `ends` are the buckets' starts; each moves on with every entry.
        let entries: Vec<AtomicU64> = (0..total).map(|_| AtomicU64::new(0)).collect();
        for_each(cells.len(), &|cell| {
            for (place, vertex) in (0..).zip(&cells[cell].vertices) {
                let entry = ends[cells[cell].first_site(vertex)].fetch_add(1, Relaxed);
                entries[entry].store((cell as u64) << 32 | place, Relaxed);
            }
        });
        Self { ends, entries }
    }

    /// What is in the buckets of these sites.
    fn entries(&self, sites: Range<usize>) -> &[AtomicU64] {
        let end = |sites: usize| match sites {
            0 => 0,
            _ => self.ends[sites - 1].load(Relaxed),
        };
        &self.entries[end(sites.start)..end(sites.end)]
    }
}

/// The cell and the vertex of an entry.
fn unpacked(entry: &AtomicU64) -> (usize, usize) {
    let entry = entry.load(Relaxed);
    ((entry >> 32) as usize, entry as u32 as usize)
}

/// Sites whose buckets one task numbers.
const RUN: usize = 1024;

/// A vertex of a cell by its key: cell, place in the cell, and the shift at which the cell sees it.
type VertexReport = (VertexKey, usize, usize, Shift);

/// Numbers of the vertices whose keys begin with sites that follow each other.
#[derive(Default)]
struct RunNumbers {
    keys: Vec<VertexKey>,
    positions: Vec<Point3<f64>>,
    reaches: Vec<f64>,
    /// How many cells see each.
    sightings: Vec<usize>,
}

/// Vertices numbered by their keys and places, cells' reaches given.
fn numbered_by_keys(
    cells: &[CellSurface],
    periods: &Vector3<f64>,
    reaches: &[f64],
) -> (NumberedVertices, Numbers) {
    let mut total = 0;
    let starts = cells.iter().map(|cell| {
        total += cell.vertices.len();
        total - cell.vertices.len()
    });
    let starts: Vec<usize> = starts.collect();
    let buckets = VertexBuckets::new(cells);
    // By the numbers of a run first, each of which begins at zero.
    let places: Vec<AtomicU64> = (0..total).map(|_| AtomicU64::new(0)).collect();
    let runs = map_runs(cells.len(), RUN, |sites| {
        RunNumbers::of(
            sites,
            &buckets,
            (cells, periods, reaches),
            |cell, vertex, place| {
                places[starts[cell] + vertex].store(place.bits(), Relaxed);
            },
        )
    });
    let mut first = 0;
    for (run, numbers) in runs.iter().enumerate() {
        let sites = run * RUN..cells.len().min((run + 1) * RUN);
        let entries = buckets.entries(sites);
        for_each(entries.len(), &|entry| {
            let (cell, vertex) = unpacked(&entries[entry]);
            places[starts[cell] + vertex].fetch_add(first, Relaxed);
        });
        first += numbers.keys.len() as u64;
    }
    let (positions, numbers) = joined(runs);
    let places = places.into_iter().map(AtomicU64::into_inner);
    let vertices = NumberedVertices {
        positions,
        starts,
        places: places.map(LoopCorner::of_bits).collect(),
    };
    (vertices, numbers)
}

/// The numbers of all runs.
fn joined(runs: Vec<RunNumbers>) -> (Vec<Point3<f64>>, Numbers) {
    let (mut positions, mut numbers) = (Vec::new(), Numbers::default());
    for run in runs {
        positions.extend(run.positions);
        numbers.reaches.extend(run.reaches);
        let walls = run.keys.iter().map(VertexKey::wall_count);
        numbers.walls.extend(walls);
        let seen = run.keys.iter().zip(run.sightings);
        let disputed = seen.map(|(key, sightings)| sightings != key.site_count());
        numbers.disputed.extend(disputed);
    }
    (positions, numbers)
}

impl RunNumbers {
    /// The numbers of the vertices whose keys begin with `sites`, from zero; `take` is told every cell and
    /// vertex with its number.
    fn of(
        sites: Range<usize>,
        buckets: &VertexBuckets,
        (cells, periods, reaches): (&[CellSurface], &Vector3<f64>, &[f64]),
        take: impl Fn(usize, usize, LoopCorner),
    ) -> Self {
        let mut run = Self::default();
        let mut reports: Vec<VertexReport> = Vec::new();
        for site in sites {
            reports.clear();
            let entries = buckets.entries(site..site + 1).iter().map(unpacked);
            reports.extend(entries.map(|(cell, vertex)| {
                let (key, shift) = cells[cell].key(&cells[cell].vertices[vertex]);
                (key, cell, vertex, shift)
            }));
            reports.sort_unstable();
            for group in reports.chunk_by(|one, other| one.0 == other.0) {
                run.number(group, (cells, periods, reaches), &take);
            }
        }
        run
    }

    /// Numbers vertices of one key, and tells `take` the cell and vertex of each with its number.
    fn number(
        &mut self,
        group: &[VertexReport],
        (cells, periods, reaches): (&[CellSurface], &Vector3<f64>, &[f64]),
        take: impl Fn(usize, usize, LoopCorner),
    ) {
        let of_cells = group.iter().map(|&(_, cell, ..)| reaches[cell]);
        let reach = of_cells.fold(f64::INFINITY, f64::min);
        let first = self.keys.len();
        for &(key, cell, vertex, shift) in group {
            let seen = cells[cell].vertices[vertex].position;
            let position = seen - displacement(shift, periods);
            let number = self.number_from(first, key, position, reach);
            self.sightings[number] += 1;
            take(cell, vertex, LoopCorner::new(number as u32, shift));
        }
    }

    /// The number from `first` on that lies at `position`, made if there is none.
    fn number_from(
        &mut self,
        first: usize,
        key: VertexKey,
        position: Point3<f64>,
        reach: f64,
    ) -> usize {
        let is_there = |known: &Point3<f64>| (known - position).norm() <= reach;
        if let Some(found) = self.positions[first..].iter().position(is_there) {
            return first + found;
        }
        self.keys.push(key);
        self.positions.push(position);
        self.reaches.push(reach);
        self.sightings.push(0);
        self.keys.len() - 1
    }
}

/// The ends of all edges shorter than the lesser reach of their ends, cell by cell; no end's reach is above
/// its cell's.
fn short_edges(
    cells: &[CellSurface],
    vertices: &NumberedVertices,
    numbers: &Numbers,
    reaches: &[f64],
) -> Vec<(ShiftedNumber, ShiftedNumber)> {
    let surfaces = cells.par_iter().enumerate();
    let edges = surfaces.flat_map_iter(|(cell, surface)| {
        let position = |vertex: u32| surface.vertices[vertex as usize].position;
        let edges = surface.facets().flat_map(|(_, corners)| {
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(&from, &to)| (from, to))
        });
        let lengths = edges
            .filter(|&(from, to)| from < to)
            .map(move |(from, to)| ((position(from) - position(to)).norm(), from, to));
        lengths
            .filter(move |&(length, ..)| length < reaches[cell])
            .map(move |(length, from, to)| {
                (length, vertices.pair(cell, from), vertices.pair(cell, to))
            })
            .filter(|&(length, from, to)| length < numbers.reach(from, to))
            .map(|(_, from, to)| (from, to))
    });
    edges.collect()
}

/// A face between two cells, the second at an image as the first sees it.
type FaceId = (u32, u32, Shift);

/// Pairs of disputed vertices that two cells give their common face in one place.
fn common_corners(
    cells: &[CellSurface],
    vertices: &NumberedVertices,
    numbers: &Numbers,
    periods: &Vector3<f64>,
) -> Vec<(ShiftedNumber, ShiftedNumber)> {
    let entries = cells
        .par_iter()
        .enumerate()
        .flat_map_iter(|(cell, surface)| {
            let places = (0..).map(move |vertex| vertices.pair(cell, vertex));
            let all = surface.vertices.iter().zip(places);
            let disputed = all.filter(|(_, place)| numbers.disputed[place.0 as usize]);
            disputed.flat_map(move |(vertex, place)| {
                let corners = vertex
                    .facets
                    .map(|label| face_corner(cell as u32, label, place));
                corners.into_iter().flatten()
            })
        });
    let mut entries: Vec<(FaceId, ShiftedNumber)> = entries.collect();
    entries.par_sort_unstable();
    entries.dedup();
    let position = |(number, shift): ShiftedNumber| {
        vertices.positions[number as usize] + displacement(shift, periods)
    };
    let mut pairs = Vec::new();
    for face in entries.chunk_by(|one, other| one.0 == other.0) {
        for (place, &(_, one)) in face.iter().enumerate() {
            let others = face[place + 1..].iter().map(|&(_, other)| other);
            let is_near = |other: &ShiftedNumber| {
                (position(one) - position(*other)).norm() <= numbers.reach(one, *other)
            };
            pairs.extend(others.filter(is_near).map(|other| (one, other)));
        }
    }
    pairs
}

/// The face that a cell's facet is, and where its first cell sees a vertex that this one sees at
/// `place`.
fn face_corner(cell: u32, facet: u64, place: ShiftedNumber) -> Option<(FaceId, ShiftedNumber)> {
    let FacetKind::Neighbor { site, image } = FacetKind::of(facet) else {
        return None;
    };
    let image = image.map(i16::from);
    if (cell, NO_SHIFT) < (site, image) {
        return Some(((cell, site, image), place));
    }
    let back = image.map(|periods| -periods);
    Some(((site, cell, back), (place.0, difference(place.1, image))))
}
