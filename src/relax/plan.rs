//! The plan of a run: its moves or descent, its perturbations, its levels. Plain Lloyd is the
//! simplest one.

use crate::relax::descent::DescentOptions;
use crate::relax::multilevel::levels_for_cubes;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm};

/// Steps after which a first descent has become so slow that perturbations gain more.
pub(crate) const FIRST_DESCENT: u64 = 150;

/// More moves than any run makes, and still exact as `f64`.
pub(crate) const NO_LIMIT: u64 = 1 << 40;

/// A run: levels from coarse to fine, on each a descent and perhaps perturbations, each followed
/// by a descent of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The energy of cells, and how Lloyd's moves minimize it.
    pub spec: EnergySpec,
    /// How often the number of sites is divided by eight (in the plane by four) before the first descent.
    pub levels: u32,
    /// Moves in total, over all levels and rounds.
    pub iterations: u64,
    /// A descent ends after a move with `movement_percent` below this.
    pub tolerance: f64,
    /// Lloyd's moves at the beginning of every level.
    pub warm_up: u64,
    /// Whether Lloyd's moves are lengthened where that ends lower.
    pub is_accelerated: bool,
    /// How to descend; `None` for Lloyd's moves alone.
    pub descent: Option<DescentOptions>,
    /// The most moves of a level's first and last descent.
    pub steps: u64,
    /// How to leave local minima; `None` descends once.
    pub perturbation: Option<Perturbation>,
}

impl Plan {
    /// Plain Lloyd: at most `iterations` moves (\[BL\] section 3.5).
    #[must_use]
    pub fn lloyd(spec: EnergySpec, iterations: u64) -> Self {
        Self {
            spec,
            descent: None,
            ..Self::quasi_newton(spec.order, iterations)
        }
    }

    /// A single descent of at most `iterations` steps.
    #[must_use]
    pub fn quasi_newton(order: u32, iterations: u64) -> Self {
        Self {
            spec: EnergySpec {
                norm: Norm::Linf,
                order,
                minimizer: Minimizer::Newton,
            },
            levels: 0,
            iterations,
            tolerance: 0.0,
            warm_up: 0,
            is_accelerated: false,
            descent: Some(DescentOptions {
                order,
                ..DescentOptions::default()
            }),
            steps: iterations,
            perturbation: None,
        }
    }

    /// A descent, then rounds of perturbation.
    #[must_use]
    pub fn perturbed(order: u32, perturbation: Perturbation) -> Self {
        Self {
            steps: FIRST_DESCENT,
            perturbation: Some(perturbation),
            ..Self::quasi_newton(order, NO_LIMIT)
        }
    }

    /// The plan that makes cubes of the cells of `count` sites, where one does.
    #[must_use]
    pub fn cubes(order: u32, count: usize) -> Self {
        Self {
            levels: levels_for_cubes::<3>(count),
            ..Self::perturbed(order, Perturbation::default_of(PerturbationKind::Exchange))
        }
    }
}

impl Perturbation {
    /// The rounds that a kind needs in most cases.
    #[must_use]
    pub fn default_of(kind: PerturbationKind) -> Self {
        let (rounds, steps, noise) = match kind {
            PerturbationKind::Anneal => (60, 10, 0.5),
            PerturbationKind::Exchange => (200, 20, 0.4),
        };
        Self {
            rounds,
            steps,
            noise,
            fall: 1.0,
            kind,
            seed: 1,
        }
    }
}

/// Rounds of disturbance, each followed by a descent; the best sites are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbation {
    /// How many on every level; none are made once all cells are cubes.
    pub rounds: u64,
    /// Moves of the descent that follows each.
    pub steps: u64,
    /// Standard deviation of the noise along every axis, in sides of the mean cell.
    pub noise: f64,
    /// The power of 1 − round/rounds with which [`PerturbationKind::Anneal`]'s noise falls; 1 is linear.
    pub fall: f64,
    /// What is done to the sites.
    pub kind: PerturbationKind,
    /// The seed of the noise.
    pub seed: u64,
}

/// What a perturbation does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PerturbationKind {
    /// Noise on all sites as the last round left them, falling to zero over the rounds.
    Anneal,
    /// From the best sites so far: sites from crowded cells go to holes, many at first, fewer when
    /// that does not help; when nothing helps, noise of random size on the cells that are no cubes.
    Exchange,
}
