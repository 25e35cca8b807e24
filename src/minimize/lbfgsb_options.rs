//! What L-BFGS-B can be asked for, and what is wrong with a question.

use crate::minimize::lbfgsb_state::LbfgsbState;

/// How L-BFGS-B steps and when it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LbfgsbOptions {
    /// How many pairs are remembered; 3 to 20 (\[B\] section 6).
    pub memory: usize,
    /// What gradients are measured by.
    pub scale: f64,
    /// Converged once the projected gradient is at most this times `scale`.
    pub gradient_tolerance: f64,
    /// Converged once a step lowers the value by at most this share of it; zero never.
    pub value_tolerance: f64,
    /// Consecutive variables whose displacement is measured together.
    pub group: usize,
    /// How far the first trial moves the farthest group.
    pub first_step: f64,
    /// The farthest a step may move a group.
    pub largest_step: f64,
    /// The most evaluations in all, those before a [`resume`](crate::minimize::lbfgsb::resume)
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
            largest_step: f64::INFINITY,
            max_evaluations: 10_000,
        }
    }
}

/// What is wrong with a question to L-BFGS-B.
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
    /// argmin's executor failed, which no solver here makes it do.
    #[error("the executor failed: {message}")]
    Executor {
        /// In its words.
        message: String,
    },
}

/// Checks a question before anything is evaluated.
pub(crate) fn check(
    state: &LbfgsbState,
    lower: &[f64],
    upper: &[f64],
    options: &LbfgsbOptions,
) -> Result<(), LbfgsbError> {
    check_lengths(state, lower, upper)?;
    check_options(options)?;
    for (variable, (&lower, &upper)) in lower.iter().zip(upper).enumerate() {
        let value = state.point[variable];
        let room = lower <= upper; // false for NaN
        if !room {
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

/// All vectors must have one entry per variable.
fn check_lengths(state: &LbfgsbState, lower: &[f64], upper: &[f64]) -> Result<(), LbfgsbError> {
    let expected = state.point.len();
    let vectors = [
        ("the lower bound", lower),
        ("the upper bound", upper),
        ("the gradient", &state.gradient),
    ];
    let steps = state
        .history
        .steps()
        .iter()
        .map(|s| ("a step", s.as_slice()));
    let changes = state.history.changes().iter();
    let changes = changes.map(|y| ("a change of the gradient", y.as_slice()));
    for (what, vector) in vectors.into_iter().chain(steps).chain(changes) {
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
    ];
    let wrong = |value: f64| value.is_nan() || value <= 0.0;
    match positive.into_iter().find(|(_, value)| wrong(*value)) {
        Some((option, value)) => Err(LbfgsbError::Option { option, value }),
        None => Ok(()),
    }
}
