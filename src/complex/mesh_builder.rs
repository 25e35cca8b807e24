//! Paired faces put in OpenFOAM's order, with their points, cells and patches.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::complex::loop_corner::LoopCorner;
use crate::complex::loops::{CellLoops, least_first};
use crate::complex::vertex_key::{NO_SHIFT, Shift};
use crate::complex::wall_patches::WallPatches;
use crate::domain::facet_kind::FacetKind;
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};

/// What a patch's faces border on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum FaceBorder {
    Wall(u32),
    Image(Shift),
}

/// A face between two cells: owner, neighbor, and the loop as the site of lower number sees it.
struct InnerFace<'a> {
    cells: [u32; 2],
    corners: &'a [LoopCorner],
    is_turned: bool,
}

/// A face that borders on a wall or on the image of a cell: its cell, and that wall or cell.
type BorderFace<'a> = (u32, u32, &'a [LoopCorner]);

/// A mesh under construction.
pub(crate) struct MeshBuilder<'a> {
    cells: &'a [CellLoops],
    positions: &'a [Point3<f64>],
    periods: Vector3<f64>,
    /// The cells of every site, by the piece of each facet; none where there is one piece.
    pieces: HashMap<u32, Vec<u32>>,
    /// The points of vertices at shift zero.
    numbers: Vec<u32>,
    /// The points of all others.
    shifted: HashMap<LoopCorner, u32>,
    mesh: PolyMesh,
    /// The walls of the faces on walls, in their order.
    walls: Vec<u32>,
}

impl<'a> MeshBuilder<'a> {
    const UNUSED: u32 = u32::MAX;

    /// A mesh of cells whose faces are the same from both sides.
    #[must_use]
    pub(crate) fn new(
        cells: &'a [CellLoops],
        positions: &'a [Point3<f64>],
        periods: Vector3<f64>,
    ) -> Self {
        let mut mesh = PolyMesh::default();
        mesh.sites.extend(0..cells.len() as u32);
        mesh.cell_count = cells.len();
        Self {
            cells,
            positions,
            periods,
            pieces: HashMap::new(),
            numbers: vec![Self::UNUSED; positions.len()],
            shifted: HashMap::new(),
            mesh,
            walls: Vec::new(),
        }
    }

    /// The same with a cell for every piece: the largest keeps its site's number, the others come after
    /// all sites.
    #[must_use]
    pub(crate) fn in_pieces(mut self) -> Self {
        let (positions, periods) = (self.positions, self.periods);
        let join = |loops: &CellLoops, pieces: &mut [u32]| {
            join_cavities(loops, pieces, positions, &periods);
        };
        self.pieces = number_pieces(self.cells, join, &mut self.mesh.sites);
        self.mesh.cell_count = self.mesh.sites.len();
        self
    }

    /// The mesh.
    #[must_use]
    pub(crate) fn build(self, patches: &WallPatches) -> PolyMesh {
        self.build_with_walls(patches).0
    }

    /// The mesh, and the walls of its faces on walls.
    #[must_use]
    pub(crate) fn build_with_walls(mut self, patches: &WallPatches) -> (PolyMesh, Vec<u32>) {
        let (mut inner, mut borders) = (Vec::new(), BTreeMap::new());
        let cells = self.cells;
        for (site, loops) in (0..).zip(cells) {
            for (facet, (label, corners)) in loops.facets().enumerate() {
                let cell = self.cell(site, facet);
                match FacetKind::of(label) {
                    FacetKind::Neighbor { site: other, image } => {
                        let image = image.map(i16::from);
                        if image == NO_SHIFT && other < site {
                            continue;
                        }
                        let other = self.cell_behind(site, (other, image), corners);
                        if image == NO_SHIFT {
                            inner.push(InnerFace::new(cell, other, corners));
                        } else {
                            let list: &mut Vec<BorderFace<'_>> =
                                borders.entry(FaceBorder::Image(image)).or_default();
                            list.push((cell, other, corners));
                        }
                    }
                    FacetKind::Wall(wall) => {
                        let border = FaceBorder::Wall(patches.of(wall));
                        borders
                            .entry(border)
                            .or_default()
                            .push((cell, wall, corners));
                    }
                    FacetKind::Inner => {}
                }
            }
        }
        self.push_inner(inner);
        self.push_borders(borders, patches);
        (self.mesh, self.walls)
    }

    /// The cell to which a facet of a site belongs.
    fn cell(&self, site: u32, facet: usize) -> u32 {
        self.pieces.get(&site).map_or(site, |cells| cells[facet])
    }

    /// The cell behind a facet of `site` towards another, seen at an image.
    fn cell_behind(&self, site: u32, (other, image): (u32, Shift), corners: &[LoopCorner]) -> u32 {
        if !self.pieces.contains_key(&other) {
            return other;
        }
        let wanted = least_first(corners);
        let back = image.map(|periods| -periods as i8);
        let label = FacetKind::Neighbor { site, image: back }.label();
        let is_same = |(_, (there, corners)): &(usize, (u64, &[LoopCorner]))| {
            *there == label && turned(corners, image) == wanted
        };
        let mut facets = self.cells[other as usize].facets().enumerate();
        let facet = facets.find(is_same).map_or(0, |(facet, _)| facet);
        self.cell(other, facet)
    }

