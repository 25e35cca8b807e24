//! The scene's `method`: how the sites move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::plan::{NO_LIMIT, PerturbationKind};
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::method_keys::{Anneal, Lloyd, Minimizer, QuasiNewton};
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

impl Default for Method {
    fn default() -> Self {
        Self::Lloyd(Lloyd::default())
    }
}

impl Method {
    /// What makes cubes of the cells: annealing with exchanges.
    #[must_use]
    pub fn cubes() -> Self {
        Self::Anneal(Anneal::of_kind(PerturbationKind::Exchange))
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

    /// Whether Lloyd's moves are lengthened where that ends lower.
    #[must_use]
    pub fn is_accelerated(&self) -> bool {
        matches!(self, Self::Lloyd(lloyd) if lloyd.accelerate)
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
                not_negative("method.anneal.fall", anneal.fall)?;
                let key = "method.anneal.gradient_tolerance";
                not_negative(key, anneal.gradient_tolerance)?;
                at_least_one("method.anneal.memory", anneal.memory as u64)?;
                at_least_one("method.anneal.first_steps", anneal.first_steps)?;
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
