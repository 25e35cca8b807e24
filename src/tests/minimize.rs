//! Minimizers: they find the minimum in the box, from any start, in few
//! evaluations, and never panic on a bad function.

use std::ops::ControlFlow;

use crate::geometry::random;
use crate::minimize::history::History;
use crate::minimize::lbfgsb::{self, LbfgsbEnd};
use crate::minimize::lbfgsb_state::{LbfgsbError, LbfgsbOptions, LbfgsbState};
use crate::minimize::newton::{NewtonOptions, minimize};
use crate::minimize::objective::Plain;
use crate::minimize::problem::{Evaluation, Jet, Minimum, Termination};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Whether a point is a minimum to the accuracy asked for or to what `f64` can tell.
fn converged(ended: Termination) -> bool {
    use Termination::{AtRounding, GradientSmall, StepNegligible, ValueSettled};
    matches!(
        ended,
        GradientSmall | StepNegligible | ValueSettled | AtRounding
    )
}

/// Newton's method for a function given by its values and derivatives.
fn newton<const D: usize, J: Into<Jet<D>>>(
    objective: impl FnMut(&SVector<f64, D>) -> J,
    start: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
    options: &NewtonOptions,
) -> Minimum<D> {
    minimize(&mut Plain(objective), start, lower, upper, options)
}

// ───────────────────────────── a source of problems ─────────────────────────────

struct Random(random::Random);

impl Random {
    fn seeded(seed: u64) -> Self {
        Self(random::Random::new(seed))
    }

    /// Uniform in [−1, 1).
    fn signed(&mut self) -> f64 {
        2.0 * self.0.uniform() - 1.0
    }

    fn vector<const D: usize>(&mut self) -> SVector<f64, D> {
        SVector::from_fn(|_, _| self.signed())
    }
}

/// A convex quadratic `½ (x−m)ᵀH(x−m)` and a box that often cuts off its minimum.
struct BoxQuadratic<const D: usize> {
    hessian: SMatrix<f64, D, D>,
    middle: SVector<f64, D>,
    lower: SVector<f64, D>,
    upper: SVector<f64, D>,
    start: SVector<f64, D>,
}

impl<const D: usize> BoxQuadratic<D> {
    fn random(random: &mut Random) -> Self {
        let root = SMatrix::<f64, D, D>::from_fn(|_, _| random.signed());
        let one: SVector<f64, D> = random.vector();
        let other: SVector<f64, D> = random.vector();
        Self {
            hessian: root * root.transpose() + SMatrix::from_diagonal_element(1e-3),
            middle: random.vector() * 1.5,
            lower: one.inf(&other),
            upper: one.sup(&other),
            start: random.vector() * 2.0,
        }
    }

    fn evaluate(&self, point: &SVector<f64, D>) -> Evaluation<D> {
        let offset = point - self.middle;
        let gradient = self.hessian * offset;
        Evaluation {
            value: 0.5 * gradient.dot(&offset),
            gradient,
            hessian: self.hessian,
        }
    }

    fn minimum(&self, options: &NewtonOptions) -> Minimum<D> {
        newton(
            |point| self.evaluate(point),
            &self.start,
            &self.lower,
            &self.upper,
            options,
        )
    }

    /// The least value over every way of fixing variables at bounds: 3^D linear solves.
    fn brute_force(&self) -> (SVector<f64, D>, f64) {
        let mut best = (self.lower, f64::INFINITY);
        for code in 0..3_usize.pow(D as u32) {
            let choice: [usize; D] =
                std::array::from_fn(|axis| code / 3_usize.pow(axis as u32) % 3);
            let point = self.restricted(&choice);
            let inside = (0..D).all(|axis| {
                self.lower[axis] - 1e-13 <= point[axis] && point[axis] <= self.upper[axis] + 1e-13
            });
            let value = self.evaluate(&point).value;
            if inside && value < best.1 {
                best = (point, value);
            }
        }
        best
    }

