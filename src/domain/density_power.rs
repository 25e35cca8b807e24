//! ∫ ρ^s over a domain for 0 < s < 1, of which there is no closed form, with an estimate of the error.
//!
//! Of s = D/(D+p) it gives the asymptotically least energy of order p (Gersho, *Asymptotically optimal block
//! quantization*, 1979): n cells that are cubes of volume ∝ ρ^−s have together D/(D+p) 2^−p n^−p/D (∫ ρ^s)^(1/s).
//!
//! In boxes ρ^s is interpolated by a polynomial of degree 3 along each axis in Chebyshev's nodes, which is
//! then integrated exactly over the box's common part with the shape. The box of the largest error is
//! halved; the error of both halves is how much that changed their sum.
//! On a tetrahedron of linear density ρ^s is its binomial series about the middle of ρ's range, each term
//! integrated exactly, and the error a bound of what is left out.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::Vector3;

use crate::arrays::MapEach;
use crate::domain::density_region::DensityRegion;
use crate::domain::shape::DomainShape;
use crate::domain::shape_integrator::ShapeIntegrator;
use crate::geometry::bounds::Bounds;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::Monomials;

/// The relative error that ends the halving.
const TOLERANCE: f64 = 1e-6;

/// How many boxes are halved at most beside those that are given, in convex shapes and in others,
/// where a box takes longer.
const BUDGETS: [usize; 2] = [2000, 200];

/// The most terms of a tetrahedron's series.
const MOST_TERMS: u32 = 400;

/// The relative error that ends a tetrahedron's series.
const LEFT_OUT: f64 = 1e-12;

/// Nodes along an axis.
pub(crate) const NODES: usize = 4;

/// An integral and an estimate of its error, both absolute.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PowerIntegral {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

/// A box with the integral over its common part with the shape; those of the largest error first.
struct Part<'a> {
    region: &'a DensityRegion,
    bounds: Bounds<3>,
    integral: PowerIntegral,
    /// The axis along which the interpolation is worst.
    axis: usize,
}

impl Ord for Part<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        let (own, others) = (self.integral.error, other.integral.error);
        own.total_cmp(&others)
    }
}

impl PartialOrd for Part<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Part<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Part<'_> {}

/// ∫ ρ^`exponent` over a shape whose density is given in boxes.
pub(crate) fn over_regions(
    shape: &dyn DomainShape,
    regions: &[DensityRegion],
    exponent: f64,
) -> PowerIntegral {
    let whole = ShapeIntegrator::new(shape);
    let all = shape.bounds();
    let monomials = Monomials::dividing([NODES as u32 - 1; 3]);
    let part = |region, bounds| interpolated((&whole, &monomials), region, bounds, exponent);
    let boxes = regions.iter();
    let parts = boxes.map(|region| part(region, region.bounds.intersection(&all)));
    let mut parts: BinaryHeap<Part<'_>> = parts.collect();
    let mut sum = total(&parts);
    let budget = BUDGETS[usize::from(!shape.is_convex())];
    for _ in 0..budget + regions.len() {
        if sum.error <= TOLERANCE * sum.value {
            break;
        }
        let Some(worst) = parts.pop() else { break };
        let (mut below, mut above) = (worst.bounds, worst.bounds);
        let middle = worst.bounds.center()[worst.axis];
        below.max[worst.axis] = middle;
        above.min[worst.axis] = middle;
        let mut halves = [below, above].map_each(|bounds| part(worst.region, bounds));
        let change = halves[0].integral.value + halves[1].integral.value - worst.integral.value;
        for half in &mut halves {
            half.integral.error = 0.5 * change.abs();
        }
        sum.value += change;
        sum.error += change.abs() - worst.integral.error;
        parts.extend(halves);
    }
    total(&parts)
}

/// The sum over all boxes, in an order that does not depend on the heap.
fn total(parts: &BinaryHeap<Part<'_>>) -> PowerIntegral {
    let mut integrals: Vec<_> = parts.iter().map(|part| part.integral).collect();
    integrals.sort_unstable_by(|a, b| a.value.total_cmp(&b.value));
    PowerIntegral {
        value: integrals.iter().map(|part| part.value).sum(),
        error: integrals.iter().map(|part| part.error).sum(),
    }
}

