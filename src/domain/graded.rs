//! From a wanted edge length to a density.
//!
//! Cells of edge h everywhere want the density ρ = h^−(3+p), which is no polynomial although h is
//! one. So the domain is cut into boxes in which ρ changes by at most a factor of two, told by the
//! Bernstein form of h; in each, ρ is the parabola in h through its values at both ends and in the
//! middle of h's range there, again a polynomial. It is within half a percent of h^−(3+p), so that
//! edges are right to a part in eight hundred, and integrals over it are as exact as over any other.

use crate::domain::error::DomainError;
use crate::domain::space::Domain;
use crate::domain::within::{holds_some, start_of_all};
use crate::geometry::bounds::Bounds;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::polynomial::Polynomial;

/// By how much the density may change within a box.
const LARGEST_CHANGE: f64 = 2.0;

/// Sizes of a higher degree make densities of more than the highest degree that integrals know.
const HIGHEST_DEGREE: u32 = 8;

/// A box is halved so often at most: lengths that need more come within a millionth of zero.
const MOST_HALVINGS: u32 = 24;

/// So many boxes at most: every cell asks each of them.
const MOST_REGIONS: usize = 4096;

/// A box, open to infinity where it ends with the domain, and the density there.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) bounds: Bounds<3>,
    pub(crate) density: Polynomial,
}

impl Region {
    /// All of space.
    pub(crate) fn everywhere(density: Polynomial) -> Self {
        let Bounds { min, max } = Bounds::empty();
        let bounds = Bounds { min: max, max: min };
        Self { bounds, density }
    }
}

/// The boxes and densities for cells whose edge is `size`, of energies of order `order`.
///
/// # Errors
/// When the size is not positive somewhere in the domain, changes too fast, or has too high a
/// degree.
pub(crate) fn regions(
    domain: &dyn Domain,
    size: &Polynomial,
    order: u32,
) -> Result<Vec<Region>, DomainError> {
    let degree = size.degree();
    if degree > HIGHEST_DEGREE {
        let highest = HIGHEST_DEGREE;
        return Err(DomainError::SizeDegree { degree, highest });
    }
    let start = start_of_all(domain);
    let exponent = 3 + order as i32;
    let change = LARGEST_CHANGE.powf(1.0 / f64::from(exponent));
    let whole = Bernstein::new(size, &domain.bounds());
    let all = Region::everywhere(Polynomial::default()).bounds;
    let mut rest = vec![(whole, all, 0)];
    let mut regions = Vec::new();
    while let Some((part, bounds, halvings)) = rest.pop() {
        let [low, high] = part.range();
        if low > 0.0 && high <= low * change {
            let density = parabola(size, low, high, exponent);
            regions.push(Region { bounds, density });
            continue;
        }
        if low <= 0.0 {
            refuse_not_positive(domain, &part)?;
            if !holds_some(domain, &start, &bounds) {
                continue;
            }
        }
        if high <= 0.0 || halvings == MOST_HALVINGS || regions.len() + rest.len() >= MOST_REGIONS {
            let position = part.bounds().center().into();
            let (value, change) = (low.max(0.0), high - low.max(0.0));
            return Err(DomainError::SizeTooSteep {
                value,
                change,
                position,
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

/// Refuses a size that is not positive at a corner of the box that the domain holds.
fn refuse_not_positive(domain: &dyn Domain, part: &Bernstein) -> Result<(), DomainError> {
    let mut corners = part.corners();
    match corners.find(|(corner, value)| *value <= 0.0 && domain.contains(corner)) {
        Some((corner, value)) => Err(DomainError::Size {
            value,
            position: corner.into(),
        }),
        None => Ok(()),
    }
}

/// The parabola in h through h^−exponent at `low`, `high` and between, with `size` for h.
fn parabola(size: &Polynomial, low: f64, high: f64, exponent: i32) -> Polynomial {
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let [a, b, c] = [low, middle, high].map(|h| h.powi(-exponent));
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
    use nalgebra::Point3;

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
                let density = here
                    .next()
                    .expect("boxes fill the domain")
                    .density
                    .at(&place);
                let wanted = size.at(&place).powi(-3 - order as i32);
                assert!((density / wanted - 1.0).abs() < 6e-3, "{text} at {place}");
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
