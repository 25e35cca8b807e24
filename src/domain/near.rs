//! Which parts of a mesh a cell may touch.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::polyhedron::Polyhedron;

/// Rounding to be allowed for when boxes and planes are compared, relative to the numbers.
const ROUNDING: f64 = 1e-12;

/// Calls `found` with every box of the tree that no plane of `cell`, in coordinates relative to
/// `site`, holds off.
pub(crate) fn visit_near(
    tree: &BoxTree,
    site: &Point3<f64>,
    cell: &Polyhedron,
    found: impl FnMut(u32),
) {
    let mut around = cell.bounds();
    let slack = Vector3::repeat(ROUNDING * (site.coords.amax() + around.extent().max()));
    around.min += site.coords - slack;
    around.max += site.coords + slack;
    let planes: Vec<_> = cell.facets().map(|facet| facet.half_space()).collect();
    let meets = |bounds: &Bounds<3>| {
        bounds.overlaps(&around)
            && planes.iter().all(|plane| {
                // The corner of the box deepest in the half-space.
                let deepest = Vector3::from([0, 1, 2].map(|axis| {
                    let upward = plane.normal[axis] > 0.0;
                    (if upward { bounds.min } else { bounds.max })[axis] - site[axis]
                }));
                let size = 3.0 * plane.normal.amax() * (deepest.amax() + site.coords.amax());
                plane.normal.dot(&deepest) - plane.offset <= ROUNDING * size
            })
    };
    tree.visit(meets, found);
}
