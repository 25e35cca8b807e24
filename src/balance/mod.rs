//! Densities fitted to conditions on a body's balance (\[BL\] section 3.2, 3.3): the least-variance
//! density within bounds, the least contrast that any density needs, and a proof where none exists.
//!
//! A condition is affine in the density d: R = ∫ d φ + c is to vanish or not to be negative. Of all
//! densities lo ≤ d ≤ hi that meet conditions φ_k, the one nearest to a constant d₀ is
//! clamp(d₀ + Σ λ_k φ_k, lo, hi), whose multipliers λ maximize a concave dual of as many variables as there
//! are conditions. [`dual`] says what a solver needs of a body for that, [`solve`] finds the multipliers,
//! [`contrast`] the least range of densities that suffices, with the proof; [`quadratic`] is a step of both.

pub(crate) mod bases;
pub(crate) mod conditions;
pub(crate) mod contrast;
pub(crate) mod dual;
pub(crate) mod elements;
pub(crate) mod quadratic;
pub(crate) mod solve;
pub(crate) mod spin;
pub(crate) mod support;
