//! Sites on a grid, jittered if told.
//!
//! The grid's box is the domain's bounding box; grid cell (i, j, k) has its middle at
//! min + ((i, j, k) + 1/2) · spacing. A site is uniform in the box about the middle that is
//! `jitter` grid cells wide, so along every axis at most `jitter`/2 of a grid cell from it. The
//! last axis runs fastest.

use nalgebra::Point;

use crate::geometry::random::Random;
use crate::scene::error::Error;
use crate::scene::region::Region;
use crate::scene::sites::Grid;

/// The grid's sites that the region holds.
///
/// # Errors
/// [`Error::EmptyGrid`] when there is none.
pub fn sites<const D: usize>(
    grid: &Grid,
    region: &Region<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let mut uniform = Random::new(grid.seed);
    let mut sites = Vec::new();
    let mut at = [0; D];
    loop {
        let site = jittered(&at, grid, region, &mut uniform);
        if region.holds(&site) {
            sites.push(site);
        }
        if !advance(&mut at, &grid.counts) {
            break;
        }
    }
    if sites.is_empty() {
        return Err(Error::EmptyGrid);
    }
    Ok(sites)
}

fn jittered<const D: usize>(
    at: &[usize; D],
    grid: &Grid,
    region: &Region<'_, D>,
    uniform: &mut Random,
) -> Point<f64, D> {
    let extent = region.bounds.extent();
    let mut site = region.bounds.min;
    for axis in 0..D {
        let shift = grid.jitter * (uniform.uniform() - 0.5);
        let steps = at[axis] as f64 + 0.5 + shift;
        site[axis] += steps * extent[axis] / grid.counts[axis] as f64;
    }
    region.bounds.clamp(&site)
}

/// The next grid cell; false after the last.
fn advance<const D: usize>(at: &mut [usize; D], counts: &[usize]) -> bool {
    for axis in (0..D).rev() {
        at[axis] += 1;
        if at[axis] < counts[axis] {
            return true;
        }
        at[axis] = 0;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use nalgebra::Point2;

    fn region() -> Region<'static, 2> {
        let bounds = Bounds {
            min: Point2::new(0.0, 1.0),
            max: Point2::new(2.0, 2.0),
        };
        Region::of_box(bounds, [false; 2])
    }

    fn grid(jitter: f64) -> Grid {
        Grid {
            counts: vec![2, 2],
            jitter,
            seed: 1,
        }
    }

    #[test]
    fn without_jitter_sites_stand_in_the_middle() {
        let sites = sites(&grid(0.0), &region()).expect("a box holds its grid");
        let expected = [[0.5, 1.25], [0.5, 1.75], [1.5, 1.25], [1.5, 1.75]];
        assert_eq!(sites, expected.map(Point2::from));
    }

    #[test]
    fn jitter_is_the_width_of_the_spread() {
        let exact = sites(&grid(0.0), &region()).expect("a box holds its grid");
        let moved = sites(&grid(0.5), &region()).expect("a box holds its grid");
        for (from, to) in exact.iter().zip(&moved) {
            let step = to - from;
            assert!(step.x.abs() <= 0.25 && step.y.abs() <= 0.125, "{step}");
            assert!(step.x != 0.0 && step.y != 0.0);
        }
    }

    #[test]
    fn the_grid_is_cropped_to_the_region() {
        let left = Region {
            contains: Box::new(|point: &Point2<f64>| point.x < 1.0),
            ..region()
        };
        assert_eq!(sites(&grid(0.0), &left).expect("two remain").len(), 2);
        let nothing = Region {
            contains: Box::new(|_| false),
            ..region()
        };
        assert!(matches!(sites(&grid(0.0), &nothing), Err(Error::EmptyGrid)));
    }
}
