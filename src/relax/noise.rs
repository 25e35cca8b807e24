//! Seeded noise: the same on every machine, and in a run that was interrupted.

use nalgebra::{Point3, Vector3};

use crate::geometry::random::Random;
use crate::relax::space::Space;
use crate::relax::tessellation::Tessellation;

/// A displacement that leaves the domain is halved at most so often, then given up.
const HALVINGS: u32 = 8;

/// Displaces the sites of which `is_moved` by Gaussian noise of standard deviation `deviation` (L)
/// along every axis, within the domain.
pub(crate) fn shake(
    space: &Space,
    sites: &mut [Point3<f64>],
    deviation: f64,
    random: &mut Random,
    is_moved: impl Fn(usize) -> bool,
) {
    for (number, site) in sites.iter_mut().enumerate() {
        let noise = Vector3::from([0; 3].map(|_| random.gaussian())) * deviation;
        if is_moved(number) {
            *site = displaced(space, site, noise);
        }
    }
}

/// `site` moved by `way`, or by as much of it as keeps it in the domain and off its box's faces,
/// where sites of other rows might meet it.
pub(crate) fn displaced(space: &Space, site: &Point3<f64>, mut way: Vector3<f64>) -> Point3<f64> {
    let bounds = space.bounds();
    let periods = space.domain().periods();
    for _ in 0..HALVINGS {
        let moved = site + way;
        let off_walls = (0..3).all(|axis| {
            periods[axis].is_some()
                || (bounds.min[axis] < moved[axis] && moved[axis] < bounds.max[axis])
        });
        let wrapped = space.domain().wrap(&moved);
        if off_walls && space.domain().contains(&wrapped) {
            return wrapped;
        }
        way *= 0.5;
    }
    *site
}
