//! Uniform random sites, the same on every machine.

use nalgebra::Point;

use crate::geometry::random::Random;
use crate::scene::error::Error;
use crate::scene::region::Region;

/// So many draws in a row may miss the domain: it then fills less than a millionth of its
/// bounding box.
const MISSES_ALLOWED: u64 = 10_000_000;

/// `count` sites uniform over the region, by rejection from its bounding box.
///
/// # Errors
/// [`Error::NoRoom`] when the region fills next to nothing of its bounding box.
pub fn sites<const D: usize>(
    count: usize,
    seed: u64,
    region: &Region<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let mut random = Random::new(seed);
    let mut sites = Vec::new();
    let mut misses = 0;
    while sites.len() < count {
        let point = random.point(&region.bounds);
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
    use crate::geometry::bounds::Bounds;
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
