//! The least-variance density under conditions: Newton's method on its dual.
//!
//! Of all densities lo ≤ d ≤ hi with R_k = ∫ d φ_k + c_k = 0 (or ≥ 0), ½∫(d − d₀)² is least for
//! d = clamp(d₀ + Σ λ_k φ_k, lo, hi). The multipliers λ (λ_k ≥ 0 for inequalities) maximize the concave dual
//! v(λ) = ½∫(d − d₀)² − λ·R, ∇v = −R, ∇²v = −M. A step goes towards the maximizer of the quadratic model
//! within the signs ([`quadratic`](crate::balance::quadratic)), halved until v rises or the residual halves.

use nalgebra::{DMatrix, DVector};

use crate::balance::dual::{Balance, DensityRange, DualPoint, Relation};
use crate::balance::quadratic::minimize_quadratic;

/// Residuals of this share of d₀ ∫|φ_k| are rounding: the goal.
const RESIDUAL_GOAL: f64 = 1e-13;

/// Where no step leads further, residuals up to this share will do.
const RESIDUAL_ENOUGH: f64 = 1e-10;

/// More steps than any case needs: 4-16 measured (`density.md` 1.3), 40 within 1e-6 of the least contrast.
const MOST_STEPS: usize = 100;

/// Halvings of a step: 2⁻³⁰ of it is none.
const MOST_HALVINGS: usize = 30;

/// Armijo's share of the rise that the slope promises.
const RISE_SHARE: f64 = 1e-4;

/// The shares of the whole body's curvature that are added to that of the slab, tried in this order.
const RIDGES: [f64; 5] = [0.0, 1e-13, 1e-9, 1e-5, 1e-1];

/// From this step on multipliers are tried as a proof that nothing meets the conditions.
const FIRST_PROOF: usize = 6;

/// Why a solution ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SolveEnd {
    /// The conditions are met up to rounding.
    Met,
    /// The multipliers prove that no density within the range meets the conditions.
    Refuted,
    /// Neither: so near to the least contrast that rounding decides.
    Undecided,
}

/// A step of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SolveStep {
    /// Steps taken before.
    pub(crate) iteration: usize,
    /// The largest residual, as a share of d₀ ∫|φ_k|.
    pub(crate) residual: f64,
    /// The dual's value.
    pub(crate) value: f64,
}

/// A least-variance density, or why there is none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeastVariance {
    /// λ of clamp(d₀ + Σ λ_k φ_k, lo, hi); where refuted, the proof.
    pub(crate) multipliers: DVector<f64>,
    /// R_k.
    pub(crate) residual: DVector<f64>,
    /// Why it ended.
    pub(crate) end: SolveEnd,
    /// Evaluations of the dual, and of proofs.
    pub(crate) evaluations: usize,
    /// One line for each iterate: one more than iterations.
    pub(crate) log: Vec<SolveStep>,
}

impl LeastVariance {
    /// Newton steps taken.
    pub(crate) fn iterations(&self) -> usize {
        self.log.last().map_or(0, |step| step.iteration)
    }
}

/// Finds the least-variance density in `range` that meets the conditions of `balance`.
pub(crate) fn least_variance(balance: &impl Balance, range: &DensityRange) -> LeastVariance {
    let mut newton = DualNewton::new(balance, range);
    let mut end = SolveEnd::Undecided;
    for iteration in 0..=MOST_STEPS {
        let residual = newton.residual_at(&newton.multipliers, &newton.point);
        newton.log.push(SolveStep {
            iteration,
            residual,
            value: newton.point.value,
        });
        if residual <= RESIDUAL_GOAL {
            end = SolveEnd::Met;
            break;
        }
        if iteration >= FIRST_PROOF && residual > RESIDUAL_ENOUGH && newton.is_refuted() {
            end = SolveEnd::Refuted;
            break;
        }
        if iteration == MOST_STEPS || !newton.step(residual) {
            if residual <= RESIDUAL_ENOUGH {
                end = SolveEnd::Met;
            }
            break;
        }
    }
    LeastVariance {
        multipliers: newton.multipliers,
        residual: newton.point.residual,
        end,
        evaluations: newton.evaluations,
        log: newton.log,
    }
}

