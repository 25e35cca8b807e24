//! Any positive density as cubic polynomials in boxes, with a measured error.
//!
//! In a box the density is interpolated in Chebyshev's nodes, four along each axis, and terms of a higher
//! degree than three are left out. The error is the largest difference at other points of a grid, relative
//! to the largest value in the box; the worst box is halved until all are within the tolerance or there
//! are too many. Boxes that the shape does not meet are left as they are.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::density_power::{NODES, along, each, nodes};
use crate::domain::density_region::{DensityRegion, MOST_REGIONS, everywhere};
use crate::domain::error::DomainError;
use crate::domain::shape::DomainShape;
use crate::domain::shape_integrator::ShapeIntegrator;
use crate::geometry::bounds::Bounds;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::polynomial::Polynomial;

/// The error within which boxes are no longer halved.
const TOLERANCE: f64 = 5e-3;

/// Errors are relative to the largest value in the box, or to this share of the largest of all.
const FLOOR: f64 = 0.01;

/// The highest degree of a term.
const DEGREE: usize = 3;

/// Points of the grid along each axis.
const GRID: usize = 6;

/// A density as polynomials in boxes.
#[derive(Debug)]
pub(crate) struct FittedDensity {
    pub(crate) regions: Vec<DensityRegion>,
    /// The largest error that was found, relative to the largest value in its box.
    pub(crate) error: f64,
}

/// A box with its polynomial in y − middle; those of the largest error first.
struct FittedBox {
    /// Finite.
    bounds: Bounds<3>,
    /// The same, open where it ends with the shape's box.
    open: Bounds<3>,
    fit: Polynomial,
    error: f64,
    greatest: f64,
    /// The axis along which the interpolation is worst.
    axis: usize,
}

impl Ord for FittedBox {
    fn cmp(&self, other: &Self) -> Ordering {
        self.error.total_cmp(&other.error)
    }
}

