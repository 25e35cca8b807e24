//! One step of Newton's method in a box, and Chebyshev's where third derivatives are known.
//!
//! One step minimizes the quadratic model over the box *exactly* (`box_qp`), instead of
//! taking the free Newton step and projecting it: Bertsekas (*Projected Newton methods*, SIAM J.
//! Control Optim. 20, 1982) shows that projection can point uphill unless nearly active
//! variables are held, while in three variables the exact step costs one small factorization
//! more, and only when a bound is in the way. At a minimum both hold the same variables: those at
//! a bound whose gradient pushes outward.
//!
//! # Third derivatives
//!
//! Where the objective knows them, a step s that no bound limits becomes Chebyshev's,
//! s − ½ H⁻¹ T s s with T the third derivative (Traub, *Iterative Methods for the Solution of
//! Equations*, 1964, section 5.2, in several variables): it converges cubically and saves a
//! Voronoi cell about one evaluation. Where the second term is not small, it is left away.
//!
//! # Acceptance
//!
//! Armijo's test, except where the change of the value drowns in rounding: there the slope
//! decides, by the approximate Wolfe condition of Hager & Zhang (SIAM J. Optim. 16, 2005, eq.
//! 4.1). For a convex function and a Newton step the first trial almost always passes.

use nalgebra::{SMatrix, SVector};

use crate::minimize::box_qp::{Inverse, minimize_quadratic, positive_definite};
use crate::minimize::objective::Objective;
use crate::minimize::problem::{Evaluation, Jet, Minimum, Termination};

/// Armijo's constant (Nocedal & Wright, section 3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Where the slope decides, it must shrink to this share (Hager & Zhang's σ).
const CURVATURE: f64 = 0.9;
/// Changes of the value below this share of it are rounding: a sum over a cell's some hundred
/// simplices is good to about that.
pub(crate) const VALUE_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Shortest and longest cut of a rejected step.
const CUTS: (f64, f64) = (0.1, 0.5);
/// Up to this share of Newton's step the correction by the third derivative is trusted.
const LARGEST_CORRECTION: f64 = 0.5;

/// The step from where the function is `evaluation`, with `third` derivatives where they are known,
/// within `lower` and `upper` (relative to the point). `length` is the size of long steps.
pub(crate) fn newton_step<const D: usize>(
    evaluation: &Evaluation<D>,
    third: Option<&[SMatrix<f64, D, D>; D]>,
    length: f64,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> Option<SVector<f64, D>> {
    let Evaluation {
        gradient, hessian, ..
    } = evaluation;
    let (shifted, inverse) = positive_definite(hessian, gradient, length)?;
    let step = minimize_quadratic(&shifted, &inverse, gradient, lower, upper);
    let is_inside = |step: &SVector<f64, D>| {
        (0..D).all(|axis| lower[axis] < step[axis] && step[axis] < upper[axis])
    };
    let corrected = third
        .filter(|_| is_inside(&step))
        .and_then(|third| corrected(&step, gradient, third, &inverse))
        .filter(is_inside);
    Some(corrected.unwrap_or(step))
}

/// Chebyshev's step, if it is known and stays near Newton's `step` and as good as downhill.
fn corrected<const D: usize>(
    step: &SVector<f64, D>,
    gradient: &SVector<f64, D>,
    third: &[SMatrix<f64, D, D>; D],
    inverse: &Inverse<D>,
) -> Option<SVector<f64, D>> {
    let mut curved = SVector::zeros();
    for (along, share) in third.iter().zip(step.iter()) {
        curved += along * step * *share;
    }
    let corrected = step - inverse.solve(&curved) * 0.5;
    let is_small = (corrected - step).amax() <= LARGEST_CORRECTION * step.amax();
    let is_downhill = gradient.dot(&corrected) <= LARGEST_CORRECTION * gradient.dot(step);
    (is_small && is_downhill).then_some(corrected)
}

/// A point, the function there, and how the last step went.
#[derive(Debug)]
pub(crate) struct NewtonState<const D: usize> {
    /// `x`, inside the box.
    pub(crate) point: SVector<f64, D>,
    /// The function there.
    pub(crate) jet: Jet<D>,
    /// Evaluations so far.
    pub(crate) evaluations: u32,
    /// The largest component of the last step, if it was a full one.
    pub(crate) last_step: Option<f64>,
}

impl<const D: usize> NewtonState<D> {
    /// Where a run begins.
    pub(crate) fn at(point: SVector<f64, D>, objective: &mut impl Objective<D>) -> Self {
        let jet = objective.jet(&point);
        Self {
            point,
            jet,
            evaluations: 1,
            last_step: None,
        }
    }

    /// The answer, given why the run ended.
    pub(crate) fn minimum(&self, ended: Option<Termination>) -> Minimum<D> {
        Minimum {
            point: self.point,
            value: self.jet.evaluation.value,
            gradient: self.jet.evaluation.gradient,
            evaluations: self.evaluations,
            ended: ended.unwrap_or(Termination::NotFinite),
        }
    }
}

/// The quadratic model's value and gradient after `step`.
pub(crate) fn predicted<const D: usize>(
    from: &Evaluation<D>,
    step: &SVector<f64, D>,
) -> Evaluation<D> {
    let change = from.hessian * step;
    Evaluation {
        value: from.value + from.gradient.dot(step) + 0.5 * change.dot(step),
        gradient: from.gradient + change,
        hessian: from.hessian,
    }
}

/// Whether every number of the evaluation is finite.
pub(crate) fn is_finite<const D: usize>(evaluation: &Evaluation<D>) -> bool {
    evaluation.value.is_finite()
        && evaluation.gradient.iter().all(|entry| entry.is_finite())
        && evaluation.hessian.iter().all(|entry| entry.is_finite())
}

/// Armijo's test, or the slope's where the values differ by rounding only; `decrease` is what
/// the slope at the start promises for the step taken, negative.
pub(crate) fn is_accepted<const D: usize>(
    start: &Evaluation<D>,
    trial: &Evaluation<D>,
    step: &SVector<f64, D>,
    decrease: f64,
) -> bool {
    if !is_finite(trial) {
        return false;
    }
    let change = trial.value - start.value;
    if change <= SUFFICIENT_DECREASE * decrease {
        return true;
    }
    let (before, after) = (start.gradient.dot(step), trial.gradient.dot(step));
    change.abs() <= VALUE_ROUNDING * start.value.abs()
        && after <= (2.0 * SUFFICIENT_DECREASE - 1.0) * before
        && after >= CURVATURE * before
}

/// By how much to shorten a rejected step: to the minimum of the parabola through both values
/// and the first slope (Nocedal & Wright, eq. 3.58), within [`CUTS`].
pub(crate) fn cut(change: f64, decrease: f64) -> f64 {
    let ratio = -0.5 * decrease / (change - decrease);
    if ratio.is_finite() {
        ratio.clamp(CUTS.0, CUTS.1)
    } else {
        CUTS.0
    }
}
