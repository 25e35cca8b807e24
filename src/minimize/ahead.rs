//! The minimum of a function that is known as far as that.
//!
//! From a jet with third derivatives, the fourth along a step and what is to be added to this
//! polynomial, the function's value, gradient and Hessian at the step's end follow exactly, and so
//! the next Newton step, without an evaluation.

use nalgebra::{SMatrix, SVector};

use crate::minimize::backtracking::is_finite;
use crate::minimize::newton::ProjectedNewton;
use crate::minimize::newton_state::{NewtonState, predicted};
use crate::minimize::objective::{Ahead, Objective};
use crate::minimize::problem::{Evaluation, Jet};

/// Steps after the first: Newton's method on a polynomial that is nearly quadratic takes one or two.
const MAX_STEPS: usize = 4;
/// Steps have to shrink at least by this factor.
const SHRINKING: f64 = 0.25;

impl<const D: usize> ProjectedNewton<D> {
    /// The minimum and the function there, if the function is known from `current` as far as that, which
    /// is about `first` away.
    pub(crate) fn ahead(
        &self,
        objective: &mut impl Objective<D>,
        current: &NewtonState<D>,
        first: &SVector<f64, D>,
    ) -> Option<(SVector<f64, D>, Evaluation<D>)> {
        let (mut way, mut last) = (*first, first.amax());
        for _ in 0..MAX_STEPS {
            let ahead = objective.ahead(&way)?;
            let evaluation = at_end(&current.jet, &ahead, &way);
            let point = self.moved(&current.point, &way, 1.0);
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
            (way, last) = (way + step, size);
        }
        None
    }
}

/// The function at the end of a step from where it is `start`.
pub(crate) fn at_end<const D: usize>(
    start: &Jet<D>,
    Ahead { fourth, passed }: &Ahead<D>,
    step: &SVector<f64, D>,
) -> Evaluation<D> {
    let Jet {
        evaluation: start,
        third,
    } = start;
    let turns = third.iter().flatten().zip(step.iter());
    let third = turns.fold(
        SMatrix::zeros(),
        |sum: SMatrix<f64, D, D>, (along, share)| sum + along * *share,
    );
    let [by_second, by_third, by_fourth] = [&start.hessian, &third, fourth].map(|form| form * step);
    let bend = by_second / 2.0 + by_third / 6.0 + by_fourth / 24.0;
    let polynomial = Evaluation {
        value: start.value + (start.gradient + bend).dot(step),
        gradient: start.gradient + by_second + by_third / 2.0 + by_fourth / 6.0,
        hessian: start.hessian + third + fourth / 2.0,
    };
    passed.map_or(polynomial, |passed| Evaluation {
        value: polynomial.value + passed.value,
        gradient: polynomial.gradient + passed.gradient,
        hessian: polynomial.hessian + passed.hessian,
    })
}