impl PartialOrd for FittedBox {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for FittedBox {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for FittedBox {}

/// `density` over `shape` as cubics in boxes.
///
/// # Errors
/// When the density is negative or no number somewhere in the shape.
pub(crate) fn fitted(
    shape: &dyn DomainShape,
    density: &dyn Fn(&Point3<f64>) -> f64,
) -> Result<FittedDensity, DomainError> {
    let whole = ShapeIntegrator::new(shape);
    let bounds = shape.bounds();
    let greatest = grid(&bounds).map(|place| density(&place));
    let floor = FLOOR
        * greatest
            .filter(|value| value.is_finite())
            .fold(0.0, f64::max);
    let mut boxes = BinaryHeap::from([fit(bounds, everywhere(), density, floor)]);
    let mut done = Vec::new();
    while boxes.len() + done.len() < MOST_REGIONS {
        let Some(worst) = boxes.pop() else { break };
        if worst.error <= TOLERANCE || !whole.fills_some(&worst.bounds) {
            done.push(worst);
            continue;
        }
        for [bounds, open] in halves(&worst) {
            boxes.push(fit(bounds, open, density, floor));
        }
    }
    done.extend(boxes);
    refuse_values(shape, density, &done)?;
    let met = |part: &&FittedBox| part.error <= TOLERANCE || whole.fills_some(&part.bounds);
    let errors = done.iter().filter(met).map(|part| part.error);
    Ok(FittedDensity {
        error: errors.fold(0.0, f64::max),
        regions: done.into_iter().map(region).collect(),
    })
}

/// The two halves of a box along its worst axis, finite and open.
fn halves(part: &FittedBox) -> [[Bounds<3>; 2]; 2] {
    let middle = part.bounds.center()[part.axis];
    let (mut below, mut above) = ([part.bounds, part.open], [part.bounds, part.open]);
    for bounds in &mut below {
        bounds.max[part.axis] = middle;
    }
    for bounds in &mut above {
        bounds.min[part.axis] = middle;
    }
    [below, above]
}

/// The interpolation in one box.
fn fit(
    bounds: Bounds<3>,
    open: Bounds<3>,
    density: &dyn Fn(&Point3<f64>) -> f64,
    floor: f64,
) -> FittedBox {
    let (center, half) = (bounds.center(), bounds.extent() * 0.5);
    let mut values = [[[0.0; NODES]; NODES]; NODES];
    each(|[i, j, k]| {
        let at = nodes();
        let arm = half.component_mul(&Vector3::new(at[i], at[j], at[k]));
        values[i][j][k] = density(&(center + arm));
    });
    for axis in 0..3 {
        along(&mut values, axis);
    }
    let (mut terms, mut last) = (Vec::new(), Vector3::<f64>::zeros());
    each(|powers| {
        let value = values[powers[0]][powers[1]][powers[2]];
        for axis in 0..3 {
            last[axis] += value.abs() * powers[axis].saturating_sub(1) as f64 * half[axis];
        }
        if powers.iter().sum::<usize>() <= DEGREE {
            let scale = (0..3).map(|axis| half[axis].powi(powers[axis] as i32));
            terms.push((
                powers.map_each(|p| p as u32),
                value / scale.product::<f64>(),
            ));
        }
    });
    let fit = Polynomial::from_terms(terms);
    let (mut error, mut greatest) = (0.0_f64, 0.0_f64);
    for place in grid(&bounds) {
        let value = density(&place);
        error = error.max((fit.at(&(place - center).into()) - value).abs());
        greatest = greatest.max(value);
    }
    FittedBox {
        bounds,
        open,
        fit,
        error: error / greatest.max(floor).max(f64::MIN_POSITIVE),
        greatest,
        axis: last.imax(),
    }
}

/// The points of a grid over a box, its corners among them.
fn grid(bounds: &Bounds<3>) -> impl Iterator<Item = Point3<f64>> + use<> {
    let bounds = *bounds;
    (0..GRID.pow(3)).map(move |number| {
        let steps = [number / (GRID * GRID), number / GRID % GRID, number % GRID];
        let share = Vector3::from(steps.map_each(|step| step as f64 / (GRID - 1) as f64));
        bounds.min + bounds.extent().component_mul(&share)
    })
}

/// Refuses a density that is negative or no number at a point of a grid in the shape.
fn refuse_values(
    shape: &dyn DomainShape,
    density: &dyn Fn(&Point3<f64>) -> f64,
    boxes: &[FittedBox],
) -> Result<(), DomainError> {
    let places = boxes.iter().flat_map(|part| grid(&part.bounds));
    let mut values = places.map(|place| (density(&place), place));
    let refused = values.find(|(value, place)| {
        let is_sound = value.is_finite() && *value >= 0.0;
        !is_sound && shape.contains(place)
    });
    match refused {
        Some((value, place)) => Err(DomainError::Density {
            value,
            position: place.into(),
        }),
        None => Ok(()),
    }
}

/// The box as a region: raised where its polynomial is not known to be positive.
fn region(part: FittedBox) -> DensityRegion {
    let center = part.bounds.center();
    let local = Bounds {
        min: (part.bounds.min - center).into(),
        max: (part.bounds.max - center).into(),
    };
    let [low, high] = Bernstein::new(&part.fit, &local).range();
    let raised = (-low).max(0.0);
    let fit = part.fit + Polynomial::constant(raised);
    let greatest = (high + raised).min(2.0 * part.greatest + raised);
    DensityRegion::around(part.open, center, fit, greatest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::cuboid::Cuboid;

    #[test]
    fn densities_are_fitted_within_the_error_that_is_told() {
        let origin = Point3::origin();
        for (name, density) in [
            (
                "sine",
                (&|y: &Point3<f64>| 2.0 + (9.0 * y.x + 3.0 * y.y).sin())
                    as &dyn Fn(&Point3<f64>) -> f64,
            ),
            ("size", &|y: &Point3<f64>| (0.1 + 0.2 * y.x).powi(-4)),
            ("cubic", &|y: &Point3<f64>| 1.0 + y.x * y.y * y.z),
        ] {
            let fitted = fitted(&Cuboid::unit(), density).expect("it is positive");
            assert!(fitted.error <= TOLERANCE, "{name}: {}", fitted.error);
            for k in 0..1000_u32 {
                let share = |k: u32| (f64::from(k % 10) + 0.37) / 10.0;
                let place = Point3::new(share(k), share(k / 10), share(k / 100));
                let mut here = fitted
                    .regions
                    .iter()
                    .filter(|it| it.bounds.contains(&place));
                let found = here
                    .next()
                    .expect("boxes fill space")
                    .about(&origin)
                    .at(&place);
                let error = (found / density(&place) - 1.0).abs();
                assert!(error < 3.0 * TOLERANCE, "{name} at {place}: {error}");
            }
        }
    }

    #[test]
    fn a_negative_density_is_refused_with_its_place() {
        let refused = fitted(&Cuboid::unit(), &|y| y.x - 0.5).expect_err("it is negative");
        assert!(matches!(refused, DomainError::Density { value, .. } if value < 0.0));
    }
}
