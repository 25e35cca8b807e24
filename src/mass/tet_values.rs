//! Values at the vertices of tetrahedra, interpolated at a point.

use std::borrow::Cow;

use nalgebra::{Matrix3, Point3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::tets::TetMesh;

/// How far a point may lie outside a tetrahedron, as a share of its height, and still count as in it.
const OUTSIDE: f64 = 1e-9;

/// Tetrahedra with values at their vertices and a tree of their boxes.
#[derive(Debug)]
pub(crate) struct TetValues<'a> {
    mesh: &'a TetMesh,
    values: Cow<'a, [f64]>,
    tree: Bvh,
}

impl<'a> TetValues<'a> {
    /// One value for each vertex of `mesh`.
    pub(crate) fn new(mesh: &'a TetMesh, values: Cow<'a, [f64]>) -> Self {
        let tree = Bvh::new(mesh.all_corners().map(|corners| Bounds::of(&corners)));
        Self { mesh, values, tree }
    }

    /// The linear interpolation at a point; NaN outside all tetrahedra.
    pub(crate) fn at(&self, point: &Point3<f64>) -> f64 {
        let Some(tet) = self.tet_at(point) else {
            return f64::NAN;
        };
        let weights = self.weights(tet, point).unwrap_or([f64::NAN; 4]);
        let corners = self.mesh.tets[tet as usize];
        let terms = weights.iter().zip(corners);
        terms
            .map(|(weight, vertex)| weight * self.values[vertex as usize])
            .sum()
    }

    /// The tetrahedron that holds a point.
    pub(crate) fn tet_at(&self, point: &Point3<f64>) -> Option<u32> {
        let mut found = (-OUTSIDE, None);
        let is_near = |bounds: &Bounds<3>| bounds.contains(point);
        self.tree.visit(is_near, |tet| {
            let weights = self.weights(tet, point);
            let least = weights.map(|weights| weights.into_iter().fold(f64::INFINITY, f64::min));
            if let Some(least) = least.filter(|&least| least > found.0) {
                found = (least, Some(tet));
            }
        });
        found.1
    }

    /// The barycentric coordinates of a point in a tetrahedron; none where that is flat.
    fn weights(&self, tet: u32, point: &Point3<f64>) -> Option<[f64; 4]> {
        let corners = self.mesh.corners(tet as usize);
        let edges = Matrix3::from_columns(&[1, 2, 3].map_each(|k| corners[k] - corners[0]));
        let shares = edges.lu().solve(&(point - corners[0]))?;
        Some([1.0 - shares.sum(), shares.x, shares.y, shares.z])
    }
}
