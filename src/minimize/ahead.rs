//! The minimum of a function that is known to be one polynomial as far as that.
//!
//! From a jet with third derivatives and the fourth along a step, the function's value, gradient and
//! Hessian at the step's end follow exactly, and so the next Newton step, without an evaluation.

use nalgebra::{SMatrix, SVector};

use crate::minimize::backtracking::is_finite;
use crate::minimize::newton::ProjectedNewton;
use crate::minimize::newton_state::{NewtonState, predicted};
use crate::minimize::objective::Objective;
use crate::minimize::problem::Evaluation;

/// Steps after the first: Newton's method on a polynomial that is nearly quadratic takes one or two.
const MAX_STEPS: usize = 4;
/// Steps have to shrink at least by this factor.
const SHRINKING: f64 = 0.25;

impl<const D: usize> ProjectedNewton<D> {
    /// The minimum and the function there, if the function is one polynomial from `current` as far
    /// as that, which is about `first` away.
    pub(crate) fn ahead(
        &self,
        objective: &mut impl Objective<D>,
        current: &NewtonState<D>,
        first: &SVector<f64, D>,
    ) -> Option<(SVector<f64, D>, Evaluation<D>)> {
        let third = current.jet.third.as_ref()?;
        let (mut way, mut last) = (*first, first.amax());
        for _ in 0..MAX_STEPS {
            let fourth = objective.fourth(&way)?;
            let evaluation = at_end(&current.jet.evaluation, third, &fourth, &way);
            let point = self.moved(&current.point, &way, 1.0);
            if !is_finite(&evaluation) {
                return None;
            }
            if self.is_flat(&point, &evaluation.gradient) {
                return Some((point, evaluation));
            }
            let step = self.step(&point, &evaluation.into())?;
            let size = step.amax();
            if self.is_negligible(size, last, false) {
                let end = self.moved(&point, &step, 1.0);
                return Some((end, predicted(&evaluation, &step)));
            }
            if size > SHRINKING * last {
                return None;
            }
            (way, last) = (way + step, size);
        }
        None
    }
}

/// The function at the end of a step along which it is a polynomial of degree four.
fn at_end<const D: usize>(
    start: &Evaluation<D>,
    third: &[SMatrix<f64, D, D>; D],
    fourth: &SMatrix<f64, D, D>,
    step: &SVector<f64, D>,
) -> Evaluation<D> {
    let turns = third.iter().zip(step.iter());
    let third = turns.fold(
        SMatrix::zeros(),
        |sum: SMatrix<f64, D, D>, (along, share)| sum + along * *share,
    );
    let [by_second, by_third, by_fourth] = [&start.hessian, &third, fourth].map(|form| form * step);
    let bend = by_second / 2.0 + by_third / 6.0 + by_fourth / 24.0;
    Evaluation {
        value: start.value + (start.gradient + bend).dot(step),
        gradient: start.gradient + by_second + by_third / 2.0 + by_fourth / 6.0,
        hessian: start.hessian + third + fourth / 2.0,
    }
}
