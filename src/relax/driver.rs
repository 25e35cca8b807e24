//! The driver of every run: plain and accelerated Lloyd, quasi-Newton, annealing, levels.
//!
//! A run is a sequence of moves, each of which leaves a record: the choice of coarse sites, a move
//! of Lloyd's, a step of the quasi-Newton descent, a perturbation, the return to the best sites, the
//! split into a finer level. The next move depends on nothing but the sites, the [`RunState`] and the
//! last record, so that a run may stop after any move and go on later, to the bit.

use std::ops::ControlFlow;
use std::time::Instant;

use nalgebra::Point;

use crate::minimize::problem::Termination;
use crate::parallel::{discard, map};
use crate::relax::descent::{DescentOptions, begin, descend, sites_of};
use crate::relax::lloyd::{EvaluatedSites, evaluate, lloyd_move};
use crate::relax::multilevel::{coarsened, sites_of_level};
use crate::relax::optimum::optimal_energy;
use crate::relax::perturb::perturb;
use crate::relax::plan::Plan;
use crate::relax::record::{Movement, Record, Stage, Totals};
use crate::relax::relaxation_space::{CellResult, RelaxationError, RelaxationSpace};
use crate::relax::split::refined;
use crate::relax::state::RunState;

/// Sites replace the best ones if their energy is lower by this share: less is rounding, or the
/// end of a descent that the last one will make anyway.
const BETTER: f64 = 1e-8;

/// All cells are cubes if the energy exceeds the least possible one by no more than this share: the
/// last descent does the rest. Far more than the gain that a round must bring.
const PERFECT: f64 = 1e-7;

/// A move of Lloyd's out of a stalled descent must gain at least this share of the energy: less is
/// rounding.
const LEAST_GAIN: f64 = 1e-12;

/// Moves that a level takes at least: the return to its best sites, and its split.
const LEVEL_MOVES: u64 = 2;

/// Why a run ended.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Method, Relaxation, RunEnd};
///
/// let lloyd = Relaxation::new(Cuboid::unit()).method(Method::lloyd(5));
/// assert_eq!(lloyd.run(&mut vec![[0.3; 3], [0.6; 3]])?.ended, RunEnd::Iterations);
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// All iterations were made.
    Iterations,
    /// The plan is carried out: the movement fell below the tolerance, or no step goes lower.
    Tolerance,
    /// The observer stopped the run.
    Interrupted,
}

/// Is shown a record, the sites that it describes and the state from which the run would go on, and
/// says whether to go on.
pub(crate) type Observer<'a, const D: usize> =
    dyn FnMut(&Record, &[Point<f64, D>], &RunState<D>) -> ControlFlow<()> + 'a;

/// Relaxes `sites` by `plan` from the start, or from where `last` was recorded with `state`.
///
/// To continue a run, give the sites, the state and the record that the observer was shown: the
/// continued run is bit-identical to an uninterrupted one.
///
/// # Errors
/// [`RelaxationError`]; sites and state are then of no further use.
pub(crate) fn drive<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    plan: &Plan,
    sites: &mut Vec<Point<f64, D>>,
    state: &mut RunState<D>,
    last: Option<&Record>,
    observer: &mut Observer<'_, D>,
) -> Result<RunEnd, RelaxationError<S::Error>> {
    if last.is_none() && plan.iterations <= LEVEL_MOVES * u64::from(state.level) {
        // So few moves are worth more on the finest level than on the way to it.
        state.level = 0;
    }
    let mut driver = Driver {
        space,
        plan,
        state,
        sites,
        observer,
        cells: None,
        is_converged: false,
        iteration: last.map_or(0, |record| record.iteration),
        movement_percent: last.map_or(f64::INFINITY, |record| record.movement_percent),
        began: Instant::now(),
        earlier: last.map_or(0.0, |record| record.seconds),
    };
    if last.is_none() {
        let totals = driver.evaluate(driver.sites.clone())?;
        if let ControlFlow::Break(end) = driver.show(&totals, Movement::default(), None) {
            return Ok(end);
        }
    }
    if driver.state.is_last && driver.has_rounds_left() {
        // The rounds were cut short to return to the best sites. With more moves they go on.
        driver.state.is_last = false;
        driver.state.is_last = driver.is_hurried();
    }
    driver.run()
}

