//! Newton's method in a box, for convex functions of two or three variables.
//!
//! The steps themselves are made in `newton_step`.
//!
//! The loop is a plain one: a Voronoi cell takes three steps, and argmin's executor around them cost
//! one or two percent of a whole relaxation's time.
//!
//! # Conventions
//!
//! `scale` is what the gradient is measured by and `length` what a step is measured by: for a
//! Voronoi cell its volume V and V^(1/3). Sizes of vectors are largest components throughout.
//!
//! # Safeguards
//!
//! * The Hessian may be singular or zero: it is shifted by a small multiple of the identity
//!   (Levenberg), and no step component exceeds `length`.
//! * A trial must pass Armijo's test; where the change of the value drowns in rounding, the
//!   slope decides instead (the approximate Wolfe condition of Hager & Zhang, SIAM J. Optim. 16,
//!   2005, eq. 4.1). Trials that are not finite are rejected.
//! * An evaluation is spent only where it can tell something: the last step is taken on trust
//!   once the steps before it show that what remains is below `step_tolerance`; and where the
//!   function can be predicted as far as the minimum, that is found by `prediction`.

use nalgebra::{SMatrix, SVector};

use crate::minimize::newton_step::{
    NewtonState, VALUE_ROUNDING, cut, is_accepted, is_finite, newton_step, predicted,
};
use crate::minimize::objective::Objective;
use crate::minimize::problem::{Evaluation, Jet, Minimum, Termination};

/// Up to this many times the rounding of values, a gain that does not come is put down to it.
const SMALL_GAIN: f64 = 1e3;
/// Steps below this share of the coordinates do not move the point.
const POINT_ROUNDING: f64 = f64::EPSILON;
/// Cuts of one step before it is given up: at 0.5 each it is then below rounding.
const MAX_CUTS: usize = 60;

/// The options of [`newton`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NewtonOptions {
    /// What the gradient is measured by (for a cell of energy order 1: its volume).
    pub scale: f64,
    /// The longest step along any axis, finite (for a cell: the cube root of its volume).
    pub length: f64,
    /// Converged once the projected gradient is at most this times `scale`.
    pub gradient_tolerance: f64,
    /// The last step is not checked by an evaluation once the distance that it is likely to
    /// leave is at most this times `length`; zero checks every step.
    pub step_tolerance: f64,
    /// The most evaluations allowed.
    pub max_evaluations: u32,
}

impl NewtonOptions {
    /// Tolerances 1e-12 for the gradient and 1e-11 for an unchecked step, 100 evaluations.
    #[must_use]
    pub(crate) fn new(scale: f64, length: f64) -> Self {
        Self {
            scale,
            length,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-11,
            max_evaluations: 100,
        }
    }
}

/// Minimizes a convex function over the box `lower ≤ x ≤ upper`, which may predict itself.
///
/// The start is moved into the box first. The function may be only piecewise twice
/// differentiable. Where `lower > upper` the upper bound counts.
pub(crate) fn minimize<const D: usize>(
    objective: &mut impl Objective<D>,
    start: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
    options: &NewtonOptions,
) -> Minimum<D> {
    let solver = ProjectedNewton {
        lower: *lower,
        upper: *upper,
        options: *options,
    };
    let mut current = NewtonState::at(solver.projected(start), objective);
    let mut ended = if is_finite(&current.jet.evaluation) {
        solver.convergence(&current)
    } else {
        Some(Termination::NotFinite)
    };
    while ended.is_none() {
        ended = solver.advance(objective, &mut current);
    }
    current.minimum(ended)
}

/// The solver: the box and the options.
#[derive(Debug)]
pub(crate) struct ProjectedNewton<const D: usize> {
    pub(crate) lower: SVector<f64, D>,
    pub(crate) upper: SVector<f64, D>,
    pub(crate) options: NewtonOptions,
}

impl<const D: usize> ProjectedNewton<D> {
    /// One Newton step with its search; a reason if it was the last.
    fn advance(
        &self,
        objective: &mut impl Objective<D>,
        current: &mut NewtonState<D>,
    ) -> Option<Termination> {
        let Jet { evaluation, third } = &current.jet;
        let Some(step) = self.step(&current.point, evaluation, third.as_ref()) else {
            return Some(Termination::NoDescent);
        };
        let size = step.amax();
        if is_lost(&step, &current.point) || self.is_noise(current, &step) {
            return Some(Termination::AtRounding);
        }
        let has_third = current.jet.third.is_some();
        if (current.last_step).is_some_and(|last| self.is_negligible(size, last, has_third)) {
            current.jet.evaluation = predicted(&current.jet.evaluation, &step);
            current.point = self.moved(&current.point, &step, 1.0);
            return Some(Termination::StepNegligible);
        }
        if let Some((point, evaluation)) = self.predicted_minimum(objective, current, &step) {
            (current.point, current.jet.evaluation) = (point, evaluation);
            return Some(Termination::StepNegligible);
        }
        match self.search(objective, current, &step) {
            Ok(fraction) => current.last_step = (fraction >= 1.0).then_some(size),
            Err(ended) => return Some(ended),
        }
        self.convergence(current)
    }

