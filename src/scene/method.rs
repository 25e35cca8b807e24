//! The scene's `method`: the options that each method has, with their defaults.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::descent::DescentOptions;
use crate::relax::plan::{FIRST_DESCENT, NO_LIMIT, Perturbation, PerturbationKind};
use crate::relax::relaxation_space::{Minimizer, REMEMBERED_STEPS};
use crate::scene::error::Error;
use crate::scene::numbers::{at_least_one, not_negative};

/// A method by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SceneMethod {
    /// Every site moves to its cell's center, again and again.
    Lloyd(Lloyd),
    /// All sites descend together along the exact global objective.
    QuasiNewton(QuasiNewton),
    /// Descents from disturbed sites, round by round; the best sites are kept.
    Anneal(Anneal),
}

impl Default for SceneMethod {
    fn default() -> Self {
        Self::Lloyd(Lloyd::default())
    }
}

impl SceneMethod {
    /// What makes cubes of the cells: annealing with exchanges.
    #[must_use]
    pub fn cubes() -> Self {
        Self::Anneal(Anneal::of_kind(PerturbationKind::Exchange))
    }

    /// What makes most hexahedra of a lattice of sites: a short descent, which keeps rows and moves walls' cells.
    /// Measured: 10 moves leave more of the volume to hexahedra than 25, 60, or Lloyd's 10 or 50, in all solids.
    #[must_use]
    pub fn mesh() -> Self {
        Self::QuasiNewton(QuasiNewton {
            iterations: 10,
            ..QuasiNewton::default()
        })
    }

    /// How many moves the method makes at most.
    #[must_use]
    pub fn iterations(&self) -> u64 {
        match self {
            Self::Lloyd(lloyd) => lloyd.iterations,
            Self::QuasiNewton(descent) => descent.iterations,
            Self::Anneal(anneal) => anneal.iterations.unwrap_or(NO_LIMIT),
        }
    }

    /// The movement in percent below which the method stops.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        match self {
            Self::Lloyd(lloyd) => lloyd.tolerance,
            Self::QuasiNewton(descent) => descent.tolerance,
            Self::Anneal(anneal) => anneal.tolerance,
        }
    }

    /// Which algorithm finds a cell's center.
    #[must_use]
    pub fn minimizer(&self) -> Minimizer {
        match self {
            Self::Lloyd(lloyd) => lloyd.minimizer,
            Self::QuasiNewton(_) | Self::Anneal(_) => Minimizer::default(),
        }
    }

    /// How many steps the method's descents remember at most; none where it has no descents.
    pub(crate) fn remembered(&self) -> Option<u64> {
        let memory = match self {
            Self::Lloyd(_) => return None,
            Self::QuasiNewton(descent) => descent.memory,
            Self::Anneal(anneal) => anneal.memory,
        };
        Some((memory.unwrap_or(REMEMBERED_STEPS) as u64).min(self.iterations()))
    }

    /// Whether Lloyd's moves are lengthened where that ends lower.
    #[must_use]
    pub fn is_accelerated(&self) -> bool {
        matches!(self, Self::Lloyd(lloyd) if lloyd.accelerate)
    }

    /// Validates the method's own numbers.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Lloyd(lloyd) => not_negative("method.lloyd.tolerance", lloyd.tolerance),
            Self::QuasiNewton(descent) => {
                not_negative("method.quasi_newton.tolerance", descent.tolerance)?;
                let key = "method.quasi_newton.gradient_tolerance";
                not_negative(key, descent.gradient_tolerance)?;
                at_least_one(
                    "method.quasi_newton.memory",
                    descent.memory.map_or(1, |memory| memory as u64),
                )
            }
            Self::Anneal(anneal) => {
                not_negative("method.anneal.tolerance", anneal.tolerance)?;
                not_negative("method.anneal.noise", anneal.noise)?;
                not_negative("method.anneal.fall", anneal.fall)?;
                let key = "method.anneal.gradient_tolerance";
                not_negative(key, anneal.gradient_tolerance)?;
                at_least_one(
                    "method.anneal.memory",
                    anneal.memory.map_or(1, |memory| memory as u64),
                )?;
                at_least_one("method.anneal.first_steps", anneal.first_steps)?;
                at_least_one("method.anneal.rounds", anneal.rounds)?;
                at_least_one("method.anneal.steps", anneal.steps)
            }
        }
    }
}

/// The options of Lloyd's iteration.
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

/// The options of the quasi-Newton descent.
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
    /// How many steps the model of the curvature remembers; ten if left out, of L∞ cells in space three.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<usize>,
    /// How many of Lloyd's moves come first, on every level.
    pub warm_up: u64,
}

/// The options of annealing.
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
    /// How many steps the model of the curvature remembers; ten if left out, of L∞ cells in space three.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub memory: Option<usize>,
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
    /// The defaults of a style.
    pub(crate) fn of_kind(style: PerturbationKind) -> Self {
        let (kicks, descent) = (Perturbation::default_of(style), DescentOptions::default());
        Self {
            iterations: None,
            tolerance: 0.0,
            rounds: kicks.rounds,
            steps: kicks.steps,
            noise: kicks.noise,
            fall: kicks.fall,
            seed: kicks.seed,
            first_steps: FIRST_DESCENT,
            memory: descent.memory,
            gradient_tolerance: descent.gradient_tolerance,
            warm_up: 0,
            exchange: style == PerturbationKind::Exchange,
        }
    }
}
