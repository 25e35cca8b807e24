//! The scene's `method`: how the sites move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::descent::DescentOptions;
use crate::relax::plan::{KickStyle, Kicks, NO_LIMIT};
use crate::relax::tessellation;
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::norm::Norm;

/// 8^20 sites are more than any machine holds.
const MOST_LEVELS: u32 = 20;

/// A method by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// Every site moves to its cell's center, again and again.
    Lloyd(Lloyd),
    /// All sites descend together along the exact global objective.
    QuasiNewton(QuasiNewton),
    /// Descents from disturbed sites, round by round; the best sites are kept.
    Anneal(Anneal),
}

/// A method's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MethodName {
    /// [`Method::Lloyd`].
    Lloyd,
    /// [`Method::QuasiNewton`].
    QuasiNewton,
    /// [`Method::Anneal`].
    Anneal,
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
    /// How many of Lloyd's moves come first.
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
    /// From which the noise comes.
    pub seed: u64,
    /// Whether sites from crowded cells go to holes, with noise only where that does not help,
    /// instead of noise everywhere that falls from round to round.
    pub exchange: bool,
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
        Self::of_style(KickStyle::Anneal)
    }
}

impl Anneal {
    fn of_style(style: KickStyle) -> Self {
        let kicks = Kicks::default_of(style);
        Self {
            iterations: None,
            tolerance: 0.0,
            rounds: kicks.rounds,
            steps: kicks.steps,
            noise: kicks.noise,
            seed: kicks.seed,
            exchange: style == KickStyle::Exchange,
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
    /// What makes cubes of the cells: annealing with exchanges.
    #[must_use]
    pub fn cubes() -> Self {
        Self::Anneal(Anneal::of_style(KickStyle::Exchange))
    }

    /// The method's name.
    #[must_use]
    pub fn name(&self) -> MethodName {
        match self {
            Self::Lloyd(_) => MethodName::Lloyd,
            Self::QuasiNewton(_) => MethodName::QuasiNewton,
            Self::Anneal(_) => MethodName::Anneal,
        }
    }

    /// Becomes the method `name` with its defaults, unless it is that method already.
    pub fn choose(&mut self, name: MethodName) {
        if self.name() != name {
            *self = match name {
                MethodName::Lloyd => Self::Lloyd(Lloyd::default()),
                MethodName::QuasiNewton => Self::QuasiNewton(QuasiNewton::default()),
                MethodName::Anneal => Self::Anneal(Anneal::default()),
            };
        }
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

    /// Sets how many moves the method makes at most.
    pub fn set_iterations(&mut self, iterations: u64) {
        match self {
            Self::Lloyd(lloyd) => lloyd.iterations = iterations,
            Self::QuasiNewton(descent) => descent.iterations = iterations,
            Self::Anneal(anneal) => anneal.iterations = Some(iterations),
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

    /// Sets the movement in percent below which the method stops.
    pub fn set_tolerance(&mut self, tolerance: f64) {
        match self {
            Self::Lloyd(lloyd) => lloyd.tolerance = tolerance,
            Self::QuasiNewton(descent) => descent.tolerance = tolerance,
            Self::Anneal(anneal) => anneal.tolerance = tolerance,
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

    pub(crate) fn validate(&self, scene: &Scene) -> Result<(), Error> {
        let is_plain = matches!(self, Self::Lloyd(_)) && scene.coarse_to_fine.unwrap_or(0) == 0;
        if scene.dimension == 2 && !is_plain {
            let message = "in the plane there is \"lloyd\" only, without coarse_to_fine";
            return Err(Error::value("method", message.to_owned()));
        }
        if scene.norm == Norm::L2 && !matches!(self, Self::Lloyd(_)) {
            let message = "only \"lloyd\" can minimize another norm than \"linf\"";
            return Err(Error::value("norm", message.to_owned()));
        }
        if scene
            .coarse_to_fine
            .is_some_and(|levels| levels > MOST_LEVELS)
        {
            let message = format!("more than {MOST_LEVELS} levels make no sense");
            return Err(Error::value("coarse_to_fine", message));
        }
        match self {
            Self::Lloyd(lloyd) => not_negative("method.lloyd.tolerance", lloyd.tolerance),
            Self::QuasiNewton(descent) => {
                not_negative("method.quasi_newton.tolerance", descent.tolerance)?;
                let key = "method.quasi_newton.gradient_tolerance";
                not_negative(key, descent.gradient_tolerance)?;
                at_least_one("method.quasi_newton.memory", descent.memory as u64)
            }
            Self::Anneal(anneal) => {
                not_negative("method.anneal.tolerance", anneal.tolerance)?;
                not_negative("method.anneal.noise", anneal.noise)?;
                at_least_one("method.anneal.rounds", anneal.rounds)?;
                at_least_one("method.anneal.steps", anneal.steps)
            }
        }
    }
}

fn not_negative(key: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let message = match key.ends_with("tolerance") {
        true => format!("{value:?} is no percentage; give 0 or a positive number"),
        false => format!("{value:?} is not 0 or a positive number"),
    };
    Err(Error::value(key, message))
}

fn at_least_one(key: &str, value: u64) -> Result<(), Error> {
    if value > 0 {
        return Ok(());
    }
    Err(Error::value(
        key,
        "0 is too few; give at least 1".to_owned(),
    ))
}
