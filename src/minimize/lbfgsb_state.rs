//! Where a run of L-BFGS-B stands between two steps.

use crate::minimize::history::History;
use crate::minimize::progress::Iterate;

/// All that decides how a run goes on: plain numbers, to be written and read by whoever needs
/// to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LbfgsbState {
    pub(crate) point: Vec<f64>,
    pub(crate) value: f64,
    pub(crate) gradient: Vec<f64>,
    pub(crate) history: History,
    pub(crate) iterations: u64,
    pub(crate) evaluations: u64,
}

impl LbfgsbState {
    /// A run that has evaluated nothing yet.
    #[must_use]
    pub fn unevaluated(start: &[f64]) -> Self {
        Self {
            point: start.to_vec(),
            value: f64::NAN,
            gradient: vec![0.0; start.len()],
            ..Self::default()
        }
    }

    /// A state put together again from what the accessors gave.
    #[must_use]
    pub fn from_parts(
        point: Vec<f64>,
        value: f64,
        gradient: Vec<f64>,
        history: History,
        iterations: u64,
        evaluations: u64,
    ) -> Self {
        Self {
            point,
            value,
            gradient,
            history,
            iterations,
            evaluations,
        }
    }

    /// The variables `x`.
    #[must_use]
    pub fn point(&self) -> &[f64] {
        &self.point
    }

    /// `f(x)`; NaN before the first evaluation.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }

    /// `∇f(x)`, not projected.
    #[must_use]
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// The pairs of the last steps.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Accepted steps so far.
    #[must_use]
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Evaluations so far; zero means that value and gradient are not known yet.
    #[must_use]
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The largest component of the gradient, without those that push against a bound.
    #[must_use]
    pub fn projected_gradient(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let bounds = lower.iter().zip(upper);
        let variables = self.point.iter().zip(&self.gradient);
        let pushed = |x: f64, slope: f64, lower: f64, upper: f64| {
            (x <= lower && slope > 0.0) || (x >= upper && slope < 0.0)
        };
        variables
            .zip(bounds)
            .filter(|((x, slope), (lower, upper))| !pushed(**x, **slope, **lower, **upper))
            .fold(0.0, |size, ((_, slope), _)| size.max(slope.abs()))
    }
}

impl Iterate for LbfgsbState {
    type Point = Vec<f64>;

    fn point(&self) -> &Vec<f64> {
        &self.point
    }

    fn value(&self) -> f64 {
        self.value
    }
}