/// The integral over a box of the polynomial that interpolates.
fn interpolated<'a>(
    (whole, monomials): (&ShapeIntegrator<'_>, &Monomials),
    region: &'a DensityRegion,
    bounds: Bounds<3>,
    exponent: f64,
) -> Part<'a> {
    let (center, half) = (bounds.center(), bounds.extent() * 0.5);
    let density = region.about(&center);
    let mut coefficients = [[[0.0; NODES]; NODES]; NODES];
    for (i, x) in nodes().into_iter().enumerate() {
        for (j, y) in nodes().into_iter().enumerate() {
            for (k, z) in nodes().into_iter().enumerate() {
                let at = half.component_mul(&Vector3::new(x, y, z));
                coefficients[i][j][k] = density.at(&at.into()).max(0.0).powf(exponent);
            }
        }
    }
    let greatest = coefficients.iter().flatten().flatten();
    let greatest = greatest.fold(0.0, |most: f64, &value| most.max(value));
    for axis in 0..3 {
        along(&mut coefficients, axis);
    }
    let mut last = Vector3::<f64>::zeros();
    let mut terms = Vec::with_capacity(NODES.pow(3));
    each(|powers| {
        let value = coefficients[powers[0]][powers[1]][powers[2]];
        for axis in 0..3 {
            if powers[axis] + 2 >= NODES {
                last[axis] += value.abs();
            }
        }
        let scale = (0..3).fold(1.0, |scale, axis| {
            scale * half[axis].powi(powers[axis] as i32)
        });
        terms.push((powers.map_each(|power| power as u32), value / scale));
    });
    let polynomial = Polynomial::from_terms(terms);
    let value = whole.mass_of_terms((&bounds, &region.planes), &center, &polynomial, monomials);
    // The last two coefficients, of which one may vanish by symmetry, stand for all that follow.
    let share = last.sum() / greatest.max(f64::MIN_POSITIVE);
    Part {
        region,
        bounds,
        integral: PowerIntegral {
            value,
            error: value.abs() * share,
        },
        axis: last.imax(),
    }
}

/// Calls with all powers below [`NODES`].
pub(crate) fn each(mut visit: impl FnMut([usize; 3])) {
    for number in 0..NODES.pow(3) {
        visit([
            number / (NODES * NODES),
            number / NODES % NODES,
            number % NODES,
        ]);
    }
}

/// Chebyshev's nodes in [−1, 1].
pub(crate) fn nodes() -> [f64; NODES] {
    let node = |k: usize| (std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64).cos();
    std::array::from_fn(node)
}

/// From values in the nodes to coefficients of powers, along an axis: by divided differences.
pub(crate) fn along(values: &mut [[[f64; NODES]; NODES]; NODES], axis: usize) {
    let at = nodes();
    each(|mut place| {
        if place[axis] != 0 {
            return;
        }
        let mut line = [0.0; NODES];
        for (k, value) in line.iter_mut().enumerate() {
            place[axis] = k;
            *value = values[place[0]][place[1]][place[2]];
        }
        for order in 1..NODES {
            for k in (order..NODES).rev() {
                line[k] = (line[k] - line[k - 1]) / (at[k] - at[k - order]);
            }
        }
        // Newton's form by Horner's rule.
        let mut powers = [0.0; NODES];
        for k in (0..NODES).rev() {
            for power in (1..NODES).rev() {
                powers[power] = powers[power - 1] - at[k] * powers[power];
            }
            powers[0] = line[k] - at[k] * powers[0];
        }
        for (k, value) in powers.into_iter().enumerate() {
            place[axis] = k;
            values[place[0]][place[1]][place[2]] = value;
        }
    });
}

