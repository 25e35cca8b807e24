//! The state of L-BFGS-B between two steps, its options, and the checks of both.

use crate::minimize::history::History;
use crate::minimize::variable_bounds::VariableBounds;

/// All that decides how a run goes on: plain numbers, to be written and read by whoever needs
/// to.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LbfgsbState {
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
    pub(crate) fn unevaluated(start: &[f64]) -> Self {
        Self {
            point: start.to_vec(),
            value: f64::NAN,
            gradient: vec![0.0; start.len()],
            ..Self::default()
        }
    }

    /// A state put together again from what the accessors gave.
    #[must_use]
    pub(crate) fn from_parts(
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
    pub(crate) fn point(&self) -> &[f64] {
        &self.point
    }

    /// `f(x)`; NaN before the first evaluation.
    #[must_use]
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// `∇f(x)`, not projected.
    #[must_use]
    pub(crate) fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    /// The pairs of the last steps.
    #[must_use]
    pub(crate) fn history(&self) -> &History {
        &self.history
    }

    /// Accepted steps so far.
    #[must_use]
    pub(crate) fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Evaluations so far; zero means that value and gradient are not known yet.
    #[must_use]
    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The largest component of the gradient, without those that push against a bound.
    #[must_use]
    pub(crate) fn projected_gradient(&self, bounds: VariableBounds<'_>) -> f64 {
        let variables = self.point.iter().zip(&self.gradient);
        let pushed = |x: f64, slope: f64, lower: f64, upper: f64| {
            (x <= lower && slope > 0.0) || (x >= upper && slope < 0.0)
        };
        variables
            .zip(bounds.iter())
            .filter(|((x, slope), (lower, upper))| !pushed(**x, **slope, *lower, *upper))
            .fold(0.0, |size, ((_, slope), _)| size.max(slope.abs()))
    }
}

/// How L-BFGS-B steps and when it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LbfgsbOptions {
    /// How many pairs are remembered; 3 to 20 (\[B\] section 6).
    pub memory: usize,
    /// What gradients are measured by.
    pub scale: f64,
    /// Converged once the projected gradient is at most this times `scale`.
    pub gradient_tolerance: f64,
    /// Converged once a step lowers the value by at most this share of it; zero never.
    pub value_tolerance: f64,
    /// Consecutive variables whose displacement is measured together, and that may share their bounds with
    /// all other groups.
    pub group: usize,
    /// How far the first trial moves the farthest group.
    pub first_step: f64,
    /// `θ` of the model without pairs; `None` for that which makes `first_step` of the gradient.
    pub first_curvature: Option<f64>,
    /// The farthest a step may move a group.
    pub largest_step: f64,
    /// The most evaluations in all, those before a run was taken up again
    /// included.
    pub max_evaluations: u64,
}

impl Default for LbfgsbOptions {
    /// Ten pairs, tolerance 1e-8, first step 1, steps unlimited, 10 000 evaluations.
    fn default() -> Self {
        Self {
            memory: 10,
            scale: 1.0,
            gradient_tolerance: 1e-8,
            value_tolerance: 0.0,
            group: 1,
            first_step: 1.0,
            first_curvature: None,
            largest_step: f64::INFINITY,
            max_evaluations: 10_000,
        }
    }
}

/// Why L-BFGS-B refuses a problem.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LbfgsbError {
    /// Two vectors that belong together differ in length.
    #[error("{what} has {found} entries instead of {expected}")]
    Length {
        /// Which vector.
        what: &'static str,
        /// The number of variables.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// The bounds of a variable leave no room or are not numbers.
    #[error("variable {variable} has no room between {lower} and {upper}")]
    NoRoom {
        /// Which variable.
        variable: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
    /// A run to be taken up stands outside the box.
    #[error("variable {variable} of the state to resume is {value}, outside its bounds")]
    Outside {
        /// Which variable.
        variable: usize,
        /// Where it stands.
        value: f64,
    },
    /// An option that must be positive is not.
    #[error("option {option} must be positive but is {value}")]
    Option {
        /// Which option.
        option: &'static str,
        /// Its value.
        value: f64,
    },
    /// argmin's executor failed; no solver here causes that.
    #[error("the executor failed: {message}")]
    Executor {
        /// Its message.
        message: String,
    },
}

/// Checks a problem before anything is evaluated.
pub(crate) fn check(
    state: &LbfgsbState,
    bounds: VariableBounds<'_>,
    options: &LbfgsbOptions,
) -> Result<(), LbfgsbError> {
    check_lengths(state, bounds, options.group)?;
    check_options(options)?;
    for (variable, (&value, (lower, upper))) in state.point.iter().zip(bounds.iter()).enumerate() {
        let is_ordered = lower <= upper; // false for NaN
        if !is_ordered {
            return Err(LbfgsbError::NoRoom {
                variable,
                lower,
                upper,
            });
        }
        if state.evaluations > 0 && !(lower <= value && value <= upper) {
            return Err(LbfgsbError::Outside { variable, value });
        }
    }
    Ok(())
}

/// All vectors must have one entry per variable, or bounds one per variable of a group.
fn check_lengths(
    state: &LbfgsbState,
    bounds: VariableBounds<'_>,
    group: usize,
) -> Result<(), LbfgsbError> {
    let expected = state.point.len();
    let VariableBounds { lower, upper } = bounds;
    let is_repeated =
        lower.len() == group && upper.len() == group && expected.is_multiple_of(group.max(1));
    let vectors = [("the lower bound", lower), ("the upper bound", upper)];
    let vectors = vectors.into_iter().filter(|_| !is_repeated);
    let vectors = vectors.chain([("the gradient", state.gradient.as_slice())]);
    let steps = state
        .history
        .steps()
        .iter()
        .map(|s| ("a step", s.as_slice()));
    let changes = state.history.changes().iter();
    let changes = changes.map(|y| ("a change of the gradient", y.as_slice()));
    for (what, vector) in vectors.chain(steps).chain(changes) {
        if vector.len() != expected {
            return Err(LbfgsbError::Length {
                what,
                expected,
                found: vector.len(),
            });
        }
    }
    Ok(())
}

/// Counts and lengths must be positive.
fn check_options(options: &LbfgsbOptions) -> Result<(), LbfgsbError> {
    let positive = [
        ("memory", options.memory as f64),
        ("group", options.group as f64),
        ("scale", options.scale),
        ("first_step", options.first_step),
        ("largest_step", options.largest_step),
        ("first_curvature", options.first_curvature.unwrap_or(1.0)),
    ];
    let wrong = |value: f64| value.is_nan() || value <= 0.0;
    match positive.into_iter().find(|(_, value)| wrong(*value)) {
        Some((option, value)) => Err(LbfgsbError::Option { option, value }),
        None => Ok(()),
    }
}
