//! The loop of every run that is more than plain Lloyd: levels, descents and kicks.
//!
//! A run is a sequence of moves, each of which leaves a record: the choice of coarse sites, a move
//! of Lloyd's, a step of the quasi-Newton descent, a kick, the return to the best sites, the split
//! into a finer level. What comes next depends on nothing but the sites, the [`Stand`] and the last
//! record, so that a run may stop after any move and go on later, to the bit.

use std::ops::ControlFlow;
use std::time::Instant;

use nalgebra::Point3;
use thiserror::Error;

use crate::minimize::lbfgsb_options::LbfgsbError;
use crate::relax::descent::{Step, Totals, begin, sites_of, step};
use crate::relax::kick::{has_kicks_left, is_perfect, kick};
use crate::relax::levels::{coarsened, refined, sites_of_level};
use crate::relax::lloyd::Ended;
use crate::relax::over_relaxation::{Moved, Moves, advance, look};
use crate::relax::plan::Plan;
use crate::relax::record::{Movement, Record, Stage};
use crate::relax::space::Space;
use crate::relax::stand::Stand;
use crate::relax::tessellation::{Assessment, Tessellation};
use crate::voronoi::diagram::DiagramError;

/// Sites replace the best ones if their energy is lower by this share: less is rounding, or the
/// end of a descent that the last one will make anyway.
const BETTER: f64 = 1e-8;

/// Why a run failed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TravelError {
    /// The sites have no diagram.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
    /// The descent was asked for something impossible.
    #[error(transparent)]
    Descent(#[from] LbfgsbError),
}

/// Is shown a record, the sites it describes and the stand from which a run would go on, and says
/// whether to go on.
pub type Watch<'a> = dyn FnMut(&Record, &[Point3<f64>], &Stand) -> ControlFlow<()> + 'a;

/// Relaxes `sites` by `plan` from the start, or from where `last` was recorded with `stand`.
///
/// # Errors
/// [`TravelError`]; sites and stand are then of no further use.
pub fn travel(
    space: &Space,
    plan: &Plan,
    sites: &mut Vec<Point3<f64>>,
    stand: &mut Stand,
    last: Option<&Record>,
    watch: &mut Watch<'_>,
) -> Result<Ended, TravelError> {
    let began = Instant::now();
    let earlier = last.map_or(0.0, |record| record.seconds);
    let mut traveler = Traveler {
        space,
        plan,
        stand,
        sites,
        cells: None,
        lengthened: None,
        iteration: last.map_or(0, |record| record.iteration),
        movement_percent: last.map_or(f64::INFINITY, |record| record.movement_percent),
    };
    let mut totals = match last {
        None => Some(traveler.enter()?),
        Some(_) => None,
    };
    if traveler.stand.is_last && has_kicks_left(space, plan, traveler.stand) {
        // The rounds were cut short to return to the best sites. With more moves they go on.
        traveler.stand.is_last = false;
        traveler.stand.is_last = traveler.is_hurried();
    }
    let mut movement = Movement::default();
    loop {
        if let Some(totals) = totals {
            let mut record = traveler.record(totals, movement);
            record.seconds = earlier + began.elapsed().as_secs_f64();
            traveler.movement_percent = record.movement_percent;
            if watch(&record, traveler.sites, traveler.stand).is_break() {
                return Ok(Ended::Interrupted);
            }
        }
        if traveler.iteration >= plan.iterations {
            return Ok(Ended::Iterations);
        }
        let before = traveler.sites.clone();
        traveler.lengthened = None;
        totals = traveler.advance()?;
        if totals.is_none() {
            return Ok(Ended::Tolerance);
        }
        traveler.iteration += 1;
        movement = if before.len() == traveler.sites.len() {
            Movement::between(space, &before, traveler.sites.iter())
        } else {
            Movement::default()
        };
    }
}

struct Traveler<'a> {
    space: &'a Space,
    plan: &'a Plan,
    stand: &'a mut Stand,
    sites: &'a mut Vec<Point3<f64>>,
    /// The answers of the cells of `sites`, if they have been asked.
    cells: Option<Vec<Assessment<3>>>,
    /// Whether the last move was a lengthened one, if it was one of Lloyd's.
    lengthened: Option<bool>,
    iteration: u64,
    movement_percent: f64,
}

