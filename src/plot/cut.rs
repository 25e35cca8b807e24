//! A plane cut through cells in space, flattened for [`crate::plot::patches`].

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::half_space::HalfSpace;
use crate::geometry::section::section;
use crate::geometry::shell::Shell;
use crate::plot::patches::Patch;

/// A plane with two directions in it: what is right and what is up for someone who looks at it
/// against its normal.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    plane: HalfSpace,
    right: Vector3<f64>,
    up: Vector3<f64>,
}

impl Cut {
    /// The cut along the border of `plane`, seen from where its normal points. Up is the direction
    /// nearest to +z; for a horizontal plane it is +y and right is +x.
    ///
    /// A plane without a normal cuts nothing.
    #[must_use]
    pub fn new(plane: HalfSpace) -> Self {
        let plane = plane.normalized();
        let normal = plane.normal;
        let horizontal = normal.x.hypot(normal.y) < 1e-9 * normal.z.abs();
        let upward = if horizontal {
            Vector3::y()
        } else {
            Vector3::z()
        };
        let up = upward - upward.dot(&normal) * normal;
        let up = up.try_normalize(0.0).unwrap_or(upward);
        Self {
            plane,
            right: up.cross(&normal),
            up,
        }
    }

    /// The horizontal cut at height `z`, seen from above.
    #[must_use]
    pub fn horizontal(z: f64) -> Self {
        Self::new(HalfSpace {
            normal: Vector3::z(),
            offset: z,
        })
    }

    /// What the cut shows of a cell; `None` where it misses it.
    #[must_use]
    pub fn patch(&self, shell: &Shell, value: f64) -> Option<Patch> {
        let flat = |point: &Point3<f64>| {
            Point2::new(self.right.dot(&point.coords), self.up.dot(&point.coords))
        };
        let contours: Vec<Vec<Point2<f64>>> = section(shell, &self.plane)
            .iter()
            .map(|contour| contour.iter().map(flat).collect())
            .collect();
        (!contours.is_empty()).then_some(Patch {
            contours,
            value,
            site: None,
        })
    }
}
