//! Functions to minimize, minima, and why a minimization ended.
//!
//! A problem is a closure and a box `lower ≤ x ≤ upper` (infinite bounds allowed). A minimizer
//! never panics on a bad closure: values that are not finite are rejected trials, and why a run
//! ended is a value with a sentence.

use std::fmt;

use nalgebra::{SMatrix, SVector};

/// A function's value and derivatives at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Evaluation<const D: usize> {
    /// `f(x)`.
    pub value: f64,
    /// `∂f/∂x_k`.
    pub gradient: SVector<f64, D>,
    /// `∂²f/∂x_j∂x_k`, symmetric.
    pub hessian: SMatrix<f64, D, D>,
}

impl<const D: usize> Default for Evaluation<D> {
    /// That of the function 0.
    fn default() -> Self {
        Self {
            value: 0.0,
            gradient: SVector::zeros(),
            hessian: SMatrix::zeros(),
        }
    }
}

/// A function's value and derivatives up to the third, where that is known, at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jet<const D: usize> {
    /// Value, gradient and Hessian.
    pub evaluation: Evaluation<D>,
    /// The derivative of the Hessian by each variable.
    pub third: Option<[SMatrix<f64, D, D>; D]>,
}

impl<const D: usize> From<Evaluation<D>> for Jet<D> {
    fn from(evaluation: Evaluation<D>) -> Self {
        Self {
            evaluation,
            third: None,
        }
    }
}

/// Where a minimization in `D` variables ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Minimum<const D: usize> {
    /// The best point found, inside the box.
    pub point: SVector<f64, D>,
    /// `f(point)`; by the last quadratic model if it ended with [`Termination::StepNegligible`].
    pub value: f64,
    /// `∇f(point)`, not projected; by the model in the same case.
    pub gradient: SVector<f64, D>,
    /// How many times the function was evaluated.
    pub evaluations: u32,
    /// Why it ended.
    pub ended: Termination,
}

/// Why a minimization ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Termination {
    /// The projected gradient is below the tolerance.
    GradientSmall,
    /// The last step was so short, and shorter than the one before by so much, that the point
    /// it leads to was taken without another evaluation.
    StepNegligible,
    /// The last step lowered the value by less than the tolerance.
    ValueSettled,
    /// The next step would not change the value or the point by more than rounding does.
    AtRounding,
    /// The allowed evaluations are spent.
    EvaluationLimit,
    /// The function is not finite at the start.
    NotFinite,
    /// No lower value was found along a descent direction: the gradient does not fit the value.
    NoDescent,
    /// The observer asked to stop.
    Stopped,
}

impl Termination {
    /// The reason as a sentence.
    #[must_use]
    pub(crate) fn sentence(self) -> &'static str {
        match self {
            Self::GradientSmall => "the projected gradient is below the tolerance",
            Self::StepNegligible => "the last step was too short to be worth checking",
            Self::ValueSettled => "the last step lowered the value by less than the tolerance",
            Self::AtRounding => "a further step would be lost in rounding",
            Self::EvaluationLimit => "the allowed evaluations are spent",
            Self::NotFinite => "the function is not finite at the start",
            Self::NoDescent => "no lower value was found along a descent direction",
            Self::Stopped => "the observer asked to stop",
        }
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.sentence())
    }
}
