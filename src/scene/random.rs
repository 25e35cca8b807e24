//! Uniform random sites, the same on every machine.
//!
//! ChaCha8 seeded by its `seed_from_u64` gives the bits; the upper 53 of every 64 become a
//! number in [0, 1) here and not in a distribution crate, so that a seed keeps its sites when
//! such a crate changes.

use nalgebra::Point;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::geometry::bounds::Bounds;
use crate::scene::error::Error;
use crate::scene::region::Region;

/// So many draws in a row may miss the domain: it then fills less than a millionth of its
/// bounding box.
const MISSES_ALLOWED: u64 = 10_000_000;

/// A stream of numbers uniform in [0, 1), fixed by its seed.
#[derive(Clone, Debug)]
pub struct Uniform(ChaCha8Rng);

impl Uniform {
    /// The stream of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// The next number: a multiple of 2⁻⁵³ in [0, 1).
    pub fn number(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// The next point of a box, axis by axis.
    pub fn point<const D: usize>(&mut self, bounds: &Bounds<D>) -> Point<f64, D> {
        let extent = bounds.extent();
        let mut point = bounds.min;
        for axis in 0..D {
            point[axis] += self.number() * extent[axis];
        }
        bounds.clamp(&point)
    }
}

/// `count` sites uniform over the region, by rejection from its bounding box.
///
/// # Errors
/// [`Error::NoRoom`] when the region fills next to nothing of its bounding box.
pub fn sites<const D: usize>(
    count: usize,
    seed: u64,
    region: &Region<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let mut uniform = Uniform::new(seed);
    let mut sites = Vec::new();
    let mut misses = 0;
    while sites.len() < count {
        let point = uniform.point(&region.bounds);
        if region.holds(&point) {
            sites.push(point);
            misses = 0;
        } else if misses < MISSES_ALLOWED {
            misses += 1;
        } else {
            return Err(Error::NoRoom { draws: misses });
        }
    }
    Ok(sites)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point2, Point3};

    fn cube() -> Bounds<3> {
        Bounds {
            min: Point3::new(0.0, 0.0, 0.0),
            max: Point3::new(1.0, 1.0, 1.0),
        }
    }

    #[test]
    fn a_seed_keeps_its_sites() {
        let region = Region::of_box(cube(), [false; 3]);
        let first = sites(2, 1, &region).expect("a cube has room");
        assert_eq!(first, sites(2, 1, &region).expect("a cube has room"));
        assert_ne!(first, sites(2, 2, &region).expect("a cube has room"));
        assert_eq!(
            format!("{:?}", first[0]),
            PINNED,
            "written down once, on x86-64"
        );
    }

    const PINNED: &str = "[0.40248566366484806, 0.08038370892978197, 0.5965601809348549]";

    #[test]
    fn numbers_fill_the_unit_interval_evenly() {
        let mut uniform = Uniform::new(3);
        let mut bins = [0_u32; 10];
        for _ in 0..10_000 {
            bins[(uniform.number() * 10.0) as usize] += 1;
        }
        // The standard deviation of a bin is 30.
        assert!(bins.iter().all(|&bin| bin.abs_diff(1000) < 150), "{bins:?}");
    }

    #[test]
    fn rejection_keeps_to_the_region() {
        let triangle = |point: &Point2<f64>| point.x + point.y <= 1.0;
        let region = Region {
            bounds: Bounds {
                min: Point2::new(0.0, 0.0),
                max: Point2::new(1.0, 1.0),
            },
            periodic: [false; 2],
            contains: Box::new(triangle),
        };
        let sites = sites(500, 1, &region).expect("half of the square is room");
        assert_eq!(sites.len(), 500);
        assert!(sites.iter().all(triangle));
    }

    #[test]
    fn a_region_without_room_is_refused() {
        let region = Region {
            contains: Box::new(|_| false),
            ..Region::of_box(cube(), [false; 3])
        };
        assert!(matches!(sites(1, 1, &region), Err(Error::NoRoom { .. })));
    }
}