/// ∫ ρ^`exponent` over a tetrahedron of this volume in which ρ is linear with these positive corner values.
///
/// With c the middle of their range and ρ = c (1 + u) it is c^s V Σ (s over k) 6 k!/(k+3)! h_k(u), h_k the complete
/// homogeneous polynomial of the corners' u.
pub(crate) fn over_tetrahedron(volume: f64, corners: [f64; 4], exponent: f64) -> PowerIntegral {
    let high = corners.into_iter().fold(0.0, f64::max);
    let low = corners.into_iter().fold(f64::INFINITY, f64::min);
    let middle = 0.5 * (low + high);
    let reach = (high - low) / (high + low);
    let u = corners.map_each(|value| (value - middle) / middle);
    let mut homogeneous = [1.0; 4];
    let (mut binomial, mut power, mut sum) = (1.0_f64, 1.0_f64, 1.0);
    let mut rest = 0.0;
    for k in 1..=MOST_TERMS {
        let order = f64::from(k);
        binomial *= (exponent - order + 1.0) / order;
        power *= reach;
        // All that follows: the binomials fall as k^−(1+s).
        rest = (binomial * power).abs() * (1.0 / (1.0 - reach)).min(order / exponent + 1.0);
        let mut below = 0.0;
        for (value, u) in homogeneous.iter_mut().zip(u) {
            *value = below + u * *value;
            below = *value;
        }
        sum += binomial * below * 6.0 / ((order + 1.0) * (order + 2.0) * (order + 3.0));
        if rest <= LEFT_OUT {
            break;
        }
    }
    let scale = volume * middle.powf(exponent);
    PowerIntegral {
        value: scale * sum,
        error: scale * rest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::cuboid::Cuboid;
    use crate::tests::quadrature::gauss;
    use nalgebra::Point3;

    fn box_integral(text: &str) -> PowerIntegral {
        let region = DensityRegion::everywhere(text.parse().expect("a polynomial"));
        over_regions(&Cuboid::unit(), &[region], 0.75)
    }

    #[test]
    fn integrals_over_a_box_are_those_of_their_primitives_within_the_estimate() {
        // ∫ (1 + a x)^s = ((1 + a)^(s+1) − 1) / (a (s+1)); ∫ x^(4s) = 1/(4 s + 1).
        let linear = |a: f64| ((1.0 + a).powf(1.75) - 1.0) / (a * 1.75);
        let cases = [
            ("2", 2.0_f64.powf(0.75)),
            ("1 + 8*x", linear(8.0)),
            ("(1 + 8*x)*(1 + y)", linear(8.0) * linear(1.0)),
            ("x^4", 0.25),
            ("x*y*z", 1.75_f64.powi(-3)),
        ];
        for (text, exact) in cases {
            let PowerIntegral { value, error } = box_integral(text);
            assert!(
                (value - exact).abs() <= 2.0 * error + 1e-13,
                "{text}: {value} {error:e}"
            );
            assert!(error < 1e-3 * exact, "{text}: {error:e}");
        }
    }

    #[test]
    fn series_on_tetrahedra_agree_with_quadrature() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let corners = corners.map(Point3::from);
        for values in [
            [1.0, 1.0, 1.0, 1.0],
            [1.0, 1.1, 0.9, 1.3],
            [1.0, 2.0, 3.0, 2.0],
        ] {
            let density = |y: &Point3<f64>| {
                let rises = [1, 2, 3].map(|k| (values[k] - values[0]) * y[k - 1]);
                values[0] + rises.iter().sum::<f64>()
            };
            let expected = gauss(&corners, |y| density(y).powf(0.75));
            let found = over_tetrahedron(1.0 / 6.0, values, 0.75);
            assert!((found.value / expected - 1.0).abs() < 1e-6, "{values:?}");
            assert!(found.error < 1e-11);
        }
        // One corner of next to nothing: ∫ (λ)^s = 6 V Γ(s+1)/Γ(s+4).
        let found = over_tetrahedron(1.0, [1.0, 1e-9, 1e-9, 1e-9], 0.75);
        let exact = 6.0 / (1.75 * 2.75 * 3.75);
        assert!((found.value - exact).abs() <= found.error + 1e-8);
        assert!(found.error < 0.02, "{:e}", found.error);
    }
}