    /// The minimizer with each variable at its lower bound (0), upper bound (1) or free (2).
    fn restricted(&self, choice: &[usize; D]) -> SVector<f64, D> {
        let mut matrix = self.hessian;
        let mut right = self.hessian * self.middle;
        for axis in 0..D {
            if choice[axis] < 2 {
                matrix.row_mut(axis).fill(0.0);
                matrix[(axis, axis)] = 1.0;
                right[axis] = [self.lower, self.upper][choice[axis]][axis];
            }
        }
        // Gauss-Jordan elimination with row pivoting.
        for column in 0..D {
            let pivot = (column..D)
                .max_by(|&a, &b| {
                    matrix[(a, column)]
                        .abs()
                        .total_cmp(&matrix[(b, column)].abs())
                })
                .unwrap();
            matrix.swap_rows(column, pivot);
            right.swap_rows(column, pivot);
            for row in (0..D).filter(|&row| row != column) {
                let factor = matrix[(row, column)] / matrix[(column, column)];
                for k in 0..D {
                    matrix[(row, k)] -= factor * matrix[(column, k)];
                }
                right[row] -= factor * right[column];
            }
        }
        SVector::from_fn(|axis, _| right[axis] / matrix[(axis, axis)])
    }
}

// ─────────────────────────────────── Newton ───────────────────────────────────

fn newton_agrees_with_brute_force<const D: usize>(seed: u64) {
    let mut random = Random::seeded(seed);
    let options = NewtonOptions::new(1.0, 10.0);
    for case in 0..4000 {
        let problem = BoxQuadratic::<D>::random(&mut random);
        let found = problem.minimum(&options);
        let (point, value) = problem.brute_force();
        assert!(converged(found.ended), "case {case}: {}", found.ended);
        assert!(
            (found.point - point).amax() < 1e-8 && (found.value - value).abs() < 1e-13,
            "case {case}: {found:?} is not {point:?}"
        );
        assert!(found.evaluations <= 2, "case {case}: {found:?}");
    }
}

#[test]
fn newton_solves_every_box_quadratic_in_two_evaluations() {
    newton_agrees_with_brute_force::<2>(0x2d);
    newton_agrees_with_brute_force::<3>(0x3d);
}

/// `Σ √(1 + (a_k·x − b_k)²)`: smooth, convex, far from quadratic.
fn rounded_distances<const D: usize>(
    normals: &[SVector<f64, D>],
    offsets: &[f64],
    point: &SVector<f64, D>,
) -> Evaluation<D> {
    let mut sum = Evaluation {
        value: 0.0,
        gradient: SVector::zeros(),
        hessian: SMatrix::zeros(),
    };
    for (normal, offset) in normals.iter().zip(offsets) {
        let height = normal.dot(point) - offset;
        let root = (1.0 + height * height).sqrt();
        sum.value += root;
        sum.gradient += normal * (height / root);
        sum.hessian += normal * normal.transpose() / (root * root * root);
    }
    sum
}

#[test]
fn newton_needs_few_evaluations_on_smooth_convex_functions() {
    let mut random = Random::seeded(7);
    let mut evaluations = 0;
    for _ in 0..1000 {
        let normals: Vec<SVector<f64, 3>> = (0..8).map(|_| random.vector()).collect();
        let offsets: Vec<f64> = (0..8).map(|_| 0.5 * random.signed()).collect();
        let found = newton(
            |point| rounded_distances(&normals, &offsets, point),
            &random.vector(),
            &SVector::repeat(-3.0),
            &SVector::repeat(3.0),
            &NewtonOptions::new(1.0, 1.0),
        );
        assert!(converged(found.ended));
        let exact = rounded_distances(&normals, &offsets, &found.point);
        let free = (0..3).filter(|&axis| found.point[axis].abs() < 3.0 - 1e-9);
        let slope = free.fold(0.0_f64, |size, axis| size.max(exact.gradient[axis].abs()));
        assert!(slope < 1e-9, "{slope:e} {found:?}");
        assert!((found.value - exact.value).abs() < 1e-13 * exact.value);
        evaluations += found.evaluations;
    }
    let mean = f64::from(evaluations) / 1000.0;
    assert!(mean < 5.0, "{mean} evaluations on average");
}