/// What follows a move: the next one, or the end of the run.
type Flow<E> = Result<ControlFlow<RunEnd>, RelaxationError<E>>;

struct Driver<'a, 'o, const D: usize, S> {
    space: &'a S,
    plan: &'a Plan,
    state: &'a mut RunState<D>,
    sites: &'a mut Vec<Point<f64, D>>,
    observer: &'a mut Observer<'o, D>,
    /// The results of the cells of `sites`, if they are known.
    cells: Option<Vec<CellResult<D>>>,
    /// Whether the present descent found no further step.
    is_converged: bool,
    iteration: u64,
    movement_percent: f64,
    began: Instant,
    /// The time that the run took before it was taken up (s).
    earlier: f64,
}

impl<const D: usize, S: RelaxationSpace<D>> Driver<'_, '_, D, S> {
    fn run(&mut self) -> Result<RunEnd, RelaxationError<S::Error>> {
        loop {
            if self.iteration >= self.plan.iterations {
                let is_last = self.plan.perturbation.is_none() || self.state.is_last;
                let is_done = is_last && self.state.level == 0 && self.is_still();
                return Ok(if is_done {
                    RunEnd::Tolerance
                } else {
                    RunEnd::Iterations
                });
            }
            let flow = if self.iteration == 0 && self.state.level > 0 {
                let count = sites_of_level::<D>(self.state.count, self.state.level);
                self.move_to(coarsened(self.sites, count))?
            } else if self.is_descent_over() {
                self.end_descent()?
            } else if let Some(options) = self.plan.descent.filter(|_| !self.is_warming_up()) {
                self.descend(&options)?
            } else {
                self.lloyd_move()?
            };
            if let ControlFlow::Break(end) = flow {
                return Ok(end);
            }
        }
    }

    /// Whether the last move of the present descent was too short to go on.
    fn is_still(&self) -> bool {
        self.state.moves > 0 && self.movement_percent < self.plan.tolerance
    }

    /// Whether the present descent is at its end.
    fn is_descent_over(&self) -> bool {
        let may_be_perfect =
            self.plan.perturbation.is_some() && !self.state.is_last && !self.is_warming_up();
        let descent = self.state.descent.as_ref().filter(|_| may_be_perfect);
        self.is_converged
            || self.is_still()
            || self.state.moves >= self.longest_descent()
            || self.is_hurried()
            || descent.is_some_and(|descent| self.is_perfect(descent.value(), self.sites.len()))
    }

    /// Whether the present move is one of Lloyd's before a level's first descent.
    fn is_warming_up(&self) -> bool {
        self.state.round == 0 && !self.state.is_last && self.state.moves < self.plan.warm_up
    }

    /// The most moves of the present descent.
    fn longest_descent(&self) -> u64 {
        match self.plan.perturbation {
            Some(perturbation) if self.state.round > 0 && !self.state.is_last => {
                // Noise disturbs more than an exchange.
                perturbation.steps * if self.state.pairs == 0 { 2 } else { 1 }
            }
            _ => self.plan.steps,
        }
    }

    /// Whether the moves left are needed to return to the best sites and to all of them. (Of a run that
    /// is stopped before, [`split_to_finest`](crate::relax::split::split_to_finest) gives all sites.)
    fn is_hurried(&self) -> bool {
        let has_rounds = u64::from(self.plan.perturbation.is_some());
        let to_return = has_rounds * u64::from(!self.state.is_last);
        let needed = to_return + u64::from(self.state.level) * (1 + has_rounds);
        self.plan.iterations.saturating_sub(self.iteration) <= needed
    }

    /// Whether `count` sites of this energy have cubes for cells, but for a last descent. Where some
    /// places weigh more than others nobody knows the least energy.
    fn is_perfect(&self, energy: f64, count: usize) -> bool {
        let order = self.plan.spec.order;
        let least = count as f64 * optimal_energy::<D>(self.space.volume(), count, order);
        self.space.varying_density().is_none() && energy <= least * (1.0 + PERFECT)
    }

