//! The reachable center nearest to what is wanted, where no density within the range does it.
//!
//! Let E(λ) be the most that Σ λ_k φ_k(C) can be over all centers C within the range: of a density that is hi
//! where Σ λ_k φ_k exceeds E(λ) and lo elsewhere (with a given mass: where it exceeds what makes that mass).
//! If condition k is missed by no more than n_k·v, v a horizontal shift, then the least |v| is
//!
//! ```text
//! |v|²/2 = −min ½ |Σ λ_k n_k|² + E(λ)     (λ_k ≥ 0 for inequalities),   v = Σ λ_k n_k
//! ```
//!
//! a smooth convex problem. The derivatives of E are φ_k(C) and integrals over the section between hi and lo.

use nalgebra::{DMatrix, DVector, Point3, Vector3};

use crate::balance::dual::{Balance, DensityRange};
use crate::balance::quadratic::minimize_quadratic;
use crate::balance::solid::{AffineForm, SolidBalance};
use crate::geometry::moments::Moments;

/// The nearest reachable center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearestCenter {
    /// The center.
    pub(crate) center: Point3<f64>,
    /// The length of the shift that it lacks.
    pub(crate) distance: f64,
    /// Evaluations of extreme centers.
    pub(crate) evaluations: usize,
}

/// More steps than are needed (5-15).
const MOST_STEPS: usize = 60;
const MOST_HALVINGS: usize = 40;

/// Densities above this multiple of the low end stand for unbounded ones.
const UNBOUNDED: f64 = 1e18;

/// What is asked of an extreme center.
pub(crate) struct Reach<'a> {
    /// The body under conditions on its center alone.
    pub(crate) balance: &'a SolidBalance<'a>,
    /// For each condition the direction along which it is missed.
    pub(crate) directions: &'a [Vector3<f64>],
    /// The range.
    pub(crate) range: &'a DensityRange,
    /// The mass, if it is given.
    pub(crate) mass: Option<f64>,
}

/// ½|v|² + E at multipliers.
struct ReachPoint {
    multipliers: DVector<f64>,
    value: f64,
    gradient: DVector<f64>,
    extreme: f64,
    center: Moments,
    /// Where hi begins.
    above: AffineForm,
}

