//! The step beyond the generalized Cauchy point, over the variables that are free there.
//!
//! \[B\] (see `compact_bfgs`), section 5.1, the direct primal method: minimize the model over the free
//! variables as if they had no bounds, by the Sherman-Morrison-Woodbury formula (eq. 5.11), then
//! return to the box. The return is by projection (Morales & Nocedal, ACM TOMS 38, 2011, section
//! 3) and by the paper's truncation (eq. 5.8) where projection does not lead downhill.
//!
//! Departure: with `(I − M N)⁻¹ M = (K − N)⁻¹` one factorization of `K − N` replaces a product and
//! two. `N = WᵀZZᵀW/θ` follows from the products of whole pairs less the few held variables,
//! which costs O(held · memory²) instead of O(free · memory²).

use nalgebra::{DMatrix, DVector};

use crate::minimize::cauchy::{BoxedPoint, CauchyPoint};
use crate::minimize::compact_bfgs::CompactBfgs;
use crate::minimize::history::Products;
use crate::minimize::variable_bounds::facing;

/// Subtraction is used below this share of held variables; above it summing the free ones
/// costs about as much.
const FEW_HELD: f64 = 0.25;
/// Subtraction is not trusted where it leaves less than this share of a diagonal entry.
const CANCELLATION: f64 = 1e-4;

/// The minimizer of the model over the free variables, returned to the box; `None` if the
/// model is singular.
pub(crate) fn subspace_minimizer(
    place: &BoxedPoint,
    model: &CompactBfgs,
    cauchy: CauchyPoint,
) -> Option<Vec<f64>> {
    let bounded = || cauchy.point.iter().zip(place.bounds.iter());
    let free: Vec<bool> = bounded()
        .map(|(x, (lower, upper))| lower < *x && *x < upper)
        .collect();
    let step = free_step(place, model, &cauchy, &free)?;
    let projected: Vec<f64> = bounded()
        .zip(&step)
        .map(|((x, (lower, upper)), step)| (x + step).max(lower).min(upper))
        .collect();
    let slope: f64 = (0..free.len())
        .map(|i| (projected[i] - place.point[i]) * place.gradient[i])
        .sum();
    if slope < 0.0 {
        Some(projected)
    } else {
        Some(truncated(place, cauchy.point, &step))
    }
}

/// `d̂` (eq. 5.11), zero for held variables.
fn free_step(
    place: &BoxedPoint,
    model: &CompactBfgs,
    cauchy: &CauchyPoint,
    free: &[bool],
) -> Option<Vec<f64>> {
    let theta = model.theta;
    let mut residual: Vec<f64> = (0..free.len())
        .map(|i| place.gradient[i] + theta * (cauchy.point[i] - place.point[i]))
        .collect();
    let compressed = model.middle_times(&cauchy.compressed)?;
    model.add_times(&mut residual, -1.0, &compressed);
    restrict(&mut residual, free);
    let matrix = &model.inverse_middle - free_products(model, free) / theta;
    let solved = model.solve_like_middle(&matrix, &model.transposed_times(&residual))?;
    let mut step: Vec<f64> = residual.iter().map(|r| -r / theta).collect();
    model.add_times(&mut step, -1.0 / (theta * theta), &solved);
    restrict(&mut step, free);
    Some(step)
}

/// Zeroes the entries of held variables.
fn restrict(vector: &mut [f64], free: &[bool]) {
    for (entry, _) in vector.iter_mut().zip(free).filter(|(_, free)| !**free) {
        *entry = 0.0;
    }
}

/// `WᵀZZᵀW`.
fn free_products(model: &CompactBfgs, free: &[bool]) -> DMatrix<f64> {
    let all = all_products(model.products(), model.theta);
    let held = free.iter().filter(|free| !**free).count();
    if held == 0 || all.is_empty() {
        return all;
    }
    if (held as f64) < FEW_HELD * free.len() as f64 {
        let rest = &all - sum_of_rows(model, free, false);
        if (0..all.nrows()).all(|i| rest[(i, i)] >= CANCELLATION * all[(i, i)]) {
            return rest;
        }
    }
    sum_of_rows(model, free, true)
}

/// `WᵀW` from the products of the pairs.
fn all_products(products: &Products, theta: f64) -> DMatrix<f64> {
    let count = products.mixed.len();
    DMatrix::from_fn(2 * count, 2 * count, |row, column| {
        match (row < count, column < count) {
            (true, true) => products.changes[row][column],
            (true, false) => theta * products.mixed[column - count][row],
            (false, true) => theta * products.mixed[row - count][column],
            (false, false) => theta * theta * products.steps[row - count][column - count],
        }
    })
}

/// `Σ w wᵀ` over the rows of `W` of the free variables, or of the held ones.
fn sum_of_rows(model: &CompactBfgs, free: &[bool], of_free: bool) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(model.width(), model.width());
    let mut row = DVector::zeros(model.width());
    for (variable, _) in (0..).zip(free).filter(|(_, free)| **free == of_free) {
        model.copy_row(variable, &mut row);
        sum.ger(1.0, &row, &row, 1.0);
    }
    sum
}

/// `xᶜ + α d̂` with the largest `α ≤ 1` in the box (eq. 5.8).
fn truncated(place: &BoxedPoint, mut point: Vec<f64>, step: &[f64]) -> Vec<f64> {
    let mut fraction = 1.0_f64;
    for ((x, &d), bounds) in point.iter().zip(step).zip(place.bounds.iter()) {
        if d != 0.0 {
            fraction = fraction.min((facing(bounds, d) - x) / d);
        }
    }
    for ((x, d), (lower, upper)) in point.iter_mut().zip(step).zip(place.bounds.iter()) {
        *x = (*x + fraction * d).max(lower).min(upper);
    }
    point
}
