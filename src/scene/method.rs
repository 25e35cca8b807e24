//! The scene's `method`: how the sites move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::tessellation;
use crate::scene::error::Error;

/// A method by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// Every site moves to its cell's center, again and again.
    Lloyd(Lloyd),
}

/// A method's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodName {
    /// [`Method::Lloyd`].
    Lloyd,
}

/// What Lloyd's iteration is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lloyd {
    /// How many moves at most.
    pub iterations: u64,
    /// Stop when `movement_percent` falls below this; 0 never stops early.
    pub tolerance: f64,
    /// Which algorithm finds a cell's center.
    pub minimizer: Minimizer,
}

/// Which algorithm finds a cell's center; both find the same one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Minimizer {
    /// Projected Newton with exact Hessians.
    #[default]
    Newton,
    /// Limited-memory BFGS with bounds, the paper's choice.
    Lbfgsb,
}

impl Default for Method {
    fn default() -> Self {
        Self::Lloyd(Lloyd::default())
    }
}

impl Default for Lloyd {
    fn default() -> Self {
        Self {
            iterations: 50,
            tolerance: 0.0,
            minimizer: Minimizer::default(),
        }
    }
}

impl From<Minimizer> for tessellation::Minimizer {
    fn from(minimizer: Minimizer) -> Self {
        match minimizer {
            Minimizer::Newton => Self::Newton,
            Minimizer::Lbfgsb => Self::Lbfgsb,
        }
    }
}

impl Method {
    /// The method's name.
    #[must_use]
    pub fn name(&self) -> MethodName {
        match self {
            Self::Lloyd(_) => MethodName::Lloyd,
        }
    }

    /// Becomes the method `name` with its defaults, unless it is that method already.
    pub fn choose(&mut self, name: MethodName) {
        if self.name() != name {
            *self = match name {
                MethodName::Lloyd => Self::Lloyd(Lloyd::default()),
            };
        }
    }

    /// How many moves the method makes at most.
    #[must_use]
    pub fn iterations(&self) -> u64 {
        match self {
            Self::Lloyd(lloyd) => lloyd.iterations,
        }
    }

    /// Sets how many moves the method makes at most.
    pub fn set_iterations(&mut self, iterations: u64) {
        match self {
            Self::Lloyd(lloyd) => lloyd.iterations = iterations,
        }
    }

    /// Sets the movement in percent below which the method stops.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        match self {
            Self::Lloyd(lloyd) => lloyd.tolerance = tolerance,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Lloyd(lloyd) => validate_tolerance("method.lloyd.tolerance", lloyd.tolerance),
        }
    }
}

fn validate_tolerance(key: &str, tolerance: f64) -> Result<(), Error> {
    if tolerance.is_finite() && tolerance >= 0.0 {
        return Ok(());
    }
    Err(Error::value(
        key,
        format!("{tolerance:?} is no percentage; give 0 or a positive number"),
    ))
}
