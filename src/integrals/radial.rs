//! Moments of densities f(|y − p|) of a solid, from its surface.
//!
//! By the divergence theorem along the rays from p, with R = |y − p|,
//!
//! ```text
//! ∫_Ω f = Σ ∫_t g₀ (y − p)·dA      ∫_Ω f (y − p) = Σ ∫_t g₁ (y − p) (y − p)·dA
//! ∫_Ω f (y − p)(y − p)ᵀ = Σ ∫_t g₂ (y − p)(y − p)ᵀ (y − p)·dA
//! g_n(R) = ∫₀¹ f(Rτ) τ^(2+n) dτ
//! ```
//!
//! g_n is in closed form, (y − p)·dA constant on a triangle, and what is left are smooth integrals over
//! triangles, by products of Gauss-Legendre rules of 5 and 7 nodes, halved until they agree to rounding.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::{
    AdaptiveIntegral, AdaptivePiece, Estimate, Goal, MomentErrors, gauss_legendre, halved,
    integrate,
};

/// A density that depends on the distance ρ from a point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Radial {
    pub(crate) point: Point3<f64>,
    pub(crate) kind: RadialKind,
}

/// How it depends on the distance.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RadialKind {
    /// sin(kρ) + 1 (\[BL\] eq. 5).
    Sine {
        /// k (1/L).
        k: f64,
    },
    /// Linear between breaks (ρ, density), ρ ascending; constant before the first and after the last.
    Linear {
        /// The breaks.
        breaks: Vec<[f64; 2]>,
    },
}

/// Below this kR the series converges to rounding in [`SERIES_TERMS`] terms, and the closed form cancels.
const SERIES: f64 = 2.5;
const SERIES_TERMS: usize = 16;

impl Radial {
    /// The density at a point.
    pub(crate) fn at(&self, place: &Point3<f64>) -> f64 {
        self.kind.at((place - self.point).norm())
    }

    /// The moments, from `origin`, of the solid within triangles that are oriented outward.
    pub(crate) fn moments(
        &self,
        triangles: impl Iterator<Item = [Point3<f64>; 3]>,
        origin: &Point3<f64>,
        goal: Goal,
    ) -> AdaptiveIntegral {
        let from = |corner: Point3<f64>| Point3::from(corner - self.point);
        let pieces = triangles
            .map(|corners| RadialPiece(corners.map_each(from)))
            .collect();
        let rules = [7, 5].map_each(gauss_legendre);
        let arm = self.point - origin;
        integrate(pieces, goal, &|piece: &RadialPiece| {
            let both = rules.each_ref().map_each(|rule| self.over(piece, rule));
            let errors = MomentErrors::between(&both[0], &both[1]).moved(arm.norm());
            let [better, lower] = both.map_each(|moments| moments.translated(&arm));
            Estimate {
                errors,
                ..Estimate::of_pair(better, &lower)
            }
        })
    }

    /// The moments, from the density's point, of the cone over a triangle.
    fn over(&self, RadialPiece([a, b, c]): &RadialPiece, rule: &[(f64, f64)]) -> Moments {
        let (second, third) = (b - a, c - a);
        // Twice the area times the height of the density's point above the triangle.
        let height = a.coords.dot(&second.cross(&third));
        let mut moments = Moments::default();
        for (u, along) in rule {
            for (v, across) in rule {
                let place = a.coords + second * (*u) + (third - second) * (u * v);
                let weight = height * along * across * u;
                let [g0, g1, g2] = self.kind.along_ray(place.norm());
                moments.mass += weight * g0;
                moments.first += place * (weight * g1);
                moments.second += place * place.transpose() * (weight * g2);
            }
        }
        moments
    }
}

impl RadialKind {
    /// The density at the distance ρ.
    pub(crate) fn at(&self, rho: f64) -> f64 {
        match self {
            Self::Sine { k } => (k * rho).sin() + 1.0,
            Self::Linear { breaks } => linear(breaks, rho),
        }
    }

    /// g₀, g₁ and g₂ at R.
    pub(crate) fn along_ray(&self, radius: f64) -> [f64; 3] {
        match self {
            Self::Sine { k } => {
                let sines = sine_integrals(k * radius);
                [0, 1, 2].map_each(|n| sines[n] + 1.0 / (3 + n) as f64)
            }
            Self::Linear { breaks } => linear_integrals(breaks, radius),
        }
    }
}

