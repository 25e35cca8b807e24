//! What a run is to do beyond plain Lloyd: descend how, kicked how often, over how many levels.

use crate::relax::descent::DescentOptions;
use crate::relax::levels::levels_for_cubes;
use crate::relax::tessellation::{Minimizer, Norm, Question};

/// Steps after which a first descent has become so slow that kicks gain more.
pub const FIRST_DESCENT: u64 = 150;

/// More moves than any run makes, and still a number of the tape.
pub const NO_LIMIT: u64 = 1 << 40;

/// A run: levels from coarse to fine, on each a descent and perhaps rounds of kicks, each followed
/// by a descent of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// What Lloyd's moves ask of every cell.
    pub question: Question,
    /// How often the number of sites is divided by eight before the first descent.
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
    /// What escapes local minima; `None` descends once.
    pub kicks: Option<Kicks>,
}

impl Plan {
    /// A single descent of at most `iterations` steps.
    #[must_use]
    pub fn quasi_newton(order: u32, iterations: u64) -> Self {
        Self {
            question: Question {
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
            kicks: None,
        }
    }

    /// A descent, then rounds of kicks.
    #[must_use]
    pub fn kicked(order: u32, kicks: Kicks) -> Self {
        Self {
            steps: FIRST_DESCENT,
            kicks: Some(kicks),
            ..Self::quasi_newton(order, NO_LIMIT)
        }
    }

    /// What makes cubes of the cells of `count` sites, if anything does.
    #[must_use]
    pub fn cubes(order: u32, count: usize) -> Self {
        Self {
            levels: levels_for_cubes(count),
            ..Self::kicked(order, Kicks::default_of(KickStyle::Exchange))
        }
    }
}

impl Kicks {
    /// The rounds that a style needs in most cases.
    #[must_use]
    pub fn default_of(style: KickStyle) -> Self {
        let (rounds, steps, noise) = match style {
            KickStyle::Anneal => (60, 10, 0.5),
            KickStyle::Exchange => (200, 20, 0.4),
        };
        Self {
            rounds,
            steps,
            noise,
            fall: 1.0,
            style,
            seed: 1,
        }
    }
}

/// Rounds of disturbance, each followed by a descent; the best sites are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kicks {
    /// How many on every level; none are made once all cells are cubes.
    pub rounds: u64,
    /// Moves of the descent that follows a kick.
    pub steps: u64,
    /// Standard deviation of the noise along every axis, in sides of the mean cell.
    pub noise: f64,
    /// The power of 1 − round/rounds with which [`KickStyle::Anneal`]'s noise falls; 1 is linear.
    pub fall: f64,
    /// What the noise falls on.
    pub style: KickStyle,
    /// From which the noise comes.
    pub seed: u64,
}

/// What a kick does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KickStyle {
    /// Noise on all sites as the last round left them, falling to zero over the rounds.
    Anneal,
    /// From the best sites so far: sites from crowded cells go to holes, many at first, fewer when
    /// that does not help; when nothing helps, noise of random size on the cells that are no cubes.
    Exchange,
}