    /// Whether the present level may be perturbed again: rounds are left, and its best sites do not
    /// yet have cubes for cells.
    fn has_rounds_left(&self) -> bool {
        match (self.plan.perturbation, &self.state.best) {
            (Some(perturbation), Some((energy, best))) => {
                self.state.round < perturbation.rounds && !self.is_perfect(*energy, best.len())
            }
            _ => false,
        }
    }

    fn lloyd_move(&mut self) -> Flow<S::Error> {
        let (space, spec) = (self.space, self.plan.spec);
        let cells = match self.cells.take() {
            Some(cells) => cells,
            None => space
                .assess(self.sites, spec)
                .map_err(RelaxationError::Space)?,
        };
        let is_accelerated = self.plan.is_accelerated;
        let targets = map(cells.len(), &|site| cells[site].target);
        discard(cells);
        let moved = lloyd_move(space, self.sites, targets, spec, is_accelerated)
            .map_err(RelaxationError::Space)?;
        self.state.descent = None;
        self.state.moves += 1;
        let lengthened = is_accelerated.then_some(moved.is_lengthened);
        let (sites, totals) = self.keep_cells(moved);
        Ok(self.moved_to(sites, &totals, lengthened))
    }

    /// Keeps the results of the cells of sites for Lloyd's next move.
    fn keep_cells(&mut self, evaluated: EvaluatedSites<D>) -> (Vec<Point<f64, D>>, Totals) {
        let totals = Totals::of_cells(&evaluated.cells);
        self.state.evaluations += evaluated.evaluations as f64;
        self.cells = Some(evaluated.cells);
        (evaluated.sites, totals)
    }

    /// Evaluates sites from which the next descent begins.
    fn evaluate(&mut self, sites: Vec<Point<f64, D>>) -> Result<Totals, RelaxationError<S::Error>> {
        self.is_converged = false;
        if self.plan.descent.is_none() {
            let evaluated = evaluate(self.space, sites, self.plan.spec);
            let evaluated = evaluated.map_err(RelaxationError::Space)?;
            return Ok(self.keep_cells(evaluated).1);
        }
        let objective = self.space.objective(&sites, self.plan.spec.order)?;
        self.state.evaluations += sites.len() as f64;
        self.state.descent = Some(begin(&sites, &objective));
        self.cells = None;
        Ok(Totals::of_objective(&objective))
    }

