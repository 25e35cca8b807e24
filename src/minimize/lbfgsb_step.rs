//! One step of L-BFGS-B: model, target, search, and what was learned.

use crate::minimize::cauchy::{Place, cauchy_point};
use crate::minimize::compact::{Compact, Products};
use crate::minimize::lbfgsb_options::LbfgsbOptions;
use crate::minimize::lbfgsb_state::LbfgsbState;
use crate::minimize::line_search::{Line, Search, Trial, line_search};
use crate::minimize::problem::Ended;
use crate::minimize::slices::{dot, largest_group};
use crate::minimize::subspace::subspace_minimizer;

/// Changes of the value below this share of it, times √n, are rounding: a long sum is good to
/// about half an ulp per √term.
const VALUE_ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The box and the options of a run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Question<'a> {
    /// `l`.
    pub(crate) lower: &'a [f64],
    /// `u`.
    pub(crate) upper: &'a [f64],
    /// How to step.
    pub(crate) options: &'a LbfgsbOptions,
}

/// Takes one step and returns how far it moved the farthest group.
///
/// # Errors
///
/// Why there is none; the state then differs in its evaluation count only.
pub(crate) fn take_step(
    question: &Question,
    products: &mut Products,
    objective: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
    state: &mut LbfgsbState,
) -> Result<f64, Ended> {
    let target = target(question, products, state).ok_or(Ended::NoDescent)?;
    let mut way = Way::new(question, objective, state, target);
    let displacement = largest_group(&way.direction, question.options.group);
    let search = way.search(displacement)?;
    let found = line_search(&search, &mut way);
    let evaluations = way.evaluations;
    let reached = found.map(|trial| (trial, way.point_at(trial.fraction), way.kept_gradient));
    state.evaluations = evaluations;
    let (trial, point, gradient) = reached?;
    let step = difference(&point, &state.point);
    let change = difference(&gradient, &state.gradient);
    if state.history.push(step, change, question.options.memory) {
        products.update(&state.history);
    }
    state.point = point;
    state.value = trial.value;
    state.gradient = gradient;
    state.iterations += 1;
    Ok(trial.fraction * displacement)
}

/// `a − b`.
fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The minimizer of the model in the box, as far as \[B\] goes for it.
fn target(question: &Question, products: &Products, state: &LbfgsbState) -> Option<Vec<f64>> {
    let options = question.options;
    let steepest = largest_group(&state.gradient, options.group);
    let model = Compact::new(&state.history, products, steepest / options.first_step);
    let place = Place {
        point: &state.point,
        gradient: &state.gradient,
        lower: question.lower,
        upper: question.upper,
    };
    let cauchy = cauchy_point(&place, &model)?;
    subspace_minimizer(&place, &model, products, cauchy)
}

/// The way from the current point to the target and beyond.
struct Way<'a, F> {
    question: &'a Question<'a>,
    objective: &'a mut F,
    start: &'a LbfgsbState,
    target: Vec<f64>,
    direction: Vec<f64>,
    trial_gradient: Vec<f64>,
    kept_gradient: Vec<f64>,
    evaluations: u64,
}

impl<'a, F: FnMut(&[f64], &mut [f64]) -> f64> Way<'a, F> {
    fn new(
        question: &'a Question<'a>,
        objective: &'a mut F,
        start: &'a LbfgsbState,
        target: Vec<f64>,
    ) -> Self {
        Self {
            question,
            objective,
            start,
            direction: difference(&target, &start.point),
            target,
            trial_gradient: vec![0.0; start.point.len()],
            kept_gradient: vec![0.0; start.point.len()],
            evaluations: start.evaluations,
        }
    }

    /// What the line search needs to know.
    fn search(&self, displacement: f64) -> Result<Search, Ended> {
        let slope = dot(&self.start.gradient, &self.direction);
        if displacement == 0.0 {
            return Err(Ended::AtRounding);
        }
        if !(slope < 0.0 && slope.is_finite()) {
            return Err(Ended::NoDescent);
        }
        let longest = self
            .room()
            .min(self.question.options.largest_step / displacement);
        let root = (self.direction.len() as f64).sqrt();
        Ok(Search {
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

    /// The fraction at which the first variable leaves the box; at least 1, where the target is.
    fn room(&self) -> f64 {
        let mut room = f64::INFINITY;
        for (i, &d) in self
            .direction
            .iter()
            .enumerate()
            .filter(|(_, d)| **d != 0.0)
        {
            let bounds = if d > 0.0 {
                self.question.upper
            } else {
                self.question.lower
            };
            room = room.min((bounds[i] - self.start.point[i]) / d);
        }
        room.max(1.0)
    }

    /// The point at a fraction of the way, inside the box; the target itself at 1.
    fn point_at(&self, fraction: f64) -> Vec<f64> {
        if fraction.to_bits() == 1.0_f64.to_bits() {
            return self.target.clone();
        }
        let at = |i: usize| {
            let moved = self.start.point[i] + fraction * self.direction[i];
            moved
                .max(self.question.lower[i])
                .min(self.question.upper[i])
        };
        (0..self.direction.len()).map(at).collect()
    }
}

impl<F: FnMut(&[f64], &mut [f64]) -> f64> Line for Way<'_, F> {
    fn evaluate(&mut self, fraction: f64) -> Option<Trial> {
        if self.evaluations >= self.question.options.max_evaluations {
            return None;
        }
        self.evaluations += 1;
        let point = self.point_at(fraction);
        let value = (self.objective)(&point, &mut self.trial_gradient);
        Some(Trial {
            fraction,
            value,
            slope: dot(&self.trial_gradient, &self.direction),
        })
    }

    fn keep(&mut self) {
        std::mem::swap(&mut self.trial_gradient, &mut self.kept_gradient);
    }
}
