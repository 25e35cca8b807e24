//! Functions that know more than their values: what lies ahead of a point.

use nalgebra::{SMatrix, SVector};

use crate::minimize::problem::{Evaluation, Jet};

/// A function to minimize.
pub(crate) trait Objective<const D: usize> {
    /// Value and derivatives at `point`.
    fn jet(&mut self, point: &SVector<f64, D>) -> Jet<D>;

    /// What lies ahead at the end of `step` from the point of the last jet, the third derivative of
    /// which is known. A function that cannot tell says `None`.
    fn ahead(&mut self, step: &SVector<f64, D>) -> Option<Ahead<D>> {
        let _ = step;
        None
    }
}

/// What tells, with a jet, a function at the end of a step, if the function is one polynomial of degree
/// four near the step's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead<const D: usize> {
    /// The fourth derivative, applied twice to the step.
    pub(crate) fourth: SMatrix<f64, D, D>,
    /// What is to be added to the polynomial at the end of the step, if anything.
    pub(crate) passed: Option<Evaluation<D>>,
}

/// A function that knows its jets only.
#[derive(Debug)]
pub(crate) struct Plain<F>(pub(crate) F);

impl<const D: usize, J: Into<Jet<D>>, F: FnMut(&SVector<f64, D>) -> J> Objective<D> for Plain<F> {
    fn jet(&mut self, point: &SVector<f64, D>) -> Jet<D> {
        self.0(point).into()
    }
}
