//! Newton's method in a box, for convex functions of two or three variables.
//!
//! Each step minimizes the quadratic model over the box *exactly* (`box_quadratic`), instead of
//! taking the free Newton step and projecting it: Bertsekas (*Projected Newton methods*, SIAM J.
//! Control Optim. 20, 1982) shows that projection can point uphill unless nearly active
//! variables are held, while in three variables the exact step costs one small factorization
//! more, and only when a bound is in the way. At a minimum both hold the same variables: those at
//! a bound whose gradient pushes outward.
//!
//! # Third derivatives
//!
//! Where the objective knows them, a step s that no bound limits becomes Chebyshev's,
//! s − ½ H⁻¹ T s s with T the third derivative (Traub, *Iterative Methods for the Solution of
//! Equations*, 1964, section 5.2, in several variables): it converges cubically and saves a
//! Voronoi cell about one evaluation. Where the second term is not small, it is left away.
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

use argmin::core::{Error, Executor, KV, Problem, Solver};
use nalgebra::{Cholesky, Const, SVector};

use crate::minimize::backtracking::{VALUE_ROUNDING, cut, is_accepted, is_finite};
use crate::minimize::box_quadratic::{minimize_quadratic, positive_definite};
use crate::minimize::newton_state::NewtonState;
use crate::minimize::problem::{Ended, Evaluation, Jet, Minimum};
use crate::minimize::progress::Progress;

/// Up to this many times the rounding of values, a gain that does not come is put down to it.
const SMALL_GAIN: f64 = 1e3;
/// Up to this share of Newton's step the correction by the third derivative is trusted.
const LARGEST_CORRECTION: f64 = 0.5;
/// Steps below this share of the coordinates do not move the point.
const POINT_ROUNDING: f64 = f64::EPSILON;
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
    /// Tolerances 1e-12 for the gradient and 1e-11 for an unchecked step, 100 evaluations.
    #[must_use]
    pub fn new(scale: f64, length: f64) -> Self {
        Self {
            scale,
            length,
            gradient_tolerance: 1e-12,
            step_tolerance: 1e-11,
            max_evaluations: 100,
        }
    }
}

