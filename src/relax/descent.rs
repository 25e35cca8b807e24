//! A quasi-Newton descent of the global objective, one accepted step at a time.
//!
//! L-BFGS-B keeps the sites in the domain's box (periodic axes have no bounds; sites are wrapped
//! back where their cells are built). In a domain that is not a box a trial that takes a site
//! outside has no diagram: it counts as infinitely high, and the search along the step retreats.

use std::ops::ControlFlow;

use nalgebra::{Point3, Vector3};

use crate::minimize::history::History;
use crate::minimize::lbfgsb::resume;
use crate::minimize::lbfgsb_options::{LbfgsbError, LbfgsbOptions};
use crate::minimize::lbfgsb_state::LbfgsbState;
use crate::minimize::problem::Ended;
use crate::relax::objective::Global;
use crate::relax::record::optimal_side;
use crate::relax::space::Space;
use crate::relax::tessellation::{Assessment, Tessellation};

/// The first model of the curvature is this share of that of a cube about its center, which is what
/// a site feels whose cell stands still: cells follow their sites about half of the way. From random
/// sites the first step is then accepted at once, and twice or half of it gains no less in the end.
const FIRST_CURVATURE: f64 = 0.5;

/// No step moves a site farther than this many sides of the mean cell. Half as far holds up the
/// first few steps from random sites; twice as far is never asked for.
const LARGEST_STEP: f64 = 1.0;

/// How to descend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DescentOptions {
    /// The order p ≥ 1 of the energy.
    pub order: u32,
    /// How many steps the model of the curvature remembers.
    pub memory: usize,
    /// Converged once no component of the projected gradient is larger than this share of
    /// s^(2+p), s the side of the mean cell, times the mean density.
    pub gradient_tolerance: f64,
}

impl Default for DescentOptions {
    /// p = 1, ten steps remembered, tolerance 1e-9.
    fn default() -> Self {
        Self {
            order: 1,
            memory: 10,
            gradient_tolerance: 1e-9,
        }
    }
}

/// The totals of a diagram, as records need them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Totals {
    pub(crate) energy: f64,
    pub(crate) chebyshev: f64,
    pub(crate) energy_max: f64,
}

impl Totals {
    pub(crate) fn of_cells(cells: &[Assessment<3>]) -> Self {
        Self {
            energy: cells.iter().map(|cell| cell.energy).sum(),
            chebyshev: cells.iter().map(|cell| cell.chebyshev).sum(),
            energy_max: cells.iter().map(|cell| cell.energy).fold(0.0, f64::max),
        }
    }

    pub(crate) fn of(global: &Global) -> Self {
        Self {
            energy: global.energy,
            chebyshev: global.chebyshev,
            energy_max: global.energy_max,
        }
    }
}

/// What one step came to.
pub(crate) enum Step {
    /// The sites moved; the totals of the new diagram.
    Taken(Totals),
    /// No further step is worth taking.
    Over,
}

/// The state of a descent from `sites`, whose objective is `global`.
pub(crate) fn begin(sites: &[Point3<f64>], global: &Global) -> LbfgsbState {
    let point = sites
        .iter()
        .flat_map(|site| site.coords.data.0[0])
        .collect();
    let gradient = global.gradient.iter().flat_map(|g| g.data.0[0]).collect();
    LbfgsbState::from_parts(point, global.energy, gradient, History::default(), 0, 1)
}

/// The sites at which a descent stands, within the domain.
pub(crate) fn sites_of(space: &Space, point: &[f64]) -> Vec<Point3<f64>> {
    let site = |x: &[f64]| space.domain().wrap(&Point3::new(x[0], x[1], x[2]));
    point.chunks_exact(3).map(site).collect()
}

/// Takes one step. `state` is changed only if it is taken, except for its evaluation count.
///
/// # Errors
/// When `state` lies outside the box or is damaged.
pub(crate) fn step(
    space: &Space,
    options: &DescentOptions,
    state: &mut LbfgsbState,
) -> Result<Step, LbfgsbError> {
    let count = state.point().len() / 3;
    let side = optimal_side::<3>(space.volume(), count);
    let density = space.domain().mean_density();
    let solver = LbfgsbOptions {
        memory: options.memory,
        scale: density * side.powi(2 + options.order as i32),
        gradient_tolerance: options.gradient_tolerance,
        value_tolerance: 0.0,
        group: 3,
        first_step: first_step(state.gradient(), options.order, side, density),
        largest_step: LARGEST_STEP * side,
        max_evaluations: u64::MAX,
    };
    let (lower, upper) = walls(space, count);
    let mut trials: Vec<Totals> = Vec::new();
    let mut objective = |point: &[f64], gradient: &mut [f64]| match space
        .global(&sites_of(space, point), options.order)
    {
        Ok(global) => {
            for (entries, of_site) in gradient.chunks_exact_mut(3).zip(&global.gradient) {
                entries.copy_from_slice(of_site.as_slice());
            }
            trials.push(Totals::of(&global));
            global.energy
        }
        Err(_) => f64::NAN,
    };
    let iterations = state.iterations();
    let end = resume(
        &mut objective,
        std::mem::take(state),
        &lower,
        &upper,
        &solver,
        |_| ControlFlow::Break(()),
    )?;
    *state = end.state;
    let is_taken = state.iterations() > iterations;
    let totals = trials
        .iter()
        .rev()
        .find(|totals| totals.energy.to_bits() == state.value().to_bits());
    Ok(match (is_taken, totals, end.ended) {
        (true, Some(totals), _) => Step::Taken(*totals),
        (_, _, Ended::Stopped) | (false, _, _) | (true, None, _) => Step::Over,
    })
}

/// How far the first trial moves the farthest site (L): as Newton's method would in a model of
/// [`FIRST_CURVATURE`] times 8p (s/2)^(1+p), the second derivative of a cube's energy ∫ d∞^p about
/// its center in every direction.
fn first_step(gradient: &[f64], order: u32, side: f64, density: f64) -> f64 {
    let cube = density * 8.0 * f64::from(order) * (0.5 * side).powi(1 + order as i32);
    let squares = gradient
        .chunks_exact(3)
        .map(|g| Vector3::from_column_slice(g).norm_squared());
    let steepest = squares.fold(0.0, f64::max).sqrt();
    (steepest / (FIRST_CURVATURE * cube)).max(f64::MIN_POSITIVE)
}

/// The bounds of all variables: the domain's box, none along periodic axes.
fn walls(space: &Space, count: usize) -> (Vec<f64>, Vec<f64>) {
    let (bounds, periods) = (space.bounds(), space.domain().periods());
    let bound = |end: &Point3<f64>, open: f64| {
        let of_axis = [0, 1, 2].map(|axis| periods[axis].map_or(end[axis], |_| open));
        of_axis.repeat(count)
    };
    (
        bound(&bounds.min, f64::NEG_INFINITY),
        bound(&bounds.max, f64::INFINITY),
    )
}
