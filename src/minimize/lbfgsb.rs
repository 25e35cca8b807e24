//! L-BFGS-B: quasi-Newton in a box, for any number of variables.
//!
//! \[B\] Byrd, Lu, Nocedal & Zhu, *A limited memory algorithm for bound constrained
//! optimization*, SIAM J. Sci. Comput. 16, 1995. One step: the quadratic model of the last few
//! pairs (`compact_bfgs`) is minimized along the projected gradient (`cauchy`), then over the
//! variables left free (`subspace`); a line search goes towards that point (`line_search`).
//! Everything is O(memory · n) a step, in an order that does not depend on threads.
//!
//! # Conventions
//!
//! `scale` is what gradients are measured by. Lengths (`first_step`, `largest_step`) are Euclidean
//! lengths of `group` consecutive variables: with three variables a site, of a site's
//! displacement. A function value that is not finite rejects the trial.
//!
//! # Departures from \[B\]
//!
//! * The first model is `θ I` with the `θ` of the options, or that which moves the farthest
//!   group by `first_step`, not the identity: sites in a unit cube have gradients of about a cell's volume.
//! * The whole step is shortened so that no group moves farther than `largest_step`.
//! * In a set that is no box the caller bends steps along its walls ([`lbfgsb_within`]); the bent step
//!   must lead down, else the pairs are dropped, and from `θ I` every group's bent step does.
//! * If a model is singular or its search fails, the pairs are dropped and the step is tried
//!   once more from `θ I`, as in the authors' code.
//!
//! # Interruption
//!
//! A step depends on nothing but an [`LbfgsbState`], which keeps the products of its pairs. Stopping
//! after one and going on later with [`resume`] gives bit for bit what an uninterrupted run would
//! have given. argmin's executor drives all steps of a call; the state that it carries is its own,
//! without parameters, of which it would keep copies.

use std::borrow::Cow;
use std::ops::ControlFlow;

use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, State, TerminationReason};

use crate::minimize::blas1::{dot_difference, farthest_group, largest_group};
use crate::minimize::cauchy::{BoxedPoint, cauchy_point};
use crate::minimize::compact_bfgs::CompactBfgs;
use crate::minimize::lbfgsb_state::{LbfgsbError, LbfgsbOptions, LbfgsbState, check};
use crate::minimize::line_search::{Line, LineSearch, Trial, line_search};
use crate::minimize::problem::Termination;
use crate::minimize::subspace::subspace_minimizer;
use crate::minimize::variable_bounds::{VariableBounds, facing};

/// Changes of the value below this share of it, times √n, are rounding: a long sum is good to
/// about half an ulp per √term.
const VALUE_ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Where a run ended and why; `state` also takes it up again.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LbfgsbEnd {
    /// The best point found, with all that is needed to go on.
    pub state: LbfgsbState,
    /// Why it ended.
    pub ended: Termination,
}

/// Minimizes a function over the box `lower ≤ x ≤ upper`, from where `state` is. Bounds of one group hold for
/// all groups.
///
/// `objective(x, gradient)` fills the gradient and returns the value. `observer` is shown the state
/// after every accepted step with the longest displacement of a group of variables, may take the
/// state for the time of its call, and may stop the run. The start is moved into the box first.
///
/// # Errors
///
/// [`LbfgsbError`] if lengths differ, a bound is NaN, a lower bound exceeds its upper one, or an
/// option makes no sense.
pub(crate) fn lbfgsb(
    objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    state: LbfgsbState,
    lower: &[f64],
    upper: &[f64],
    options: &LbfgsbOptions,
    observer: impl FnMut(&mut LbfgsbState, f64) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    lbfgsb_within(objective, state, [lower, upper], None, options, observer)
}

/// Bends a step from a point so that the straight way along it stays in the set of allowed points, and
/// says whether it did. A bent step makes no group's descent an ascent.
pub(crate) type Bend<'a> = &'a dyn Fn(&[f64], &mut [f64]) -> bool;

