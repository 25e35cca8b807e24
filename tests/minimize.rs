//! What must hold of the minimizers: they find the minimum in the box, from anywhere, in few
//! evaluations, and never panic on a bad function.

use chebloyd::minimize::newton::{NewtonOptions, newton};
use chebloyd::minimize::problem::{Ended, Evaluation, Minimum};
use nalgebra::{SMatrix, SVector};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

// ───────────────────────────── a source of problems ─────────────────────────────

struct Random(ChaCha8Rng);

impl Random {
    fn seeded(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Uniform in [−1, 1).
    fn signed(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
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
        assert!(found.ended.converged(), "case {case}: {}", found.ended);
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
        assert!(found.ended.converged());
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
    assert!(found.ended.converged(), "{found:?}");
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
    assert_eq!(found.ended, Ended::GradientSmall);
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
    assert!(found.ended.converged(), "{found:?}");
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
    let ask = |lower, upper, options: &NewtonOptions| {
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
    assert_eq!(found.ended, Ended::NotFinite);

    let zero_size = ask(&problem.lower, &problem.lower, &options);
    assert_eq!(zero_size.ended, Ended::GradientSmall);
    assert_eq!((zero_size.point, zero_size.evaluations), (problem.lower, 1));

    let inverted = ask(&problem.upper, &problem.lower, &options);
    assert_eq!(inverted.point, problem.lower);

    let mut short = NewtonOptions::new(1.0, 1e-3);
    short.max_evaluations = 5;
    let above = SVector::repeat(f64::INFINITY);
    let below = -above;
    let cut_off = ask(&below, &above, &short);
    assert_eq!(
        (cut_off.ended, cut_off.evaluations),
        (Ended::EvaluationLimit, 5)
    );

    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = ask(&below, &above, &NewtonOptions::new(1.0, length));
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
    assert!(found.point.iter().all(|x| x.is_finite()));
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
        assert!(found.ended.converged(), "{found:?}");
        assert!(found.evaluations <= 12, "{found:?}");
        assert!((found.point - far - problem.middle).amax() < 1e-5);
    }
}
