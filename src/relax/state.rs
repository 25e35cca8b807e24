//! The state of a run between two moves: all that decides how it goes on, as plain numbers.
//!
//! A run that is taken up again from its sites and its state goes on to the bit as if nothing had
//! happened. All of the [`numbers`](RunState::numbers) are `f64`: counts are far below 2⁵³.

use nalgebra::Point;

use crate::minimize::history::History;
use crate::minimize::lbfgsb_state::LbfgsbState;
use crate::relax::multilevel::sites_of_level;
use crate::relax::record::Record;

/// The layout of the numbers.
const FORMAT: f64 = 1.0;

/// More levels than any run has: 8^64 is beyond all counts.
const MOST_LEVELS: f64 = 64.0;

/// How many counts begin the numbers.
const COUNTS: usize = 10;

/// The state of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunState<const D: usize> {
    /// How many sites the finest level has.
    pub(crate) count: usize,
    /// Levels still to come.
    pub(crate) level: u32,
    /// Perturbations made on this level.
    pub(crate) round: u64,
    /// Perturbations made on all levels, which number the streams of noise.
    pub(crate) perturbed: u64,
    /// Moves of the present descent.
    pub(crate) moves: u64,
    /// Whether the present descent is the level's last.
    pub(crate) is_last: bool,
    /// How many sites the next exchange moves at most; zero when the last perturbation was noise.
    pub(crate) pairs: usize,
    /// Exchanges of one site that did not help since the last noise.
    pub(crate) failures: u64,
    /// Sites × evaluations so far.
    pub(crate) evaluations: f64,
    /// The best sites of the level after a whole round, and their energy.
    pub(crate) best: Option<(f64, Vec<Point<f64, D>>)>,
    /// The present descent; none before its first step and during Lloyd's moves.
    pub(crate) descent: Option<LbfgsbState>,
}

impl<const D: usize> RunState<D> {
    /// Before the first move of a run with `count` sites and `levels` levels.
    #[must_use]
    pub fn new(count: usize, levels: u32) -> Self {
        Self {
            count,
            level: levels,
            ..Self::default()
        }
    }

    /// The state of plain Lloyd with `count` sites after `last`, which tells all of it.
    #[must_use]
    pub fn of_lloyd(count: usize, last: &Record) -> Self {
        Self {
            moves: last.iteration,
            evaluations: (last.evaluations * count as f64).round(),
            ..Self::new(count, 0)
        }
    }

    /// Whether this is the state of a run that has `sites` sites now: all of them, or those of a level.
    #[must_use]
    pub(crate) fn is_of(&self, sites: usize) -> bool {
        let of_level = sites_of_level::<D>(self.count, self.level);
        let best = self.best.as_ref().map_or(sites, |(_, best)| best.len());
        let point = self.descent.as_ref().map(|descent| descent.point().len());
        (sites == self.count || sites == of_level)
            && best == sites
            && point.is_none_or(|variables| variables == D * sites)
    }

    /// Begins the next finer level.
    pub(crate) fn begin_finer_level(&mut self) {
        *self = Self {
            perturbed: self.perturbed,
            evaluations: self.evaluations,
            ..Self::new(self.count, self.level.saturating_sub(1))
        };
    }

    /// The number of perturbations on the present level.
    #[must_use]
    pub fn round(&self) -> u64 {
        self.round
    }

    /// How many levels are still to come.
    #[must_use]
    pub fn level(&self) -> u32 {
        self.level
    }

    /// The state as numbers: those of a descent are many times the sites.
    pub fn numbers(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        let counts: [f64; COUNTS] = [
            FORMAT,
            self.count as f64,
            f64::from(self.level),
            self.round as f64,
            self.perturbed as f64,
            self.moves as f64,
            f64::from(u8::from(self.is_last)),
            self.pairs as f64,
            self.failures as f64,
            self.evaluations,
        ];
        let (energy, best) = self.best.as_ref().map_or((0.0, &[][..]), |(e, b)| (*e, b));
        let counts = counts.into_iter().chain([energy, best.len() as f64]);
        let best = best.iter().flat_map(|site| site.coords.data.0[0]);
        let descent = self.descent.iter().flat_map(numbers_of);
        counts.chain(best).chain(descent)
    }

