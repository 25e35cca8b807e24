//! The elements of a mesh that a cell may touch, by bounding boxes and separating planes.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// Rounding to be allowed for when boxes and planes are compared, relative to the numbers.
const ROUNDING: f64 = 1e-12;

/// Calls `found` with every box of the tree that no plane of `cell`, in coordinates relative to
/// `site`, separates from it.
pub(crate) fn visit_candidates(
    tree: &Bvh,
    site: &Point3<f64>,
    cell: &Polyhedron,
    found: impl FnMut(u32),
) {
    let mut around = cell.bounds();
    let slack = Vector3::repeat(ROUNDING * (site.coords.amax() + around.extent().max()));
    around.min += site.coords - slack;
    around.max += site.coords + slack;
    let planes = cell.facets().map(|facet| facet.half_space());
    let planes: Vec<Separator> = planes.map(|plane| Separator::of(&plane)).collect();
    let far = site.coords.amax();
    let is_separated = |bounds: &Bounds<3>| {
        let middle = bounds.center() - site;
        let half = bounds.extent() * 0.5;
        let size = middle.amax() + half.amax() + far;
        let mut planes = planes.iter();
        planes.any(|plane| plane.separates(&middle, &half, size))
    };
    tree.visit(
        |bounds| bounds.overlaps(&around) && !is_separated(bounds),
        found,
    );
}

/// A plane of the cell, ready to be compared with many boxes.
struct Separator {
    normal: Vector3<f64>,
    /// Its normal's components without signs.
    reach: Vector3<f64>,
    offset: f64,
    /// The rounding per length.
    slack: f64,
}

impl Separator {
    fn of(plane: &HalfSpace) -> Self {
        Self {
            normal: plane.normal,
            reach: plane.normal.abs(),
            offset: plane.offset,
            slack: 3.0 * ROUNDING * plane.normal.amax(),
        }
    }

    /// Whether the box about `middle` that reaches `half` to either side lies beyond the plane.
    /// `size` bounds the coordinates involved.
    fn separates(&self, middle: &Vector3<f64>, half: &Vector3<f64>, size: f64) -> bool {
        // The corner of the box deepest in the half-space.
        let deepest = self.normal.dot(middle) - self.reach.dot(half);
        deepest - self.offset > self.slack * size
    }
}