/// As [`lbfgsb`] over the points of the box `[lower, upper]` to which `bend` holds all steps.
///
/// # Errors
/// As [`lbfgsb`].
pub(crate) fn lbfgsb_within(
    mut objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    state: LbfgsbState,
    [lower, upper]: [&[f64]; 2],
    bend: Option<Bend<'_>>,
    options: &LbfgsbOptions,
    observer: impl FnMut(&mut LbfgsbState, f64) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    let bounds = VariableBounds { lower, upper };
    check(&state, bounds, options)?;
    let solver = Lbfgsb {
        bounded: BoxProblem {
            bounds,
            bend,
            options,
        },
        observer,
        state,
        ended: None,
    };
    let run = Executor::new(&mut objective, solver).ctrlc(false).run();
    let solver = run.map(|result| result.solver);
    let solver = solver.map_err(|error| LbfgsbError::Executor {
        message: error.to_string(),
    })?;
    Ok(LbfgsbEnd {
        state: solver.state,
        ended: solver.ended.unwrap_or(Termination::NotFinite),
    })
}

/// argmin's bookkeeping: whether the run is over.
type Bookkeeping = IterState<(), (), (), (), (), f64>;

/// The box, what holds steps to other sets, and the options of a run.
#[derive(Clone, Copy)]
struct BoxProblem<'a> {
    bounds: VariableBounds<'a>,
    bend: Option<Bend<'a>>,
    options: &'a LbfgsbOptions,
}

/// The solver, with the state that it steps from.
struct Lbfgsb<'a, O> {
    bounded: BoxProblem<'a>,
    observer: O,
    state: LbfgsbState,
    /// Why the run is over, once it is.
    ended: Option<Termination>,
}

impl<F, O> Solver<F, Bookkeeping> for Lbfgsb<'_, O>
where
    F: FnMut(&[f64], &mut [f64]) -> f64,
    O: FnMut(&mut LbfgsbState, f64) -> ControlFlow<()>,
{
    fn name(&self) -> &'static str {
        "L-BFGS-B"
    }

    fn init(
        &mut self,
        problem: &mut Problem<F>,
        bookkeeping: Bookkeeping,
    ) -> Result<(Bookkeeping, Option<KV>), Error> {
        let BoxProblem {
            bounds, options, ..
        } = self.bounded;
        let state = &mut self.state;
        if let (0, Some(objective)) = (state.evaluations, &mut problem.problem) {
            for (x, (lower, upper)) in state.point.iter_mut().zip(bounds.iter()) {
                *x = x.max(lower).min(upper);
            }
            state.value = objective(&state.point, &mut state.gradient);
            state.evaluations = 1;
        }
        state.history.shorten(options.memory);
        let is_finite = state.value.is_finite() && state.gradient.iter().all(|g| g.is_finite());
        self.ended = if is_finite {
            self.convergence()
        } else {
            Some(Termination::NotFinite)
        };
        Ok((noted(bookkeeping, self.ended), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<F>,
        bookkeeping: Bookkeeping,
    ) -> Result<(Bookkeeping, Option<KV>), Error> {
        self.ended = match &mut problem.problem {
            Some(objective) => self.advance(objective),
            None => Some(Termination::NotFinite),
        };
        Ok((noted(bookkeeping, self.ended), None))
    }
}

/// The bookkeeping, with the reason for which the run is over.
fn noted(bookkeeping: Bookkeeping, ended: Option<Termination>) -> Bookkeeping {
    let Some(ended) = ended else {
        return bookkeeping;
    };
    bookkeeping.terminate_with(match ended {
        Termination::EvaluationLimit => TerminationReason::MaxItersReached,
        Termination::Stopped => TerminationReason::Interrupt,
        _ => TerminationReason::SolverConverged,
    })
}

impl<O: FnMut(&mut LbfgsbState, f64) -> ControlFlow<()>> Lbfgsb<'_, O> {
    /// One accepted step; a reason if it was the last or there is none.
    fn advance(
        &mut self,
        objective: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
    ) -> Option<Termination> {
        let value_before = self.state.value;
        let displacement = loop {
            match self.bounded.take_step(objective, &mut self.state) {
                Ok(displacement) => break displacement,
                Err(ended) if self.forget(ended) => {}
                Err(ended) => return Some(ended),
            }
        };
        let observed = (self.observer)(&mut self.state, displacement);
        let decrease = value_before - self.state.value;
        let size = value_before.abs().max(self.state.value.abs());
        let tolerance = self.bounded.options.value_tolerance;
        let is_settled = tolerance > 0.0 && decrease <= tolerance * size;
        self.convergence()
            .or(is_settled.then_some(Termination::ValueSettled))
            .or(observed.is_break().then_some(Termination::Stopped))
    }

    /// Forgets pairs after a step that failed; false if another try would be of no use.
    ///
    /// First all but the last pair go, which keeps the scale of the model, then that one too.
    fn forget(&mut self, ended: Termination) -> bool {
        let left = match (self.state.history.len(), ended) {
            (0, _) | (_, Termination::EvaluationLimit) | (1, Termination::AtRounding) => {
                return false;
            }
            (1, _) => 0,
            _ => 1,
        };
        self.state.history.shorten(left);
        true
    }

    /// Whether the run is over whatever the last step was.
    fn convergence(&self) -> Option<Termination> {
        let options = self.bounded.options;
        let gradient = self.bounded.projected_gradient(&self.state);
        if gradient <= options.gradient_tolerance * options.scale {
            Some(Termination::GradientSmall)
        } else if self.state.evaluations >= options.max_evaluations {
            Some(Termination::EvaluationLimit)
        } else {
            None
        }
    }
}

