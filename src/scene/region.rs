//! The domain as its sites see it.

use std::fmt;

use nalgebra::Point;

use crate::domain::domain::Domain;
use crate::domain::planar::PlaneDomain;
use crate::geometry::bounds::Bounds;

/// Says whether a point lies in a closed domain.
pub type Contains<'a, const D: usize> = Box<dyn Fn(&Point<f64, D>) -> bool + Sync + 'a>;

/// What placing and checking sites needs to know of a domain.
pub struct Region<'a, const D: usize> {
    /// The domain's bounding box.
    pub bounds: Bounds<D>,
    /// Along which axes the domain repeats itself.
    pub periodic: [bool; D],
    /// Whether the closed domain holds a point.
    pub contains: Contains<'a, D>,
}

impl<const D: usize> Region<'_, D> {
    /// The box `bounds` itself.
    #[must_use]
    pub fn of_box(bounds: Bounds<D>, periodic: [bool; D]) -> Self {
        Self {
            bounds,
            periodic,
            contains: Box::new(move |point| bounds.contains(point)),
        }
    }

    /// The region of a domain in space.
    #[must_use]
    pub fn of_solid(domain: &dyn Domain) -> Region<'_, 3> {
        Region {
            bounds: domain.bounds(),
            periodic: domain.periods().map(|period| period.is_some()),
            contains: Box::new(|point| domain.contains(point)),
        }
    }

    /// The region of a domain in the plane.
    #[must_use]
    pub fn of_plane(domain: &PlaneDomain) -> Region<'_, 2> {
        Region {
            bounds: domain.bounds(),
            periodic: [false; 2],
            contains: Box::new(|point| domain.contains(point)),
        }
    }

    /// Whether the domain holds `point`.
    #[must_use]
    pub fn holds(&self, point: &Point<f64, D>) -> bool {
        (self.contains)(point)
    }

    /// The image of `point` on the lower wall where it lies on the upper wall of a periodic axis.
    #[must_use]
    pub fn canonical(&self, point: &Point<f64, D>) -> Point<f64, D> {
        let mut image = *point;
        for axis in 0..D {
            if self.periodic[axis] && image[axis] >= self.bounds.max[axis] {
                image[axis] = self.bounds.min[axis];
            }
        }
        image
    }
}

impl<const D: usize> fmt::Debug for Region<'_, D> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Region")
            .field("bounds", &self.bounds)
            .field("periodic", &self.periodic)
            .finish_non_exhaustive()
    }
}
