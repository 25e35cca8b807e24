//! L-BFGS-B: quasi-Newton in a box, for any number of variables.
//!
//! \[B\] Byrd, Lu, Nocedal & Zhu, *A limited memory algorithm for bound constrained
//! optimization*, SIAM J. Sci. Comput. 16, 1995. One step: the quadratic model of the last few
//! pairs (`compact`) is minimized along the projected gradient (`cauchy`), then over the
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
//! * The first model is `θ I` with the `θ` that moves the farthest group by `first_step`, not the
//!   identity: sites in a unit cube have gradients of about a cell's volume.
//! * The whole step is shortened so that no group moves farther than `largest_step`.
//! * If a model is singular or its search fails, the pairs are dropped and the step is tried
//!   once more from `θ I`, as in the authors' code.
//!
//! # Interruption
//!
//! A step depends on nothing but an [`LbfgsbState`]. Stopping after one and going on later with
//! [`resume`] gives bit for bit what an uninterrupted run would have given.

use std::ops::ControlFlow;

use argmin::core::{Error, Executor, KV, Problem, Solver};

use crate::minimize::compact::Products;
use crate::minimize::lbfgsb_options::{LbfgsbError, LbfgsbOptions, check};
use crate::minimize::lbfgsb_state::LbfgsbState;
use crate::minimize::lbfgsb_step::{Question, take_step};
use crate::minimize::problem::Ended;
use crate::minimize::progress::Progress;

/// An accepted step, as the observer sees it.
#[derive(Clone, Copy, Debug)]
pub struct LbfgsbStep<'a> {
    /// Where the run stands after the step.
    pub state: &'a LbfgsbState,
    /// The largest component of the gradient, without those that push against a bound.
    pub projected_gradient: f64,
    /// The longest displacement of a group of variables.
    pub displacement: f64,
}

/// Where a run ended and why; `state` also takes it up again.
#[derive(Clone, Debug, PartialEq)]
pub struct LbfgsbEnd {
    /// The best point found, with all that is needed to go on.
    pub state: LbfgsbState,
    /// Why it ended.
    pub ended: Ended,
}

/// Minimizes a function over the box `lower ≤ x ≤ upper`.
///
/// `objective(x, gradient)` fills the gradient and returns the value. `observer` is told of every
/// accepted step and may stop the run. The start is moved into the box first.
///
/// # Errors
///
/// [`LbfgsbError`] if lengths differ, a bound is NaN, a lower bound exceeds its upper one, or an
/// option makes no sense.
pub fn lbfgsb(
    objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    options: &LbfgsbOptions,
    observer: impl FnMut(&LbfgsbStep) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    let state = LbfgsbState::unevaluated(start);
    resume(objective, state, lower, upper, options, observer)
}

/// Takes up a run where `state` left it.
///
/// # Errors
///
/// As [`lbfgsb`].
pub fn resume(
    mut objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    state: LbfgsbState,
    lower: &[f64],
    upper: &[f64],
    options: &LbfgsbOptions,
    observer: impl FnMut(&LbfgsbStep) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    check(&state, lower, upper, options)?;
    let solver = Lbfgsb {
        question: Question {
            lower,
            upper,
            options,
        },
        observer,
        products: Products::default(),
    };
    let run = Executor::new(&mut objective, solver)
        .configure(|mut progress| {
            progress.iterate = state;
            progress
        })
        .ctrlc(false)
        .run();
    match run {
        Ok(result) => Ok(LbfgsbEnd {
            state: result.state.iterate,
            ended: result.state.ended.unwrap_or(Ended::NotFinite),
        }),
        Err(error) => Err(LbfgsbError::Executor {
            message: error.to_string(),
        }),
    }
}

/// The solver: the question without its function.
struct Lbfgsb<'a, O> {
    question: Question<'a>,
    observer: O,
    products: Products,
}

impl<F, O> Solver<F, Progress<LbfgsbState>> for Lbfgsb<'_, O>
where
    F: FnMut(&[f64], &mut [f64]) -> f64,
    O: FnMut(&LbfgsbStep) -> ControlFlow<()>,
{
    fn name(&self) -> &'static str {
        "L-BFGS-B"
    }

    fn init(
        &mut self,
        problem: &mut Problem<F>,
        mut progress: Progress<LbfgsbState>,
    ) -> Result<(Progress<LbfgsbState>, Option<KV>), Error> {
        let state = &mut progress.iterate;
        if let (0, Some(objective)) = (state.evaluations, &mut problem.problem) {
            for (x, (lower, upper)) in state
                .point
                .iter_mut()
                .zip(self.question.lower.iter().zip(self.question.upper))
            {
                *x = x.max(*lower).min(*upper);
            }
            state.value = objective(&state.point, &mut state.gradient);
            state.evaluations = 1;
        }
        state.history.shorten(self.question.options.memory);
        self.products = Products::of(&state.history);
        let finite = state.value.is_finite() && state.gradient.iter().all(|g| g.is_finite());
        let ended = if finite {
            self.convergence(state)
        } else {
            Some(Ended::NotFinite)
        };
        if let Some(ended) = ended {
            progress.end(ended);
        }
        Ok((progress, None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<F>,
        mut progress: Progress<LbfgsbState>,
    ) -> Result<(Progress<LbfgsbState>, Option<KV>), Error> {
        let ended = match &mut problem.problem {
            Some(objective) => self.advance(objective, &mut progress.iterate),
            None => Some(Ended::NotFinite),
        };
        if let Some(ended) = ended {
            progress.end(ended);
        }
        Ok((progress, None))
    }
}

impl<O: FnMut(&LbfgsbStep) -> ControlFlow<()>> Lbfgsb<'_, O> {
    /// One accepted step; a reason if it was the last or there is none.
    fn advance(
        &mut self,
        objective: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
        state: &mut LbfgsbState,
    ) -> Option<Ended> {
        let value_before = state.value;
        let displacement = loop {
            match take_step(&self.question, &mut self.products, objective, state) {
                Ok(displacement) => break displacement,
                Err(ended) if self.forget(state, ended) => {}
                Err(ended) => return Some(ended),
            }
        };
        let observed = (self.observer)(&LbfgsbStep {
            state,
            projected_gradient: state.projected_gradient(self.question.lower, self.question.upper),
            displacement,
        });
        let decrease = value_before - state.value;
        let size = value_before.abs().max(state.value.abs());
        let settled = decrease <= self.question.options.value_tolerance * size;
        let settled = settled && self.question.options.value_tolerance > 0.0;
        self.convergence(state)
            .or(settled.then_some(Ended::ValueSettled))
            .or(observed.is_break().then_some(Ended::Stopped))
    }

    /// Forgets pairs after a step that failed; false if another try would be of no use.
    ///
    /// First all but the last pair go, which keeps the scale of the model, then that one too.
    fn forget(&mut self, state: &mut LbfgsbState, ended: Ended) -> bool {
        let left = match (state.history.len(), ended) {
            (0, _) | (_, Ended::EvaluationLimit) | (1, Ended::AtRounding) => return false,
            (1, _) => 0,
            _ => 1,
        };
        state.history.shorten(left);
        self.products = Products::of(&state.history);
        true
    }

    /// Whether the run is over whatever the last step was.
    fn convergence(&self, state: &LbfgsbState) -> Option<Ended> {
        let gradient = state.projected_gradient(self.question.lower, self.question.upper);
        if gradient <= self.question.options.gradient_tolerance * self.question.options.scale {
            Some(Ended::GradientSmall)
        } else if state.evaluations >= self.question.options.max_evaluations {
            Some(Ended::EvaluationLimit)
        } else {
            None
        }
    }
}