/// Minimizes a convex function over the box `lower ≤ x ≤ upper`.
///
/// The start is moved into the box first. The function may be only piecewise twice
/// differentiable. Where `lower > upper` the upper bound counts.
pub fn newton<const D: usize, J: Into<Jet<D>>>(
    mut objective: impl FnMut(&SVector<f64, D>) -> J,
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
    let objective = |point: &SVector<f64, D>| objective(point).into();
    match Executor::new(objective, solver).ctrlc(false).run() {
        Ok(result) => result.state.iterate.minimum(result.state.ended),
        Err(_) => NewtonState::default().minimum(None),
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

impl<const D: usize, F> Solver<F, Progress<NewtonState<D>>> for ProjectedNewton<D>
where
    F: FnMut(&SVector<f64, D>) -> Jet<D>,
{
    fn name(&self) -> &'static str {
        "projected Newton"
    }

    fn init(
        &mut self,
        problem: &mut Problem<F>,
        mut state: Progress<NewtonState<D>>,
    ) -> Result<(Progress<NewtonState<D>>, Option<KV>), Error> {
        let current = &mut state.iterate;
        current.point = self.projected(&self.start);
        if let Some(objective) = &mut problem.problem {
            let jet = objective(&current.point);
            (current.evaluation, current.third) = (jet.evaluation, jet.third);
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
        mut state: Progress<NewtonState<D>>,
    ) -> Result<(Progress<NewtonState<D>>, Option<KV>), Error> {
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
        objective: &mut impl FnMut(&SVector<f64, D>) -> Jet<D>,
        current: &mut NewtonState<D>,
    ) -> Option<Ended> {
        let Some(step) = self.step(current) else {
            return Some(Ended::NoDescent);
        };
        let size = step.amax();
        if is_lost(&step, &current.point) || self.is_noise(current, &step) {
            return Some(Ended::AtRounding);
        }
        if self.is_negligible(size, current) {
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
    fn step(&self, current: &NewtonState<D>) -> Option<SVector<f64, D>> {
        let Evaluation {
            gradient, hessian, ..
        } = &current.evaluation;
        let length = SVector::repeat(self.options.length);
        let lower = (self.lower - current.point).sup(&-length);
        let upper = (self.upper - current.point).inf(&length);
        let (shifted, factor) = positive_definite(hessian, gradient, self.options.length)?;
        let step = minimize_quadratic(&shifted, &factor, gradient, &lower, &upper);
        let is_inside = |step: &SVector<f64, D>| {
            (0..D).all(|axis| lower[axis] < step[axis] && step[axis] < upper[axis])
        };
        let corrected = corrected(&step, current, &factor).filter(is_inside);
        Some(corrected.filter(|_| is_inside(&step)).unwrap_or(step))
    }

    /// Whether what `size` leaves is below the tolerance, if the steps go on shrinking at least
    /// as fast as the last two did; with third derivatives, if their ratio squares at least.
    fn is_negligible(&self, size: f64, current: &NewtonState<D>) -> bool {
        let tolerance = self.options.step_tolerance * self.options.length;
        current.last_step.is_some_and(|last| {
            let ratio = size / last;
            let shrinks_to = if current.third.is_some() {
                ratio * ratio
            } else {
                ratio
            };
            ratio < 1.0 && size * shrinks_to <= tolerance
        })
    }

    /// Whether the steps have stopped shrinking and gain nothing that rounding would leave.
    fn is_noise(&self, current: &NewtonState<D>, step: &SVector<f64, D>) -> bool {
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
        objective: &mut impl FnMut(&SVector<f64, D>) -> Jet<D>,
        current: &mut NewtonState<D>,
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
            let Jet {
                evaluation: trial,
                third,
            } = objective(&point);
            current.evaluations += 1;
            if is_accepted(&start, &trial, step, fraction * slope) {
                current.point = point;
                (current.evaluation, current.third) = (trial, third);
                return Ok(fraction);
            }
            if -fraction * slope <= VALUE_ROUNDING * start.value.abs() {
                break;
            }
            fraction *= cut(trial.value - start.value, fraction * slope);
        }
        if -slope <= SMALL_GAIN * VALUE_ROUNDING * start.value.abs() {
            Err(Ended::AtRounding)
        } else {
            Err(Ended::NoDescent)
        }
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
    fn convergence(&self, current: &NewtonState<D>) -> Option<Ended> {
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
    fn free_slope(&self, current: &NewtonState<D>, axis: usize) -> f64 {
        let slope = current.evaluation.gradient[axis];
        let at_lower = current.point[axis] <= self.lower[axis] && slope > 0.0;
        let at_upper = current.point[axis] >= self.upper[axis] && slope < 0.0;
        if at_lower || at_upper { 0.0 } else { slope }
    }
}

/// Chebyshev's step, if it is known and stays near Newton's `step` and as good as downhill.
fn corrected<const D: usize>(
    step: &SVector<f64, D>,
    current: &NewtonState<D>,
    factor: &Cholesky<f64, Const<D>>,
) -> Option<SVector<f64, D>> {
    let third = current.third.as_ref()?;
    let mut bend = SVector::zeros();
    for (along, share) in third.iter().zip(step.iter()) {
        bend += along * step * *share;
    }
    let corrected = step - factor.solve(&bend) * 0.5;
    let gradient = &current.evaluation.gradient;
    let is_small = (corrected - step).amax() <= LARGEST_CORRECTION * step.amax();
    let is_downhill = gradient.dot(&corrected) <= LARGEST_CORRECTION * gradient.dot(step);
    (is_small && is_downhill).then_some(corrected)
}

/// Whether the step would change no coordinate.
fn is_lost<const D: usize>(step: &SVector<f64, D>, point: &SVector<f64, D>) -> bool {
    (0..D).all(|axis| step[axis].abs() <= POINT_ROUNDING * point[axis].abs())
}
