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

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::complex::cell_surface::CellSurface;
use crate::complex::shifted_union::{ShiftedNumber, ShiftedUnion};
use crate::complex::vertex_key::{NO_SHIFT, Shift, VertexKey, difference, displacement};
use crate::domain::facet_kind::FacetKind;
use crate::parallel::map;

/// Edges shorter than this share of the size of the least cell at them are contracted. Relaxed lattices
/// are met to some 1e-9; √ε = 1.5e-8.
pub(crate) const RESOLUTION: f64 = 1e-6;

/// The vertices of all cells by their numbers.
#[derive(Clone, Debug)]
pub(crate) struct NumberedVertices {
    /// The place of every number, at shift zero.
    pub(crate) positions: Vec<Point3<f64>>,
    /// Per cell: where its vertices begin in `places`.
    starts: Vec<usize>,
    /// The number of every vertex of every cell, and the shift at which the cell sees it.
    places: Vec<ShiftedNumber>,
}

impl NumberedVertices {
    /// Numbers the vertices of `cells`, which repeat themselves by `periods`.
    #[must_use]
    pub(crate) fn new(cells: &[CellSurface], periods: &Vector3<f64>, resolution: f64) -> Self {
        let reports = VertexReports::new(cells);
        let mut numbered = Numbering::default();
        numbered.number(cells, &reports, periods, resolution);
        let mut classes = ShiftedUnion::new(numbered.positions.len());
        for (one, other) in short_edges(cells, &reports, &numbered) {
            classes.unite(one, other);
        }
        for (one, other) in common_corners(cells, &reports, &numbered, periods) {
            classes.unite(one, other);
        }
        let walls: Vec<usize> = numbered.keys.iter().map(VertexKey::wall_count).collect();
        classes.settle(walls, &mut numbered.positions, periods);
        let mut places = numbered.places;
        let resolve = |place: &mut ShiftedNumber| *place = classes.resolved(*place);
        places.par_iter_mut().for_each(resolve);
        Self {
            positions: numbered.positions,
            starts: reports.starts,
            places,
        }
    }

    /// The number of a cell's vertex, and the shift at which the cell sees it.
    #[inline]
    #[must_use]
    pub(crate) fn of(&self, cell: usize, vertex: u32) -> ShiftedNumber {
        self.places[self.starts[cell] + vertex as usize]
    }
}

/// A vertex of a cell by its key: cell and place in the cell.
type VertexReport = (VertexKey, u32, u32);

/// The vertices of all cells.
struct VertexReports {
    /// Sorted by key, then by cell.
    sorted: Vec<VertexReport>,
    /// Per cell: how many vertices are in the cells before it.
    starts: Vec<usize>,
}

impl VertexReports {
    fn new(cells: &[CellSurface]) -> Self {
        let mut total = 0;
        let start = |cell: &CellSurface| {
            total += cell.vertices.len();
            total - cell.vertices.len()
        };
        let starts: Vec<usize> = cells.iter().map(start).collect();
        let keys: Vec<Vec<VertexReport>> = map(cells.len(), &|place| {
            let cell = &cells[place];
            let key = |(vertex, at)| (cell.key(at).0, place as u32, vertex as u32);
            cell.vertices.iter().enumerate().map(key).collect()
        });
        let mut sorted = by_first_site(&keys, cells.len(), total);
        drop(keys);
        sorted
            .par_chunk_by_mut(|one, other| one.0.first_site() == other.0.first_site())
            .for_each(<[VertexReport]>::sort_unstable);
        Self { sorted, starts }
    }

    fn groups(&self) -> impl Iterator<Item = &[VertexReport]> {
        self.sorted.chunk_by(|one, other| one.0 == other.0)
    }
}

/// Reports by the first sites of their keys.
fn by_first_site(keys: &[Vec<VertexReport>], sites: usize, total: usize) -> Vec<VertexReport> {
    let mut next = vec![0_usize; sites + 1];
    for report in keys.iter().flatten() {
        next[report.0.first_site() + 1] += 1;
    }
    for site in 0..sites {
        next[site + 1] += next[site];
    }
    let Some(&any) = keys.iter().flatten().next() else {
        return Vec::new();
    };
    let mut sorted = vec![any; total];
    for report in keys.iter().flatten() {
        let place = &mut next[report.0.first_site()];
        sorted[*place] = *report;
        *place += 1;
    }
    sorted
}

