//! Where a run of Newton's method stands between two steps.

use nalgebra::{SMatrix, SVector};

use crate::minimize::problem::{Ended, Evaluation, Jet, Minimum};

/// A point, the function there, and how the last step went.
#[derive(Debug)]
pub(crate) struct NewtonState<const D: usize> {
    /// `x`, inside the box.
    pub(crate) point: SVector<f64, D>,
    /// The function there.
    pub(crate) evaluation: Evaluation<D>,
    /// The derivative of the Hessian there by each variable, where it is known.
    pub(crate) third: Option<[SMatrix<f64, D, D>; D]>,
    /// Evaluations so far.
    pub(crate) evaluations: u32,
    /// The largest component of the last step, if it was a full one.
    pub(crate) last_step: Option<f64>,
}

impl<const D: usize> NewtonState<D> {
    /// Where a run begins.
    pub(crate) fn at(
        point: SVector<f64, D>,
        objective: &mut impl FnMut(&SVector<f64, D>) -> Jet<D>,
    ) -> Self {
        let Jet { evaluation, third } = objective(&point);
        Self {
            point,
            evaluation,
            third,
            evaluations: 1,
            last_step: None,
        }
    }

    /// The answer, given why the run ended.
    pub(crate) fn minimum(&self, ended: Option<Ended>) -> Minimum<D> {
        Minimum {
            point: self.point,
            value: self.evaluation.value,
            gradient: self.evaluation.gradient,
            evaluations: self.evaluations,
            ended: ended.unwrap_or(Ended::NotFinite),
        }
    }

    /// The model's value and gradient after `step`.
    pub(crate) fn predicted(&self, step: &SVector<f64, D>) -> Evaluation<D> {
        let Evaluation {
            value,
            gradient,
            hessian,
        } = self.evaluation;
        let bend = hessian * step;
        Evaluation {
            value: value + gradient.dot(step) + 0.5 * bend.dot(step),
            gradient: gradient + bend,
            hessian,
        }
    }
}