/// `Σ max(0, |x_k| − 1)³`: flat, with a zero Hessian, in the unit box.
#[test]
fn newton_ends_on_the_flat_bottom_of_a_function_without_hessian() {
    let flat = |point: &SVector<f64, 3>| {
        let over = point.map(|x| (x.abs() - 1.0).max(0.0) * x.signum());
        Evaluation {
            value: over.map(|x| x.abs().powi(3)).sum(),
            gradient: over.map(|x| 3.0 * x * x.abs()),
            hessian: SMatrix::from_diagonal(&over.map(|x| 6.0 * x.abs())),
        }
    };
    let found = newton(
        flat,
        &SVector::<f64, 3>::new(4.0, -3.0, 0.5),
        &SVector::repeat(-10.0),
        &SVector::repeat(10.0),
        &NewtonOptions::new(1.0, 1.0),
    );
    assert!(converged(found.ended), "{found:?}");
    assert!(found.value < 1e-9 && found.point.amax() < 1.01, "{found:?}");
}

#[test]
fn newton_follows_a_linear_function_to_the_corner() {
    let slope = SVector::<f64, 3>::new(1.0, -2.0, 1e-3);
    let found = newton(
        |point| Evaluation {
            value: slope.dot(point),
            gradient: slope,
            hessian: SMatrix::zeros(),
        },
        &SVector::zeros(),
        &SVector::repeat(-5.0),
        &SVector::repeat(5.0),
        &NewtonOptions::new(1.0, 2.0),
    );
    assert_eq!(found.ended, Termination::GradientSmall);
    assert_eq!(found.point, SVector::<f64, 3>::new(-5.0, 5.0, -5.0));
    assert!(found.evaluations <= 4);
}

#[test]
fn newton_starts_anywhere_and_steps_no_longer_than_allowed() {
    let mut random = Random::seeded(11);
    for _ in 0..200 {
        let mut problem = BoxQuadratic::<3>::random(&mut random);
        let bounds = [problem.lower, problem.upper];
        problem.start = SVector::from_fn(|axis, _| bounds[(random.signed() > 0.0) as usize][axis]);
        let (point, _) = problem.brute_force();
        let mut last: Option<SVector<f64, 3>> = None;
        let found = newton(
            |trial| {
                let longest = last.map_or(0.0, |last| (trial - last).amax());
                assert!(longest <= 0.1 + 1e-15, "{longest}");
                last = Some(*trial);
                problem.evaluate(trial)
            },
            &problem.start,
            &problem.lower,
            &problem.upper,
            &NewtonOptions::new(1.0, 0.1),
        );
        assert!((found.point - point).amax() < 1e-8, "{found:?}");
    }
}

#[test]
fn newton_backs_off_from_trials_that_are_not_finite() {
    // −ln(x) has a wall at zero and steps of Newton that overshoot it from the far side.
    let barrier = |point: &SVector<f64, 2>| Evaluation {
        value: point.map(|x| 0.1 * x - x.ln()).sum(),
        gradient: point.map(|x| 0.1 - 1.0 / x),
        hessian: SMatrix::from_diagonal(&point.map(|x| 1.0 / (x * x))),
    };
    let found = newton(
        barrier,
        &SVector::<f64, 2>::new(30.0, 0.01),
        &SVector::repeat(-100.0),
        &SVector::repeat(100.0),
        &NewtonOptions::new(1.0, 50.0),
    );
    assert!(converged(found.ended), "{found:?}");
    assert!((found.point - SVector::<f64, 2>::repeat(10.0)).amax() < 1e-8);
}

