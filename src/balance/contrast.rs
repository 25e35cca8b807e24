//! The least range of densities that any density needs to meet conditions, and the proof of it.
//!
//! Within lo ≤ d ≤ hi the most that Σ λ_k R_k can be is hi A₊(λ) − lo A₋(λ) + λ·c, reached by the two densities
//! that the surface Σ λ_k φ_k = 0 parts. By minimax some density meets the conditions R_k = ∫ d φ_k + c_k = 0
//! (or ≥ 0) if and only if this is not negative for any λ (λ_k ≥ 0 for inequalities). Let the range grow as
//! lo = m − e s, hi = m + f s. With A₋ = A₊ − λ·T, Q = (e + f) A₊ − e λ·T and b = m T + c that reads
//! s Q(λ) + b·λ ≥ 0, so
//!
//! ```text
//! least s = sup −b·λ / Q(λ),       (½ Q² + b·λ) → min,   there s = Q
//! ```
//!
//! Q is convex and homogeneous, so the second form is convex and needs no scale of λ. Every λ bounds s from
//! below; the minimizer proves that the range cannot be smaller.

use nalgebra::{DMatrix, DVector};

use crate::balance::dual::{Balance, DensityRange, Relation};
use crate::balance::quadratic::minimize_quadratic;
use crate::balance::solve::sizes;

/// How a range grows with s: from `middle − down s` to `middle + up s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RangeGrowth {
    /// Where it begins.
    pub(crate) middle: f64,
    /// How its lower end falls.
    pub(crate) down: f64,
    /// How its upper end rises.
    pub(crate) up: f64,
}

/// The least growth that suffices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeastGrowth {
    /// s: zero where the constant density `middle` meets the conditions, infinite where no range does.
    pub(crate) growth: f64,
    /// λ that refutes every smaller growth; zero where s is zero.
    pub(crate) multipliers: DVector<f64>,
    /// Steps taken.
    pub(crate) iterations: usize,
    /// Evaluations of A₊.
    pub(crate) evaluations: usize,
}

/// Growths above this multiple of `middle`/`up` are taken for infinite: A₊ is a rounding error of ∫|φ_λ|.
const INFINITE: f64 = 1e14;

/// More steps than are needed where curvatures are known (4-20), and enough for the others.
const MOST_STEPS: usize = 400;

/// Trials of one step.
const MOST_TRIALS: usize = 60;

/// Armijo's and Wolfe's shares of the slope.
const FALL_SHARE: f64 = 1e-4;
const SLOPE_SHARE: f64 = 0.9;

/// Gradients of this share of their terms are rounding.
const GRADIENT_GOAL: f64 = 1e-15;

/// The least contrast hi/lo with which some density meets conditions without constants, κ* = 1 + growth.
pub(crate) fn least_contrast(balance: &impl Balance) -> LeastGrowth {
    least_growth(
        balance,
        &RangeGrowth {
            middle: 1.0,
            down: 0.0,
            up: 1.0,
        },
    )
}

/// Whether some density within the range meets the conditions up to a share `rounding` of the range's
/// width, and the multipliers that refute it otherwise.
pub(crate) fn refute(
    balance: &impl Balance,
    range: &DensityRange,
    rounding: f64,
) -> Option<DVector<f64>> {
    let growth = RangeGrowth {
        middle: range.low,
        down: 0.0,
        up: 1.0,
    };
    let least = least_growth(balance, &growth);
    let width = range.high - range.low;
    let suffices = if width.is_finite() {
        least.growth <= width + rounding * range.high
    } else {
        least.growth.is_finite()
    };
    (!suffices).then_some(least.multipliers)
}

/// The least growth of the range with which some density meets the conditions.
pub(crate) fn least_growth(balance: &impl Balance, growth: &RangeGrowth) -> LeastGrowth {
    let mut descent = Descent::new(balance, growth);
    let mut iterations = 0;
    while iterations < MOST_STEPS && !descent.is_done() && descent.step() {
        iterations += 1;
    }
    LeastGrowth {
        growth: descent.growth(),
        multipliers: descent.at.multipliers,
        iterations,
        evaluations: descent.evaluations,
    }
}

