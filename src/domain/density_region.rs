//! Boxes with densities: one for all of space, or many in which the density of a size is a parabola.
//!
//! Cells of edge h everywhere need the density ρ = h^−(3+p), which is no polynomial although h is
//! one. So the domain is cut into boxes in which ρ changes by at most a factor of two, bounded by
//! the Bernstein form of h; in each, ρ is the parabola in h through its values at both ends and in the
//! middle of h's range there, again a polynomial. It is within half a percent of h^−(3+p), so that
//! edges are right to a part in eight hundred; integrals of that parabola are exact.

use std::sync::Arc;

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::domain::error::DomainError;
use crate::domain::shape::DomainShape;
use crate::domain::shape_integrator::ShapeIntegrator;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::polynomial::Polynomial;

/// The largest factor by which the density of a size may change within a box.
const LARGEST_CHANGE: f64 = 2.0;

/// The highest degree of a size: the density has twice that, the highest degree of integrals.
const HIGHEST_DEGREE: u32 = 8;

/// How often a box is halved at most for a size: sizes that need more come within a millionth of zero.
const SIZE_HALVINGS: u32 = 24;

/// The largest number of boxes: every cell is compared with each of them.
pub(crate) const MOST_REGIONS: usize = 4096;

/// A box, open to infinity where it ends with the domain, cut by planes, and the density there.
#[derive(Clone, Debug)]
pub(crate) struct DensityRegion {
    pub(crate) bounds: Bounds<3>,
    /// The region lies in all of these.
    pub(crate) planes: Vec<HalfSpace>,
    density: RegionDensity,
    /// No less than the density in the region.
    greatest: f64,
}

/// A density in a box.
#[derive(Clone, Debug)]
enum RegionDensity {
    Polynomial(Arc<Polynomial>),
    /// A polynomial in y − center.
    Around(Arc<Polynomial>, Point3<f64>),
    /// The parabola in the size through size^−exponent at the ends of `range` and in its middle.
    OfSize {
        size: Arc<Polynomial>,
        range: [f64; 2],
        exponent: i32,
    },
}

impl DensityRegion {
    /// All of space.
    pub(crate) fn everywhere(density: Polynomial) -> Self {
        Self::within(everywhere(), Vec::new(), density, f64::INFINITY)
    }

    /// The part of a box that lies in half-spaces; there the density is at most `greatest`.
    pub(crate) fn within(
        bounds: Bounds<3>,
        planes: Vec<HalfSpace>,
        density: Polynomial,
        greatest: f64,
    ) -> Self {
        Self {
            bounds,
            planes,
            density: RegionDensity::Polynomial(Arc::new(density)),
            greatest,
        }
    }

    /// A box in which the density is a polynomial in y − `center` of at most `greatest`.
    pub(crate) fn around(
        bounds: Bounds<3>,
        center: Point3<f64>,
        density: Polynomial,
        greatest: f64,
    ) -> Self {
        Self {
            bounds,
            planes: Vec::new(),
            density: RegionDensity::Around(Arc::new(density), center),
            greatest,
        }
    }

    /// The density as a polynomial in y − `origin`.
    pub(crate) fn about(&self, origin: &Point3<f64>) -> Polynomial {
        match &self.density {
            RegionDensity::Polynomial(polynomial) => polynomial.relative_to(origin),
            RegionDensity::Around(polynomial, center) => {
                polynomial.relative_to(&Point3::from(origin - center))
            }
            RegionDensity::OfSize {
                size,
                range,
                exponent,
            } => parabola(&size.relative_to(origin), *range, *exponent),
        }
    }

    /// No less than the density anywhere in the part of the box within `bounds`.
    pub(crate) fn upper_bound(&self, bounds: &Bounds<3>) -> f64 {
        match &self.density {
            RegionDensity::Polynomial(polynomial) => {
                let within = self.bounds.intersection(bounds);
                Bernstein::new(polynomial, &within).range()[1].min(self.greatest)
            }
            RegionDensity::Around(..) => self.greatest,
            // The parabola falls with the size.
            RegionDensity::OfSize {
                range, exponent, ..
            } => range[0].powi(-exponent),
        }
    }
}

/// The box that is all of space.
pub(crate) fn everywhere() -> Bounds<3> {
    let Bounds { min, max } = Bounds::empty();
    Bounds { min: max, max: min }
}