/// hi A₊(λ) − lo A₋(λ) + λ·c, the most that λ·R can be within the range, and the size of its terms: if it
/// is negative then nothing meets the conditions.
pub(crate) fn greatest_product(
    balance: &impl Balance,
    range: &DensityRange,
    multipliers: &DVector<f64>,
) -> (f64, f64) {
    let (above, _) = balance.positive_part(multipliers);
    let below = above - multipliers.dot(&balance.totals());
    let constant = multipliers.dot(&balance.constants());
    let heavy = if above > 0.0 { range.high * above } else { 0.0 };
    let light = range.low * below;
    (heavy - light + constant, heavy + light + constant.abs())
}

/// ∫|φ_k| of what may vary.
pub(crate) fn sizes(balance: &impl Balance) -> DVector<f64> {
    let count = balance.relations().len();
    DVector::from_fn(count, |k, _| {
        let mut only = DVector::zeros(count);
        only[k] = 1.0;
        let (above, _) = balance.positive_part(&only);
        2.0 * above - balance.totals()[k]
    })
}

/// An iterate of Newton's method on the dual.
struct DualNewton<'a, B: Balance> {
    balance: &'a B,
    range: &'a DensityRange,
    /// What residuals are measured by.
    scale: DVector<f64>,
    /// The whole body's curvature.
    whole: DMatrix<f64>,
    multipliers: DVector<f64>,
    point: DualPoint,
    evaluations: usize,
    log: Vec<SolveStep>,
}

impl<'a, B: Balance> DualNewton<'a, B> {
    fn new(balance: &'a B, range: &'a DensityRange) -> Self {
        let multipliers = DVector::zeros(balance.relations().len());
        let point = balance.dual(range, &multipliers, true);
        let constants = balance.constants();
        let scale = sizes(balance) * range.prefer.max(range.low) + constants.abs();
        Self {
            balance,
            range,
            scale: scale.map(|size| if size > 0.0 { size } else { 1.0 }),
            whole: point.curvature.clone(),
            multipliers,
            point,
            evaluations: 1,
            log: Vec::new(),
        }
    }

    /// The largest share by which a condition, or the complementarity of an inequality, is missed.
    fn residual_at(&self, multipliers: &DVector<f64>, point: &DualPoint) -> f64 {
        let missed = |k: usize| match self.balance.relations()[k] {
            Relation::AtLeast if multipliers[k] <= 0.0 => (-point.residual[k]).max(0.0),
            _ => point.residual[k].abs(),
        };
        let shares = (0..multipliers.len()).map(|k| missed(k) / self.scale[k]);
        shares.fold(0.0, f64::max)
    }

    /// Whether the multipliers, or the way from the start of the last step, prove that nothing does it.
    fn is_refuted(&mut self) -> bool {
        self.evaluations += 1;
        let (most, size) = greatest_product(self.balance, self.range, &self.multipliers);
        most < -1e-13 * size
    }

    /// One accepted step; `false` if there is none.
    fn step(&mut self, residual: f64) -> bool {
        for ridge in RIDGES {
            let goal = self.model_maximizer(ridge);
            if self.search(&goal, residual) {
                return true;
            }
            if residual <= RESIDUAL_ENOUGH {
                return false;
            }
        }
        false
    }

    /// The maximizer of the quadratic model, the slab's curvature with a share of the whole body's.
    fn model_maximizer(&self, ridge: f64) -> DVector<f64> {
        let matrix = &self.point.curvature + &self.whole * ridge;
        let linear = &self.point.residual - &matrix * &self.multipliers;
        minimize_quadratic(&matrix, &linear, self.balance.relations())
    }

    /// Goes towards `goal`, halving the way until the dual rises or the residual halves.
    fn search(&mut self, goal: &DVector<f64>, residual: f64) -> bool {
        let way = goal - &self.multipliers;
        let slope = -self.point.residual.dot(&way);
        let mut share = 1.0;
        for _ in 0..MOST_HALVINGS {
            let trial = &self.multipliers + &way * share;
            let point = self.balance.dual(self.range, &trial, false);
            self.evaluations += 1;
            let rises = slope > 0.0 && point.value >= self.point.value + RISE_SHARE * share * slope;
            let at_trial = self.residual_at(&trial, &point);
            if (rises && trial != self.multipliers) || at_trial <= 0.5 * residual {
                self.multipliers = trial;
                self.point = point;
                return true;
            }
            if residual <= RESIDUAL_ENOUGH {
                return false;
            }
            share *= 0.5;
        }
        false
    }
}
