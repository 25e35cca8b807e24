//! A domain as the rest of the program sees it: a signed sum of convex pieces.
//!
//! Everything that a cell is worth is additive over a partition of C ∩ Ω into convex pieces and
//! linear in signs. So a domain only says from which convex polyhedron a cell starts and which
//! signed convex pieces then overlap it.

use std::fmt::Debug;

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::clip::ClipScratch;
use crate::geometry::polyhedron::Polyhedron;

/// A bounded solid Ω in space, possibly periodic along some axes.
pub trait Domain: Debug + Send + Sync {
    /// The least axis-aligned box around Ω.
    fn bounds(&self) -> Bounds<3>;

    /// |Ω| (L³).
    fn volume(&self) -> f64;

    /// Whether `point` lies in the closed set Ω.
    fn contains(&self, point: &Point3<f64>) -> bool;

    /// The period along each axis (L), `None` where the axis ends in walls.
    fn periods(&self) -> [Option<f64>; 3] {
        [None; 3]
    }

    /// The same place with periodic coordinates brought into the bounds.
    fn wrap(&self, point: &Point3<f64>) -> Point3<f64> {
        let (bounds, periods) = (self.bounds(), self.periods());
        let mut wrapped = *point;
        for axis in 0..3 {
            let Some(period) = periods[axis] else {
                continue;
            };
            if bounds.min[axis] <= point[axis] && point[axis] < bounds.max[axis] {
                continue;
            }
            let inside = bounds.min[axis] + (point[axis] - bounds.min[axis]).rem_euclid(period);
            let past_end = inside >= bounds.max[axis];
            wrapped[axis] = if past_end { bounds.min[axis] } else { inside };
        }
        wrapped
    }

    /// Sets `cell` to a convex polyhedron, in coordinates relative to `site` (number `index`),
    /// from which the site's cell is cut: all of Ω that the cell may hold lies in it.
    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron);

    /// Whether every cell is its own only piece, with sign +1.
    fn is_convex(&self) -> bool {
        true
    }

    /// Visits the signed convex pieces of `cell` ∩ Ω, in coordinates relative to `site`.
    fn pieces(
        &self,
        _site: &Point3<f64>,
        cell: &Polyhedron,
        _scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, &Polyhedron),
    ) {
        visit(1.0, cell);
    }
}

/// The memory of [`Domain::pieces`], to be reused from one cell to the next.
#[derive(Clone, Debug, Default)]
pub struct PieceScratch {
    /// The piece under construction.
    pub piece: Polyhedron,
    /// The memory of its clips.
    pub clip: ClipScratch,
}

/// The displacement from `from` to `to`, the shortest one along periodic axes.
#[must_use]
pub fn displacement(
    periods: &[Option<f64>; 3],
    from: &Point3<f64>,
    to: &Point3<f64>,
) -> Vector3<f64> {
    let mut displacement = to - from;
    for axis in 0..3 {
        if let Some(period) = periods[axis] {
            displacement[axis] -= period * (displacement[axis] / period).round();
        }
    }
    displacement
}
