//! The minimizer of a convex quadratic over a small box.
//!
//! `q(d) = g·d + ½ dᵀHd` over `lower ≤ d ≤ upper` with `lower ≤ 0 ≤ upper`, by the primal
//! active-set method (Nocedal & Wright, *Numerical Optimization*, 2nd ed., Algorithm 16.3), where
//! a constraint is one variable held at a bound. Mostly the unconstrained minimizer lies inside
//! and one inversion does. Every iterate is feasible and no higher than the one
//! before, so stopping early still leaves a descent step.
//!
//! The inverse of `H` is taken by cofactors where three variables allow it: they do not wait for each other and take one
//! quotient, which a cell's Newton step waits for. A matrix too flat for that is taken apart into
//! factors L D Lᵀ, Cholesky's without its roots (Golub & Van Loan, *Matrix Computations*, 4th ed.,
//! section 4.1.2).

use crate::arrays::MapEach;
use nalgebra::{SMatrix, SVector};

/// Changes of the set of held variables before the best step so far is taken. Three variables
/// have 27 such sets and each is met at most once; in practice two or three are.
const MAX_CHANGES: usize = 32;
/// Shift of the Hessian relative to its trace: far above the rounding of its entries (1e-16),
/// far below what would slow convergence.
const SHIFT_OF_TRACE: f64 = 1e-13;
/// Shift relative to `gradient / length`, which is what the Hessian must be for a step of
/// `length`. It decides only where the Hessian is (nearly) zero, and vanishes at the minimum.
const SHIFT_OF_GRADIENT: f64 = 1e-9;
/// Factor between attempts to find a shift that makes the Hessian positive definite.
const SHIFT_GROWTH: f64 = 100.0;
/// Attempts to do so; 100^20 spans everything from rounding to the trace and beyond.
const MAX_SHIFTS: usize = 20;

/// The Hessian, shifted as little as makes it positive definite, and its inverse.
pub(crate) fn positive_definite<const D: usize>(
    hessian: &SMatrix<f64, D, D>,
    gradient: &SVector<f64, D>,
    length: f64,
) -> Option<(SMatrix<f64, D, D>, Inverse<D>)> {
    let mut shift = (SHIFT_OF_TRACE * hessian.trace().abs())
        .max(SHIFT_OF_GRADIENT / length * gradient.amax())
        .max(f64::MIN_POSITIVE);
    for _ in 0..MAX_SHIFTS {
        let shifted = hessian + SMatrix::from_diagonal_element(shift);
        if let Some(inverse) = Inverse::of(&shifted) {
            return Some((shifted, inverse));
        }
        shift *= SHIFT_GROWTH;
    }
    None
}

/// The minimizer of `g·d + ½ dᵀHd` over the box, for a positive definite `H`.
///
/// The first inversion is the caller's, who had to find out that `H` is positive definite.
pub(crate) fn minimize_quadratic<const D: usize>(
    hessian: &SMatrix<f64, D, D>,
    inverse: &Inverse<D>,
    gradient: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> SVector<f64, D> {
    let free = inverse.solve(&-gradient);
    if (0..D).all(|axis| lower[axis] <= free[axis] && free[axis] <= upper[axis]) {
        return free;
    }
    let mut held = held_at_start(gradient, lower, upper);
    let mut step = SVector::zeros();
    for _ in 0..MAX_CHANGES {
        let slope = gradient + hessian * step;
        let rest = remaining_step(hessian, &slope, &held);
        if let Some(axis) = advance(&mut step, &rest, lower, upper) {
            held[axis] = true;
            continue;
        }
        let slope = gradient + hessian * step;
        match wrongly_held(&step, &slope, &held, lower, upper) {
            Some(axis) => held[axis] = false,
            None => break,
        }
    }
    step
}

/// Variables that start at a bound and are pushed against it.
fn held_at_start<const D: usize>(
    gradient: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> [bool; D] {
    std::array::from_fn(|axis| {
        (lower[axis] >= 0.0 && gradient[axis] >= 0.0)
            || (upper[axis] <= 0.0 && gradient[axis] <= 0.0)
    })
}

/// The step to the minimizer over the variables that are not held.
fn remaining_step<const D: usize>(
    hessian: &SMatrix<f64, D, D>,
    slope: &SVector<f64, D>,
    held: &[bool; D],
) -> SVector<f64, D> {
    let mut matrix = *hessian;
    let mut right = -slope;
    for axis in (0..D).filter(|&axis| held[axis]) {
        matrix.column_mut(axis).fill(0.0);
        matrix.row_mut(axis).fill(0.0);
        matrix[(axis, axis)] = 1.0;
        right[axis] = 0.0;
    }
    Inverse::of(&matrix).map_or_else(SVector::zeros, |inverse| inverse.solve(&right))
}

/// Goes along `rest` as far as the box allows and returns the variable that blocked it.
fn advance<const D: usize>(
    step: &mut SVector<f64, D>,
    rest: &SVector<f64, D>,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> Option<usize> {
    let (mut fraction, mut blocking) = (1.0, None);
    for axis in 0..D {
        let bound = if rest[axis] < 0.0 { lower } else { upper }[axis];
        if (step[axis] + rest[axis] - bound) * rest[axis] > 0.0 {
            let reach = (bound - step[axis]) / rest[axis];
            if reach < fraction {
                fraction = reach.max(0.0);
                blocking = Some((axis, bound));
            }
        }
    }
    *step += rest * fraction;
    let (axis, bound) = blocking?;
    step[axis] = bound;
    Some(axis)
}

/// The held variable whose slope pulls hardest off its bound.
fn wrongly_held<const D: usize>(
    step: &SVector<f64, D>,
    slope: &SVector<f64, D>,
    held: &[bool; D],
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> Option<usize> {
    let pull = |axis: usize| {
        if lower[axis] >= upper[axis] {
            0.0
        } else if step[axis] <= lower[axis] {
            -slope[axis]
        } else {
            slope[axis]
        }
    };
    (0..D)
        .filter(|&axis| held[axis] && pull(axis) > 0.0)
        .max_by(|&a, &b| pull(a).total_cmp(&pull(b)))
}

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
    let [a, b, c] = [0, 1, 2].map_each(|k| matrix[(k, k)]);
    let [ab, ac, bc] = [(1, 0), (2, 0), (2, 1)].map_each(|place| matrix[place]);
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

    #[test]
    fn a_corner_of_the_box_is_found_past_a_correlated_minimum() {
        let hessian = SMatrix::<f64, 2, 2>::new(2.0, 1.9, 1.9, 2.0);
        let inverse = Inverse::of(&hessian).unwrap();
        let gradient = SVector::<f64, 2>::new(-3.0, 1.0);
        let lower = SVector::repeat(-1.0);
        let upper = SVector::repeat(0.5);
        let step = minimize_quadratic(&hessian, &inverse, &gradient, &lower, &upper);
        // By hand: x = 0.5 is active, then y = −(1 + 1.9·0.5)/2 = −0.975.
        assert!((step - SVector::<f64, 2>::new(0.5, -0.975)).norm() < 1e-14);
    }
}
