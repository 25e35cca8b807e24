//! How far a site may move at once.

use nalgebra::{Point3, Vector3};

use crate::domain::space::Domain;
use crate::energy::center::BOUNDARY_FRACTION;
use crate::energy::evaluation::SignedPiece;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::voronoi::cell::Cell;

/// The box in which the site may move, relative to it: around its cell and within the domain's.
pub(crate) fn reach(domain: &dyn Domain, cell: &Cell<'_>) -> Bounds<3> {
    let around = cell.bounds();
    let mut within = domain.bounds();
    for (axis, period) in domain.periods().iter().enumerate() {
        if period.is_some() {
            within.min[axis] = f64::NEG_INFINITY;
            within.max[axis] = f64::INFINITY;
        }
    }
    within.min -= cell.position.coords;
    within.max -= cell.position.coords;
    around.intersection(&within)
}

/// Where the site goes that is drawn to `step`: there, or [`BOUNDARY_FRACTION`] of the way to where the
/// straight way first leaves the cell or the domain. The energy is convex, also if the cell is not,
/// so it falls all along the way.
pub(crate) fn target(domain: &dyn Domain, cell: &Cell<'_>, step: &Vector3<f64>) -> Point3<f64> {
    let mut share = share_within(cell.half_spaces(), step);
    if !domain.is_convex() {
        let exit = domain.first_exit(&cell.position, &(step * share));
        if exit.is_finite() {
            share *= BOUNDARY_FRACTION * exit;
        }
        // Rounding may put a point that is nearly on the surface on its wrong side.
        while share > 0.0 && !domain.contains(&(cell.position + step * share)) {
            share *= 0.5;
        }
    }
    within_walls(domain, domain.wrap(&(cell.position + step * share)))
}

/// The place itself, or where rounding has put it beyond the box around the domain, that box's wall.
fn within_walls(domain: &dyn Domain, place: Point3<f64>) -> Point3<f64> {
    let inside = domain.bounds().clamp(&place);
    let periods = domain.periods();
    Point3::from([0, 1, 2].map(|axis| match periods[axis] {
        Some(_) => place[axis],
        None => inside[axis],
    }))
}

/// The share of `step` that a site may make: all of it while that ends in the cell, else
/// [`BOUNDARY_FRACTION`] of the way to the border. Since the energy is convex it falls all the way.
///
/// Planes that have no facet any more are asked too: the way leaves the cell before it meets them.
fn share_within(half_spaces: &[HalfSpace], step: &Vector3<f64>) -> f64 {
    let mut share: f64 = 1.0;
    for border in half_spaces {
        let climb = border.normal.dot(step);
        if climb > border.offset {
            share = share.min(BOUNDARY_FRACTION * (border.offset / climb).max(0.0));
        }
    }
    share
}

/// The box around the pieces, in their frame.
pub(crate) fn around(pieces: &[SignedPiece]) -> Bounds<3> {
    let mut bounds = Bounds::empty();
    for vertex in pieces.iter().flat_map(|piece| piece.piece.vertices()) {
        bounds.include(&vertex);
    }
    bounds
}
