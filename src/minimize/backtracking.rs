//! Whether a trial step is accepted, and by how much it is cut if not.
//!
//! Armijo's test, except where the change of the value drowns in rounding: there the slope
//! decides, by the approximate Wolfe condition of Hager & Zhang (SIAM J. Optim. 16, 2005, eq.
//! 4.1). For a convex function and a Newton step the first trial almost always passes.

use nalgebra::SVector;

use crate::minimize::problem::Evaluation;

/// Armijo's constant (Nocedal & Wright, section 3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Where the slope decides, it must shrink to this share (Hager & Zhang's σ).
const CURVATURE: f64 = 0.9;
/// Changes of the value below this share of it are rounding: a sum over a cell's some hundred
/// simplices is good to about that.
pub(crate) const VALUE_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Shortest and longest cut of a rejected step.
const CUTS: (f64, f64) = (0.1, 0.5);

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