    /// The state that gave the numbers; `None` if none did.
    #[must_use]
    pub fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let (counts, rest) = numbers.split_at_checked(COUNTS)?;
        let (best, rest) = rest.split_at_checked(2)?;
        let (sites, descent) = rest.split_at_checked(D.checked_mul(best[1] as usize)?)?;
        if counts[0].to_bits() != FORMAT.to_bits() || counts[2] > MOST_LEVELS {
            return None;
        }
        let sites: Vec<_> = sites.chunks_exact(D).map(Point::from_slice).collect();
        Some(Self {
            count: counts[1] as usize,
            level: counts[2] as u32,
            round: counts[3] as u64,
            perturbed: counts[4] as u64,
            moves: counts[5] as u64,
            is_last: counts[6] > 0.0,
            pairs: counts[7] as usize,
            failures: counts[8] as u64,
            evaluations: counts[9],
            best: (!sites.is_empty()).then_some((best[0], sites)),
            descent: if descent.is_empty() {
                None
            } else {
                Some(descent_of(descent)?)
            },
        })
    }
}

fn numbers_of(descent: &LbfgsbState) -> impl Iterator<Item = f64> + Clone + '_ {
    let history = descent.history();
    let head = [
        descent.point().len() as f64,
        history.len() as f64,
        descent.value(),
        descent.iterations() as f64,
        descent.evaluations() as f64,
    ];
    let place = descent.point().iter().chain(descent.gradient());
    let pairs = history.steps().iter().zip(history.changes());
    let pairs = pairs.flat_map(|(step, change)| step.iter().chain(change));
    head.into_iter().chain(place.chain(pairs).copied())
}

fn descent_of(numbers: &[f64]) -> Option<LbfgsbState> {
    let (head, vectors) = numbers.split_at_checked(5)?;
    let (variables, pairs) = (head[0] as usize, head[1] as usize);
    let count = pairs.checked_mul(2)?.checked_add(2)?;
    if variables == 0 || count.checked_mul(variables)? != vectors.len() {
        return None;
    }
    let mut vectors = vectors.chunks_exact(variables).map(<[f64]>::to_vec);
    let (point, gradient) = (vectors.next()?, vectors.next()?);
    let rest: Vec<_> = vectors.collect();
    let every_other = |first: usize| rest.iter().skip(first).step_by(2).cloned().collect();
    Some(LbfgsbState::from_parts(
        point,
        head[2],
        gradient,
        History::from_parts(every_other(0), every_other(1)),
        head[3] as u64,
        head[4] as u64,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_reads_back_from_its_numbers() {
        let numbers = |state: &RunState<3>| state.numbers().collect::<Vec<_>>();
        let mut state = RunState::<3>::new(9, 2);
        assert_eq!(
            RunState::from_numbers(&numbers(&state)),
            Some(state.clone())
        );
        state.best = Some((0.1 + 0.2, vec![Point::from([1.0, -0.0, 3.0])]));
        state.pairs = 4;
        let history = History::from_parts(vec![vec![1.0, 2.0, 3.0]], vec![vec![4.0, 5.0, 6.0]]);
        let (point, gradient) = (vec![0.5, 0.25, 1e-300], vec![1.0, 2.0, 1.0 / 3.0]);
        let descent = LbfgsbState::from_parts(point, 0.7, gradient, history, 5, 8);
        state.descent = Some(descent);
        assert_eq!(
            RunState::from_numbers(&numbers(&state)),
            Some(state.clone())
        );
        let numbers = numbers(&state);
        assert_eq!(
            RunState::<3>::from_numbers(&numbers[..numbers.len() - 1]),
            None
        );
        assert_eq!(RunState::<3>::from_numbers(&[]), None);
    }
}
