//! How far one may go from a point of a solid before leaving it.

use nalgebra::{Point3, Vector3};
use robust::orient3d;

use crate::domain::surface::winding::{coordinates, depth};
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::surface::SurfaceMesh;

/// The share of `step` after which the way from `from`, a point of the solid, first crosses the
/// surface outward; infinity where it does not. Touching an edge counts as crossing. `tree` holds
/// the triangles' bounds.
#[must_use]
pub fn first_exit(
    surface: &SurfaceMesh,
    tree: &Bvh,
    from: &Point3<f64>,
    step: &Vector3<f64>,
) -> f64 {
    let to = from + step;
    let around = Bounds::of([from, &to]);
    let mut first = f64::INFINITY;
    tree.visit(
        |bounds| bounds.overlaps(&around),
        |triangle| {
            let corners = surface.corners(triangle as usize);
            let (before, after) = (depth(&corners, from), depth(&corners, &to));
            if before >= 0.0 && after < 0.0 && passes(&corners, from, &to) {
                first = first.min(before / (before - after));
            }
        },
    );
    first
}

/// Whether the line through both points meets the closed triangle.
fn passes(corners: &[Point3<f64>; 3], from: &Point3<f64>, to: &Point3<f64>) -> bool {
    let sides = [0, 1, 2].map(|k| {
        let [p, q, a, b] = [*from, *to, corners[k], corners[(k + 1) % 3]].map(coordinates);
        orient3d(p, q, a, b)
    });
    sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0)
}
