//! Quasi-Newton descent of the global objective (\[LL\] section 4) by L-BFGS-B.
//!
//! L-BFGS-B keeps the sites in the domain's box (periodic axes have no bounds; sites are wrapped
//! back where their cells are built). In every other domain each site's step is bent along the walls
//! that it would cross, for itself: one site at a wall holds up no other. A trial that has no diagram
//! all the same counts as infinitely high, and the search along the step retreats.
//!
//! argmin's executor drives a whole descent; the observer of each accepted step may end it.

use std::cell::RefCell;
use std::ops::ControlFlow;

use nalgebra::{Point, SVector};

use crate::minimize::history::History;
use crate::minimize::lbfgsb::{Bend, LbfgsbEnd, lbfgsb_within};
use crate::minimize::lbfgsb_state::{LbfgsbError, LbfgsbOptions, LbfgsbState};
use crate::relax::optimum::optimal_side;
use crate::relax::record::Totals;
use crate::relax::relaxation_space::{ObjectiveValue, RelaxationSpace};

/// The first model of the curvature is this share of that of a cube about its center, which is what
/// a site feels whose cell stands still: cells follow their sites about half of the way. From random
/// sites the first step is then accepted at once, and twice or half of it gains no less in the end.
const FIRST_CURVATURE: f64 = 0.5;

/// No step moves a site farther than this many sides of the mean cell. Half as far holds up the
/// first few steps from random sites; twice as far never happens.
const LARGEST_STEP: f64 = 1.0;

/// The options of a descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentOptions {
    /// The order p ≥ 1 of the energy.
    pub order: u32,
    /// How many steps the model of the curvature remembers; as many as suit the cells where it is none (ten,
    /// of L∞ cells in space three).
    pub memory: Option<usize>,
    /// Converged once no component of the projected gradient is larger than this share of
    /// s^(2+p), s the side of the mean cell, times the mean density.
    pub gradient_tolerance: f64,
}

impl Default for DescentOptions {
    /// p = 1, tolerance 1e-9.
    fn default() -> Self {
        Self {
            order: 1,
            memory: None,
            gradient_tolerance: 1e-9,
        }
    }
}

/// The state of a descent from `sites`, where the objective is `objective`.
pub(crate) fn begin<const D: usize>(
    sites: &[Point<f64, D>],
    objective: &ObjectiveValue<D>,
) -> LbfgsbState {
    let point = sites.iter().flat_map(|site| site.coords.data.0[0]);
    let gradient = objective.gradient.iter().flat_map(|g| g.data.0[0]);
    LbfgsbState::from_parts(
        point.collect(),
        objective.energy,
        gradient.collect(),
        History::default(),
        0,
        1,
    )
}

/// The sites of a descent's variables, within the domain.
pub(crate) fn sites_of<const D: usize>(
    space: &impl RelaxationSpace<D>,
    point: &[f64],
) -> Vec<Point<f64, D>> {
    let sites = point.chunks_exact(D).map(Point::from_slice);
    sites.map(|site| space.wrap(&site)).collect()
}

/// Descends from `state` until no further step is worth taking or `accepted` breaks. That is shown
/// the state after each step and the totals there, and may take the state for the time of its call.
///
/// # Errors
/// When `state` lies outside the box or is damaged.
pub(crate) fn descend<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    options: &DescentOptions,
    state: LbfgsbState,
    mut accepted: impl FnMut(&mut LbfgsbState, Totals) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    let count = state.point().len() / D;
    let trials: RefCell<Vec<Totals>> = RefCell::default();
    let objective = |point: &[f64], gradient: &mut [f64]| {
        let Ok(value) = space.objective(&sites_of(space, point), options.order) else {
            return f64::NAN;
        };
        for (entries, of_site) in gradient.chunks_exact_mut(D).zip(&value.gradient) {
            entries.copy_from_slice(of_site.as_slice());
        }
        trials.borrow_mut().push(Totals::of_objective(&value));
        value.energy
    };
    let (lower, upper) = box_bounds(space);
    let solver = solver_options(space, options, count);
    let bend = |point: &[f64], step: &mut [f64]| bend_along_walls(space, point, step);
    let walls: Option<Bend<'_>> = if space.is_box() { None } else { Some(&bend) };
    let within = [lower.as_slice(), upper.as_slice()];
    lbfgsb_within(objective, state, within, walls, &solver, |state, _| {
        let trials = std::mem::take(&mut *trials.borrow_mut());
        let is_taken = |trial: &&Totals| trial.energy.to_bits() == state.value().to_bits();
        match trials.iter().rev().find(is_taken) {
            Some(totals) => accepted(state, *totals),
            None => ControlFlow::Break(()),
        }
    })
}

/// Bends every site's step along the walls in its way and says whether there were any.
fn bend_along_walls<const D: usize>(
    space: &impl RelaxationSpace<D>,
    point: &[f64],
    step: &mut [f64],
) -> bool {
    let mut is_bent = false;
    for (site, step) in point.chunks_exact(D).zip(step.chunks_exact_mut(D)) {
        let wanted = SVector::from_column_slice(step);
        let site = space.wrap(&Point::from_slice(site));
        let bent = space.along_walls(&site, wanted);
        if bent != wanted {
            step.copy_from_slice(bent.as_slice());
            is_bent = true;
        }
    }
    is_bent
}

/// The scales of a descent of `count` sites. The first model is [`FIRST_CURVATURE`] times
/// 8p (s/2)^(1+p), the second derivative of a cube's energy ∫ d∞^p about its center in every
/// direction, s the side of the mean cell.
fn solver_options<const D: usize>(
    space: &impl RelaxationSpace<D>,
    options: &DescentOptions,
    count: usize,
) -> LbfgsbOptions {
    let side = optimal_side::<D>(space.volume(), count);
    let density = space.varying_density().unwrap_or(1.0);
    let cube =
        density * 8.0 * f64::from(options.order) * (0.5 * side).powi(1 + options.order as i32);
    LbfgsbOptions {
        memory: options.memory.unwrap_or(space.remembered_steps()),
        scale: density * side.powi(2 + options.order as i32),
        gradient_tolerance: options.gradient_tolerance,
        group: D,
        first_curvature: Some(FIRST_CURVATURE * cube),
        largest_step: LARGEST_STEP * side,
        max_evaluations: u64::MAX,
        ..LbfgsbOptions::default()
    }
}

/// The bounds of every site: the domain's box, none along periodic axes and none where the walls are
/// not those of a box.
fn box_bounds<const D: usize>(space: &impl RelaxationSpace<D>) -> ([f64; D], [f64; D]) {
    let (bounds, periods) = (space.bounds(), space.periods());
    let bound = |end: &Point<f64, D>, open: f64| -> [f64; D] {
        std::array::from_fn(|k| match periods[k] {
            None if space.is_box() => end[k],
            _ => open,
        })
    };
    (
        bound(&bounds.min, f64::NEG_INFINITY),
        bound(&bounds.max, f64::INFINITY),
    )
}
