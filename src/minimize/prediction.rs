//! The predicted minimum of a function that is known to be one polynomial as far as that.
//!
//! From a jet with third derivatives and the fourth along a step the function's value, gradient and
//! Hessian at the step's end follow exactly, and so the next Newton step, without an evaluation.

use nalgebra::SVector;

use crate::minimize::newton::ProjectedNewton;
use crate::minimize::newton_step::{NewtonState, is_finite, predicted};
use crate::minimize::objective::Objective;
use crate::minimize::problem::Evaluation;

/// Steps after the first: Newton's method on what is nearly quadratic takes one to three.
const MAX_STEPS: usize = 4;
/// Steps have to shrink at least by this factor.
const SHRINKING: f64 = 0.25;

impl<const D: usize> ProjectedNewton<D> {
    /// The minimum and the function there, if the function can be predicted from `current` as far as that,
    /// which is about `first` away.
    pub(crate) fn predicted_minimum(
        &self,
        objective: &impl Objective<D>,
        current: &NewtonState<D>,
        first: &SVector<f64, D>,
    ) -> Option<(SVector<f64, D>, Evaluation<D>)> {
        let third = current.jet.third.as_ref()?;
        let (mut total, mut last) = (*first, first.amax());
        for _ in 0..MAX_STEPS {
            let prediction = objective.predict(&total)?;
            let evaluation = prediction.at_end(&current.jet.evaluation, third, &total);
            let point = self.moved(&current.point, &total, 1.0);
            if !is_finite(&evaluation) {
                return None;
            }
            if self.is_flat(&point, &evaluation.gradient) {
                return Some((point, evaluation));
            }
            let step = self.step(&point, &evaluation, None)?;
            let size = step.amax();
            if self.is_negligible(size, last, false) {
                let end = self.moved(&point, &step, 1.0);
                return Some((end, predicted(&evaluation, &step)));
            }
            if size > SHRINKING * last {
                return None;
            }
            (total, last) = (total + step, size);
        }
        None
    }
}
