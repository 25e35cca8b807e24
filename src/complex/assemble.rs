//! The mesh of a diagram's cells: vertices identified, faces paired, patches named.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use crate::complex::cell_surface::CellSurface;
use crate::complex::identify::{NumberedVertices, RESOLUTION};
use crate::complex::loop_corner::LoopCorner;
use crate::complex::loops::{CellLoops, least_first, merge, numbered_loops, straighten};
use crate::complex::mesh_builder::{MeshBuilder, turned};
use crate::complex::vertex_key::Shift;
use crate::complex::wall_patches::WallPatches;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::mesh::poly_mesh::PolyMesh;
use crate::parallel::map;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// How often vertices that some cells have and others do not are merged with the nearest.
const ROUNDS: usize = 16;

/// Why cells do not become a conforming mesh. Sites count from zero.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum AssembleError {
    /// There are no cells.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
    /// A cell has no closed boundary in the domain.
    #[error(
        "the cell of site {site} at {position:?} has no consistent boundary within the solid; move the \
         site a little, or take more sites"
    )]
    Open {
        /// The cell's site.
        site: usize,
        /// Its position.
        position: [f64; 3],
    },
    /// Cells that are neighbors have different faces.
    #[error(
        "{count} faces are not the same from both sides, the first between the cells of sites {site} \
         and {neighbor}; please report these sites"
    )]
    Unpaired {
        /// How many.
        count: usize,
        /// A cell's site.
        site: usize,
        /// Its neighbor.
        neighbor: usize,
    },
}

/// The mesh of the cells of `diagram` in site order; a cell in several pieces becomes as many cells, the
/// further ones after all others.
///
/// # Errors
/// [`AssembleError`] when a site has no cell, or cells do not fit together.
pub(crate) fn assemble(
    diagram: &Diagram<'_>,
    patches: &WallPatches,
) -> Result<PolyMesh, AssembleError> {
    Ok(assemble_with_walls(diagram, patches)?.0)
}

/// As [`assemble`], and the walls of the faces on walls.
///
/// # Errors
/// As [`assemble`].
pub(crate) fn assemble_with_walls(
    diagram: &Diagram<'_>,
    patches: &WallPatches,
) -> Result<(PolyMesh, Vec<u32>), AssembleError> {
    let paired = paired(diagram, RESOLUTION)?;
    // Cells of a convex domain are convex.
    let builder = match diagram.domain().is_convex() {
        true => paired.builder(),
        false => paired.builder().in_pieces(),
    };
    Ok(builder.build_with_walls(patches))
}

/// As [`assemble`], but cells stay whole: one for each site.
pub(crate) fn assemble_whole(diagram: &Diagram<'_>) -> Result<PolyMesh, AssembleError> {
    let paired = paired(diagram, RESOLUTION)?;
    Ok(paired.builder().build(&WallPatches::Each))
}

/// Cells whose faces are the same from both sides.
pub(crate) struct PairedCells {
    loops: Vec<CellLoops>,
    positions: Vec<Point3<f64>>,
    periods: Vector3<f64>,
}

impl PairedCells {
    /// A mesh of them to be built.
    #[must_use]
    pub(crate) fn builder(&self) -> MeshBuilder<'_> {
        MeshBuilder::new(&self.loops, &self.positions, self.periods)
    }
}

/// The cells of `diagram`, paired, with edges contracted that are shorter than `resolution` times their
/// cells' size.
pub(crate) fn paired(diagram: &Diagram<'_>, resolution: f64) -> Result<PairedCells, AssembleError> {
    let domain = diagram.domain();
    let periods = Vector3::from(domain.periods().map(|period| period.unwrap_or(0.0)));
    let cells = diagram.map(|scratch: &mut PieceScratch, cell| CellSurface::of(&cell, scratch))?;
    refuse_open(&cells, diagram)?;
    let vertices = NumberedVertices::new(&cells, &periods, resolution);
    let mut loops = numbered_loops(cells, &vertices);
    let positions = vertices.positions;
    agree(&mut loops, &positions, &periods)?;
    Ok(PairedCells {
        loops,
        positions,
        periods,
    })
}

fn refuse_open(cells: &[CellSurface], diagram: &Diagram<'_>) -> Result<(), AssembleError> {
    match cells.iter().position(CellSurface::is_open) {
        Some(site) => Err(AssembleError::Open {
            site,
            position: diagram.position(site as u32).into(),
        }),
        None => Ok(()),
    }
}

/// Removes what only some of the cells at a face have, until all faces are the same from both
/// sides.
fn agree(
    cells: &mut [CellLoops],
    positions: &[Point3<f64>],
    periods: &Vector3<f64>,
) -> Result<(), AssembleError> {
    straighten(cells, positions.len());
    for _ in 0..ROUNDS {
        let disputes = disputes(cells);
        if disputes.is_empty() {
            return Ok(());
        }
        let pairs = nearest(cells, &disputes, positions, periods);
        merge(cells, &pairs);
        straighten(cells, positions.len());
    }
    let disputes = disputes(cells);
    match disputes.first() {
        None => Ok(()),
        Some(first) => Err(AssembleError::Unpaired {
            count: disputes.len(),
            site: first.cells[0] as usize,
            neighbor: first.cells[1] as usize,
        }),
    }
}

/// A face that is not the same from both sides.
struct Dispute {
    cells: [u32; 2],
    /// The vertices that only one side has; all where only one side has the face.
    vertices: Vec<u32>,
}

