//! From a scene's `sites` to points, checked.

use nalgebra::Point;

use crate::scene::check;
use crate::scene::error::Error;
use crate::scene::region::Region;
use crate::scene::sites::Sites;
use crate::scene::{grid, random, site_file};

/// The points that `sites` names, in their order, each finite, in the region, and alone at its
/// place. Where told to, those outside the region are left out.
///
/// # Errors
/// When a site file cannot be read, or [`check::sites`] refuses a point.
pub fn place<const D: usize>(
    sites: &Sites,
    region: &Region<'_, D>,
    drop_outside: bool,
) -> Result<Vec<Point<f64, D>>, Error> {
    let mut points: Vec<Point<f64, D>> = match sites {
        Sites::Random(random) => random::sites(random.count, random.seed, region)?,
        Sites::Grid(grid) => grid::sites(grid, region)?,
        Sites::List(list) => list.iter().map(|row| point(row)).collect(),
        Sites::File(path) => site_file::read::sites(path)?,
    };
    if drop_outside {
        points.retain(|point| region.holds(point));
        if points.is_empty() {
            return Err(Error::AllOutside);
        }
    }
    check::sites(&points, region)?;
    Ok(points)
}

/// `row` has `D` numbers: the scene has been validated.
pub(crate) fn point<const D: usize>(row: &[f64]) -> Point<f64, D> {
    Point::from(std::array::from_fn::<f64, D, _>(|axis| row[axis]))
}