impl BoxProblem<'_> {
    /// Takes one step and returns how far it moved the farthest group.
    ///
    /// # Errors
    ///
    /// Why there is none; the state then differs in its evaluation count only.
    fn take_step(
        &self,
        objective: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
        state: &mut LbfgsbState,
    ) -> Result<f64, Termination> {
        let mut target = self.target(state).ok_or(Termination::NoDescent)?;
        let is_bent = self.bend_toward(&state.point, &mut target);
        let mut line = LineToTarget::new(self, objective, state, target, is_bent);
        let displacement = line.length(self.options.group);
        let search = line.search(displacement)?;
        let found = line_search(&search, &mut line);
        let evaluations = line.evaluations;
        let reached = found.map(|trial| {
            let point = point_at(trial.fraction, &state.point, &line.target, self.bounds);
            let point = point.into_owned();
            (trial, point, std::mem::take(&mut line.kept_gradient))
        });
        drop(line);
        state.evaluations = evaluations;
        let (trial, point, gradient) = reached?;
        let step = difference(&point, &state.point);
        let change = difference(&gradient, &state.gradient);
        state.history.push(step, change, self.options.memory);
        (state.point, state.value, state.gradient) = (point, trial.value, gradient);
        state.iterations += 1;
        Ok(trial.fraction * displacement)
    }

    /// Bends the step from `point` to `target`, if there is more than a box; says whether it did.
    fn bend_toward(&self, point: &[f64], target: &mut [f64]) -> bool {
        let Some(bend) = self.bend else { return false };
        let mut step = difference(target, point);
        let is_bent = bend(point, &mut step);
        if is_bent {
            for (target, (point, step)) in target.iter_mut().zip(point.iter().zip(step)) {
                *target = point + step;
            }
        }
        is_bent
    }

    /// The largest component of the gradient, without what pushes against bounds or walls: of
    /// the first model's bent step, times its curvature.
    fn projected_gradient(&self, state: &LbfgsbState) -> f64 {
        let Some(bend) = self.bend else {
            return state.projected_gradient(self.bounds);
        };
        let curvature = self.first_curvature(state);
        let mut step: Vec<f64> = state.gradient.iter().map(|g| -g / curvature).collect();
        if curvature > 0.0 && bend(&state.point, &mut step) {
            return step.iter().fold(0.0, |size: f64, s| size.max(s.abs())) * curvature;
        }
        state.projected_gradient(self.bounds)
    }

    /// `θ` of the model without pairs.
    fn first_curvature(&self, state: &LbfgsbState) -> f64 {
        let options = self.options;
        options
            .first_curvature
            .unwrap_or_else(|| largest_group(&state.gradient, options.group) / options.first_step)
    }

    /// The minimizer of the model in the box, as far as \[B\] goes for it.
    fn target(&self, state: &LbfgsbState) -> Option<Vec<f64>> {
        let model = CompactBfgs::new(&state.history, self.first_curvature(state));
        let place = BoxedPoint {
            point: &state.point,
            gradient: &state.gradient,
            bounds: self.bounds,
        };
        let cauchy = cauchy_point(&place, &model)?;
        subspace_minimizer(&place, &model, cauchy)
    }
}

