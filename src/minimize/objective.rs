//! Functions to minimize, some of which can predict themselves a step away.

use nalgebra::{SMatrix, SVector};

use crate::arrays::MapEach;
use crate::minimize::problem::{Evaluation, Jet};

/// A function to minimize.
pub(crate) trait Objective<const D: usize> {
    /// Value and derivatives at `point`.
    fn jet(&mut self, point: &SVector<f64, D>) -> Jet<D>;

    /// The prediction at the end of `step` from the point of the last jet, the third derivative of which
    /// is known; none where the function is not one polynomial of degree four that far.
    fn predict(&self, step: &SVector<f64, D>) -> Option<Prediction<D>> {
        let _ = step;
        None
    }
}

/// What determines, with a jet, a polynomial of degree four at the end of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Prediction<const D: usize> {
    /// The fourth derivative, applied twice to the step.
    pub(crate) fourth: SMatrix<f64, D, D>,
}

impl<const D: usize> Prediction<D> {
    /// The function at the end of the step from where it is `start`, with `third` derivatives.
    pub(crate) fn at_end(
        &self,
        start: &Evaluation<D>,
        third: &[SMatrix<f64, D, D>; D],
        step: &SVector<f64, D>,
    ) -> Evaluation<D> {
        let turns = third.iter().zip(step.iter());
        let third = turns.fold(
            SMatrix::zeros(),
            |sum: SMatrix<f64, D, D>, (along, share)| sum + along * *share,
        );
        let fourth = &self.fourth;
        let [by_second, by_third, by_fourth] =
            [&start.hessian, &third, fourth].map_each(|form| form * step);
        let bend = by_second / 2.0 + by_third / 6.0 + by_fourth / 24.0;
        Evaluation {
            value: start.value + (start.gradient + bend).dot(step),
            gradient: start.gradient + by_second + by_third / 2.0 + by_fourth / 6.0,
            hessian: start.hessian + third + fourth / 2.0,
        }
    }
}

/// A function that knows its jets only.
#[derive(Debug)]
pub(crate) struct Plain<F>(pub(crate) F);

impl<const D: usize, J: Into<Jet<D>>, F: FnMut(&SVector<f64, D>) -> J> Objective<D> for Plain<F> {
    fn jet(&mut self, point: &SVector<f64, D>) -> Jet<D> {
        self.0(point).into()
    }
}