/// ½ Q² + b·λ at a point, after the best scaling of λ.
#[derive(Clone, Debug)]
struct GrowthPoint {
    multipliers: DVector<f64>,
    value: f64,
    gradient: DVector<f64>,
    /// Q and its gradient.
    spread: f64,
    spread_gradient: DVector<f64>,
}

/// A minimization of ½ Q² + b·λ.
struct Descent<'a, B: Balance> {
    balance: &'a B,
    growth: &'a RangeGrowth,
    totals: DVector<f64>,
    /// b.
    linear: DVector<f64>,
    /// ∫|φ_k|.
    sizes: DVector<f64>,
    at: GrowthPoint,
    /// Where the body gives no curvature: that of BFGS.
    model: Option<DMatrix<f64>>,
    evaluations: usize,
}

impl<'a, B: Balance> Descent<'a, B> {
    fn new(balance: &'a B, growth: &'a RangeGrowth) -> Self {
        let totals = balance.totals();
        let linear = &totals * growth.middle + balance.constants();
        let count = linear.len();
        let range = DensityRange {
            low: 1.0,
            high: 1.0,
            prefer: 1.0,
        };
        let whole = balance.dual(&range, &DVector::zeros(count), true).curvature;
        let start = minimize_quadratic(&whole, &linear, balance.relations());
        let knows_curvature = balance.positive_curvature(&start).is_some();
        let mut descent = Self {
            balance,
            growth,
            totals,
            linear,
            sizes: sizes(balance),
            at: GrowthPoint {
                multipliers: DVector::zeros(count),
                value: 0.0,
                gradient: DVector::zeros(count),
                spread: 0.0,
                spread_gradient: DVector::zeros(count),
            },
            model: None,
            evaluations: 0,
        };
        descent.at = descent.evaluate(&start);
        descent.at = descent.scaled(descent.at.clone());
        descent.model = (!knows_curvature).then(|| descent.first_model(&whole));
        descent
    }

    /// The curvature of ½ Q² as if A₊ were half the root mean square of φ_λ.
    fn first_model(&self, whole: &DMatrix<f64>) -> DMatrix<f64> {
        let product = (whole * &self.at.multipliers).dot(&self.at.multipliers);
        let factor = self.at.spread.powi(2) / product;
        whole * if factor.is_finite() { factor } else { 1.0 }
    }

    /// −b·λ / Q(λ).
    fn growth(&self) -> f64 {
        let along = -self.linear.dot(&self.at.multipliers);
        let up = self.growth.up + self.growth.down;
        if along <= 0.0 {
            0.0
        } else if along * up > INFINITE * self.at.spread * self.growth.middle.max(0.0) {
            f64::INFINITY
        } else {
            along / self.at.spread
        }
    }

    /// Whether the growth is known: infinite, zero, or the gradient is rounding.
    fn is_done(&self) -> bool {
        let is_rounding = |k: usize| {
            let size = self.at.spread * self.sizes[k] + self.linear[k].abs();
            let slope = match self.balance.relations()[k] {
                Relation::AtLeast if self.at.multipliers[k] <= 0.0 => -self.at.gradient[k],
                _ => self.at.gradient[k].abs(),
            };
            slope <= GRADIENT_GOAL * size
        };
        !self.growth().is_finite() || (0..self.linear.len()).all(is_rounding)
    }

    fn evaluate(&mut self, multipliers: &DVector<f64>) -> GrowthPoint {
        self.evaluations += 1;
        let (above, of_above) = self.balance.positive_part(multipliers);
        let RangeGrowth { down, up, .. } = *self.growth;
        let spread = ((up + down) * above - down * self.totals.dot(multipliers)).max(0.0);
        let spread_gradient = of_above * (up + down) - &self.totals * down;
        GrowthPoint {
            value: 0.5 * spread * spread + self.linear.dot(multipliers),
            gradient: &spread_gradient * spread + &self.linear,
            multipliers: multipliers.clone(),
            spread,
            spread_gradient,
        }
    }

