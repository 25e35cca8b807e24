//! The center of a cell: the minimizer of its Chebyshev energy within bounds.
//!
//! E is convex in the center (for pieces that sum to a set), so Newton's method with the exact
//! Hessian finds it in two to five evaluations; for p = 1 mostly in one where the center is near, for
//! there the energy is known as a polynomial (`prediction`).
//! L-BFGS-B, which uses gradients only, is the choice of \[BL\] section 3.5. The search is the same
//! in the plane and in space.

use std::ops::ControlFlow;

use nalgebra::{SVector, Vector3};

use crate::arrays::MapEach;
use crate::energy::evaluation::{EnergyScratch, SignedPiece, energy_jet};
use crate::energy::prediction::predict;
use crate::geometry::bounds::Bounds;
use crate::minimize::lbfgsb::lbfgsb;
use crate::minimize::lbfgsb_state::{LbfgsbOptions, LbfgsbState};
use crate::minimize::newton::{NewtonOptions, minimize};
use crate::minimize::objective::{Objective, Plain, Prediction};
use crate::minimize::problem::{Evaluation, Jet};

/// The projected gradient at which L-BFGS-B stops, relative to that of a step of the cell's size.
/// The gradient falls about linearly, so centers agree with Newton's to 1e-10 of that size.
const LBFGSB_TOLERANCE: f64 = 1e-11;

/// The share of the distance to the boundary of its cell that a site moves whose center lies beyond it:
/// so near to 1 that little is lost, and so far that rounding cannot move two sites to one place.
///
/// A center may lie outside a slanted, slender cell, for the Chebyshev distance to a point can
/// shrink as the point leaves a convex set. The energy is convex, so it falls all along the line;
/// and a site that stays inside its own cell can neither leave the domain nor meet another.
pub(crate) const BOUNDARY_FRACTION: f64 = 1023.0 / 1024.0;

/// Which algorithm finds a cell's center.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "scene",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)
)]
#[cfg_attr(feature = "scene", serde(rename_all = "snake_case"))]
pub enum Minimizer {
    #[default]
    /// Projected Newton with exact Hessians.
    Newton,
    /// Limited-memory BFGS with bounds, the choice of \[BL\] section 3.5.
    Lbfgsb,
}

/// The algorithm, the scales and the bounds of the search for a center.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CenterSearch<const D: usize> {
    /// The algorithm.
    pub minimizer: Minimizer,
    /// The order p ≥ 1 of the energy.
    pub order: u32,
    /// The cell's volume (L^D), by which steps are measured.
    pub volume: f64,
    /// The cell's mass, by which gradients are measured: the volume where the density is 1.
    pub mass: f64,
    /// The box that holds the center, relative to the site; it holds the site.
    pub bounds: Bounds<D>,
}

/// A center, and the energy at both ends of the search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Center<const D: usize> {
    /// The center's displacement from the site.
    pub point: SVector<f64, D>,
    /// The energy about the center (L^(D+p)).
    pub energy: f64,
    /// The energy about the site, where the search begins (L^(D+p)).
    pub energy_at_site: f64,
    /// The gradient about the site (L^(D+p−1)).
    pub gradient_at_site: SVector<f64, D>,
    /// How many evaluations it took.
    pub evaluations: u32,
}

impl<const D: usize> CenterSearch<D> {
    /// The center of the cell whose energy `evaluate` gives about a displacement from the site.
    ///
    /// Newton ends with a projected gradient of at most 1e-12 of that of a step of the cell's
    /// size, L-BFGS-B of 1e-11.
    #[must_use]
    pub(crate) fn center<J: Into<Jet<D>>>(
        &self,
        evaluate: impl FnMut(&SVector<f64, D>) -> J,
    ) -> Center<D> {
        self.center_of(Plain(evaluate))
    }

    /// As [`CenterSearch::center`], for energies that may be predicted by a polynomial.
    pub(crate) fn center_of(&self, mut energy: impl Objective<D>) -> Center<D> {
        let first = energy.jet(&SVector::zeros());
        self.center_from(&first, energy)
    }

    /// As [`CenterSearch::center_of`], where the energy about the site is known.
    fn center_from(&self, first: &Jet<D>, energy: impl Objective<D>) -> Center<D> {
        let Evaluation {
            value: energy_at_site,
            gradient: gradient_at_site,
            ..
        } = first.evaluation;
        let mut energy = WithFirstEvaluation {
            energy,
            first: Some(first),
        };
        let (point, energy, evaluations) = match self.minimizer {
            Minimizer::Newton => self.by_newton(&mut energy),
            Minimizer::Lbfgsb => self.by_lbfgsb(&mut energy),
        };
        Center {
            point,
            energy,
            energy_at_site,
            gradient_at_site,
            evaluations,
        }
    }

    /// The cell's size s (L) and p m s^(p−1), m its mass, the size of a fragment's share of the
    /// gradient.
    fn scales(&self) -> (f64, f64) {
        let volume = self.volume.max(0.0);
        let length = if D == 3 {
            near_cube_root(volume)
        } else {
            volume.powf(1.0 / D as f64)
        };
        let scale = (1..self.order).fold(self.mass * f64::from(self.order), |s, _| s * length);
        (length, scale)
    }

