//! The center of a convex polygon: the minimizer of its Chebyshev energy.

use nalgebra::{Point2, Vector2};

use crate::chebyshev::plane::energy_with_derivatives;
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::newton::{NewtonOptions, newton};
use crate::minimize::problem::Minimum;

/// A reach above this means that the center lies inside or on the boundary.
const ON_BOUNDARY: f64 = 1.0 - 1e-12;

/// Which share of the way to the boundary a site goes at most: so near that nothing is lost, and
/// far enough that rounding cannot carry two sites to one point.
const SHY_OF_BOUNDARY: f64 = 1023.0 / 1024.0;

/// Minimizes ∫ d∞^p over the center, for p = `order` ≥ 1, starting at `start` and staying in
/// `bounds`. The energy is convex, so any minimum is the minimum.
#[must_use]
pub fn center(
    polygon: &ConvexPolygon,
    start: &Point2<f64>,
    bounds: &Bounds<2>,
    order: u32,
) -> Minimum<2> {
    newton(
        |x| energy_with_derivatives(polygon, &Point2::from(*x), order),
        &start.coords,
        &bounds.min.coords,
        &bounds.max.coords,
        &options(polygon.area(), order),
    )
}

/// Steps are measured by the side of the square of the same `area`, gradients by p A s^(p−1),
/// what a fragment of that size contributes.
fn options(area: f64, order: u32) -> NewtonOptions {
    let side = area.max(0.0).sqrt();
    let scale = (1..order).fold(area * f64::from(order), |scale, _| scale * side);
    NewtonOptions::new(scale, side)
}

/// Where a site moves that wants to go to `center`: all the way if that lies in the cell
/// `polygon` (which has the site as origin), else along the straight line, up to just before the
/// cell's boundary.
///
/// A center may lie outside a slanted, slender cell, for the Chebyshev distance to a point can
/// shrink as the point leaves a convex set. The energy is convex, so it falls all along the line;
/// and a site that stays inside its own cell can neither leave the domain nor meet another.
#[must_use]
pub fn step_inside(polygon: &ConvexPolygon, center: &Point2<f64>) -> Vector2<f64> {
    let reach = polygon.reach(&Point2::origin(), &center.coords);
    if reach >= ON_BOUNDARY {
        center.coords
    } else {
        center.coords * (reach * SHY_OF_BOUNDARY)
    }
}
