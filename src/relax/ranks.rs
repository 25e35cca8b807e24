//! Lloyd's iteration over ranks: processes that hold the sites of parts of the domain.
//!
//! Sites belong to the rank in whose brick they lie; bricks halve the sites again and again. Before every
//! diagram a rank is sent all sites within a width of its brick, its halo, in their true positions in the whole
//! domain, and builds the cells of its own sites only. A cell that reaches as far as r is right if every site within
//! r is known, so that a brick needs the width max(r − distance to the brick's open sides); where that is more
//! than it had, all is done again with as much, which is enough: more sites make cells smaller.
//!
//! Local indices are in the order of the sites' numbers, cells are cut in an order that depends on distances and
//! indices alone (`voronoi::search`), and sums are exact: sites and records have the same bits for any number of
//! ranks. Whatever leads to an exchange is decided by all ranks together.

use std::ops::ControlFlow;
use std::time::Instant;

use nalgebra::Point3;
use rayon::prelude::*;
use thiserror::Error;

use crate::integrals::exact_sum::{ExactSum, exact_sums};
use crate::relax::bricks::Bricks;
use crate::relax::driver::RunEnd;
use crate::relax::plan::Plan;
use crate::relax::record::{Movement, MovementSums, Record, Totals};
use crate::relax::relaxation_space::{CellResult, RelaxationSpace};
use crate::relax::space::{Space, SpaceError};

/// Processes that take part in a run, each calling the same methods in the same order.
pub trait Ranks {
    /// The number of this process, from zero.
    fn rank(&self) -> usize;

    /// How many there are.
    fn size(&self) -> usize;

    /// Sends `parts[r]` to rank r, for all r, and returns what each has sent here.
    fn exchange(&self, parts: Vec<Vec<u64>>) -> Vec<Vec<u64>>;

    /// Adds numbers over all ranks, each in its place.
    fn add(&self, numbers: &mut [i64]);

    /// The largest over all ranks of the numbers in each place.
    fn largest(&self, numbers: &mut [f64]);
}

/// Why a run over ranks failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum RanksError {
    /// The sites of this rank have no cells. Site indices count among those known to it.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// Another rank failed, and says why.
    #[error("another rank failed")]
    Elsewhere,
    /// The plan is of another method.
    #[error(
        "over ranks there is Lloyd's iteration only, not accelerated: \"method\": {{ \"lloyd\": {{}} }}"
    )]
    Method,
}

/// The first width, in sides of the mean cell: enough for most random sites.
const FIRST_WIDTH: f64 = 3.5;

/// The next width is this times what the last diagram needed: it needs less from move to move.
const SPARE: f64 = 1.05;

/// Moves between two divisions into bricks.
const MOVES_PER_DIVISION: u64 = 8;

/// Sites by whose places bricks are divided, per rank.
const SAMPLE: usize = 4096;

/// Some of the sites: their numbers among all, ascending, and where they lie.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SomeSites {
    /// Their numbers.
    pub(crate) numbers: Vec<u64>,
    /// Their positions.
    pub(crate) positions: Vec<Point3<f64>>,
}

impl SomeSites {
    fn push(&mut self, number: u64, position: Point3<f64>) {
        self.numbers.push(number);
        self.positions.push(position);
    }

    /// A site as it is sent.
    fn words(&self, place: usize) -> [u64; 4] {
        let at = &self.positions[place];
        [
            self.numbers[place],
            at.x.to_bits(),
            at.y.to_bits(),
            at.z.to_bits(),
        ]
    }

    /// The sites that were sent, in the order of their numbers.
    fn of_words(parts: &[Vec<u64>]) -> Self {
        let all = parts.iter().flat_map(|part| part.as_chunks::<4>().0);
        let mut all: Vec<&[u64; 4]> = all.collect();
        all.par_sort_unstable_by_key(|words| words[0]);
        let mut sites = Self::default();
        for [number, x, y, z] in all {
            let position = [x, y, z].map(|&bits| f64::from_bits(bits));
            sites.push(*number, Point3::from(position));
        }
        sites
    }
}

/// A run over ranks, as one of them sees it.
pub(crate) struct RankedRun<'a> {
    ranks: &'a dyn Ranks,
    space: &'a Space,
    plan: &'a Plan,
    /// How many sites there are in all.
    count: usize,
    bricks: Bricks,
    /// How wide the halo of each rank is (L).
    widths: Vec<f64>,
    own: SomeSites,
    cells: Vec<CellResult<3>>,
    evaluations: f64,
    began: Instant,
    earlier: f64,
}

/// Is shown each record by all ranks, and decides with them: what it returns must agree.
pub(crate) type RankedObserver<'o> = dyn FnMut(&Record, &RankedRun<'_>) -> ControlFlow<()> + 'o;

