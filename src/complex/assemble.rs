//! The mesh of a diagram's cells: vertices identified, faces paired, patches named.

use std::collections::{BTreeMap, HashMap, HashSet};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use thiserror::Error;

use crate::complex::cell_surface::CellSurface;
use crate::complex::identify::{NumberedVertices, RESOLUTION};
use crate::complex::loops::{CellLoops, LoopCorner, merge, numbered_loops, straighten};
use crate::complex::vertex_key::{NO_SHIFT, Shift};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};
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

/// What a patch's faces border on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum FaceBorder {
    Wall(u32),
    Image(Shift),
}

/// The mesh of the cells of `diagram`, one cell for each site in site order. Walls are named by
/// `wall_name`.
///
/// # Errors
/// [`AssembleError`] when a site has no cell, or cells do not fit together.
pub(crate) fn assemble(
    diagram: &Diagram<'_>,
    wall_name: &dyn Fn(u32) -> String,
) -> Result<PolyMesh, AssembleError> {
    assemble_within(diagram, RESOLUTION, wall_name)
}

/// As [`assemble`], with edges contracted that are shorter than `resolution` times their cells' size.
pub(crate) fn assemble_within(
    diagram: &Diagram<'_>,
    resolution: f64,
    wall_name: &dyn Fn(u32) -> String,
) -> Result<PolyMesh, AssembleError> {
    let domain = diagram.domain();
    let periods = Vector3::from(domain.periods().map(|period| period.unwrap_or(0.0)));
    let cells = diagram
        .map(|scratch: &mut PieceScratch, cell| (CellSurface::of(&cell, scratch), cell.position))?;
    refuse_open(&cells)?;
    let cells: Vec<CellSurface> = cells.into_iter().map(|(cell, _)| cell).collect();
    let vertices = NumberedVertices::new(&cells, &periods, resolution);
    let mut loops = numbered_loops(&cells, &vertices);
    drop(cells);
    let positions = vertices.positions;
    agree(&mut loops, &positions, &periods)?;
    Ok(MeshBuilder::new(positions, periods).build(&loops, wall_name))
}