impl Reach<'_> {
    /// The nearest center; `start` are multipliers that refute the conditions.
    pub(crate) fn nearest(&self, start: &DVector<f64>) -> NearestCenter {
        let mut at = self.scaled(self.evaluate(start));
        let mut evaluations = 1;
        for _ in 0..MOST_STEPS {
            let matrix = self.curvature(&at);
            let linear = &at.gradient - &matrix * &at.multipliers;
            let goal = minimize_quadratic(&matrix, &linear, self.balance.relations());
            let way = goal - &at.multipliers;
            let slope = at.gradient.dot(&way);
            let next = (0..MOST_HALVINGS).find_map(|halvings| {
                let share = 0.5_f64.powi(halvings as i32);
                evaluations += 1;
                let trial = self.scaled(self.evaluate(&(&at.multipliers + &way * share)));
                (trial.value < at.value + 1e-4 * share * slope).then_some(trial)
            });
            match next {
                Some(next) => at = next,
                None => break,
            }
        }
        let shift = self.shift(&at.multipliers);
        NearestCenter {
            center: self.balance.middle + at.center.center(),
            distance: shift.norm(),
            evaluations,
        }
    }

    /// Σ λ_k n_k.
    fn shift(&self, multipliers: &DVector<f64>) -> Vector3<f64> {
        let pairs = self.directions.iter().zip(multipliers.iter());
        pairs.map(|(direction, factor)| direction * *factor).sum()
    }

    fn high(&self) -> f64 {
        self.range.high.min(UNBOUNDED * self.range.low)
    }

    fn evaluate(&self, multipliers: &DVector<f64>) -> ReachPoint {
        let tilt = self.balance.combined(multipliers);
        let above = match self.mass {
            Some(mass) => self.level_of_mass(&tilt, mass),
            None => self.own_level(&tilt),
        };
        let center = self.step(&above);
        let rows = self.balance.rows(&center) / center.mass;
        let extreme = rows.dot(multipliers);
        let shift = self.shift(multipliers);
        let directions = self.directions.iter();
        let outward = directions.map(|direction| direction.dot(&shift));
        ReachPoint {
            value: 0.5 * shift.norm_squared() + extreme,
            gradient: rows + DVector::from_iterator(self.directions.len(), outward),
            multipliers: multipliers.clone(),
            extreme,
            center,
            above,
        }
    }

    /// The moments of the density that is hi where a form is positive and lo elsewhere.
    fn step(&self, above: &AffineForm) -> Moments {
        let heavy = self.balance.above(above);
        self.balance.whole * self.range.low + heavy * (self.high() - self.range.low)
    }

    /// φ less its own value at the center of the step that it makes (Dinkelbach's iteration: the value
    /// rises to the largest).
    fn own_level(&self, tilt: &AffineForm) -> AffineForm {
        let value_of = |moments: &Moments| tilt.value + tilt.gradient.dot(&moments.center());
        let mut level = value_of(&self.balance.whole);
        for _ in 0..200 {
            let next = value_of(&self.step(&tilt.less(level)));
            if next.is_nan() || next <= level {
                break;
            }
            level = next;
        }
        tilt.less(level)
    }

    /// φ less what it exceeds where the step has a mass, by bisection.
    fn level_of_mass(&self, tilt: &AffineForm, mass: f64) -> AffineForm {
        let reach = self.balance.reach(&tilt.gradient);
        let (mut low, mut high) = (tilt.value - reach, tilt.value + reach);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let is_heavy = self.step(&tilt.less(middle)).mass > mass;
            *(if is_heavy { &mut low } else { &mut high }) = middle;
        }
        tilt.less(0.5 * (low + high))
    }

    /// The point with the best multiple of its multipliers: −E/|v|².
    fn scaled(&self, mut point: ReachPoint) -> ReachPoint {
        let shift = self.shift(&point.multipliers);
        let factor = -point.extreme / shift.norm_squared();
        if factor > 0.0 && factor.is_finite() {
            let outward = self
                .directions
                .iter()
                .map(|direction| direction.dot(&shift));
            let outward = DVector::from_iterator(self.directions.len(), outward);
            point.gradient += outward * (factor - 1.0);
            point.multipliers *= factor;
            point.extreme *= factor;
            point.value = 0.5 * (shift * factor).norm_squared() + point.extreme;
            point.above.value *= factor;
            point.above.gradient *= factor;
        }
        point
    }

    /// n_k·n_l + ∂²E: (hi − lo)/mass ∫ (φ_k − φ̄_k)(φ_l − φ̄_l) dA/|w| over the section, φ̄ at the center, or
    /// with a given mass at the section's middle.
    fn curvature(&self, at: &ReachPoint) -> DMatrix<f64> {
        let count = self.directions.len();
        let square = |k: usize, l: usize| self.directions[k].dot(&self.directions[l]);
        let squares = DMatrix::from_fn(count, count, square);
        let section = self.balance.section(&at.above);
        let slope = at.above.gradient.norm();
        if !(slope > 0.0 && section.mass > 0.0) {
            return squares;
        }
        let middle = if self.mass.is_some() {
            &section
        } else {
            &at.center
        };
        let rows = self.balance.rows(&section) / section.mass;
        let about = self.balance.rows(middle) / middle.mass;
        let difference = &rows - &about;
        // ∫(φ − φ̄)(φ − φ̄) = ∫φφ − area·(rows rowsᵀ) + area·(difference differenceᵀ).
        let centered = self.balance.products(&section) - &rows * rows.transpose() * section.mass;
        let spread = centered + &difference * difference.transpose() * section.mass;
        squares + spread * ((self.high() - self.range.low) / (at.center.mass * slope))
    }
}