    /// The point with the best multiple of its multipliers: t = −b·λ / Q².
    fn scaled(&self, mut point: GrowthPoint) -> GrowthPoint {
        let along = -self.linear.dot(&point.multipliers);
        let factor = along / point.spread.powi(2);
        if along > 0.0 && factor.is_finite() {
            point.multipliers *= factor;
            point.spread *= factor;
            point.value = 0.5 * point.spread * point.spread - along * factor;
            point.gradient = &point.spread_gradient * point.spread + &self.linear;
        }
        point
    }

    /// One step of Newton, or of BFGS; `false` if nothing falls any more.
    fn step(&mut self) -> bool {
        let mut ridge = 0.0;
        while ridge < 1e3 {
            let matrix = self.curvature(ridge);
            let linear = &self.at.gradient - &matrix * &self.at.multipliers;
            let goal = minimize_quadratic(&matrix, &linear, self.balance.relations());
            let way = goal - &self.at.multipliers;
            if let Some(next) = self.search(&way) {
                self.accept(next);
                return true;
            }
            ridge = if ridge > 0.0 { ridge * 1e3 } else { 1e-9 };
        }
        false
    }

    /// Second derivatives of ½ Q², with a share of their diagonal added.
    fn curvature(&self, ridge: f64) -> DMatrix<f64> {
        let mut matrix = self.model.clone().unwrap_or_else(|| {
            let of_above = self.balance.positive_curvature(&self.at.multipliers);
            let factor = self.at.spread * (self.growth.up + self.growth.down);
            let outer = &self.at.spread_gradient * self.at.spread_gradient.transpose();
            of_above.map_or(outer.clone(), |curvature| curvature * factor + outer)
        });
        for k in 0..self.linear.len() {
            matrix[(k, k)] += ridge * self.sizes[k].powi(2).max(matrix[(k, k)]);
        }
        matrix
    }

    /// A point along `way` that meets Armijo's condition, and without curvatures Wolfe's too, by bisection
    /// (Lewis & Overton, *Nonsmooth optimization via quasi-Newton methods*, 2013).
    fn search(&mut self, way: &DVector<f64>) -> Option<GrowthPoint> {
        let slope = self.at.gradient.dot(way);
        if slope.is_nan() || slope >= 0.0 {
            return None;
        }
        let (mut low, mut high, mut share) = (0.0, f64::INFINITY, 1.0);
        let longest = self.longest(way);
        let mut best: Option<GrowthPoint> = None;
        for _ in 0..MOST_TRIALS {
            let trial = self.evaluate(&(&self.at.multipliers + way * share));
            if trial.value > self.at.value + FALL_SHARE * share * slope {
                high = share;
            } else {
                let is_steep = trial.gradient.dot(way) < SLOPE_SHARE * slope;
                best = Some(trial);
                if self.model.is_none() || !is_steep || share >= longest {
                    break;
                }
                low = share;
            }
            share = if high.is_finite() {
                0.5 * (low + high)
            } else {
                2.0 * low
            };
            share = share.min(longest);
            if high - low < 1e-14 {
                break;
            }
        }
        best.filter(|point| point.value < self.at.value)
    }

    /// The longest share of a way on which no inequality's multiplier turns negative.
    fn longest(&self, way: &DVector<f64>) -> f64 {
        let bound = |k: usize| match self.balance.relations()[k] {
            Relation::AtLeast if way[k] < 0.0 => -self.at.multipliers[k] / way[k],
            _ => f64::INFINITY,
        };
        (0..way.len())
            .map(bound)
            .fold(f64::INFINITY, f64::min)
            .max(1.0)
    }

    /// Takes a point, after the best scaling, and learns from the step to it where curvatures are learnt.
    fn accept(&mut self, next: GrowthPoint) {
        if let Some(model) = &mut self.model {
            let way = &next.multipliers - &self.at.multipliers;
            let change = &next.gradient - &self.at.gradient;
            let curved = change.dot(&way);
            let along = &*model * &way;
            let known = along.dot(&way);
            if curved > 1e-12 * known && known > 0.0 {
                *model +=
                    &change * change.transpose() / curved - &along * along.transpose() / known;
            }
        }
        self.at = self.scaled(next);
    }
}
