//! Which sites have no diagram: not finite, outside the domain, two at one place.

use std::cmp::Ordering;

use nalgebra::Point;
use rayon::slice::ParallelSliceMut;

use crate::scene::error::Error;
use crate::scene::region::Region;

/// Refuses sites that have no diagram.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::Outside`] or [`Error::Duplicate`], in that order, with the
/// lowest index and the number of further ones.
pub fn sites<const D: usize>(sites: &[Point<f64, D>], region: &Region<'_, D>) -> Result<(), Error> {
    finite(sites)?;
    inside(sites, region)?;
    distinct(sites, region)
}

/// A point as messages show it: `(0.5, 0.25, 1.0)`.
#[must_use]
pub fn shown<const D: usize>(point: &Point<f64, D>) -> String {
    let numbers: Vec<String> = point.iter().map(|value| format!("{value:?}")).collect();
    format!("({})", numbers.join(", "))
}

fn finite<const D: usize>(sites: &[Point<f64, D>]) -> Result<(), Error> {
    let strange = |site: &Point<f64, D>| site.iter().any(|value| !value.is_finite());
    match sites.iter().position(strange) {
        Some(index) => Err(Error::NotFinite {
            index,
            point: shown(&sites[index]),
        }),
        None => Ok(()),
    }
}

fn inside<const D: usize>(sites: &[Point<f64, D>], region: &Region<'_, D>) -> Result<(), Error> {
    let outside = |&index: &usize| !region.holds(&sites[index]);
    let mut strays = (0..sites.len()).filter(outside);
    match strays.next() {
        Some(index) => Err(Error::Outside {
            index,
            point: shown(&sites[index]),
            others: strays.count(),
        }),
        None => Ok(()),
    }
}

fn distinct<const D: usize>(sites: &[Point<f64, D>], region: &Region<'_, D>) -> Result<(), Error> {
    let key = |index: usize| region.canonical(&sites[index]);
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.par_sort_unstable_by(|&a, &b| lexicographic(&key(a), &key(b)).then(a.cmp(&b)));
    let twins = || {
        order
            .windows(2)
            .filter(|pair| lexicographic(&key(pair[0]), &key(pair[1])) == Ordering::Equal)
    };
    match twins().min_by_key(|pair| pair[1]) {
        Some(pair) => Err(Error::Duplicate {
            first: pair[0],
            second: pair[1],
            point: shown(&sites[pair[1]]),
            others: twins().count() - 1,
        }),
        None => Ok(()),
    }
}

/// Compares finite points axis by axis; −0 equals 0.
fn lexicographic<const D: usize>(a: &Point<f64, D>, b: &Point<f64, D>) -> Ordering {
    let axes = a.iter().zip(b.iter());
    axes.fold(Ordering::Equal, |order, (a, b)| {
        order.then_with(|| a.partial_cmp(b).unwrap_or(Ordering::Equal))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use nalgebra::Point2;

    fn check(points: &[[f64; 2]], periodic: bool) -> Result<(), Error> {
        let bounds = Bounds {
            min: Point2::new(0.0, 0.0),
            max: Point2::new(1.0, 1.0),
        };
        let points: Vec<Point2<f64>> = points.iter().copied().map(Point2::from).collect();
        sites(&points, &Region::of_box(bounds, [periodic, false]))
    }

    #[test]
    fn good_sites_pass() {
        check(&[[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]], false).expect("walls belong to the box");
    }

    #[test]
    fn duplicates_are_named_by_both_indices() {
        let points = [[0.5, 0.5], [0.1, 0.2], [0.3, 0.0], [0.1, 0.2], [0.3, -0.0]];
        let error = check(&points, false).unwrap_err().to_string();
        assert_eq!(
            error,
            "sites 1 and 3 are at the same place (0.1, 0.2) (and 1 more such sites); \
             remove one of them"
        );
    }

    #[test]
    fn opposite_walls_of_a_periodic_axis_are_one_place() {
        let points = [[0.0, 0.5], [1.0, 0.5]];
        check(&points, false).expect("two walls");
        let error = check(&points, true).unwrap_err();
        assert!(
            matches!(
                error,
                Error::Duplicate {
                    first: 0,
                    second: 1,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn strays_are_named_by_index_and_point() {
        let error = check(&[[0.5, 0.5], [1.5, 0.2], [-1.0, 0.0]], false).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("site 1 (1.5, 0.2) lies outside the domain (and 1 more"),
            "{text}"
        );
    }

    #[test]
    fn strange_numbers_are_refused() {
        let error = check(&[[0.5, 0.5], [f64::NAN, 0.2]], false).unwrap_err();
        assert_eq!(error.to_string(), "site 1 (NaN, 0.2) is not finite");
        assert!(check(&[[f64::INFINITY, 0.2]], false).is_err());
    }
}
