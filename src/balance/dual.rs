//! The dual of a least-variance density: what a solver needs of a body and of conditions on it.

use nalgebra::{DMatrix, DVector};

/// Whether a condition is ∫ d φ = 0, or ∫ d φ ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    /// ∫ d φ = 0; its multiplier is free.
    Equal,
    /// ∫ d φ ≥ 0; its multiplier is not negative.
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

/// The dual at multipliers λ, of d = clamp(d₀ + Σ λ_k φ_k, lo, hi).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DualPoint {
    /// The dual's value, to be maximized.
    pub(crate) value: f64,
    /// R_k = ∫ d φ_k: minus the value's gradient.
    pub(crate) residual: DVector<f64>,
    /// M_kl = ∫ φ_k φ_l over where lo < d < hi: minus the value's second derivatives.
    pub(crate) curvature: DMatrix<f64>,
}

/// A body (a solid, or a sum of elements each of one density) under conditions φ_k.
pub(crate) trait Balance {
    /// What is asked of each ∫ d φ_k.
    fn relations(&self) -> &[Relation];

    /// The dual at `multipliers`; with `whole` the curvature is that of the whole body, not of the slab
    /// alone (the first step, and a slab that is empty).
    fn dual(&self, range: &DensityRange, multipliers: &DVector<f64>, whole: bool) -> DualPoint;

    /// ∫ φ_k for the density 1, and for what does not vary at its own density.
    fn totals(&self) -> DVector<f64>;

    /// A₊(λ) = ∫ (Σ λ_k φ_k)₊ of what may vary, and its gradient ∫ φ_k over where Σ λ_k φ_k > 0.
    fn positive_part(&self, multipliers: &DVector<f64>) -> (f64, DVector<f64>);
}