/// Numbers by keys and places.
#[derive(Default)]
struct Numbering {
    /// Per number: its key, its place at shift zero, the reach (L) within which it is one with others,
    /// and how many cells see it.
    keys: Vec<VertexKey>,
    positions: Vec<Point3<f64>>,
    reaches: Vec<f64>,
    sightings: Vec<usize>,
    /// The number of every vertex of every cell, and the shift at which the cell sees it.
    places: Vec<ShiftedNumber>,
}

impl Numbering {
    fn number(
        &mut self,
        cells: &[CellSurface],
        reports: &VertexReports,
        periods: &Vector3<f64>,
        resolution: f64,
    ) {
        let sizes = map(cells.len(), &|cell| cells[cell].size());
        self.places = vec![(0, NO_SHIFT); reports.sorted.len()];
        for group in reports.groups() {
            let sizes = group.iter().map(|&(_, cell, _)| sizes[cell as usize]);
            let reach = resolution * sizes.fold(f64::INFINITY, f64::min);
            let first = self.keys.len();
            for &(key, cell, vertex) in group {
                let surface = &cells[cell as usize];
                let at = &surface.vertices[vertex as usize];
                let shift = surface.key(at).1;
                let position = at.position - displacement(shift, periods);
                let number = self.number_from(first, key, position, reach);
                self.sightings[number] += 1;
                let place = reports.starts[cell as usize] + vertex as usize;
                self.places[place] = (number as u32, shift);
            }
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

    /// Whether not all cells that a number's key names see it.
    fn is_disputed(&self, number: u32) -> bool {
        let number = number as usize;
        self.sightings[number] != self.keys[number].site_count()
    }

    fn reach(&self, one: ShiftedNumber, other: ShiftedNumber) -> f64 {
        let [one, other] = [one, other].map(|(number, _)| self.reaches[number as usize]);
        one.min(other)
    }
}

/// The ends of all edges shorter than the lesser reach of their ends, cell by cell.
fn short_edges(
    cells: &[CellSurface],
    reports: &VertexReports,
    numbered: &Numbering,
) -> Vec<(ShiftedNumber, ShiftedNumber)> {
    let surfaces = cells.par_iter().enumerate();
    let edges = surfaces.flat_map_iter(|(cell, surface)| {
        let position = |vertex: u32| surface.vertices[vertex as usize].position;
        let of = move |vertex: u32| numbered.places[reports.starts[cell] + vertex as usize];
        let edges = surface.facets().flat_map(|(_, corners)| {
            let next = corners.iter().cycle().skip(1);
            corners.iter().zip(next).map(|(&from, &to)| (from, to))
        });
        edges
            .filter(move |&(from, to)| from < to)
            .map(move |(from, to)| ((position(from) - position(to)).norm(), of(from), of(to)))
            .filter(|&(length, from, to)| length < numbered.reach(from, to))
            .map(|(_, from, to)| (from, to))
    });
    edges.collect()
}

/// A face between two cells, the second at an image as the first sees it.
type FaceId = (u32, u32, Shift);

/// Pairs of disputed vertices that two cells give their common face in one place.
fn common_corners(
    cells: &[CellSurface],
    reports: &VertexReports,
    numbered: &Numbering,
    periods: &Vector3<f64>,
) -> Vec<(ShiftedNumber, ShiftedNumber)> {
    let entries = cells
        .par_iter()
        .enumerate()
        .flat_map_iter(|(cell, surface)| {
            let places = &numbered.places[reports.starts[cell]..];
            let vertices = surface.vertices.iter().zip(places);
            let disputed = vertices.filter(|(_, place)| numbered.is_disputed(place.0));
            disputed.flat_map(move |(vertex, &place)| {
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
        numbered.positions[number as usize] + displacement(shift, periods)
    };
    let mut pairs = Vec::new();
    for face in entries.chunk_by(|one, other| one.0 == other.0) {
        for (place, &(_, one)) in face.iter().enumerate() {
            let others = face[place + 1..].iter().map(|&(_, other)| other);
            let is_near = |other: &ShiftedNumber| {
                (position(one) - position(*other)).norm() <= numbered.reach(one, *other)
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
