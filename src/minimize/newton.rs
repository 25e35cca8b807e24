//! Newton's method in a box, for convex functions of two or three variables.
//!
//! Each step minimizes the quadratic model over the box *exactly* (`box_quadratic`), instead of
//! taking the free Newton step and projecting it: Bertsekas (*Projected Newton methods*, SIAM J.
//! Control Optim. 20, 1982) shows that projection can point uphill unless nearly active
//! variables are held, while in three variables the exact step costs one small factorization
//! more, and only when a bound is in the way. At a minimum both hold the same variables: those at
//! a bound whose gradient pushes outward.
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
//!   once the steps before it show that what remains is below `step_tolerance`.
//!

use argmin::core::{Error, Executor, KV, Problem, Solver};
use nalgebra::{Cholesky, Const, SMatrix, SVector};

use crate::minimize::box_quadratic::minimize_quadratic;
use crate::minimize::problem::{Ended, Evaluation, Minimum};
use crate::minimize::progress::{Iterate, Progress};

/// Shift of the Hessian relative to its trace: far above the rounding of its entries (1e-16),
/// far below what would slow convergence.
const SHIFT_OF_TRACE: f64 = 1e-13;
/// Shift relative to `gradient / length`, which is what the Hessian must be for a step of
/// `length`. It decides only where the Hessian is (nearly) zero, and vanishes at the minimum.
const SHIFT_OF_GRADIENT: f64 = 1e-9;
/// Factor between attempts to find a shift that makes the Hessian positive definite.
const SHIFT_GROWTH: f64 = 100.0;
/// Attempts to do so; 100^20 spans everything from rounding to the trace and beyond.
const MAX_SHIFTS: usize = 20;
/// Armijo's constant (Nocedal & Wright, section 3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;
/// Changes of the value below this share of it are rounding: a sum over a cell's some hundred
/// simplices is good to about that.
const VALUE_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Steps below this share of the coordinates do not move the point.
const POINT_ROUNDING: f64 = f64::EPSILON;
/// Shortest and longest cut of a rejected step.
const CUTS: (f64, f64) = (0.1, 0.5);
/// Cuts of one step before it is given up: at 0.5 each it is then below rounding.
const MAX_CUTS: usize = 60;

/// What [`newton`] is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonOptions {
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
    /// Tolerances 1e-12 for the gradient and 1e-10 for an unchecked step, 100 evaluations.
    #[must_use]
    pub fn new(scale: f64, length: f64) -> Self {
        Self {
            scale,
            length,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-10,
            max_evaluations: 100,
        }
    }
}

/// Minimizes a convex function over the box `lower ≤ x ≤ upper`.
///
/// The start is moved into the box first. The function may be only piecewise twice
/// differentiable. Where `lower > upper` the upper bound counts.
pub fn newton<const D: usize>(
    mut objective: impl FnMut(&SVector<f64, D>) -> Evaluation<D>,
    start: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
    options: &NewtonOptions,
) -> Minimum<D> {
    let solver = ProjectedNewton {
        start: *start,
        lower: *lower,
        upper: *upper,
        options: *options,
    };
    match Executor::new(&mut objective, solver).ctrlc(false).run() {
        Ok(result) => result.state.iterate.minimum(result.state.ended),
        Err(_) => Current::default().minimum(None),
    }
}

/// The solver: the question without its function.
#[derive(Debug)]
struct ProjectedNewton<const D: usize> {
    start: SVector<f64, D>,
    lower: SVector<f64, D>,
    upper: SVector<f64, D>,
    options: NewtonOptions,
}

/// Where the solver stands.
#[derive(Debug)]
struct Current<const D: usize> {
    point: SVector<f64, D>,
    evaluation: Evaluation<D>,
    evaluations: u32,
    /// The largest component of the last step, if it was a full one.
    last_step: Option<f64>,
}

impl<const D: usize> Default for Current<D> {
    fn default() -> Self {
        Self {
            point: SVector::zeros(),
            evaluation: Evaluation {
                value: f64::NAN,
                gradient: SVector::zeros(),
                hessian: SMatrix::zeros(),
            },
            evaluations: 0,
            last_step: None,
        }
    }
}

impl<const D: usize> Iterate for Current<D> {
    type Point = SVector<f64, D>;

    fn point(&self) -> &SVector<f64, D> {
        &self.point
    }

    fn value(&self) -> f64 {
        self.evaluation.value
    }
}