/// `a − b`.
fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The function on the line from the current point to the target and beyond.
struct LineToTarget<'a, F> {
    bounded: &'a BoxProblem<'a>,
    objective: &'a mut F,
    start: &'a LbfgsbState,
    target: Vec<f64>,
    /// Whether walls lie right behind the target.
    is_bent: bool,
    trial_gradient: Vec<f64>,
    kept_gradient: Vec<f64>,
    evaluations: u64,
}

impl<'a, F: FnMut(&[f64], &mut [f64]) -> f64> LineToTarget<'a, F> {
    fn new(
        bounded: &'a BoxProblem<'a>,
        objective: &'a mut F,
        start: &'a LbfgsbState,
        target: Vec<f64>,
        is_bent: bool,
    ) -> Self {
        Self {
            bounded,
            objective,
            start,
            target,
            is_bent,
            trial_gradient: Vec::new(),
            kept_gradient: Vec::new(),
            evaluations: start.evaluations,
        }
    }

    /// What the line search needs to know.
    fn search(&self, displacement: f64) -> Result<LineSearch, Termination> {
        let slope = self.slope(&self.start.gradient);
        if displacement == 0.0 {
            return Err(Termination::AtRounding);
        }
        if !(slope < 0.0 && slope.is_finite()) {
            return Err(Termination::NoDescent);
        }
        let largest = self.bounded.options.largest_step / displacement;
        let longest = self.longest_in_box().min(largest);
        let root = (self.target.len() as f64).sqrt();
        Ok(LineSearch {
            start: Trial {
                fraction: 0.0,
                value: self.start.value,
                slope,
            },
            first: longest.min(1.0),
            longest,
            rounding: VALUE_ROUNDING * root * self.start.value.abs(),
        })
    }

    /// The fraction at which the first variable leaves the box; at least 1, where the target is, and no
    /// more along walls.
    fn longest_in_box(&self) -> f64 {
        if self.is_bent {
            return 1.0;
        }
        let mut longest = f64::INFINITY;
        let places = self.start.point.iter().zip(&self.target);
        for ((start, target), bounds) in places.zip(self.bounded.bounds.iter()) {
            let way = target - start;
            if way != 0.0 {
                longest = longest.min((facing(bounds, way) - start) / way);
            }
        }
        longest.max(1.0)
    }

    /// The derivative along the line where the function has this gradient.
    fn slope(&self, gradient: &[f64]) -> f64 {
        dot_difference(gradient, &self.target, &self.start.point)
    }

    /// How far the target is for the farthest group.
    fn length(&self, group: usize) -> f64 {
        farthest_group(&self.target, &self.start.point, group)
    }
}

/// The point at a fraction of the way to the target, inside the box; the target itself at 1.
fn point_at<'a>(
    fraction: f64,
    start: &[f64],
    target: &'a [f64],
    bounds: VariableBounds<'_>,
) -> Cow<'a, [f64]> {
    if fraction.to_bits() == 1.0_f64.to_bits() {
        return Cow::Borrowed(target);
    }
    let bounded = start.iter().zip(target).zip(bounds.iter());
    let at = bounded.map(|((start, target), (lower, upper))| {
        let moved = start + fraction * (target - start);
        moved.max(lower).min(upper)
    });
    Cow::Owned(at.collect())
}

impl<F: FnMut(&[f64], &mut [f64]) -> f64> Line for LineToTarget<'_, F> {
    fn evaluate(&mut self, fraction: f64) -> Option<Trial> {
        if self.evaluations >= self.bounded.options.max_evaluations {
            return None;
        }
        self.evaluations += 1;
        let mut gradient = std::mem::take(&mut self.trial_gradient);
        gradient.resize(self.target.len(), 0.0);
        let (start, bounds) = (&self.start.point, self.bounded.bounds);
        let point = point_at(fraction, start, &self.target, bounds);
        let value = (self.objective)(&point, &mut gradient);
        let slope = self.slope(&gradient);
        self.trial_gradient = gradient;
        Some(Trial {
            fraction,
            value,
            slope,
        })
    }

    fn keep(&mut self) {
        std::mem::swap(&mut self.trial_gradient, &mut self.kept_gradient);
    }
}
