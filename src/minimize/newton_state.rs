//! Where a run of Newton's method stands between two steps.

use nalgebra::SVector;

use crate::minimize::objective::Objective;
use crate::minimize::problem::{Ended, Evaluation, Jet, Minimum};

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
    pub(crate) fn minimum(&self, ended: Option<Ended>) -> Minimum<D> {
        Minimum {
            point: self.point,
            value: self.jet.evaluation.value,
            gradient: self.jet.evaluation.gradient,
            evaluations: self.evaluations,
            ended: ended.unwrap_or(Ended::NotFinite),
        }
    }
}

/// The quadratic model's value and gradient after `step`.
pub(crate) fn predicted<const D: usize>(
    from: &Evaluation<D>,
    step: &SVector<f64, D>,
) -> Evaluation<D> {
    let bend = from.hessian * step;
    Evaluation {
        value: from.value + from.gradient.dot(step) + 0.5 * bend.dot(step),
        gradient: from.gradient + bend,
        hessian: from.hessian,
    }
}
