//! What each method is told, with its defaults.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::descent::DescentOptions;
use crate::relax::plan::{FIRST_DESCENT, Perturbation, PerturbationKind};
use crate::relax::relaxation_space;

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
    /// Whether moves go three times as far, where that ends lower than Lloyd's own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub accelerate: bool,
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

/// What the quasi-Newton descent is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct QuasiNewton {
    /// How many steps at most, those of the warm-up counted.
    pub iterations: u64,
    /// Stop when `movement_percent` falls below this; 0 never stops early.
    pub tolerance: f64,
    /// Stop when no component of the projected gradient is larger than this share of s^(2+p), s the
    /// side of the mean cell, times the mean density.
    pub gradient_tolerance: f64,
    /// How many steps the model of the curvature remembers.
    pub memory: usize,
    /// How many of Lloyd's moves come first, on every level.
    pub warm_up: u64,
}

/// What annealing is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Anneal {
    /// How many moves at most, over all rounds and levels; none if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iterations: Option<u64>,
    /// A descent ends when `movement_percent` falls below this.
    pub tolerance: f64,
    /// How many rounds on every level; fewer if all cells become cubes.
    pub rounds: u64,
    /// Steps of the descent that follows a disturbance.
    pub steps: u64,
    /// The greatest standard deviation of the noise, in sides of the mean cell.
    pub noise: f64,
    /// How the noise falls over the rounds: as (1 − round/rounds) to this power. 1 is linear, 0 not
    /// at all.
    pub fall: f64,
    /// From which the noise comes.
    pub seed: u64,
    /// The most steps of a level's first and last descent.
    pub first_steps: u64,
    /// How many steps the model of the curvature remembers.
    pub memory: usize,
    /// A descent ends when no component of the projected gradient is larger than this share of
    /// s^(2+p), s the side of the mean cell, times the mean density.
    pub gradient_tolerance: f64,
    /// How many of Lloyd's moves come first, on every level.
    pub warm_up: u64,
    /// Whether sites from crowded cells go to holes, with noise only where that does not help,
    /// instead of noise everywhere that falls from round to round.
    pub exchange: bool,
}

impl Default for Lloyd {
    fn default() -> Self {
        Self {
            iterations: 50,
            tolerance: 0.0,
            minimizer: Minimizer::default(),
            accelerate: false,
        }
    }
}

impl Default for QuasiNewton {
    fn default() -> Self {
        let descent = DescentOptions::default();
        Self {
            iterations: 200,
            tolerance: 0.0,
            gradient_tolerance: descent.gradient_tolerance,
            memory: descent.memory,
            warm_up: 0,
        }
    }
}

impl Default for Anneal {
    fn default() -> Self {
        Self::of_kind(PerturbationKind::Anneal)
    }
}

impl Anneal {
    /// The defaults of a kind.
    pub(crate) fn of_kind(kind: PerturbationKind) -> Self {
        let (rounds, descent) = (Perturbation::default_of(kind), DescentOptions::default());
        Self {
            iterations: None,
            tolerance: 0.0,
            rounds: rounds.rounds,
            steps: rounds.steps,
            noise: rounds.noise,
            fall: rounds.fall,
            seed: rounds.seed,
            first_steps: FIRST_DESCENT,
            memory: descent.memory,
            gradient_tolerance: descent.gradient_tolerance,
            warm_up: 0,
            exchange: kind == PerturbationKind::Exchange,
        }
    }
}

impl From<Minimizer> for relaxation_space::Minimizer {
    fn from(minimizer: Minimizer) -> Self {
        match minimizer {
            Minimizer::Newton => Self::Newton,
            Minimizer::Lbfgsb => Self::Lbfgsb,
        }
    }
}