impl Traveler<'_> {
    /// The next move; `None` when the plan is carried out.
    fn advance(&mut self) -> Result<Option<Totals>, TravelError> {
        let is_worth_it = self.plan.iterations > 2 * u64::from(self.plan.levels);
        if self.iteration == 0 && self.stand.level > 0 && is_worth_it {
            let count = sites_of_level(self.stand.count, self.stand.level);
            *self.sites = coarsened(self.sites, count);
            return self.enter().map(Some);
        }
        loop {
            if let Some(totals) = self.descend()? {
                self.stand.moves += 1;
                return Ok(Some(totals));
            }
            if let Some(totals) = self.turn()? {
                return Ok(totals);
            }
        }
    }

    /// One move of the present descent, unless that is over.
    fn descend(&mut self) -> Result<Option<Totals>, TravelError> {
        let is_still = self.stand.moves > 0 && self.movement_percent < self.plan.tolerance;
        if is_still || self.stand.moves >= self.longest_descent() || self.is_hurried() {
            return Ok(None);
        }
        let is_warming_up =
            self.stand.round == 0 && !self.stand.is_last && self.stand.moves < self.plan.warm_up;
        let Some(options) = self.plan.descent.filter(|_| !is_warming_up) else {
            return self.lloyd_move().map(Some);
        };
        if self.stand.descent.is_none() {
            self.enter()?;
        }
        let Some(state) = &mut self.stand.descent else {
            return Ok(None);
        };
        let may_stop = self.plan.kicks.is_some() && !self.stand.is_last;
        if may_stop && is_perfect(self.space, state.value(), self.sites.len(), options.order) {
            return Ok(None);
        }
        let before = state.evaluations();
        let step = step(self.space, &options, state)?;
        let spent = (state.evaluations() - before) * self.sites.len() as u64;
        self.stand.evaluations += spent as f64;
        Ok(match step {
            Step::Taken(totals) => {
                *self.sites = sites_of(self.space, state.point());
                self.cells = None;
                Some(totals)
            }
            Step::Over => None,
        })
    }

    /// The most moves of the present descent.
    fn longest_descent(&self) -> u64 {
        match self.plan.kicks {
            Some(kicks) if self.stand.round > 0 && !self.stand.is_last => {
                // Noise disturbs more than an exchange.
                kicks.steps * if self.stand.pairs == 0 { 2 } else { 1 }
            }
            _ => self.plan.steps,
        }
    }

    /// Whether the moves left are needed to return to the best sites and to all of them.
    fn is_hurried(&self) -> bool {
        let has_kicks = u64::from(self.plan.kicks.is_some());
        let to_return = has_kicks * u64::from(!self.stand.is_last);
        let needed = to_return + u64::from(self.stand.level) * (1 + has_kicks);
        self.plan.iterations.saturating_sub(self.iteration) <= needed
    }

    fn lloyd_move(&mut self) -> Result<Totals, TravelError> {
        let (space, question) = (self.space, self.plan.question);
        let cells = match self.cells.take() {
            Some(cells) => cells,
            None => space.assess(self.sites, question)?,
        };
        let is_accelerated = self.plan.is_accelerated;
        let moves = Moves {
            question,
            is_accelerated,
        };
        let moved = advance(space, self.sites, &cells, moves)?;
        self.stand.descent = None;
        self.lengthened = is_accelerated.then_some(moved.is_lengthened);
        Ok(self.settle(moved))
    }

    /// Takes over sites whose cells are ready for Lloyd's next move.
    fn settle(&mut self, moved: Moved<3>) -> Totals {
        let totals = Totals::of_cells(&moved.cells);
        self.stand.evaluations += moved.evaluations as f64;
        *self.sites = moved.sites;
        self.cells = Some(moved.cells);
        totals
    }

    /// Evaluates new sites, from which the next descent begins.
    fn enter(&mut self) -> Result<Totals, TravelError> {
        if self.plan.descent.is_none() {
            let seen = look(self.space, self.sites.clone(), self.plan.question)?;
            return Ok(self.settle(seen));
        }
        let global = self.space.global(self.sites, self.plan.question.order)?;
        self.stand.evaluations += self.sites.len() as f64;
        self.stand.descent = self.plan.descent.map(|_| begin(self.sites, &global));
        self.cells = None;
        Ok(Totals::of(&global))
    }

    /// What follows a descent: the totals of a kick, of the best sites or of a finer level, `None`
    /// for another descent, `Some(None)` for nothing. A stand whose plan is carried out stays as it
    /// is, so that a run taken up again ends at once.
    fn turn(&mut self) -> Result<Option<Option<Totals>>, TravelError> {
        if let Some(kicks) = self.plan.kicks.filter(|_| !self.stand.is_last) {
            let is_better = self.keep_best();
            if has_kicks_left(self.space, self.plan, self.stand) && !self.is_hurried() {
                self.stand.moves = 0;
                let spent = kick(self.space, &kicks, is_better, self.sites, self.stand)?;
                self.stand.evaluations += spent;
                return self.enter().map(|totals| Some(Some(totals)));
            }
            self.stand.is_last = true;
            self.stand.moves = 0;
            let best = self.stand.best.as_ref().map(|(_, best)| best.clone());
            match best {
                Some(best) if *self.sites != best => *self.sites = best,
                _ => return Ok(None),
            }
            return self.enter().map(|totals| Some(Some(totals)));
        }
        if self.stand.level == 0 {
            return Ok(Some(None));
        }
        self.stand.descend_to_finer_level();
        let level = self.stand.level;
        *self.sites = refined(
            self.space,
            self.sites,
            sites_of_level(self.stand.count, level),
        );
        self.enter().map(|totals| Some(Some(totals)))
    }

    /// Takes the sites for the best if they are; says whether.
    fn keep_best(&mut self) -> bool {
        let Some(descent) = &self.stand.descent else {
            return false;
        };
        let energy = descent.value();
        let best = self.stand.best.as_ref();
        let is_better = best.is_none_or(|(best, _)| energy < best * (1.0 - BETTER));
        if is_better {
            self.stand.best = Some((energy, self.sites.clone()));
        }
        is_better
    }

    fn record(&self, totals: Totals, movement: Movement) -> Record {
        let mut record = Record::of_totals::<3>(
            self.iteration,
            self.space.volume(),
            (
                self.sites.len(),
                totals.energy,
                totals.energy_max,
                totals.chebyshev,
            ),
            movement,
        );
        record.evaluations = self.stand.evaluations / self.stand.count as f64;
        record.stage = Stage {
            level: (self.plan.levels > 0).then_some(self.stand.level),
            round: self.plan.kicks.map(|_| self.stand.round),
            sites: (self.plan.levels > 0).then_some(self.sites.len()),
            lengthened: self.lengthened,
        };
        record
    }
}
