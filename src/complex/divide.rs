//! Polyhedra parted into pyramids and tetrahedra about a point inside.
//!
//! Cells that are hexahedra, prisms, pyramids or tetrahedra with a positive Jacobian stay whole. Of the
//! others each face becomes the base of a pyramid or tetrahedron whose apex is the cell's center, or, where
//! a face would see it from behind or too low, a point higher above all faces. Faces of more than four
//! corners, and quadrilaterals that would make a bad pyramid on either side, are cut into the
//! triangles whose least tetrahedron is greatest; both sides have the same.

use nalgebra::{Point3, Vector3};

use crate::complex::element::CellElement;
use crate::complex::element_mesh::ElementMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::jacobian::least_jacobian;
use crate::complex::polygon_cut::cut_polygon;
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};
use crate::parallel::map;

/// A center stays where the least height above the faces is this share of the cell's size.
const HIGH_ENOUGH: f64 = 0.05;

/// Steps by which a center rises above its lowest face.
const STEPS: usize = 100;

/// How often faces are cut for given centers and centers found for given faces.
const ROUNDS: usize = 3;

/// The parts of `mesh`. The points of the mesh come first, then the centers of cells that were parted.
#[must_use]
pub(crate) fn divide(mesh: &PolyMesh) -> ElementMesh {
    Division::done(mesh).finish()
}

/// The cells that have no place from which all parts of their faces are seen, or two faces between the same
/// points.
#[must_use]
pub(crate) fn unseen(mesh: &PolyMesh) -> Vec<usize> {
    let division = Division::done(mesh);
    let is_unseen = |&cell: &usize| {
        !division.is_whole[cell] && (division.least(cell) <= 0.0 || division.has_twins(cell))
    };
    (0..mesh.cell_count).filter(is_unseen).collect()
}

struct Division<'a> {
    mesh: &'a PolyMesh,
    cells: CellFaces,
    elements: Vec<CellElement>,
    /// Per cell whether it stays.
    is_whole: Vec<bool>,
    centers: Vec<Point3<f64>>,
    sizes: Vec<f64>,
    /// Per face its parts by points, outward of the owner.
    parts: Vec<Vec<Vec<u32>>>,
}

impl<'a> Division<'a> {
    fn new(mesh: &'a PolyMesh) -> Self {
        let cells = mesh.cell_faces();
        let geometry = MeshGeometry::of(mesh, &cells);
        let elements: Vec<CellElement> =
            map(mesh.cell_count, &|cell| CellElement::of(mesh, &cells, cell));
        let is_good = |element: &CellElement| least_jacobian(&mesh.points, element) > 0.0;
        Self {
            mesh,
            cells,
            is_whole: elements.iter().map(is_good).collect(),
            elements,
            centers: geometry.cell_centers,
            sizes: geometry
                .cell_volumes
                .iter()
                .map(|volume| volume.abs().cbrt())
                .collect(),
            parts: Vec::new(),
        }
    }

    /// The division of a mesh.
    fn done(mesh: &'a PolyMesh) -> Self {
        let mut division = Self::new(mesh);
        for _ in 0..ROUNDS {
            division.cut_faces();
            division.raise_centers();
        }
        division.cut_faces();
        division
    }