#[test]
fn newton_reports_a_bad_question_instead_of_panicking() {
    let mut random = Random::seeded(3);
    let problem = BoxQuadratic::<3>::random(&mut random);
    let bad = |_: &SVector<f64, 3>| Evaluation {
        value: f64::NAN,
        gradient: SVector::zeros(),
        hessian: SMatrix::zeros(),
    };
    let options = NewtonOptions::new(1.0, 1.0);
    let minimize = |lower, upper, options: &NewtonOptions| {
        newton(
            |x| problem.evaluate(x),
            &problem.start,
            lower,
            upper,
            options,
        )
    };
    let found = newton(
        bad,
        &problem.start,
        &problem.lower,
        &problem.upper,
        &options,
    );
    assert_eq!(found.ended, Termination::NotFinite);

    let zero_size = minimize(&problem.lower, &problem.lower, &options);
    assert_eq!(zero_size.ended, Termination::GradientSmall);
    assert_eq!((zero_size.point, zero_size.evaluations), (problem.lower, 1));

    let inverted = minimize(&problem.upper, &problem.lower, &options);
    assert_eq!(inverted.point, problem.lower);

    let mut short = NewtonOptions::new(1.0, 1e-3);
    short.max_evaluations = 5;
    let above = SVector::repeat(f64::INFINITY);
    let below = -above;
    let cut_off = minimize(&below, &above, &short);
    assert_eq!(
        (cut_off.ended, cut_off.evaluations),
        (Termination::EvaluationLimit, 5)
    );

    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = minimize(&below, &above, &NewtonOptions::new(1.0, length));
        assert!(found.point.iter().all(|x| x.is_finite()), "length {length}");
    }
    let uphill = |point: &SVector<f64, 3>| Evaluation {
        gradient: -problem.evaluate(point).gradient,
        ..problem.evaluate(point)
    };
    let found = newton(
        uphill,
        &problem.start,
        &problem.lower,
        &problem.upper,
        &options,
    );
    assert_eq!(found.ended, Termination::NoDescent);
}

#[test]
fn newton_ends_at_rounding_when_the_gradient_cannot_become_small() {
    let mut random = Random::seeded(5);
    for _ in 0..500 {
        let problem = BoxQuadratic::<3>::random(&mut random);
        let far = SVector::repeat(1e4);
        let mut noise = Random::seeded(9);
        let mut options = NewtonOptions::new(1.0, 10.0);
        options.step_tolerance = 0.0;
        let found = newton(
            |point| {
                let mut evaluation = problem.evaluate(&(point - far));
                evaluation.gradient += noise.vector::<3>() * 1e-9;
                evaluation.value += 1.0;
                evaluation
            },
            &(far + problem.start),
            &(far - SVector::repeat(9.0)),
            &(far + SVector::repeat(9.0)),
            &options,
        );
        assert!(converged(found.ended), "{found:?}");
        assert!(found.evaluations <= 12, "{found:?}");
        assert!((found.point - far - problem.middle).amax() < 1e-5);
    }
}

// ────────────────────────────────── L-BFGS-B ──────────────────────────────────