/// The boxes and densities for cells whose edge is `size`, of energies of order `order`.
///
/// # Errors
/// When the size is not positive somewhere in the domain, changes too fast, or has too high a
/// degree.
pub(crate) fn regions(
    shape: &dyn DomainShape,
    size: &Polynomial,
    order: u32,
) -> Result<Vec<DensityRegion>, DomainError> {
    let degree = size.degree();
    if degree > HIGHEST_DEGREE {
        let highest = HIGHEST_DEGREE;
        return Err(DomainError::SizeDegree { degree, highest });
    }
    let whole = ShapeIntegrator::new(shape);
    let exponent = 3 + order as i32;
    let change = LARGEST_CHANGE.powf(1.0 / f64::from(exponent));
    let shared = Arc::new(size.clone());
    let mut rest = vec![(Bernstein::new(size, &shape.bounds()), everywhere(), 0)];
    let mut regions = Vec::new();
    while let Some((part, bounds, halvings)) = rest.pop() {
        let [low, high] = part.range();
        if low > 0.0 && high <= low * change {
            let (size, range) = (shared.clone(), [low, high]);
            let density = RegionDensity::OfSize {
                size,
                range,
                exponent,
            };
            regions.push(DensityRegion {
                bounds,
                planes: Vec::new(),
                density,
                greatest: f64::INFINITY,
            });
            continue;
        }
        if low.is_nan() || low <= 0.0 {
            refuse_corners(shape, size, &part)?;
            if !whole.fills_some(&bounds) {
                continue;
            }
        }
        let is_hopeless = halvings == SIZE_HALVINGS || regions.len() + rest.len() >= MOST_REGIONS;
        if high.is_nan() || high <= 0.0 || is_hopeless {
            let value = low.max(0.0);
            return Err(DomainError::SizeTooSteep {
                value,
                change: high - value,
                position: part.bounds().center().into(),
            });
        }
        let axis = part.steepest_axis();
        let middle = part.bounds().center()[axis];
        let [lower, upper] = part.halves(axis);
        let (mut below, mut above) = (bounds, bounds);
        below.max[axis] = middle;
        above.min[axis] = middle;
        rest.push((upper, above, halvings + 1));
        rest.push((lower, below, halvings + 1));
    }
    Ok(regions)
}

/// Refuses a size that is not positive at a corner of the box in the shape.
fn refuse_corners(
    shape: &dyn DomainShape,
    size: &Polynomial,
    part: &Bernstein,
) -> Result<(), DomainError> {
    let mut corners = part.corners().map(|(corner, _)| (corner, size.at(&corner)));
    let refused = corners.find(|(corner, value)| {
        let is_positive = *value > 0.0;
        !is_positive && shape.contains(corner)
    });
    match refused {
        Some((corner, value)) => Err(DomainError::Size {
            value,
            position: corner.into(),
        }),
        None => Ok(()),
    }
}

/// The parabola in h through h^−exponent at `low`, `high` and between, with `size` for h.
fn parabola(size: &Polynomial, [low, high]: [f64; 2], exponent: i32) -> Polynomial {
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let [a, b, c] = [low, middle, high].map_each(|h| h.powi(-exponent));
    if half <= 0.0 {
        return Polynomial::constant(b);
    }
    // In u = (h − middle)/half: b + (c − a)/2 u + (a − 2b + c)/2 u².
    let u = (size.clone() + Polynomial::constant(-middle)) * Polynomial::constant(1.0 / half);
    let square = u.clone() * u.clone();
    Polynomial::constant(b)
        + u * Polynomial::constant(0.5 * (c - a))
        + square * Polynomial::constant(0.5 * (a - 2.0 * b + c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::cuboid::Cuboid;

    #[test]
    fn densities_are_those_of_the_size_everywhere() {
        for (text, order) in [
            ("0.1 + 0.2*x", 1),
            ("0.05 + 0.1*(x - 0.5)^2 + 0.1*y*z", 1),
            ("0.3", 1),
            ("0.2 - 0.1*z", 4),
        ] {
            let size: Polynomial = text.parse().expect("a polynomial");
            let regions = regions(&Cuboid::unit(), &size, order).expect("it is positive");
            for k in 0..1000_u32 {
                let share = |k: u32| (f64::from(k) + 0.5) / 10.0;
                let place = Point3::new(share(k % 10), share(k / 10 % 10), share(k / 100));
                let mut here = regions.iter().filter(|part| part.bounds.contains(&place));
                let region = here.next().expect("boxes fill the domain");
                let density = region.about(&Point3::origin()).at(&place);
                let wanted = size.at(&place).powi(-3 - order as i32);
                assert!((density / wanted - 1.0).abs() < 6e-3, "{text} at {place}");
                let bound = region.upper_bound(&Cuboid::unit().bounds());
                assert!(density <= bound * (1.0 + 1e-12));
            }
        }
    }

    #[test]
    fn sizes_that_reach_zero_are_refused() {
        for text in ["x", "0.1 - x", "(x - 0.3)^2", "(x - 0.5)^2", "-1"] {
            let size: Polynomial = text.parse().expect("a polynomial");
            let refused = regions(&Cuboid::unit(), &size, 1)
                .expect_err(text)
                .to_string();
            assert!(refused.contains("size"), "{text}: {refused}");
        }
    }
}