fn refuse_open(cells: &[(CellSurface, Point3<f64>)]) -> Result<(), AssembleError> {
    match cells.iter().position(|(cell, _)| cell.is_open()) {
        Some(site) => Err(AssembleError::Open {
            site,
            position: cells[site].1.into(),
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
    let found = cells.par_iter().enumerate().flat_map_iter(|(cell, loops)| {
        let mut mine = BorderLoops::new();
        for (label, corners) in loops.facets() {
            if let FacetKind::Neighbor { site, image } = FacetKind::of(label) {
                mine.entry((site, image.map(i16::from)))
                    .or_default()
                    .push(least_first(corners));
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
        mine.into_iter().filter_map(compare)
    });
    found.collect()
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
    let turned = facets.map(|(_, corners)| {
        let back = corners.iter().rev().map(|corner| corner.shifted(image));
        least_first(&back.collect::<Vec<_>>())
    });
    turned.collect()
}

/// The same loop from its least corner on.
fn least_first(corners: &[LoopCorner]) -> Vec<LoopCorner> {
    let least = (0..corners.len()).min_by_key(|&place| corners[place]);
    let (before, after) = corners.split_at(least.unwrap_or(0));
    [after, before].concat()
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

/// A mesh under construction.
struct MeshBuilder {
    positions: Vec<Point3<f64>>,
    periods: Vector3<f64>,
    /// The points of vertices at shift zero.
    numbers: Vec<u32>,
    /// The points of all others.
    shifted: HashMap<LoopCorner, u32>,
    mesh: PolyMesh,
}

/// A face that borders on a wall or on the image of a cell.
type BorderFace<'a> = (u32, u32, &'a [LoopCorner]);

impl MeshBuilder {
    const UNUSED: u32 = u32::MAX;

    fn new(positions: Vec<Point3<f64>>, periods: Vector3<f64>) -> Self {
        Self {
            numbers: vec![Self::UNUSED; positions.len()],
            positions,
            periods,
            shifted: HashMap::new(),
            mesh: PolyMesh::default(),
        }
    }

    fn build(mut self, cells: &[CellLoops], wall_name: &dyn Fn(u32) -> String) -> PolyMesh {
        self.mesh.cell_count = cells.len();
        let mut borders: BTreeMap<FaceBorder, Vec<BorderFace<'_>>> = BTreeMap::new();
        for (cell, loops) in (0..).zip(cells) {
            let mut inner = Vec::new();
            for (label, corners) in loops.facets() {
                let (border, other) = match FacetKind::of(label) {
                    FacetKind::Neighbor { site, image } => {
                        (FaceBorder::Image(image.map(i16::from)), site)
                    }
                    FacetKind::Wall(number) => (FaceBorder::Wall(number), 0),
                    FacetKind::Inner => continue,
                };
                if border != FaceBorder::Image(NO_SHIFT) {
                    let faces = borders.entry(border).or_default();
                    faces.push((cell, other, corners));
                } else if other > cell {
                    inner.push((other, corners));
                }
            }
            inner.sort_by_key(|&(other, _)| other);
            for (other, corners) in inner {
                self.push_face(cell, corners.iter().copied());
                self.mesh.neighbor.push(other);
            }
        }
        for (border, faces) in borders {
            match border {
                FaceBorder::Wall(number) => self.push_wall(wall_name(number), &faces),
                FaceBorder::Image(image) if image > NO_SHIFT => self.push_pair(image, faces),
                FaceBorder::Image(_) => {}
            }
        }
        self.mesh
    }

    fn push_wall(&mut self, name: String, faces: &[BorderFace<'_>]) {
        let start = self.mesh.face_count();
        for &(cell, _, corners) in faces {
            self.push_face(cell, corners.iter().copied());
        }
        self.push_patch(name, start, None);
    }

    /// The faces towards an image and, in the same order, those on the other side.
    fn push_pair(&mut self, image: Shift, mut faces: Vec<BorderFace<'_>>) {
        faces.sort_by_key(|&(cell, other, _)| (cell, other));
        let back = image.map(|periods| -periods);
        let way = Vector3::from(image.map(f64::from)).component_mul(&self.periods);
        let here = self.mesh.patches.len();
        let start = self.mesh.face_count();
        for &(cell, _, corners) in &faces {
            self.push_face(cell, corners.iter().copied());
        }
        self.push_patch(image_name(image), start, Some((here + 1, -way)));
        let start = self.mesh.face_count();
        for &(_, other, corners) in &faces {
            let turned = corners[..1].iter().chain(corners[1..].iter().rev());
            self.push_face(other, turned.map(|corner| corner.shifted(back)));
        }
        self.push_patch(image_name(back), start, Some((here, way)));
    }

    fn push_patch(&mut self, name: String, start: usize, partner: Option<(usize, Vector3<f64>)>) {
        let count = self.mesh.face_count() - start;
        self.mesh.patches.push(MeshPatch {
            name,
            start,
            count,
            partner,
        });
    }

    fn push_face(&mut self, owner: u32, corners: impl Iterator<Item = LoopCorner>) {
        let points: Vec<u32> = corners.map(|corner| self.point(corner)).collect();
        self.mesh.push_corners(points);
        self.mesh.owner.push(owner);
    }

    /// The point of a corner, numbered on its first use.
    fn point(&mut self, corner: LoopCorner) -> u32 {
        let number = match corner.shift() {
            NO_SHIFT => &mut self.numbers[corner.number() as usize],
            _ => self.shifted.entry(corner).or_insert(Self::UNUSED),
        };
        if *number == Self::UNUSED {
            *number = self.mesh.points.len() as u32;
            let place = corner.position(&self.positions, &self.periods);
            self.mesh.points.push(place);
        }
        *number
    }
}

/// The sides of the box through which an image is reached.
fn image_name(image: Shift) -> String {
    let mut names = Vec::new();
    for (axis, periods) in ["x", "y", "z"].into_iter().zip(image) {
        let side = if periods < 0 { "min" } else { "max" };
        for _ in 0..periods.abs() {
            names.push(format!("{axis}{side}"));
        }
    }
    names.join("_")
}
