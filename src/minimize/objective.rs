//! Functions that know more than their values: what lies ahead of a point.

use nalgebra::{SMatrix, SVector};

use crate::minimize::problem::Jet;

/// A function to minimize.
pub(crate) trait Objective<const D: usize> {
    /// Value and derivatives at `point`.
    fn jet(&mut self, point: &SVector<f64, D>) -> Jet<D>;

    /// The fourth derivative, applied twice to `step`, if the function is one polynomial of degree
    /// four all along `step` from the point of the last jet, whose third derivative is known.
    ///
    /// Value and derivatives at the end of the step then follow from the jet, exactly. A function that
    /// cannot tell says `None`.
    fn fourth(&mut self, step: &SVector<f64, D>) -> Option<SMatrix<f64, D, D>> {
        let _ = step;
        None
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
