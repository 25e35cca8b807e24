//! The compact form of the limited-memory BFGS matrix.
//!
//! \[B\] Byrd, Lu, Nocedal & Zhu, *A limited memory algorithm for bound constrained
//! optimization*, SIAM J. Sci. Comput. 16, 1995, section 3:
//!
//! ```text
//! B = θ I − W M Wᵀ,   W = [Y  θS],   M = K⁻¹,   K = [ −D   Lᵀ   ]      (eq. 3.2 – 3.6)
//!                                                  [  L   θ SᵀS ]
//! D = diag(s_i·y_i),  L = strictly lower part of SᵀY,  θ = y·y / s·y of the last pair
//! ```
//!
//! With `k` pairs, `K` is `2k × 2k` and indefinite. The pairs' lengths differ by many orders
//! near a minimum, so `K` is scaled to a diagonal of ±1 before it is factored: that changes
//! neither `B` nor the paper's formulas.

use nalgebra::{DMatrix, DVector, Dyn, LU};

use crate::minimize::blas1::{add_scaled, dot};
use crate::minimize::history::{History, Products};

/// The matrix `B` of a history.
#[derive(Debug)]
pub(crate) struct CompactBfgs<'a> {
    history: &'a History,
    /// `θ`.
    pub(crate) theta: f64,
    /// `K`.
    pub(crate) inverse_middle: DMatrix<f64>,
    scales: DVector<f64>,
    factor: LU<f64, Dyn, Dyn>,
}

impl<'a> CompactBfgs<'a> {
    /// The matrix of a history, or `theta_at_start · I` if that is empty.
    pub(crate) fn new(history: &'a History, theta_at_start: f64) -> Self {
        let products = history.products();
        let theta = match products.mixed.len() {
            0 => theta_at_start,
            count => products.changes[count - 1][count - 1] / products.mixed[count - 1][count - 1],
        };
        let inverse_middle = inverse_middle(products, theta);
        let scales = inverse_middle
            .diagonal()
            .map(|entry| 1.0 / entry.abs().sqrt());
        Self {
            history,
            theta,
            factor: scaled(&inverse_middle, &scales).lu(),
            inverse_middle,
            scales,
        }
    }

    /// The dot products of the pairs.
    pub(crate) fn products(&self) -> &'a Products {
        self.history.products()
    }

    /// `2k`, the number of columns of `W`.
    pub(crate) fn width(&self) -> usize {
        2 * self.history.len()
    }

    /// `M v`; `None` if `K` is singular.
    pub(crate) fn middle_times(&self, vector: &DVector<f64>) -> Option<DVector<f64>> {
        if vector.is_empty() {
            return Some(vector.clone());
        }
        let solved = self.factor.solve(&vector.component_mul(&self.scales))?;
        Some(solved.component_mul(&self.scales))
    }

    /// `matrix⁻¹ v` for a matrix that scales as `K` does; `None` if it is singular.
    pub(crate) fn solve_like_middle(
        &self,
        matrix: &DMatrix<f64>,
        vector: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        if vector.is_empty() {
            return Some(vector.clone());
        }
        let factor = scaled(matrix, &self.scales).lu();
        let solved = factor.solve(&vector.component_mul(&self.scales))?;
        Some(solved.component_mul(&self.scales))
    }

    /// Row `variable` of `W`.
    pub(crate) fn row(&self, variable: usize) -> DVector<f64> {
        let mut row = DVector::zeros(self.width());
        self.copy_row(variable, &mut row);
        row
    }

    /// Copies row `variable` of `W`.
    pub(crate) fn copy_row(&self, variable: usize, row: &mut DVector<f64>) {
        let changes = self.history.changes().iter().map(|y| y[variable]);
        let steps = self.history.steps().iter();
        let steps = steps.map(|s| self.theta * s[variable]);
        for (target, entry) in row.iter_mut().zip(changes.chain(steps)) {
            *target = entry;
        }
    }

    /// `Wᵀ v`.
    pub(crate) fn transposed_times(&self, vector: &[f64]) -> DVector<f64> {
        let changes = self.history.changes().iter().map(|y| dot(y, vector));
        let steps = self
            .history
            .steps()
            .iter()
            .map(|s| self.theta * dot(s, vector));
        DVector::from_iterator(self.width(), changes.chain(steps))
    }

    /// `target += factor · W c`.
    pub(crate) fn add_times(&self, target: &mut [f64], factor: f64, c: &DVector<f64>) {
        let count = self.history.len();
        for (index, change) in self.history.changes().iter().enumerate() {
            add_scaled(target, factor * c[index], change);
        }
        for (index, step) in self.history.steps().iter().enumerate() {
            add_scaled(target, factor * self.theta * c[count + index], step);
        }
    }
}

/// `K` (eq. 3.4).
fn inverse_middle(products: &Products, theta: f64) -> DMatrix<f64> {
    let count = products.mixed.len();
    DMatrix::from_fn(2 * count, 2 * count, |row, column| {
        let lower = |i: usize, j: usize| if i > j { products.mixed[i][j] } else { 0.0 };
        match (row < count, column < count) {
            (true, true) if row == column => -products.mixed[row][row],
            (true, true) => 0.0,
            (true, false) => lower(column - count, row),
            (false, true) => lower(row - count, column),
            (false, false) => theta * products.steps[row - count][column - count],
        }
    })
}

/// The matrix with row and column `i` multiplied by `scales[i]`.
fn scaled(matrix: &DMatrix<f64>, scales: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        matrix[(row, column)] * scales[row] * scales[column]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// BFGS applied pair by pair to `θ I` (Nocedal & Wright, eq. 6.19), the definition.
    fn by_definition(history: &History, theta: f64, size: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::identity(size, size) * theta;
        for (s, y) in history.steps().iter().zip(history.changes()) {
            let (s, y) = (DVector::from_column_slice(s), DVector::from_column_slice(y));
            let image = &matrix * &s;
            matrix = &matrix - &image * image.transpose() / s.dot(&image)
                + &y * y.transpose() / y.dot(&s);
        }
        matrix
    }

    #[test]
    fn the_compact_form_is_bfgs() {
        let curvatures = [1.0, 3.0, 0.5, 2.0];
        let mut history = History::default();
        for pair in 0..5 {
            let step: Vec<f64> = (0..4)
                .map(|k| f64::from((7 * pair + 3 * k) % 11) - 5.0)
                .map(|x| x * 0.1_f64.powi(pair))
                .collect();
            let change = step.iter().zip(curvatures).map(|(s, c)| s * c).collect();
            assert!(history.push(step, change, 3));
        }
        let read = History::from_parts(history.steps().to_vec(), history.changes().to_vec());
        assert_eq!(read, history);
        let compact = CompactBfgs::new(&history, 1.0);
        let expected = by_definition(&history, compact.theta, 4);
        for axis in 0..4 {
            let mut unit = vec![0.0; 4];
            unit[axis] = 1.0;
            let c = compact
                .middle_times(&compact.transposed_times(&unit))
                .unwrap();
            let mut column: Vec<f64> = unit.iter().map(|x| compact.theta * x).collect();
            compact.add_times(&mut column, -1.0, &c);
            for (row, entry) in column.iter().enumerate() {
                assert!((entry - expected[(row, axis)]).abs() < 1e-10);
            }
        }
    }
}