impl<'a> RankedRun<'a> {
    /// A run of `sites`, which rank 0 gives, all of them, that goes on after `last`.
    ///
    /// # Errors
    /// [`RanksError::Method`].
    pub(crate) fn new(
        ranks: &'a dyn Ranks,
        space: &'a Space,
        plan: &'a Plan,
        sites: Option<Vec<Point3<f64>>>,
        last: Option<&Record>,
    ) -> Result<Self, RanksError> {
        if plan.descent.is_some() || plan.is_accelerated || plan.perturbation.is_some() {
            return Err(RanksError::Method);
        }
        let positions = sites.unwrap_or_default();
        let mut count = [positions.len() as i64];
        ranks.add(&mut count);
        let count = count[0] as usize;
        let side = (space.volume() / count as f64).cbrt();
        let mut run = Self {
            ranks,
            space,
            plan,
            count,
            bricks: Bricks::new(&space.bounds(), space.periods(), Vec::new(), ranks.size()),
            widths: vec![FIRST_WIDTH * side; ranks.size()],
            own: SomeSites {
                numbers: (0..positions.len() as u64).collect(),
                positions,
            },
            cells: Vec::new(),
            evaluations: last.map_or(0.0, |last| (last.evaluations * count as f64).round()),
            began: Instant::now(),
            earlier: last.map_or(0.0, |last| last.seconds),
        };
        run.divide(SAMPLE * ranks.size());
        run.migrate();
        Ok(run)
    }

    /// Moves the sites until the plan is carried out or the observer stops it.
    ///
    /// # Errors
    /// [`RanksError`], on all ranks if on one.
    pub(crate) fn run(
        &mut self,
        last: Option<&Record>,
        observer: &mut RankedObserver<'_>,
    ) -> Result<RunEnd, RanksError> {
        let mut iteration = last.map_or(0, |last| last.iteration);
        let mut percent = last.map_or(f64::INFINITY, |last| last.movement_percent);
        self.assess()?;
        if last.is_none() {
            let record = self.record(0, Movement::default());
            if observer(&record, self).is_break() {
                return Ok(RunEnd::Interrupted);
            }
        }
        loop {
            let is_still = iteration > 0 && percent < self.plan.tolerance;
            if is_still {
                return Ok(RunEnd::Tolerance);
            }
            if iteration >= self.plan.iterations {
                return Ok(RunEnd::Iterations);
            }
            let movement = self.step(iteration)?;
            iteration += 1;
            let record = self.record(iteration, movement);
            percent = record.movement_percent;
            if observer(&record, self).is_break() {
                return Ok(RunEnd::Interrupted);
            }
        }
    }

    /// Whether any rank says so.
    #[must_use]
    pub(crate) fn any(&self, says: bool) -> bool {
        let mut flag = [f64::from(u8::from(says))];
        self.ranks.largest(&mut flag);
        flag[0] > 0.0
    }

    /// All sites in the order of their numbers, at rank 0; nothing elsewhere. All ranks must ask.
    #[must_use]
    pub(crate) fn gathered(&self) -> Option<Vec<Point3<f64>>> {
        let mut parts = vec![Vec::new(); self.ranks.size()];
        parts[0] = (0..self.own.numbers.len())
            .flat_map(|place| self.own.words(place))
            .collect();
        let came = SomeSites::of_words(&self.ranks.exchange(parts));
        (self.ranks.rank() == 0).then_some(came.positions)
    }

    /// One move: every site to its cell's center, and to the rank in whose brick that lies.
    fn step(&mut self, iteration: u64) -> Result<Movement, RanksError> {
        let targets: Vec<_> = self.cells.iter().map(|cell| cell.target).collect();
        let sums = MovementSums::of(self.space, &self.own.positions, &targets);
        let mut max = [sums.max];
        self.ranks.largest(&mut max);
        let movement = Movement {
            mean: self.total(&sums.total) / self.count as f64,
            max: max[0],
        };
        self.own.positions = targets;
        if (iteration + 1).is_multiple_of(MOVES_PER_DIVISION) {
            self.divide(SAMPLE);
        }
        self.migrate();
        self.assess()?;
        Ok(movement)
    }

    /// New bricks, of as many sites each, by up to `most` of the sites of every rank.
    fn divide(&mut self, most: usize) {
        let step = self.own.positions.len().div_ceil(most).max(1);
        let picked = self.own.positions.iter().step_by(step);
        let words: Vec<u64> = picked
            .flat_map(|site| <[f64; 3]>::from(self.space.wrap(site)).map(f64::to_bits))
            .collect();
        let came = self.ranks.exchange(vec![words; self.ranks.size()]);
        let all = came.iter().flat_map(|part| part.as_chunks::<3>().0);
        let sample = all
            .map(|words| Point3::from(words.map(f64::from_bits)))
            .collect();
        let (bounds, periods) = (self.space.bounds(), self.space.periods());
        self.bricks = Bricks::new(&bounds, periods, sample, self.ranks.size());
    }