fn never(_: &mut LbfgsbState, _: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// A run from a point whose value is not known.
fn lbfgsb(
    objective: impl FnMut(&[f64], &mut [f64]) -> f64,
    start: &[f64],
    lower: &[f64],
    upper: &[f64],
    options: &LbfgsbOptions,
    observer: impl FnMut(&mut LbfgsbState, f64) -> ControlFlow<()>,
) -> Result<LbfgsbEnd, LbfgsbError> {
    let state = LbfgsbState::unevaluated(start);
    lbfgsb::lbfgsb(objective, state, lower, upper, options, observer)
}

fn options(gradient_tolerance: f64) -> LbfgsbOptions {
    LbfgsbOptions {
        gradient_tolerance,
        ..LbfgsbOptions::default()
    }
}

/// `½ (x−m)ᵀH(x−m)` in any dimension.
struct LargeQuadratic {
    hessian: DMatrix<f64>,
    middle: DVector<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    start: Vec<f64>,
}

impl LargeQuadratic {
    /// Of `size` variables; with a `width` of 1 about half of them end at a bound, with 5 few.
    fn random(random: &mut Random, size: usize, width: f64) -> Self {
        let root = DMatrix::from_fn(size, size, |_, _| random.signed());
        let mut uniform =
            |width: f64| -> Vec<f64> { (0..size).map(|_| width * random.signed()).collect() };
        let (one, other) = (uniform(width), uniform(width));
        Self {
            hessian: &root * root.transpose() / size as f64 + DMatrix::identity(size, size) * 0.01,
            middle: DVector::from_vec(uniform(1.5)),
            lower: one.iter().zip(&other).map(|(a, b)| a.min(*b)).collect(),
            upper: one.iter().zip(&other).map(|(a, b)| a.max(*b)).collect(),
            start: uniform(2.0),
        }
    }

    fn evaluate(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let offset = DVector::from_column_slice(point) - &self.middle;
        let slope = &self.hessian * &offset;
        gradient.copy_from_slice(slope.as_slice());
        0.5 * slope.dot(&offset)
    }

    fn minimum(&self, options: &LbfgsbOptions) -> LbfgsbEnd {
        lbfgsb(
            |point, gradient| self.evaluate(point, gradient),
            &self.start,
            &self.lower,
            &self.upper,
            options,
            never,
        )
        .unwrap()
    }

    /// The largest violation of the conditions of Karush, Kuhn and Tucker.
    fn violation(&self, point: &[f64]) -> f64 {
        let mut gradient = vec![0.0; point.len()];
        self.evaluate(point, &mut gradient);
        (0..point.len()).fold(0.0, |worst, i| {
            assert!(self.lower[i] <= point[i] && point[i] <= self.upper[i]);
            let moved = (point[i] - gradient[i]).clamp(self.lower[i], self.upper[i]);
            f64::max(worst, (moved - point[i]).abs())
        })
    }
}

#[test]
fn lbfgsb_agrees_with_brute_force_on_small_box_quadratics() {
    let mut random = Random::seeded(0xb3);
    let (mut evaluations, mut worst) = (0, 0);
    for case in 0..4000 {
        let problem = BoxQuadratic::<3>::random(&mut random);
        let found = lbfgsb(
            |point, gradient| {
                let evaluation = problem.evaluate(&SVector::from_column_slice(point));
                gradient.copy_from_slice(evaluation.gradient.as_slice());
                evaluation.value
            },
            problem.start.as_slice(),
            problem.lower.as_slice(),
            problem.upper.as_slice(),
            &options(1e-12),
            never,
        )
        .unwrap();
        let (point, _) = problem.brute_force();
        let distance = (SVector::<f64, 3>::from_column_slice(found.state.point()) - point).amax();
        assert!(converged(found.ended), "case {case}: {}", found.ended);
        assert!(
            distance < 1e-8,
            "case {case}: off by {distance:e}: {found:?}"
        );
        evaluations += found.state.evaluations();
        worst = worst.max(found.state.evaluations());
    }
    assert!(evaluations < 4000 * 12, "{evaluations} evaluations");
    assert!(worst < 60, "{worst} evaluations");
}

#[test]
fn lbfgsb_meets_the_optimality_conditions_and_a_second_implementation() {
    let mut random = Random::seeded(0xb200);
    for size in [10, 20, 50, 100, 200] {
        for case in 0..20 {
            let width = [1.0, 2.0, 5.0][case % 3];
            let problem = LargeQuadratic::random(&mut random, size, width);
            let found = problem.minimum(&options(1e-9));
            let violation = problem.violation(found.state.point());
            assert!(converged(found.ended), "{size} {case}: {}", found.ended);
            assert!(violation < 1e-8, "{size} {case}: {violation:e}");
            let peer = by_rcompat(&problem);
            assert!(
                found.state.value() <= peer + 1e-9 * peer.abs(),
                "{size} {case}: {} above {peer}",
                found.state.value()
            );
        }
    }
}

/// The minimum another crate finds.
fn by_rcompat(problem: &LargeQuadratic) -> f64 {
    let size = problem.start.len();
    let start = (0..size).map(|i| problem.start[i].clamp(problem.lower[i], problem.upper[i]));
    let mut control = rcompat_lbfgsb::OptimControl::default_for_dimension(size);
    control.maxit = 2000;
    control.factr = 10.0;
    let value = |point: &[f64]| problem.evaluate(point, &mut vec![0.0; size]);
    let gradient = |point: &[f64]| {
        let mut gradient = vec![0.0; size];
        problem.evaluate(point, &mut gradient);
        gradient
    };
    let bounds = rcompat_lbfgsb::Bounds::new(problem.lower.clone(), problem.upper.clone()).unwrap();
    rcompat_lbfgsb::optim_lbfgsb_with_gradient(start.collect(), bounds, value, gradient, control)
        .unwrap()
        .value
}

/// The chained function of Rosenbrock, `Σ 100 (x_{i+1} − x_i²)² + (1 − x_i)²`.
fn rosenbrock(point: &[f64], gradient: &mut [f64]) -> f64 {
    gradient.fill(0.0);
    let mut sum = 0.0;
    for i in 0..point.len() - 1 {
        let (deviation, rest) = (point[i + 1] - point[i] * point[i], 1.0 - point[i]);
        sum += 100.0 * deviation * deviation + rest * rest;
        gradient[i] -= 400.0 * deviation * point[i] + 2.0 * rest;
        gradient[i + 1] += 200.0 * deviation;
    }
    sum
}

#[test]
fn lbfgsb_walks_the_valley_of_rosenbrock() {
    for (size, upper, expected) in [
        (2, f64::INFINITY, [1.0, 1.0]),
        (2, 0.5, [0.5, 0.25]),
        (50, f64::INFINITY, [1.0, 1.0]),
    ] {
        let found = lbfgsb(
            rosenbrock,
            &vec![-1.2; size],
            &vec![-5.0; size],
            &vec![upper; size],
            &options(1e-10),
            never,
        )
        .unwrap();
        assert!(converged(found.ended), "{}", found.ended);
        let point = &found.state.point()[..2];
        let near = (point[0] - expected[0]).abs() + (point[1] - expected[1]).abs() < 1e-8;
        // The long chain has a second minimum near (−1, 1, …): what counts is the gradient.
        assert!(near || size > 2, "{point:?}");
        assert!(
            found.state.evaluations() < 600,
            "{}",
            found.state.evaluations()
        );
    }
}

#[test]
fn lbfgsb_and_newton_find_the_same_center() {
    let mut random = Random::seeded(17);
    for case in 0..500 {
        let normals: Vec<SVector<f64, 3>> = (0..8).map(|_| random.vector()).collect();
        let offsets: Vec<f64> = (0..8).map(|_| 0.5 * random.signed()).collect();
        let start: SVector<f64, 3> = random.vector();
        let (lower, upper) = (SVector::repeat(-0.6), SVector::repeat(0.6));
        let evaluate = |point: &SVector<f64, 3>| rounded_distances(&normals, &offsets, point);
        let exact = newton(
            evaluate,
            &start,
            &lower,
            &upper,
            &NewtonOptions::new(1.0, 1.0),
        );
        let found = lbfgsb(
            |point, gradient| {
                let evaluation = evaluate(&SVector::from_column_slice(point));
                gradient.copy_from_slice(evaluation.gradient.as_slice());
                evaluation.value
            },
            start.as_slice(),
            lower.as_slice(),
            upper.as_slice(),
            &options(1e-11),
            never,
        )
        .unwrap();
        let distance = (SVector::from_column_slice(found.state.point()) - exact.point).amax();
        assert!(converged(found.ended), "case {case}: {}", found.ended);
        assert!(distance < 1e-8, "case {case}: {distance:e} apart");
    }
}

#[test]
fn lbfgsb_gives_the_same_steps_in_any_unit() {
    // Lengths in units 2^20 smaller, values in units 2^30 larger: powers of two are exact.
    let problem = LargeQuadratic::random(&mut Random::seeded(23), 30, 1.0);
    let (length, value) = ((2.0_f64).powi(-20), (2.0_f64).powi(30));
    let shrunk = |numbers: &[f64]| -> Vec<f64> { numbers.iter().map(|x| x * length).collect() };
    let small = lbfgsb(
        |point, gradient| {
            let large: Vec<f64> = point.iter().map(|x| x / length).collect();
            let result = problem.evaluate(&large, gradient);
            gradient.iter_mut().for_each(|g| *g *= value / length);
            result * value
        },
        &shrunk(&problem.start),
        &shrunk(&problem.lower),
        &shrunk(&problem.upper),
        &LbfgsbOptions {
            scale: value / length,
            first_step: length,
            ..options(1e-8)
        },
        never,
    )
    .unwrap();
    let large = problem.minimum(&options(1e-8));
    assert_eq!(small.state.evaluations(), large.state.evaluations());
    for (small, large) in small.state.point().iter().zip(large.state.point()) {
        assert!((small / length - large).abs() < 1e-12);
    }
}

#[test]
fn lbfgsb_never_moves_a_site_farther_than_allowed() {
    let problem = LargeQuadratic::random(&mut Random::seeded(29), 60, 1.0);
    let wide = (vec![-3.0; 60], vec![3.0; 60]);
    let mut last = problem.start.clone();
    let found = lbfgsb(
        |point, gradient| problem.evaluate(point, gradient),
        &problem.start,
        &wide.0,
        &wide.1,
        &LbfgsbOptions {
            group: 3,
            largest_step: 0.05,
            ..options(1e-9)
        },
        |state, displacement| {
            let point = state.point();
            let moved: Vec<f64> = point.iter().zip(&last).map(|(a, b)| a - b).collect();
            let farthest = moved
                .chunks(3)
                .map(|d| DVector::from_column_slice(d).norm());
            let farthest = farthest.fold(0.0, f64::max);
            assert!((farthest - displacement).abs() < 1e-12 && farthest < 0.05 + 1e-12);
            last = point.to_vec();
            ControlFlow::Continue(())
        },
    )
    .unwrap();
    assert!(converged(found.ended));
    let inside = LargeQuadratic {
        lower: wide.0,
        upper: wide.1,
        ..problem
    };
    assert!(inside.violation(found.state.point()) < 1e-8);
}

#[test]
fn lbfgsb_taken_up_again_goes_on_bit_for_bit() {
    for size in [3, 40] {
        let problem = LargeQuadratic::random(&mut Random::seeded(31), size, 1.0);
        let options = LbfgsbOptions {
            memory: 5,
            ..options(1e-10)
        };
        let whole = problem.minimum(&options);
        assert_eq!(whole, problem.minimum(&options));
        let mut state = LbfgsbState::unevaluated(&problem.start);
        let ended = loop {
            let next = lbfgsb::lbfgsb(
                |point, gradient| problem.evaluate(point, gradient),
                state,
                &problem.lower,
                &problem.upper,
                &options,
                |_, _| ControlFlow::Break(()),
            )
            .unwrap();
            state = through_text(&next.state);
            if next.ended != Termination::Stopped {
                break next.ended;
            }
        };
        assert_eq!((state, ended), (whole.state, whole.ended));
    }
}

/// The state written as decimal numbers and read again.
fn through_text(state: &LbfgsbState) -> LbfgsbState {
    let copy = |numbers: &[f64]| -> Vec<f64> {
        let text = |x: &f64| format!("{x:e}").parse().unwrap();
        numbers.iter().map(text).collect()
    };
    let copies = |vectors: &[Vec<f64>]| vectors.iter().map(|vector| copy(vector)).collect();
    let history = state.history();
    LbfgsbState::from_parts(
        copy(state.point()),
        copy(&[state.value()])[0],
        copy(state.gradient()),
        History::from_parts(copies(history.steps()), copies(history.changes())),
        state.iterations(),
        state.evaluations(),
    )
}

#[test]
fn lbfgsb_backs_off_from_trials_that_are_not_finite() {
    let barrier = |point: &[f64], gradient: &mut [f64]| {
        for (slope, x) in gradient.iter_mut().zip(point) {
            *slope = 0.1 - 1.0 / x;
        }
        point.iter().map(|x| 0.1 * x - x.ln()).sum()
    };
    let found = lbfgsb(
        barrier,
        &[30.0, 0.01, 1.0],
        &[-100.0; 3],
        &[100.0; 3],
        &LbfgsbOptions {
            first_step: 50.0,
            ..options(1e-10)
        },
        never,
    )
    .unwrap();
    assert!(converged(found.ended), "{}", found.ended);
    assert!(found.state.point().iter().all(|x| (x - 10.0).abs() < 1e-7));
}

#[test]
fn lbfgsb_ends_where_it_cannot_go_on() {
    let mut problem = LargeQuadratic::random(&mut Random::seeded(37), 10, 1.0);
    let never_finite = lbfgsb(
        |_, _| f64::INFINITY,
        &problem.start,
        &problem.lower,
        &problem.upper,
        &options(1e-9),
        never,
    );
    assert_eq!(never_finite.unwrap().ended, Termination::NotFinite);

    let limited = problem.minimum(&LbfgsbOptions {
        max_evaluations: 4,
        ..options(1e-9)
    });
    assert_eq!(limited.ended, Termination::EvaluationLimit);
    assert_eq!(limited.state.evaluations(), 4);

    let settled = problem.minimum(&LbfgsbOptions {
        value_tolerance: 1e-3,
        ..options(1e-15)
    });
    assert_eq!(settled.ended, Termination::ValueSettled);

    let uphill = lbfgsb(
        |point, gradient| {
            let value = problem.evaluate(point, gradient);
            gradient.iter_mut().for_each(|g| *g = -*g);
            value
        },
        &[0.0; 10],
        &[-9.0; 10],
        &[9.0; 10],
        &options(1e-9),
        never,
    );
    assert_eq!(uphill.unwrap().ended, Termination::NoDescent);

    problem.upper = problem.lower.clone();
    let zero_size = problem.minimum(&options(1e-9));
    assert_eq!(zero_size.ended, Termination::GradientSmall);
    assert_eq!(zero_size.state.point(), problem.lower);

    let nothing = lbfgsb(|_, _| 0.0, &[], &[], &[], &options(1e-9), never).unwrap();
    assert_eq!(nothing.ended, Termination::GradientSmall);
}

#[test]
fn lbfgsb_names_what_is_wrong_with_a_question() {
    let refusal = |start: &[f64], lower: &[f64], upper: &[f64], options: &LbfgsbOptions| {
        lbfgsb(rosenbrock, start, lower, upper, options, never).unwrap_err()
    };
    let good = LbfgsbOptions::default();
    assert!(matches!(
        refusal(&[0.0; 2], &[0.0; 3], &[1.0; 2], &good),
        LbfgsbError::Length {
            expected: 2,
            found: 3,
            ..
        }
    ));
    assert!(matches!(
        refusal(&[0.0; 2], &[0.0, 2.0], &[1.0; 2], &good),
        LbfgsbError::NoRoom { variable: 1, .. }
    ));
    assert!(matches!(
        refusal(&[0.0; 2], &[f64::NAN, 0.0], &[1.0; 2], &good),
        LbfgsbError::NoRoom { variable: 0, .. }
    ));
    let forgetful = LbfgsbOptions { memory: 0, ..good };
    assert!(matches!(
        refusal(&[0.0; 2], &[0.0; 2], &[1.0; 2], &forgetful),
        LbfgsbError::Option {
            option: "memory",
            ..
        }
    ));
    let outside =
        LbfgsbState::from_parts(vec![7.0; 2], 1.0, vec![1.0; 2], History::default(), 1, 1);
    let error =
        lbfgsb::lbfgsb(rosenbrock, outside, &[0.0; 2], &[1.0; 2], &good, never).unwrap_err();
    assert!(error.to_string().contains("variable 0"));
}