/// The faces between two cells that are not the same from both sides, by cell.
fn disputes(cells: &[CellLoops]) -> Vec<Dispute> {
    let matched: Vec<AtomicU32> = cells.iter().map(|_| AtomicU32::new(0)).collect();
    let lower = map(cells.len(), &|cell| {
        matched_upward(cells, cell as u32, &matched)
    });
    let found = cells.par_iter().enumerate().flat_map_iter(|(cell, loops)| {
        let mut mine = BorderLoops::new();
        if lower[cell] == Some(matched[cell].load(Relaxed)) {
            return Vec::new();
        }
        for (label, corners) in loops.facets() {
            if let FacetKind::Neighbor { site, image } = FacetKind::of(label) {
                let facet = mine.entry((site, image.map(i16::from))).or_default();
                facet.push(least_first(corners));
            }
        }
        let compare = move |((site, image), mut mine): ((u32, Shift), Vec<Vec<LoopCorner>>)| {
            let mut theirs = seen_from(&cells[site as usize], cell as u32, image);
            mine.sort_unstable();
            theirs.sort_unstable();
            (mine != theirs).then(|| Dispute {
                cells: [cell as u32, site],
                vertices: one_sided(&mine.concat(), &theirs.concat()),
            })
        };
        mine.into_iter().filter_map(compare).collect()
    });
    found.collect()
}

/// How many facets a cell has towards lower neighbors, if it has one facet towards every neighbor, all of them
/// at image zero, and those towards higher ones are the same from the other side, which is counted there: where
/// that count is its own, all its facets are the same from both sides. So it is nearly always, and each pair of
/// cells, far apart in memory, is visited once.
fn matched_upward(cells: &[CellLoops], cell: u32, matched: &[AtomicU32]) -> Option<u32> {
    let mut seen = [u64::MAX; 64];
    let mut lower = 0;
    for (place, (label, _)) in cells[cell as usize].facets().enumerate() {
        let FacetKind::Neighbor { site, image } = FacetKind::of(label) else {
            continue;
        };
        if image != [0; 3] || place >= seen.len() || seen[..place].contains(&label) {
            return None;
        }
        seen[place] = label;
        lower += u32::from(site < cell);
    }
    let here = FacetKind::Neighbor {
        site: cell,
        image: [0; 3],
    };
    let mut are_same = true;
    for (label, corners) in cells[cell as usize].facets() {
        let FacetKind::Neighbor { site, .. } = FacetKind::of(label) else {
            continue;
        };
        if site > cell {
            let other = cells[site as usize].facets();
            let mut others = other.filter(|(label, _)| *label == here.label());
            let (first, second) = (others.next(), others.next());
            let is_same = |(_, there): (u64, &[LoopCorner])| is_reverse(corners, there);
            match second.is_none() && first.is_some_and(is_same) {
                true => drop(matched[site as usize].fetch_add(1, Relaxed)),
                false => are_same = false,
            }
        }
    }
    are_same.then_some(lower)
}

/// Whether a loop is another one backwards.
fn is_reverse(corners: &[LoopCorner], other: &[LoopCorner]) -> bool {
    let count = corners.len();
    let Some(start) = other.iter().position(|corner| *corner == corners[0]) else {
        return false;
    };
    count == other.len()
        && (0..count).all(|place| corners[place] == other[(start + count - place) % count])
}

/// Loops by the neighbor and its image.
type BorderLoops = BTreeMap<(u32, Shift), Vec<Vec<LoopCorner>>>;

/// The loops of `other`'s facets towards `cell`, as they look from there: `other` is at `image`.
fn seen_from(other: &CellLoops, cell: u32, image: Shift) -> Vec<Vec<LoopCorner>> {
    let here = FacetKind::Neighbor {
        site: cell,
        image: image.map(|periods| -periods as i8),
    };
    let facets = other.facets().filter(|(label, _)| *label == here.label());
    facets.map(|(_, corners)| turned(corners, image)).collect()
}

/// The vertices that are in one list only; all if a list is empty or both have the same.
fn one_sided(mine: &[LoopCorner], theirs: &[LoopCorner]) -> Vec<u32> {
    let only = |one: &[LoopCorner], other: &[LoopCorner]| -> Vec<u32> {
        let lacking = one.iter().filter(|corner| !other.contains(corner));
        lacking.map(|corner| corner.number()).collect()
    };
    let found = [only(mine, theirs), only(theirs, mine)].concat();
    match found.is_empty() {
        true => mine.iter().map(|corner| corner.number()).collect(),
        false => found,
    }
}

/// The shortest edge of each dispute: the vertices that go, and where they are moved.
fn nearest(
    cells: &[CellLoops],
    disputes: &[Dispute],
    positions: &[Point3<f64>],
    periods: &Vector3<f64>,
) -> HashMap<u32, LoopCorner> {
    let mut targets: HashMap<u32, LoopCorner> = HashMap::new();
    let mut taken: HashSet<u32> = HashSet::new();
    for dispute in disputes {
        let edges = dispute.cells.iter().flat_map(|&cell| {
            cells[cell as usize].facets().flat_map(|(_, corners)| {
                let next = corners.iter().cycle().skip(1);
                corners.iter().zip(next).map(|(&from, &to)| (from, to))
            })
        });
        let touched = edges.filter(|(from, _)| dispute.vertices.contains(&from.number()));
        let length = |(from, to): &(LoopCorner, LoopCorner)| {
            let [from, to] = [from, to].map(|corner| corner.position(positions, periods));
            (from - to).norm_squared()
        };
        let shortest = touched.min_by(|one, other| length(one).total_cmp(&length(other)));
        let Some((from, to)) = shortest else { continue };
        let is_free = |number: u32| !taken.contains(&number);
        if from.number() != to.number() && is_free(from.number()) && is_free(to.number()) {
            let back = from.shift().map(|periods| -periods);
            targets.insert(from.number(), to.shifted(back));
            taken.extend([from.number(), to.number()]);
        }
    }
    targets
}