    fn push_inner(&mut self, mut faces: Vec<InnerFace<'_>>) {
        faces.par_sort_by_key(|face| face.cells);
        for face in faces {
            let [owner, neighbor] = face.cells;
            match face.is_turned {
                false => self.push_face(owner, face.corners.iter().copied()),
                true => self.push_face(owner, face.corners.iter().rev().copied()),
            }
            self.mesh.neighbor.push(neighbor);
        }
    }

    fn push_borders(
        &mut self,
        borders: BTreeMap<FaceBorder, Vec<BorderFace<'_>>>,
        patches: &WallPatches,
    ) {
        for (border, mut faces) in borders {
            faces.sort_by_key(|&(cell, other, _)| (cell, other));
            match border {
                FaceBorder::Wall(patch) => self.push_wall(patches.name(patch), &faces),
                FaceBorder::Image(image) if image > NO_SHIFT => self.push_pair(image, &faces),
                FaceBorder::Image(_) => {}
            }
        }
    }

    fn push_wall(&mut self, name: String, faces: &[BorderFace<'_>]) {
        let start = self.mesh.face_count();
        for &(cell, wall, corners) in faces {
            self.push_face(cell, corners.iter().copied());
            self.walls.push(wall);
        }
        self.push_patch(name, start, None);
    }

    /// The faces towards an image and, in the same order, those on the other side, where a loop
    /// begins at the same corner and runs the other way round.
    fn push_pair(&mut self, image: Shift, faces: &[BorderFace<'_>]) {
        let back = image.map(|periods| -periods);
        let way = Vector3::from(image.map(f64::from)).component_mul(&self.periods);
        let here = self.mesh.patches.len();
        let start = self.mesh.face_count();
        for &(cell, _, corners) in faces {
            self.push_face(cell, corners.iter().copied());
        }
        self.push_patch(image_name(image), start, Some((here + 1, -way)));
        let start = self.mesh.face_count();
        for &(_, other, corners) in faces {
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
            let place = corner.position(self.positions, &self.periods);
            self.mesh.points.push(place);
        }
        *number
    }
}

impl<'a> InnerFace<'a> {
    fn new(cell: u32, other: u32, corners: &'a [LoopCorner]) -> Self {
        Self {
            cells: [cell.min(other), cell.max(other)],
            corners,
            is_turned: other < cell,
        }
    }
}

/// The loop of a facet as its neighbor sees it, from where this cell is at `image`.
#[must_use]
pub(crate) fn turned(corners: &[LoopCorner], image: Shift) -> Vec<LoopCorner> {
    let back = corners.iter().rev().map(|corner| corner.shifted(image));
    least_first(&back.collect::<Vec<_>>())
}

/// Cells for the pieces of every site that has several: per facet. Sites of further cells are appended.
fn number_pieces(
    cells: &[CellLoops],
    join: impl Fn(&CellLoops, &mut [u32]) + Sync,
    sites: &mut Vec<u32>,
) -> HashMap<u32, Vec<u32>> {
    let several = |(site, loops): (usize, &CellLoops)| {
        let mut pieces = loops.pieces();
        if pieces.iter().any(|&piece| piece > 0) {
            join(loops, &mut pieces);
        }
        let is_split = pieces.iter().any(|&piece| piece > 0);
        is_split.then_some((site as u32, pieces))
    };
    let split: Vec<_> = cells.par_iter().enumerate().filter_map(several).collect();
    let mut cells = HashMap::new();
    for (site, mut pieces) in split {
        let first = sites.len() as u32;
        let count = pieces.iter().max().copied().unwrap_or(0);
        sites.extend((0..count).map(|_| site));
        for piece in &mut pieces {
            *piece = if *piece == 0 {
                site
            } else {
                first + *piece - 1
            };
        }
        cells.insert(site, pieces);
    }
    cells
}

/// Gives the surfaces of cavities, which enclose a negative volume, to the largest piece of the cell, and
/// numbers the pieces anew.
fn join_cavities(
    loops: &CellLoops,
    pieces: &mut [u32],
    positions: &[Point3<f64>],
    periods: &Vector3<f64>,
) {
    let count = pieces.iter().max().map_or(0, |&last| last as usize + 1);
    let mut volumes = vec![0.0; count];
    let mut origin = None;
    for ((_, corners), &piece) in loops.facets().zip(pieces.iter()) {
        let place = |corner: &LoopCorner| corner.position(positions, periods);
        let origin = *origin.get_or_insert_with(|| place(&corners[0]));
        for pair in corners.windows(2).skip(1) {
            let [a, b, c] = [&corners[0], &pair[0], &pair[1]].map(|corner| place(corner) - origin);
            volumes[piece as usize] += a.dot(&b.cross(&c));
        }
    }
    let largest = (0..count).max_by(|&one, &other| volumes[one].total_cmp(&volumes[other]));
    let mut next = 0;
    let mut numbers = vec![0; count];
    for piece in (0..count).filter(|&piece| volumes[piece] > 0.0 && Some(piece) != largest) {
        next += 1;
        numbers[piece] = next;
    }
    for piece in pieces {
        *piece = numbers[*piece as usize];
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
