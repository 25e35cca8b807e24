//! Lloyd's iteration over ranks: no rank holds more than its own sites and its halo.
//!
//! Sums are exact, so that nobody's order matters: sites and records have the same bits for any number of ranks.

use std::ops::ControlFlow;
use std::time::Instant;

use crate::integrals::exact_sum::exact_sums;
use crate::relax::cell_check::CellsError;
use crate::relax::driver::RunEnd;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::plan::Plan;
use crate::relax::ranked_sites::RankedSites;
use crate::relax::ranks::{RanksError, total};
use crate::relax::record::{Movement, MovementSums, Record, Totals};
use crate::relax::relaxation_space::{CellResult, RelaxationSpace};

/// Moves between two divisions into bricks.
const MOVES_PER_DIVISION: u64 = 8;

/// A run of Lloyd's iteration over ranks, as one of them sees it.
#[derive(Debug)]
pub(crate) struct RankedRun<'a> {
    pub(crate) sites: RankedSites<'a>,
    plan: &'a Plan,
    cells: Vec<CellResult<3>>,
    evaluations: f64,
    began: Instant,
    earlier: f64,
}

/// Is shown each record by all ranks, and decides with them: what it returns must agree.
pub(crate) type RankedObserver<'o> = dyn FnMut(&Record, &RankedSites<'_>) -> ControlFlow<()> + 'o;

/// Whether a plan is of Lloyd's iteration alone.
pub(crate) fn is_plain(plan: &Plan) -> bool {
    let is_lloyd = plan.descent.is_none() && plan.perturbation.is_none();
    is_lloyd && !plan.is_accelerated && plan.levels == 0
}

impl<'a> RankedRun<'a> {
    /// A run of `sites` that goes on after `last`, by a plan of Lloyd's iteration alone.
    pub(crate) fn new(sites: RankedSites<'a>, plan: &'a Plan, last: Option<&Record>) -> Self {
        let count = sites.count as f64;
        Self {
            sites,
            plan,
            cells: Vec::new(),
            evaluations: last.map_or(0.0, |last| (last.evaluations * count).round()),
            began: Instant::now(),
            earlier: last.map_or(0.0, |last| last.seconds),
        }
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
            let record = self.record(0, Movement::default())?;
            if observer(&record, &self.sites).is_break() {
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
            let record = self.record(iteration, movement)?;
            percent = record.movement_percent;
            if observer(&record, &self.sites).is_break() {
                return Ok(RunEnd::Interrupted);
            }
        }
    }

    /// One move: every site to its cell's center, and to the rank in whose brick that lies.
    fn step(&mut self, iteration: u64) -> Result<Movement, RanksError> {
        let sites = &mut self.sites;
        let targets: Vec<_> = self.cells.iter().map(|cell| cell.target).collect();
        let sums = MovementSums::of(sites.space, &sites.own.positions, &targets);
        let mut max = [sums.max];
        sites.ranks.largest(&mut max);
        let movement = Movement {
            mean: total(sites.ranks, &sums.total) / sites.count as f64,
            max: max[0],
        };
        sites.own.positions = targets;
        if (iteration + 1).is_multiple_of(MOVES_PER_DIVISION) {
            sites.divide_again();
        }
        sites.migrate();
        self.assess()?;
        Ok(movement)
    }

    /// The results of the own sites' cells.
    fn assess(&mut self) -> Result<(), RanksError> {
        let (space, spec) = (self.sites.space, self.plan.spec);
        space.check_scale(self.sites.count, spec)?;
        self.cells = self.sites.map_own(|memory: &mut CellMemory, cell| {
            memory.load_in_frame(space.domain(), cell, space.frames().of(cell.site));
            memory.assess(space.domain(), cell, spec)
        })?;
        let figures = self.cells.iter().map(|cell| (cell.volume, cell.energy));
        self.sites.check(&figures.collect::<Vec<_>>(), spec.kind())
    }

    /// The record of the sites, of which every rank has the same.
    fn record(&mut self, iteration: u64, movement: Movement) -> Result<Record, CellsError> {
        let (ranks, space, count) = (self.sites.ranks, self.sites.space, self.sites.count);
        let [energy, chebyshev] = exact_sums(&self.cells, |cell| [cell.energy, cell.chebyshev]);
        let energies = self.cells.iter().map(|cell| cell.energy);
        let mut max = [energies.fold(0.0, f64::max)];
        ranks.largest(&mut max);
        let own = self.cells.iter().map(|cell| i64::from(cell.evaluations));
        let mut evaluations = [own.sum::<i64>()];
        ranks.add(&mut evaluations);
        self.evaluations += evaluations[0] as f64;
        let totals = Totals {
            count,
            energy: total(ranks, &energy),
            energy_max: max[0],
            chebyshev: total(ranks, &chebyshev),
        };
        let (volume, optimum) = (space.volume(), space.optimum());
        let record = Record {
            evaluations: self.evaluations / count as f64,
            seconds: self.earlier + self.began.elapsed().as_secs_f64(),
            ..Record::new::<3>(iteration, (volume, &optimum), &totals, movement)
        };
        match record.not_finite() {
            None => Ok(record),
            Some((figure, value)) => Err(CellsError::Total {
                figure,
                iteration,
                value,
            }),
        }
    }
}
