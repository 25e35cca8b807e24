//! Values at the vertices of tetrahedra, interpolated at a point.

use nalgebra::{Matrix3, Point3};

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::tets::TetMesh;

/// How far a point may lie outside a tetrahedron, as a share of its height, and still count as in it.
const OUTSIDE: f64 = 1e-9;

/// Tetrahedra with values at their vertices and a tree of their boxes.
#[derive(Debug)]
pub(crate) struct TetValues<'a> {
    mesh: &'a TetMesh,
    values: &'a [f64],
    tree: Bvh,
}

impl<'a> TetValues<'a> {
    /// One value for each vertex of `mesh`.
    pub(crate) fn new(mesh: &'a TetMesh, values: &'a [f64]) -> Self {
        let tree = Bvh::new(mesh.all_corners().map(|corners| Bounds::of(&corners)));
        Self { mesh, values, tree }
    }

    /// The linear interpolation at a point; NaN outside all tetrahedra.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        let mut found = (-OUTSIDE, f64::NAN);
        let is_near = |bounds: &Bounds<3>| bounds.contains(point);
        self.tree.visit(is_near, |tet| {
            let (least, value) = self.in_tet(tet, point);
            if least > found.0 {
                found = (least, value);
            }
        });
        found.1
    }

    /// The least barycentric coordinate of a point in a tetrahedron, and the value of its linear function.
    fn in_tet(&self, tet: u32, point: &Point3<f64>) -> (f64, f64) {
        let vertices = self.mesh.tets[tet as usize].map(|vertex| vertex as usize);
        let corners = vertices.map(|vertex| self.mesh.vertices[vertex]);
        let edges = Matrix3::from_columns(&[1, 2, 3].map(|k| corners[k] - corners[0]));
        let Some(shares) = edges.lu().solve(&(point - corners[0])) else {
            return (f64::NEG_INFINITY, f64::NAN);
        };
        let weights = [1.0 - shares.sum(), shares.x, shares.y, shares.z];
        let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
        let terms = weights.iter().zip(vertices);
        (
            least,
            terms
                .map(|(weight, vertex)| weight * self.values[vertex])
                .sum(),
        )
    }
}