    /// Steps of the quasi-Newton descent until it is at its end or the run is.
    fn descend(&mut self, options: &DescentOptions) -> Flow<S::Error> {
        if self.state.descent.is_none() {
            self.evaluate(self.sites.clone())?;
            if self.is_descent_over() {
                return Ok(ControlFlow::Continue(()));
            }
        }
        let start = self.state.descent.take().unwrap_or_default();
        let (space, count) = (self.space, self.sites.len() as u64);
        let mut counted = start.evaluations();
        let mut flow = ControlFlow::Continue(());
        let end = descend(space, options, start, |descent, totals| {
            self.state.moves += 1;
            self.state.evaluations += ((descent.evaluations() - counted) * count) as f64;
            counted = descent.evaluations();
            let sites = sites_of(space, descent.point());
            self.cells = None;
            self.state.descent = Some(std::mem::take(descent));
            flow = self.moved_to(sites, &totals, None);
            let is_over = self.iteration >= self.plan.iterations || self.is_descent_over();
            *descent = self.state.descent.take().unwrap_or_default();
            if flow.is_break() || is_over {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        })?;
        self.state.evaluations += ((end.state.evaluations() - counted) * count) as f64;
        self.state.descent = Some(end.state);
        match end.ended {
            Termination::NoDescent if flow.is_continue() => self.lloyd_out_of_stall(),
            ended => {
                self.is_converged = ended != Termination::Stopped;
                Ok(flow)
            }
        }
    }

    /// One of Lloyd's moves where the descent's search finds nothing lower although the gradient says that
    /// there is; the end of the descent if that gains nothing either.
    fn lloyd_out_of_stall(&mut self) -> Flow<S::Error> {
        let (space, spec) = (self.space, self.plan.spec);
        let Some(stalled) = self.state.descent.take() else {
            return Ok(ControlFlow::Continue(()));
        };
        let cells = space
            .assess(self.sites, spec)
            .map_err(RelaxationError::Space)?;
        let evaluations: u64 = cells.iter().map(|cell| u64::from(cell.evaluations)).sum();
        self.state.evaluations += evaluations as f64;
        let targets: Vec<_> = cells.iter().map(|cell| cell.target).collect();
        let totals = self.evaluate(targets.clone())?;
        if totals.energy < stalled.value() * (1.0 - LEAST_GAIN) {
            self.state.moves += 1;
            return Ok(self.moved_to(targets, &totals, None));
        }
        self.state.descent = Some(stalled);
        self.is_converged = true;
        Ok(ControlFlow::Continue(()))
    }

    /// The move after a descent: a perturbation, the return to the best sites or a finer level; none
    /// before another descent. A state whose plan is carried out stays as it is, so that a run taken
    /// up again ends at once.
    fn end_descent(&mut self) -> Flow<S::Error> {
        if let Some(perturbation) = self.plan.perturbation.filter(|_| !self.state.is_last) {
            let is_better = self.keep_best();
            self.state.moves = 0;
            if self.has_rounds_left() && !self.is_hurried() {
                let mut sites = self.sites.clone();
                let spent = perturb(self.space, &perturbation, is_better, &mut sites, self.state)?;
                self.state.evaluations += spent;
                return self.move_to(sites);
            }
            self.state.is_last = true;
            self.is_converged = false;
            let best = self.state.best.as_ref().map(|(_, best)| best.clone());
            return match best {
                Some(best) if *self.sites != best => self.move_to(best),
                _ => Ok(ControlFlow::Continue(())),
            };
        }
        if self.state.level == 0 {
            return Ok(ControlFlow::Break(RunEnd::Tolerance));
        }
        self.state.begin_finer_level();
        let count = sites_of_level::<D>(self.state.count, self.state.level);
        self.move_to(refined(self.space, self.sites, count)?)
    }

    /// Takes the sites for the best if they are; says whether.
    fn keep_best(&mut self) -> bool {
        let Some(descent) = &self.state.descent else {
            return false;
        };
        let energy = descent.value();
        let best = self.state.best.as_ref();
        let is_better = best.is_none_or(|(best, _)| energy < best * (1.0 - BETTER));
        if is_better {
            self.state.best = Some((energy, self.sites.clone()));
        }
        is_better
    }

    /// Moves to sites from which the next descent begins.
    fn move_to(&mut self, sites: Vec<Point<f64, D>>) -> Flow<S::Error> {
        let totals = self.evaluate(sites.clone())?;
        Ok(self.moved_to(sites, &totals, None))
    }

    /// Takes over sites after a move and shows its record.
    fn moved_to(
        &mut self,
        sites: Vec<Point<f64, D>>,
        totals: &Totals,
        lengthened: Option<bool>,
    ) -> ControlFlow<RunEnd> {
        let movement = if sites.len() == self.sites.len() {
            Movement::between(self.space, self.sites, &sites)
        } else {
            Movement::default()
        };
        discard(std::mem::replace(self.sites, sites));
        self.iteration += 1;
        self.show(totals, movement, lengthened)
    }

    /// Shows the observer the record of the sites.
    fn show(
        &mut self,
        totals: &Totals,
        movement: Movement,
        lengthened: Option<bool>,
    ) -> ControlFlow<RunEnd> {
        let (plan, state) = (self.plan, &*self.state);
        let (volume, optimum) = (self.space.volume(), self.space.optimum());
        let record = Record {
            evaluations: state.evaluations / state.count as f64,
            seconds: self.earlier + self.began.elapsed().as_secs_f64(),
            stage: Stage {
                level: (plan.levels > 0).then_some(state.level),
                round: plan.perturbation.map(|_| state.round),
                sites: (plan.levels > 0).then_some(self.sites.len()),
                lengthened,
            },
            ..Record::new::<D>(self.iteration, (volume, &optimum), totals, movement)
        };
        self.movement_percent = record.movement_percent;
        if (self.observer)(&record, self.sites, state).is_break() {
            return ControlFlow::Break(RunEnd::Interrupted);
        }
        ControlFlow::Continue(())
    }
}