    /// Sends sites to their owners.
    fn migrate(&mut self) {
        let mut parts = vec![Vec::new(); self.ranks.size()];
        for (place, site) in self.own.positions.iter().enumerate() {
            let owner = self.bricks.owner(&self.space.wrap(site));
            parts[owner].extend(self.own.words(place));
        }
        self.own = SomeSites::of_words(&self.ranks.exchange(parts));
    }

    /// The results of the own sites' cells, with as wide a halo as they need.
    fn assess(&mut self) -> Result<(), RanksError> {
        loop {
            let (known, chosen) = self.with_halo();
            let answers = match chosen.is_empty() {
                true => Ok(Vec::new()),
                false => {
                    (self.space).assess_of(&known.positions, self.count, &chosen, self.plan.spec)
                }
            };
            if self.any(answers.is_err()) {
                return Err(answers
                    .err()
                    .map_or(RanksError::Elsewhere, RanksError::Space));
            }
            let answers = answers.unwrap_or_default();
            let mut needed = vec![0.0; self.ranks.size()];
            needed[self.ranks.rank()] = self.needed(&answers);
            self.ranks.largest(&mut needed);
            let pairs = needed.iter().zip(&self.widths);
            let is_enough = pairs.clone().all(|(needed, width)| needed <= width);
            if is_enough {
                self.widths = needed.iter().map(|needed| SPARE * needed).collect();
                self.cells = answers.into_iter().map(|(cell, _)| cell).collect();
                return Ok(());
            }
            let wider = pairs.map(|(needed, width)| width.max(SPARE * needed));
            self.widths = wider.collect();
        }
    }

    /// The own sites with those within each rank's width of its brick, and the places of the own.
    fn with_halo(&self) -> (SomeSites, Vec<usize>) {
        let (size, rank) = (self.ranks.size(), self.ranks.rank());
        let mut parts = vec![Vec::new(); size];
        for (place, site) in self.own.positions.iter().enumerate() {
            let site = self.space.wrap(site);
            for (other, part) in parts.iter_mut().enumerate() {
                if other == rank || self.bricks.gap(other, &site) <= self.widths[other] {
                    part.extend(self.own.words(place));
                }
            }
        }
        let known = SomeSites::of_words(&self.ranks.exchange(parts));
        let chosen = self.own.numbers.iter().map(|number| {
            let place = known.numbers.binary_search(number);
            place.unwrap_or_else(|place| place)
        });
        let chosen = chosen.collect();
        (known, chosen)
    }

    /// How wide the halo must be for cells with these reaches (L).
    fn needed(&self, answers: &[(CellResult<3>, f64)]) -> f64 {
        let rank = self.ranks.rank();
        let each = self
            .own
            .positions
            .iter()
            .zip(answers)
            .map(|(site, (_, reach))| {
                let inside = self.bricks.depth(rank, &self.space.wrap(site));
                reach * (1.0 + 1e-9) - inside
            });
        each.fold(0.0, f64::max)
    }

    /// A sum over all ranks.
    fn total(&self, own: &ExactSum) -> f64 {
        let mut numbers = own.to_numbers();
        self.ranks.add(&mut numbers);
        ExactSum::from_numbers(&numbers).value()
    }

    /// The record of the sites, of which every rank has the same.
    fn record(&mut self, iteration: u64, movement: Movement) -> Record {
        let [energy, chebyshev] = exact_sums(&self.cells, |cell| [cell.energy, cell.chebyshev]);
        let energies = self.cells.iter().map(|cell| cell.energy);
        let mut max = [energies.fold(0.0, f64::max)];
        self.ranks.largest(&mut max);
        let own: i64 = self
            .cells
            .iter()
            .map(|cell| i64::from(cell.evaluations))
            .sum();
        let mut evaluations = [own];
        self.ranks.add(&mut evaluations);
        self.evaluations += evaluations[0] as f64;
        let totals = Totals {
            count: self.count,
            energy: self.total(&energy),
            energy_max: max[0],
            chebyshev: self.total(&chebyshev),
        };
        let (volume, optimum) = (self.space.volume(), self.space.optimum());
        Record {
            evaluations: self.evaluations / self.count as f64,
            seconds: self.earlier + self.began.elapsed().as_secs_f64(),
            ..Record::new::<3>(iteration, (volume, &optimum), &totals, movement)
        }
    }
}

impl std::fmt::Debug for RankedRun<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = formatter.debug_struct("RankedRun");
        text.field("rank", &self.ranks.rank());
        text.field("own", &self.own.numbers.len());
        text.finish_non_exhaustive()
    }
}