    /// The next step within the box and the largest step, from where the function is `evaluation`, with
    /// `third` derivatives where they are known.
    pub(crate) fn step(
        &self,
        point: &SVector<f64, D>,
        evaluation: &Evaluation<D>,
        third: Option<&[SMatrix<f64, D, D>; D]>,
    ) -> Option<SVector<f64, D>> {
        let length = self.options.length;
        let longest = SVector::repeat(length);
        let lower = (self.lower - point).sup(&-longest);
        let upper = (self.upper - point).inf(&longest);
        newton_step(evaluation, third, length, &lower, &upper)
    }

    /// Whether what a step of `size` after one of `last` leaves is below the tolerance, if the steps
    /// go on shrinking at least as fast as these two did; with third derivatives, if their ratio
    /// squares at least.
    pub(crate) fn is_negligible(&self, size: f64, last: f64, has_third: bool) -> bool {
        let tolerance = self.options.step_tolerance * self.options.length;
        let ratio = size / last;
        let shrinks_to = if has_third { ratio * ratio } else { ratio };
        ratio < 1.0 && size * shrinks_to <= tolerance
    }

    /// Whether the steps have stopped shrinking and gain nothing that rounding would leave.
    fn is_noise(&self, current: &NewtonState<D>, step: &SVector<f64, D>) -> bool {
        let evaluation = &current.jet.evaluation;
        let gain = -evaluation.gradient.dot(step);
        current
            .last_step
            .is_some_and(|last| 2.0 * step.amax() >= last)
            && gain <= VALUE_ROUNDING * evaluation.value.abs()
    }

    /// Cuts the step until it is accepted and returns the fraction taken.
    fn search(
        &self,
        objective: &mut impl Objective<D>,
        current: &mut NewtonState<D>,
        step: &SVector<f64, D>,
    ) -> Result<f64, Termination> {
        let start = current.jet.evaluation;
        let slope = start.gradient.dot(step);
        let mut fraction = 1.0;
        for _ in 0..MAX_CUTS {
            if current.evaluations >= self.options.max_evaluations {
                return Err(Termination::EvaluationLimit);
            }
            let point = self.moved(&current.point, step, fraction);
            let jet = objective.jet(&point);
            let trial = jet.evaluation;
            current.evaluations += 1;
            if is_accepted(&start, &trial, step, fraction * slope) {
                (current.point, current.jet) = (point, jet);
                return Ok(fraction);
            }
            if -fraction * slope <= VALUE_ROUNDING * start.value.abs() {
                break;
            }
            fraction *= cut(trial.value - start.value, fraction * slope);
        }
        if -slope <= SMALL_GAIN * VALUE_ROUNDING * start.value.abs() {
            Err(Termination::AtRounding)
        } else {
            Err(Termination::NoDescent)
        }
    }

    /// `point + fraction · step`, exactly on a bound where the whole step ends on it.
    pub(crate) fn moved(
        &self,
        point: &SVector<f64, D>,
        step: &SVector<f64, D>,
        fraction: f64,
    ) -> SVector<f64, D> {
        let mut moved = point + step * fraction;
        for axis in (0..D).filter(|_| fraction >= 1.0) {
            if step[axis] <= self.lower[axis] - point[axis] {
                moved[axis] = self.lower[axis];
            } else if step[axis] >= self.upper[axis] - point[axis] {
                moved[axis] = self.upper[axis];
            }
        }
        self.projected(&moved)
    }

    /// The point of the box nearest to `point`.
    fn projected(&self, point: &SVector<f64, D>) -> SVector<f64, D> {
        point.sup(&self.lower).inf(&self.upper)
    }

    /// Whether the run is over at `current`.
    fn convergence(&self, current: &NewtonState<D>) -> Option<Termination> {
        if self.is_flat(&current.point, &current.jet.evaluation.gradient) {
            Some(Termination::GradientSmall)
        } else if current.evaluations >= self.options.max_evaluations {
            Some(Termination::EvaluationLimit)
        } else {
            None
        }
    }

    /// Whether the projected gradient is small.
    pub(crate) fn is_flat(&self, point: &SVector<f64, D>, gradient: &SVector<f64, D>) -> bool {
        let tolerance = self.options.gradient_tolerance * self.options.scale;
        (0..D).all(|axis| {
            let slope = gradient[axis];
            let at_lower = point[axis] <= self.lower[axis] && slope > 0.0;
            let at_upper = point[axis] >= self.upper[axis] && slope < 0.0;
            at_lower || at_upper || slope.abs() <= tolerance
        })
    }
}

/// Whether the step would change no coordinate.
fn is_lost<const D: usize>(step: &SVector<f64, D>, point: &SVector<f64, D>) -> bool {
    (0..D).all(|axis| step[axis].abs() <= POINT_ROUNDING * point[axis].abs())
}