    fn by_newton(&self, energy: &mut impl Objective<D>) -> (SVector<f64, D>, f64, u32) {
        let (length, scale) = self.scales();
        let found = minimize(
            energy,
            &SVector::zeros(),
            &self.bounds.min.coords,
            &self.bounds.max.coords,
            &NewtonOptions::new(scale, length),
        );
        (found.point, found.value, found.evaluations)
    }

    /// In units of the cell, since L-BFGS-B first steps by the bare gradient.
    fn by_lbfgsb(&self, energy: &mut impl Objective<D>) -> (SVector<f64, D>, f64, u32) {
        let (length, scale) = self.scales();
        let mut objective = |x: &[f64], gradient: &mut [f64]| {
            let evaluation = energy
                .jet(&(SVector::from_column_slice(x) * length))
                .evaluation;
            gradient.copy_from_slice((evaluation.gradient / scale).as_slice());
            evaluation.value / (scale * length)
        };
        let options = LbfgsbOptions {
            gradient_tolerance: LBFGSB_TOLERANCE,
            largest_step: 1.0,
            group: D,
            ..LbfgsbOptions::default()
        };
        let [lower, upper] = [self.bounds.min, self.bounds.max].map_each(|end| end.coords / length);
        let found = lbfgsb(
            &mut objective,
            LbfgsbState::unevaluated(&[0.0; D]),
            lower.as_slice(),
            upper.as_slice(),
            &options,
            |_, _| ControlFlow::Continue(()),
        );
        match found {
            Ok(end) => {
                let point = SVector::from_column_slice(end.state.point()) * length;
                let evaluations = end.state.evaluations() as u32;
                (point, end.state.value() * scale * length, evaluations)
            }
            // A box without extent contains the site only.
            Err(_) => (
                SVector::zeros(),
                energy.jet(&SVector::zeros()).evaluation.value,
                1,
            ),
        }
    }
}

/// The cube root of a number that is not negative, to four digits: the scale of steps needs no more. A third of the exponent, with the constant that makes that right on average, and one step of
/// Halley's method (Kahan, *Computing a real cube root*, 1991).
fn near_cube_root(number: f64) -> f64 {
    const THIRD_OF_BIAS: u64 = 0x2a9f_7893_782d_a1ce;
    let near = f64::from_bits(number.to_bits() / 3 + THIRD_OF_BIAS);
    let cube = near * near * near;
    near * (cube + 2.0 * number) / (2.0 * cube + number)
}

/// An energy, and its first evaluation, about the site, where every search begins.
struct WithFirstEvaluation<'a, const D: usize, Energy> {
    energy: Energy,
    first: Option<&'a Jet<D>>,
}

impl<const D: usize, Energy: Objective<D>> Objective<D> for WithFirstEvaluation<'_, D, Energy> {
    fn jet(&mut self, center: &SVector<f64, D>) -> Jet<D> {
        let is_site = center.iter().all(|&along| along == 0.0);
        let first = self.first.take().filter(|_| is_site);
        first.map_or_else(|| self.energy.jet(center), |first| *first)
    }

    fn predict(&self, step: &SVector<f64, D>) -> Option<Prediction<D>> {
        self.energy.predict(step)
    }
}

/// The energy of signed pieces.
struct EnergyOf<'a> {
    pieces: &'a [SignedPiece],
    order: u32,
    scratch: &'a mut EnergyScratch,
}

impl Objective<3> for EnergyOf<'_> {
    fn jet(&mut self, center: &Vector3<f64>) -> Jet<3> {
        energy_jet(self.pieces, center, self.order, self.scratch)
    }

    fn predict(&self, step: &Vector3<f64>) -> Option<Prediction<3>> {
        let [SignedPiece { sign, piece }] = self.pieces else {
            return None;
        };
        let is_plain = self.order == 1 && piece.density.is_none() && *sign > 0.0;
        let EnergyScratch {
            surface,
            center,
            velocity_determinants,
            ..
        } = &*self.scratch;
        is_plain.then(|| predict(piece, [center, step], &surface.ends, velocity_determinants))?
    }
}

/// The center of signed pieces in coordinates about their site, where their energy is `first`, just
/// evaluated by [`energy_jet`] with the same `scratch`.
#[must_use]
pub(crate) fn center(
    pieces: &[SignedPiece],
    search: &CenterSearch<3>,
    first: &Jet<3>,
    scratch: &mut EnergyScratch,
) -> Center<3> {
    let energy = EnergyOf {
        pieces,
        order: search.order,
        scratch,
    };
    search.center_from(first, energy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_have_four_digits() {
        for exponent in -60..60 {
            for share in [1.0, 1.7, 2.9, 5.3, 7.9] {
                let number = share * 8.0_f64.powi(exponent);
                let root = near_cube_root(number);
                assert!(
                    (root / number.cbrt() - 1.0).abs() < 1e-4,
                    "{number}: {root}"
                );
            }
        }
        assert!(near_cube_root(0.0) < 1e-100);
    }
}
