//! The dual of a least-variance density: what a solver needs of a body and of conditions on it.

use nalgebra::{DMatrix, DVector};

/// Whether a condition is R = ∫ d φ + c = 0, or R ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// R = 0; its multiplier is free.
    Equal,
    /// R ≥ 0; its multiplier is not negative.
    AtLeast,
}

/// The bounds of a density and the constant that it stays near to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DensityRange {
    /// The least density, positive.
    pub(crate) low: f64,
    /// The greatest density; may be infinite.
    pub(crate) high: f64,
    /// The preferred density d₀.
    pub(crate) prefer: f64,
}

impl DensityRange {
    /// The density within the bounds that is nearest to this one.
    pub(crate) fn clamp(&self, density: f64) -> f64 {
        density.max(self.low).min(self.high)
    }
}

/// The dual at multipliers λ, of d = clamp(d₀ + Σ λ_k φ_k, lo, hi).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DualPoint {
    /// ½∫(d − d₀)² − λ·R, to be maximized.
    pub(crate) value: f64,
    /// R_k = ∫ d φ_k + c_k: minus the value's gradient.
    pub(crate) residual: DVector<f64>,
    /// M_kl = ∫ φ_k φ_l over where lo < d < hi: minus the value's second derivatives.
    pub(crate) curvature: DMatrix<f64>,
}

/// A body (a solid, or a sum of elements each of one density) under conditions R_k = ∫ d φ_k + c_k that are
/// to vanish or not to be negative: c_k is minus a target (a mass, φ = 1), or what parts add whose density
/// does not vary.
pub(crate) trait Balance {
    /// What is asked of each R_k.
    fn relations(&self) -> &[Relation];

    /// The dual at `multipliers`; with `whole` the curvature is that of the whole body, not of the slab
    /// alone (the first step, and a slab that is empty).
    fn dual(&self, range: &DensityRange, multipliers: &DVector<f64>, whole: bool) -> DualPoint;

    /// T_k = ∫ φ_k of what may vary, at density 1.
    fn totals(&self) -> DVector<f64>;

    /// c_k.
    fn constants(&self) -> DVector<f64> {
        DVector::zeros(self.relations().len())
    }

    /// A₊(λ) = ∫ (Σ λ_k φ_k)₊ of what may vary, and its gradient ∫ φ_k over where Σ λ_k φ_k > 0.
    fn positive_part(&self, multipliers: &DVector<f64>) -> (f64, DVector<f64>);

    /// The second derivatives of A₊, where the body knows them; sums of elements have none, and may give
    /// smoothed ones.
    fn positive_curvature(&self, _multipliers: &DVector<f64>) -> Option<DMatrix<f64>> {
        None
    }
}
