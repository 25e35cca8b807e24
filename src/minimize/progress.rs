//! The state that carries a solver of ours through argmin's executor.
//!
//! argmin's own `IterState` keeps three copies of the parameters and a dozen options, and its
//! executor copies the state every iteration. This one holds only what a solver carries
//! from step to step, a count, and whether it is over, so that the executor can drive even the
//! problem of a single Voronoi cell. Call counts and times stay off.

use std::collections::HashMap;
use std::sync::LazyLock;
use std::time::Duration;

use argmin::core::{Problem, State, TerminationReason, TerminationStatus};

use crate::minimize::problem::Ended;

/// argmin asks every state for a table of call counts; this empty one serves all.
static NO_COUNTS: LazyLock<HashMap<String, u64>> = LazyLock::new(HashMap::new);

/// What a solver carries from step to step.
pub(crate) trait Iterate: Default {
    /// The variables.
    type Point;

    /// The best variables so far.
    fn point(&self) -> &Self::Point;

    /// The function's value there.
    fn value(&self) -> f64;
}

/// An [`Iterate`] with argmin's bookkeeping.
#[derive(Debug)]
pub(crate) struct Progress<T> {
    /// What the solver carries.
    pub(crate) iterate: T,
    /// Why the run is over, once it is.
    pub(crate) ended: Option<Ended>,
    iteration: u64,
    status: TerminationStatus,
}

impl<T> Progress<T> {
    /// Marks the run as over.
    pub(crate) fn end(&mut self, ended: Ended) {
        self.ended = Some(ended);
        self.status = TerminationStatus::Terminated(match ended {
            Ended::EvaluationLimit => TerminationReason::MaxItersReached,
            Ended::Stopped => TerminationReason::Interrupt,
            _ => TerminationReason::SolverConverged,
        });
    }
}

impl<T: Iterate> State for Progress<T> {
    type Param = T::Point;
    type Float = f64;

    fn new() -> Self {
        Self {
            iterate: T::default(),
            ended: None,
            iteration: 0,
            status: TerminationStatus::NotTerminated,
        }
    }

    fn update(&mut self) {}

    fn get_param(&self) -> Option<&T::Point> {
        Some(self.iterate.point())
    }

    fn get_best_param(&self) -> Option<&T::Point> {
        Some(self.iterate.point())
    }

    fn get_max_iters(&self) -> u64 {
        u64::MAX
    }

    fn increment_iter(&mut self) {
        self.iteration += 1;
    }

    fn get_iter(&self) -> u64 {
        self.iteration
    }

    fn get_cost(&self) -> f64 {
        self.iterate.value()
    }

    fn get_best_cost(&self) -> f64 {
        self.iterate.value()
    }

    fn get_target_cost(&self) -> f64 {
        f64::NEG_INFINITY
    }

    fn func_counts<O>(&mut self, _problem: &Problem<O>) {}

    fn get_func_counts(&self) -> &HashMap<String, u64> {
        &NO_COUNTS
    }

    fn time(&mut self, _time: Option<Duration>) -> &mut Self {
        self
    }

    fn get_time(&self) -> Option<Duration> {
        None
    }

    fn get_last_best_iter(&self) -> u64 {
        self.iteration
    }

    fn is_best(&self) -> bool {
        true
    }

    fn terminate_with(mut self, reason: TerminationReason) -> Self {
        self.status = TerminationStatus::Terminated(reason);
        self
    }

    fn get_termination_status(&self) -> &TerminationStatus {
        &self.status
    }

    fn get_termination_reason(&self) -> Option<&TerminationReason> {
        match &self.status {
            TerminationStatus::Terminated(reason) => Some(reason),
            TerminationStatus::NotTerminated => None,
        }
    }
}
