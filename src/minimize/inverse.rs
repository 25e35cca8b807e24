//! The inverse of a small symmetric positive definite matrix.
//!
//! By its cofactors where three variables allow it: they do not wait for each other and take one
//! quotient, which a cell's Newton step waits for. A matrix too flat for that is taken apart into
//! factors L D Lᵀ, Cholesky's without its roots (Golub & Van Loan, *Matrix Computations*, 4th ed.,
//! section 4.1.2).

use nalgebra::{SMatrix, SVector};

/// The least determinant of three variables by cofactors, relative to the product of the diagonal:
/// half of the digits are left then.
const FLATTEST: f64 = 1e-8;

/// A matrix's inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inverse<const D: usize>(SMatrix<f64, D, D>);

impl<const D: usize> Inverse<D> {
    /// Inverts `matrix`, of which the lower triangle is read; none if that is not positive definite.
    pub(crate) fn of(matrix: &SMatrix<f64, D, D>) -> Option<Self> {
        by_cofactors(matrix)
            .or_else(|| by_factors(matrix))
            .map(Self)
    }

    /// The x for which the matrix times x is `right`.
    pub(crate) fn solve(&self, right: &SVector<f64, D>) -> SVector<f64, D> {
        self.0 * right
    }
}

/// The inverse of a matrix in three variables that is not too flat.
fn by_cofactors<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    if D != 3 {
        return None;
    }
    let [a, b, c] = [0, 1, 2].map(|k| matrix[(k, k)]);
    let [ab, ac, bc] = [(1, 0), (2, 0), (2, 1)].map(|place| matrix[place]);
    let rows = [
        [b * c - bc * bc, ac * bc - ab * c, ab * bc - ac * b],
        [ac * bc - ab * c, a * c - ac * ac, ab * ac - a * bc],
        [ab * bc - ac * b, ab * ac - a * bc, a * b - ab * ab],
    ];
    let determinant = a * rows[0][0] + ab * rows[0][1] + ac * rows[0][2];
    let is_definite = (a > 0.0) & (rows[2][2] > 0.0) & (determinant > FLATTEST * (a * b * c));
    let scale = 1.0 / determinant;
    let inverse = SMatrix::from_fn(|row, column| rows[row % 3][column % 3] * scale);
    (is_definite && scale.is_finite()).then_some(inverse)
}

/// The inverse by the factors L, of unit diagonal, and D.
fn by_factors<const D: usize>(matrix: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let (mut lower, mut diagonal) = ([[0.0; D]; D], [0.0; D]);
    for column in 0..D {
        let scaled: [f64; D] = std::array::from_fn(|k| lower[column][k] * diagonal[k]);
        let rest = |row: &[f64; D], row_number: usize| {
            let known = (0..column).map(|k| row[k] * scaled[k]);
            matrix[(row_number, column)] - known.sum::<f64>()
        };
        let pivot = rest(&lower[column], column);
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        diagonal[column] = pivot;
        for row in column + 1..D {
            lower[row][column] = rest(&lower[row], row) / pivot;
        }
    }
    let mut inverse = SMatrix::<f64, D, D>::identity();
    for mut solution in inverse.column_iter_mut() {
        for row in 0..D {
            for k in 0..row {
                solution[row] -= lower[row][k] * solution[k];
            }
        }
        for row in (0..D).rev() {
            solution[row] /= diagonal[row];
            for k in row + 1..D {
                solution[row] -= lower[k][row] * solution[k];
            }
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_and_indefinite_matrices_have_no_inverse() {
        let matrix = SMatrix::<f64, 3, 3>::new(4.0, 1.0, -2.0, 1.0, 3.0, 0.5, -2.0, 0.5, 5.0);
        let right = SVector::<f64, 3>::new(1.0, -2.0, 3.0);
        let inverse = Inverse::of(&matrix).expect("it is positive definite");
        assert!((matrix * inverse.solve(&right) - right).norm() < 1e-14);
        assert!(Inverse::of(&(matrix - SMatrix::identity() * 2.5)).is_none());
        assert!(Inverse::of(&(matrix * f64::NAN)).is_none());
        assert!(Inverse::<3>::of(&SMatrix::zeros()).is_none());
    }

    #[test]
    fn flat_matrices_are_inverted_by_factors() {
        let along = SVector::<f64, 3>::new(1.0, 2.0, -1.0);
        let matrix = along * along.transpose() + SMatrix::identity() * 1e-9;
        assert!(by_cofactors(&matrix).is_none());
        let inverse = Inverse::of(&matrix).expect("it is positive definite");
        let right = SVector::<f64, 3>::new(0.5, 1.0, 0.5);
        assert!((matrix * inverse.solve(&right) - right).norm() < 1e-6);
    }
}
