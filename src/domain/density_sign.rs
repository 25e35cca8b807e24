//! Places in a shape at which a density is negative, found by halving the shape's box.
//!
//! A box is done with where Bernstein's bounds are positive, or where it has nothing in common with the
//! shape; a place is found at a corner of a box, or of a box's common part with the shape, in which the
//! polynomial itself is negative. Boxes of the lowest bounds come first, so that a dip is found by a few
//! dozen halvings, however small it is. Where a density touches zero along a surface no bound decides; the
//! search then ends with its budget.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Point3;

use crate::domain::error::DomainError;
use crate::domain::shape::DomainShape;
use crate::domain::shape_integrator::ShapeIntegrator;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::polynomial::Polynomial;

/// How many boxes are halved at most.
const BUDGET: usize = 4096;

/// A lower bound above −`ROUNDING` times the largest value is that of a density that reaches zero.
const ROUNDING: f64 = 1e-13;

/// A part of the box, those of the lowest bound first.
struct SignCandidate {
    part: Bernstein,
    low: f64,
    halvings: u32,
}

impl SignCandidate {
    fn new(part: Bernstein, halvings: u32) -> Self {
        let low = part.range()[0];
        Self {
            part,
            low,
            halvings,
        }
    }
}

impl Ord for SignCandidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.low.total_cmp(&self.low)
    }
}

impl PartialOrd for SignCandidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for SignCandidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for SignCandidate {}

/// Refuses a density that is negative or not finite somewhere in the shape, or zero in a part of it.
///
/// # Errors
/// [`DomainError::Density`] with a place.
pub(crate) fn check_positive(
    shape: &dyn DomainShape,
    density: &Polynomial,
) -> Result<(), DomainError> {
    match refused_place(shape, density) {
        Some((position, value)) => Err(DomainError::Density {
            value,
            position: position.into(),
        }),
        None => Ok(()),
    }
}

/// A place in the shape at which the density is negative or not finite, or the middle of a box in which
/// it is nowhere positive, with its value.
pub(crate) fn refused_place(
    shape: &dyn DomainShape,
    density: &Polynomial,
) -> Option<(Point3<f64>, f64)> {
    let whole = ShapeIntegrator::new(shape);
    let all = Bernstein::new(density, &shape.bounds());
    let [low, high] = all.range();
    let scale = high.abs().max(low.abs());
    if !scale.is_finite() {
        return Some((
            shape.bounds().center(),
            density.at(&shape.bounds().center()),
        ));
    }
    let mut rest = BinaryHeap::from([SignCandidate::new(all, 0)]);
    for _ in 0..BUDGET {
        let SignCandidate {
            part,
            low,
            halvings,
        } = rest.pop()?;
        let high = part.range()[1];
        if low >= 0.0 && high > 0.0 {
            continue;
        }
        if let Some(place) = negative_corner(&whole, density, &part, scale) {
            return Some(place);
        }
        if high <= 0.0 {
            let middle = part.bounds().center();
            if whole.fills_some(part.bounds()) {
                return Some((middle, density.at(&middle)));
            }
            continue;
        }
        // Every third halving has halved all axes.
        if halvings % 3 == 0 {
            let points = whole.points_within(part.bounds());
            if points.is_empty() {
                continue;
            }
            let mut points = points.into_iter();
            if let Some(place) = points.find_map(|point| negative(&whole, density, &point)) {
                return Some(place);
            }
        }
        if low < -ROUNDING * scale {
            let halves = part.halves(part.steepest_axis()).into_iter();
            rest.extend(halves.map(|half| SignCandidate::new(half, halvings + 1)));
        }
    }
    None
}

/// A corner of the box in the shape at which the density is negative.
fn negative_corner(
    whole: &ShapeIntegrator<'_>,
    density: &Polynomial,
    part: &Bernstein,
    scale: f64,
) -> Option<(Point3<f64>, f64)> {
    let doubtful = part
        .corners()
        .filter(|(_, value)| *value < ROUNDING * scale);
    let mut corners = doubtful.map(|(corner, _)| corner);
    corners.find_map(|corner| negative(whole, density, &corner))
}

/// The point and the density there, if that is negative and the point lies in the shape.
fn negative(
    whole: &ShapeIntegrator<'_>,
    density: &Polynomial,
    point: &Point3<f64>,
) -> Option<(Point3<f64>, f64)> {
    let value = density.at(point);
    let is_found = value < 0.0 && whole.shape.contains(point);
    is_found.then_some((*point, value))
}