/// ∫₀¹ sin(aτ) τ^(2+n) dτ for n = 0, 1, 2.
fn sine_integrals(a: f64) -> [f64; 3] {
    if a.abs() < SERIES {
        // Σ (−1)^j a^(2j+1) / ((2j+1)! (2j+4+n)).
        let mut sums = [0.0; 3];
        let mut term = a;
        for j in 0..SERIES_TERMS {
            let order = (2 * j) as f64;
            for (n, sum) in sums.iter_mut().enumerate() {
                *sum += term / (order + 4.0 + n as f64);
            }
            term *= -a * a / ((order + 2.0) * (order + 3.0));
        }
        return sums;
    }
    let (sin, cos, square) = (a.sin(), a.cos(), a * a);
    [
        (2.0 * a * sin - (square - 2.0) * cos - 2.0) / (a * square),
        (3.0 * (square - 2.0) * sin - a * (square - 6.0) * cos) / (square * square),
        (4.0 * a * (square - 6.0) * sin - (square * square - 12.0 * square + 24.0) * cos + 24.0)
            / (a * square * square),
    ]
}

/// The density at ρ, linear between breaks.
fn linear(breaks: &[[f64; 2]], rho: f64) -> f64 {
    let after = breaks.partition_point(|pair| pair[0] <= rho);
    match (after.checked_sub(1).map(|k| breaks[k]), breaks.get(after)) {
        (Some([low, from]), Some([high, to])) => from + (to - from) * ((rho - low) / (high - low)),
        (Some([_, value]), None) | (None, Some(&[_, value])) => value,
        (None, None) => 0.0,
    }
}

/// Three Gauss-Legendre nodes on [0, 1], exact to degree 5: that of a linear function times τ⁴.
const THREE: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// ∫₀¹ f(Rτ) τ^(2+n) dτ for n = 0, 1, 2 and f linear between breaks.
fn linear_integrals(breaks: &[[f64; 2]], radius: f64) -> [f64; 3] {
    let inner = breaks.iter().map(|pair| pair[0] / radius);
    let inner = inner.filter(|tau| (0.0..1.0).contains(tau));
    let mut sums = [0.0; 3];
    let mut start = 0.0;
    for end in inner.chain([1.0]) {
        for (node, weight) in THREE {
            let tau = start + (end - start) * node;
            let part = weight * (end - start) * linear(breaks, radius * tau) * tau * tau;
            for (n, sum) in sums.iter_mut().enumerate() {
                *sum += part * tau.powi(n as i32);
            }
        }
        start = end;
    }
    sums
}

/// A triangle, from the density's point.
struct RadialPiece([Point3<f64>; 3]);

impl AdaptivePiece for RadialPiece {
    fn halves(&self) -> [Self; 2] {
        halved(&self.0).map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The integrals along a ray by 64 nodes in each of 8 parts.
    fn by_quadrature(kind: &RadialKind, radius: f64) -> [f64; 3] {
        let rule = gauss_legendre(64);
        [2, 3, 4].map(|power| {
            let parts = (0..800).flat_map(|part| {
                let shifted = move |(node, weight): &(f64, f64)| {
                    ((f64::from(part) + node) / 800.0, weight / 800.0)
                };
                rule.iter().map(shifted)
            });
            parts
                .map(|(tau, weight)| weight * kind.at(radius * tau) * tau.powi(power))
                .sum()
        })
    }

    #[test]
    fn integrals_along_rays_are_those_of_quadrature() {
        let sine = RadialKind::Sine { k: 20.0 };
        let steps = RadialKind::Linear {
            breaks: vec![[0.2, 1.0], [0.5, 5.0], [0.501, 2.0]],
        };
        for radius in [1e-6, 0.01, 0.12, 0.13, 0.2, 0.3, 0.5, 0.7, 3.0] {
            for kind in [&sine, &steps] {
                let (own, other) = (kind.along_ray(radius), by_quadrature(kind, radius));
                let slack = if *kind == sine { 1e-14 } else { 1e-6 };
                for (a, b) in own.iter().zip(other) {
                    assert!((a - b).abs() < slack, "{kind:?} at {radius}: {a} {b}");
                }
            }
        }
        // By hand: ∫₀¹ (1 + τ) τ² = 1/3 + 1/4 …
        let line = RadialKind::Linear {
            breaks: vec![[0.0, 1.0], [1.0, 2.0]],
        };
        let exact = [7.0 / 12.0, 9.0 / 20.0, 11.0 / 30.0];
        for (a, b) in line.along_ray(1.0).iter().zip(exact) {
            assert!((a - b).abs() < 1e-15);
        }
    }

    #[test]
    fn gauss_legendre_nodes_are_exact_to_their_degree() {
        for count in 1..10 {
            let rule = gauss_legendre(count);
            for power in 0..2 * count as i32 {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
                assert!(
                    (sum * f64::from(power + 1) - 1.0).abs() < 1e-14,
                    "{count} {power}"
                );
            }
        }
    }
}
