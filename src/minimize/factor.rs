//! The factors L D Lᵀ of a small symmetric matrix.
//!
//! Cholesky's factorization without its roots (Golub & Van Loan, *Matrix Computations*, 4th ed.,
//! section 4.1.2): one quotient per variable, which is what a cell's Newton step waits for.

use nalgebra::{SMatrix, SVector};

/// L, of unit diagonal, and the inverse of D.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const D: usize> {
    lower: [[f64; D]; D],
    inverse: [f64; D],
}

impl<const D: usize> Factor<D> {
    /// Factorizes the lower triangle of `matrix`; none if that is not positive definite.
    pub(crate) fn of(matrix: &SMatrix<f64, D, D>) -> Option<Self> {
        let mut factor = Self {
            lower: [[0.0; D]; D],
            inverse: [0.0; D],
        };
        let mut diagonal = [0.0; D];
        for column in 0..D {
            let scaled: [f64; D] = std::array::from_fn(|k| factor.lower[column][k] * diagonal[k]);
            let rest = |row: &[f64; D], row_number: usize| {
                let known = (0..column).map(|k| row[k] * scaled[k]);
                matrix[(row_number, column)] - known.sum::<f64>()
            };
            let pivot = rest(&factor.lower[column], column);
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            diagonal[column] = pivot;
            factor.inverse[column] = 1.0 / pivot;
            for row in column + 1..D {
                factor.lower[row][column] = rest(&factor.lower[row], row) * factor.inverse[column];
            }
        }
        Some(factor)
    }

    /// The x for which the matrix times x is `right`.
    pub(crate) fn solve(&self, right: &SVector<f64, D>) -> SVector<f64, D> {
        let mut solution = *right;
        for row in 0..D {
            for k in 0..row {
                solution[row] -= self.lower[row][k] * solution[k];
            }
        }
        for row in (0..D).rev() {
            solution[row] *= self.inverse[row];
            for k in row + 1..D {
                solution[row] -= self.lower[k][row] * solution[k];
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_and_indefinite_matrices_have_no_factors() {
        let matrix = SMatrix::<f64, 3, 3>::new(4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 5.0);
        let right = SVector::<f64, 3>::new(1.0, -2.0, 3.0);
        let factor = Factor::of(&matrix).expect("it is positive definite");
        assert!((matrix * factor.solve(&right) - right).norm() < 1e-14);
        assert!(Factor::of(&(matrix - SMatrix::identity() * 2.5)).is_none());
        assert!(Factor::of(&(matrix * f64::NAN)).is_none());
        assert!(Factor::<3>::of(&SMatrix::zeros()).is_none());
    }
}
