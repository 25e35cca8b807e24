//! The winding number of a closed surface about a point, and where a ray leaves the surface.
//!
//! The winding number of a point is the signed number of triangles on a ray from it along +x. Whether
//! the ray's line passes through a triangle, and on which side of the triangle the point lies, is
//! computed by Shewchuk's exact predicates. Ties in the first are broken the
//! same way for both triangles at an edge: a side counts where it rises past the line on its left.

use nalgebra::{Point3, Vector3};
use robust::{Coord, Coord3D, orient2d, orient3d};

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::surface::SurfaceMesh;

/// The winding number of the surface about `point`, or `None` for a point on the surface. `tree`
/// holds the triangles' bounds.
#[must_use]
pub(crate) fn winding(surface: &SurfaceMesh, tree: &Bvh, point: &Point3<f64>) -> Option<i32> {
    let mut sum = 0;
    let on_surface = visit_turns(surface, tree, point, |_, turns| sum += turns);
    (!on_surface).then_some(sum)
}

/// Visits the triangles ahead of `point` along +x, each with the number by which it changes the
/// winding number; returns whether the point lies on the surface.
pub(crate) fn visit_turns(
    surface: &SurfaceMesh,
    tree: &Bvh,
    point: &Point3<f64>,
    mut visit: impl FnMut(u32, i32),
) -> bool {
    let ahead = |bounds: &Bounds<3>| {
        let beside =
            |axis: usize| bounds.min[axis] <= point[axis] && point[axis] <= bounds.max[axis];
        bounds.max.x >= point.x && beside(1) && beside(2)
    };
    let mut on_surface = false;
    tree.visit(ahead, |triangle| {
        let corners = surface.corners(triangle as usize);
        let depth = depth(&corners, point);
        on_surface |= depth == 0.0 && holds(&corners, point);
        let turns = turns(&corners, point);
        if depth * f64::from(turns) > 0.0 {
            visit(triangle, turns);
        }
    });
    on_surface
}

/// The share of `step` after which the way from `from`, a point of the solid, first crosses the
/// surface outward, and the triangle; none where it does not. Touching an edge counts as crossing. `tree` holds
/// the triangles' bounds.
#[must_use]
pub(crate) fn ray_exit(
    surface: &SurfaceMesh,
    tree: &Bvh,
    from: &Point3<f64>,
    step: &Vector3<f64>,
) -> Option<(f64, u32)> {
    let to = from + step;
    let around = Bounds::of([from, &to]);
    let mut first: Option<(f64, u32)> = None;
    let near = |bounds: &Bounds<3>| bounds.overlaps(&around);
    tree.visit(near, |triangle| {
        let corners = surface.corners(triangle as usize);
        let (before, after) = (depth(&corners, from), depth(&corners, &to));
        if before >= 0.0 && after < 0.0 && passes(&corners, from, &to) {
            let share = before / (before - after);
            if first.is_none_or(|(least, _)| share < least) {
                first = Some((share, triangle));
            }
        }
    });
    first
}

/// Whether the line through both points meets the closed triangle.
fn passes(corners: &[Point3<f64>; 3], from: &Point3<f64>, to: &Point3<f64>) -> bool {
    let sides = [0, 1, 2].map(|k| {
        let [p, q, a, b] = [*from, *to, corners[k], corners[(k + 1) % 3]].map(coordinates);
        orient3d(p, q, a, b)
    });
    have_one_sign(&sides)
}

/// Whether no two of the numbers have opposite signs.
fn have_one_sign(numbers: &[f64; 3]) -> bool {
    numbers.iter().all(|&number| number >= 0.0) || numbers.iter().all(|&number| number <= 0.0)
}

/// Positive behind the triangle, on the inner side of an outward one. The sign is exact.
pub(crate) fn depth(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> f64 {
    let [a, b, c, p] = [corners[0], corners[1], corners[2], *point].map(coordinates);
    orient3d(a, b, c, p)
}

fn coordinates(point: Point3<f64>) -> Coord3D<f64> {
    let [x, y, z] = point.into();
    Coord3D { x, y, z }
}

/// How often the triangle, projected along x, winds about the point.
pub(crate) fn turns(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> i32 {
    let mut turns = 0;
    for from in 0..3 {
        let (a, b) = (&corners[from], &corners[(from + 1) % 3]);
        let rises = i32::from(b.z > point.z) - i32::from(a.z > point.z);
        if rises != 0 && f64::from(rises) * turn(a, b, point, [1, 2]) > 0.0 {
            turns += rises;
        }
    }
    turns
}

/// Whether the triangle holds a point of its plane.
fn holds(corners: &[Point3<f64>; 3], point: &Point3<f64>) -> bool {
    // The projections along all three axes must hold the point; at least one is not degenerate.
    let holds_along = |axes: [usize; 2]| {
        let turns = [0, 1, 2].map(|k| turn(&corners[k], &corners[(k + 1) % 3], point, axes));
        have_one_sign(&turns)
    };
    Bounds::of(corners).contains(point) && [[0, 1], [1, 2], [2, 0]].into_iter().all(holds_along)
}

fn turn(a: &Point3<f64>, b: &Point3<f64>, point: &Point3<f64>, axes: [usize; 2]) -> f64 {
    let flat = |p: &Point3<f64>| Coord {
        x: p[axes[0]],
        y: p[axes[1]],
    };
    orient2d(flat(a), flat(b), flat(point))
}