    /// Whether two faces of a cell have the same points.
    fn has_twins(&self, cell: usize) -> bool {
        let sorted = |(face, _): (usize, bool)| {
            let mut corners = self.mesh.face(face).to_vec();
            corners.sort_unstable();
            corners
        };
        let mut faces: Vec<Vec<u32>> = self.cells.of(cell).map(sorted).collect();
        faces.sort_unstable();
        faces.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// The least height (L) of a cell's center above the planes of its faces' parts.
    fn least(&self, cell: usize) -> f64 {
        let planes = self.planes(cell).into_iter();
        let heights = planes.map(|(point, normal)| normal.dot(&(point - self.centers[cell])));
        heights.fold(f64::INFINITY, f64::min)
    }

    /// The cells at a face that are parted, and whether each owns it.
    fn parted(&self, face: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let owner = Some((self.mesh.owner[face] as usize, true));
        let neighbor = self.mesh.neighbor_of(face).map(|cell| (cell, false));
        let sides = owner.into_iter().chain(neighbor);
        sides.filter(|&(cell, _)| !self.is_whole[cell])
    }

    /// Six times the least volume (L³) of the tetrahedra over a triangle of a face in the cells that
    /// are parted.
    fn worth(&self, face: usize, corners: [u32; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| self.mesh.points[corner as usize]);
        let area = (b - a).cross(&(c - a));
        let of = |(cell, is_owner): (usize, bool)| {
            let below = area.dot(&(a - self.centers[cell]));
            if is_owner { below } else { -below }
        };
        self.parted(face).map(of).fold(f64::INFINITY, f64::min)
    }

    /// Cuts faces as the centers ask for.
    fn cut_faces(&mut self) {
        self.parts = map(self.mesh.face_count(), &|face| self.cut_face(face));
    }

    fn cut_face(&self, face: usize) -> Vec<Vec<u32>> {
        let corners = self.mesh.face(face);
        let whole = vec![corners.to_vec()];
        let is_fixed = self.parted(face).count()
            < if self.mesh.neighbor_of(face).is_some() {
                2
            } else {
                1
            };
        if corners.len() == 3 || is_fixed {
            return whole;
        }
        if corners.len() == 4 && self.pyramid_worth(face, corners) > 0.0 {
            return whole;
        }
        let worth = |places: [usize; 3]| self.worth(face, places.map(|place| corners[place]));
        let triangles = cut_polygon(corners.len(), worth);
        let points = |places: [usize; 3]| places.map(|place| corners[place]).to_vec();
        triangles.into_iter().map(points).collect()
    }

    fn pyramid_worth(&self, face: usize, corners: &[u32]) -> f64 {
        let corner = |place: usize| corners[place % 4];
        let of = |place| self.worth(face, [corner(place), corner(place + 1), corner(place + 2)]);
        (0..4).map(of).fold(f64::INFINITY, f64::min)
    }

    /// Moves centers of parted cells up from their lowest faces.
    fn raise_centers(&mut self) {
        let raised: Vec<Point3<f64>> =
            map(self.mesh.cell_count, &|cell| match self.is_whole[cell] {
                true => self.centers[cell],
                false => raised(&self.planes(cell), self.centers[cell], self.sizes[cell]),
            });
        self.centers = raised;
    }

    /// The planes of all triangles of corners that follow each other in the parts of a cell's faces, by
    /// a point and the normal, outward.
    fn planes(&self, cell: usize) -> Vec<(Point3<f64>, Vector3<f64>)> {
        let mut planes = Vec::new();
        for (face, is_owner) in self.cells.of(cell) {
            for part in &self.parts[face] {
                let count = if part.len() == 3 { 1 } else { part.len() };
                planes.extend((0..count).filter_map(|place| {
                    let corner =
                        |step: usize| self.mesh.points[part[(place + step) % part.len()] as usize];
                    let area = (corner(1) - corner(0)).cross(&(corner(2) - corner(0)));
                    let normal = area.try_normalize(0.0)?;
                    Some((corner(0), if is_owner { normal } else { -normal }))
                }));
            }
        }
        planes
    }

    fn finish(self) -> ElementMesh {
        let patches = self.mesh.patches.iter();
        let mut made = ElementMesh {
            points: self.mesh.points.clone(),
            patches: patches.map(|patch| patch.name.clone()).collect(),
            ..ElementMesh::default()
        };
        for cell in 0..self.mesh.cell_count {
            match self.is_whole[cell] {
                true => made.elements.push(self.elements[cell].clone()),
                false => self.push_parts(cell, &mut made),
            }
            made.cells.resize(made.elements.len(), cell as u32);
        }
        for (number, patch) in (0..).zip(&self.mesh.patches) {
            for face in patch.start..patch.start + patch.count {
                let parts = self.parts[face].iter();
                made.walls.extend(parts.map(|part| (part.clone(), number)));
            }
        }
        made
    }

    fn push_parts(&self, cell: usize, made: &mut ElementMesh) {
        let apex = made.points.len() as u32;
        made.points.push(self.centers[cell]);
        for (face, is_owner) in self.cells.of(cell) {
            for part in &self.parts[face] {
                // The base runs counter-clockwise as seen from inside.
                let mut base = part.clone();
                if is_owner {
                    base.reverse();
                }
                made.elements.push(match base[..] {
                    [a, b, c, d] => CellElement::Pyramid([a, b, c, d, apex]),
                    _ => CellElement::Tetrahedron([base[0], base[1], base[2], apex]),
                });
            }
        }
    }
}

/// A point whose least height above the planes is no less than that of `center`, near the greatest:
/// subgradient steps away from the lowest plane, shorter every time.
fn raised(planes: &[(Point3<f64>, Vector3<f64>)], center: Point3<f64>, size: f64) -> Point3<f64> {
    let lowest = |place: &Point3<f64>| {
        let heights = planes
            .iter()
            .map(|(point, normal)| (normal.dot(&(point - place)), *normal));
        heights.min_by(|one, other| one.0.total_cmp(&other.0))
    };
    let Some((mut height, mut normal)) = lowest(&center) else {
        return center;
    };
    let (mut best, mut place) = ((height, center), center);
    for step in 0..STEPS {
        if best.0 > HIGH_ENOUGH * size {
            break;
        }
        place -= normal * (0.5 * size / (step + 2) as f64);
        let Some(now) = lowest(&place) else { break };
        (height, normal) = now;
        if height > best.0 {
            best = (height, place);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_center_rises_into_a_corner_that_sees_all_faces() {
        // The unit cube's planes and one through (0.9, 0.9, 0.9): only near that corner is inside.
        let mut planes = Vec::new();
        for axis in 0..3 {
            let mut normal = Vector3::zeros();
            normal[axis] = 1.0;
            planes.push((Point3::new(1.0, 1.0, 1.0), normal));
            planes.push((Point3::origin(), -normal));
        }
        planes.push((
            Point3::new(0.8, 0.8, 0.8),
            -Vector3::new(1.0, 1.0, 1.0).normalize(),
        ));
        let place = raised(&planes, Point3::new(0.5, 0.5, 0.5), 1.0);
        for (point, normal) in planes {
            assert!(normal.dot(&(point - place)) > 0.04, "{place}");
        }
    }
}