impl<const D: usize> Current<D> {
    fn minimum(&self, ended: Option<Ended>) -> Minimum<D> {
        Minimum {
            point: self.point,
            value: self.evaluation.value,
            gradient: self.evaluation.gradient,
            evaluations: self.evaluations,
            ended: ended.unwrap_or(Ended::NotFinite),
        }
    }

    /// The model's value and gradient after `step`.
    fn predicted(&self, step: &SVector<f64, D>) -> Evaluation<D> {
        let Evaluation {
            value,
            gradient,
            hessian,
        } = self.evaluation;
        let bend = hessian * step;
        Evaluation {
            value: value + gradient.dot(step) + 0.5 * bend.dot(step),
            gradient: gradient + bend,
            hessian,
        }
    }
}

impl<const D: usize, F> Solver<F, Progress<Current<D>>> for ProjectedNewton<D>
where
    F: FnMut(&SVector<f64, D>) -> Evaluation<D>,
{
    fn name(&self) -> &'static str {
        "projected Newton"
    }

    fn init(
        &mut self,
        problem: &mut Problem<F>,
        mut state: Progress<Current<D>>,
    ) -> Result<(Progress<Current<D>>, Option<KV>), Error> {
        let current = &mut state.iterate;
        current.point = self.projected(&self.start);
        if let Some(objective) = &mut problem.problem {
            current.evaluation = objective(&current.point);
            current.evaluations = 1;
        }
        let ended = if is_finite(&current.evaluation) {
            self.convergence(current)
        } else {
            Some(Ended::NotFinite)
        };
        if let Some(ended) = ended {
            state.end(ended);
        }
        Ok((state, None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<F>,
        mut state: Progress<Current<D>>,
    ) -> Result<(Progress<Current<D>>, Option<KV>), Error> {
        let ended = match &mut problem.problem {
            Some(objective) => self.advance(objective, &mut state.iterate),
            None => Some(Ended::NotFinite),
        };
        if let Some(ended) = ended {
            state.end(ended);
        }
        Ok((state, None))
    }
}

impl<const D: usize> ProjectedNewton<D> {
    /// One Newton step with its search; a reason if it was the last.
    fn advance(
        &self,
        objective: &mut impl FnMut(&SVector<f64, D>) -> Evaluation<D>,
        current: &mut Current<D>,
    ) -> Option<Ended> {
        let Some(step) = self.step(current) else {
            return Some(Ended::NoDescent);
        };
        let size = step.amax();
        if is_lost(&step, &current.point) || self.is_noise(current, &step) {
            return Some(Ended::AtRounding);
        }
        if self.is_negligible(size, current.last_step) {
            current.evaluation = current.predicted(&step);
            current.point = self.moved(&current.point, &step, 1.0);
            return Some(Ended::StepNegligible);
        }
        match self.search(objective, current, &step) {
            Ok(fraction) => current.last_step = (fraction >= 1.0).then_some(size),
            Err(ended) => return Some(ended),
        }
        self.convergence(current)
    }

    /// The minimizer of the model over the box and the largest step.
    fn step(&self, current: &Current<D>) -> Option<SVector<f64, D>> {
        let Evaluation {
            gradient, hessian, ..
        } = &current.evaluation;
        let length = SVector::repeat(self.options.length);
        let lower = (self.lower - current.point).sup(&-length);
        let upper = (self.upper - current.point).inf(&length);
        let (shifted, factor) = positive_definite(hessian, gradient, self.options.length)?;
        Some(minimize_quadratic(
            &shifted, &factor, gradient, &lower, &upper,
        ))
    }

    /// Whether what `size` leaves is below the tolerance, if the steps go on shrinking at least
    /// as fast as the last two did.
    fn is_negligible(&self, size: f64, last: Option<f64>) -> bool {
        let tolerance = self.options.step_tolerance * self.options.length;
        last.is_some_and(|last| size * size <= last * tolerance)
    }

    /// Whether the steps have stopped shrinking and gain nothing that rounding would leave.
    fn is_noise(&self, current: &Current<D>, step: &SVector<f64, D>) -> bool {
        let evaluation = &current.evaluation;
        let gain = -evaluation.gradient.dot(step);
        current
            .last_step
            .is_some_and(|last| 2.0 * step.amax() >= last)
            && gain <= VALUE_ROUNDING * evaluation.value.abs()
    }

    /// Cuts the step until it is accepted and returns the fraction taken.
    fn search(
        &self,
        objective: &mut impl FnMut(&SVector<f64, D>) -> Evaluation<D>,
        current: &mut Current<D>,
        step: &SVector<f64, D>,
    ) -> Result<f64, Ended> {
        let start = current.evaluation;
        let slope = start.gradient.dot(step);
        let mut fraction = 1.0;
        for _ in 0..MAX_CUTS {
            if current.evaluations >= self.options.max_evaluations {
                return Err(Ended::EvaluationLimit);
            }
            let point = self.moved(&current.point, step, fraction);
            let trial = objective(&point);
            current.evaluations += 1;
            if is_accepted(&start, &trial, step, fraction * slope) {
                current.point = point;
                current.evaluation = trial;
                return Ok(fraction);
            }
            if -fraction * slope <= VALUE_ROUNDING * start.value.abs() {
                return Err(Ended::AtRounding);
            }
            fraction *= cut(trial.value - start.value, fraction * slope);
        }
        Err(Ended::NoDescent)
    }

    /// `point + fraction · step`, exactly on a bound where the whole step ends on it.
    fn moved(
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
    fn convergence(&self, current: &Current<D>) -> Option<Ended> {
        let size = (0..D).fold(0.0_f64, |size, axis| {
            size.max(self.free_slope(current, axis).abs())
        });
        if size <= self.options.gradient_tolerance * self.options.scale {
            Some(Ended::GradientSmall)
        } else if current.evaluations >= self.options.max_evaluations {
            Some(Ended::EvaluationLimit)
        } else {
            None
        }
    }

    /// The gradient along `axis`, zero where it pushes against a bound.
    fn free_slope(&self, current: &Current<D>, axis: usize) -> f64 {
        let slope = current.evaluation.gradient[axis];
        let at_lower = current.point[axis] <= self.lower[axis] && slope > 0.0;
        let at_upper = current.point[axis] >= self.upper[axis] && slope < 0.0;
        if at_lower || at_upper { 0.0 } else { slope }
    }
}

/// The Hessian, shifted as little as makes it positive definite, and its factor.
fn positive_definite<const D: usize>(
    hessian: &SMatrix<f64, D, D>,
    gradient: &SVector<f64, D>,
    length: f64,
) -> Option<(SMatrix<f64, D, D>, Cholesky<f64, Const<D>>)> {
    let mut shift = (SHIFT_OF_TRACE * hessian.trace().abs())
        .max(SHIFT_OF_GRADIENT * gradient.amax() / length)
        .max(f64::MIN_POSITIVE);
    for _ in 0..MAX_SHIFTS {
        let shifted = hessian + SMatrix::from_diagonal_element(shift);
        if let Some(factor) = shifted.cholesky() {
            return Some((shifted, factor));
        }
        shift *= SHIFT_GROWTH;
    }
    None
}

/// Whether the step would change no coordinate.
fn is_lost<const D: usize>(step: &SVector<f64, D>, point: &SVector<f64, D>) -> bool {
    (0..D).all(|axis| step[axis].abs() <= POINT_ROUNDING * point[axis].abs())
}

/// Whether every number of the evaluation is finite.
fn is_finite<const D: usize>(evaluation: &Evaluation<D>) -> bool {
    evaluation.value.is_finite()
        && evaluation.gradient.iter().all(|entry| entry.is_finite())
        && evaluation.hessian.iter().all(|entry| entry.is_finite())
}

/// Armijo's test, or the slope's where the values differ by rounding only; `decrease` is what
/// the slope at the start promises for the step taken, negative.
fn is_accepted<const D: usize>(
    start: &Evaluation<D>,
    trial: &Evaluation<D>,
    step: &SVector<f64, D>,
    decrease: f64,
) -> bool {
    if !is_finite(trial) {
        return false;
    }
    let change = trial.value - start.value;
    if change <= SUFFICIENT_DECREASE * decrease {
        return true;
    }
    let slope = start.gradient.dot(step);
    change <= VALUE_ROUNDING * start.value.abs()
        && trial.gradient.dot(step) <= (2.0 * SUFFICIENT_DECREASE - 1.0) * slope
}

/// By how much to shorten a rejected step: to the minimum of the parabola through both values
/// and the first slope (Nocedal & Wright, eq. 3.58), within [`CUTS`].
fn cut(change: f64, decrease: f64) -> f64 {
    let ratio = -0.5 * decrease / (change - decrease);
    if ratio.is_finite() {
        ratio.clamp(CUTS.0, CUTS.1)
    } else {
        CUTS.0
    }
}
