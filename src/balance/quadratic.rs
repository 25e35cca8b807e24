//! Small convex quadratic programs whose variables may be held to be not negative, by the active sets of
//! Lawson & Hanson (*Solving Least Squares Problems*, 1974, chapter 23) on the normal equations.

use nalgebra::{DMatrix, DVector};

use crate::balance::dual::Relation;

/// What is added to the unit diagonal of the scaled matrix, so that dependent columns can be told apart.
const RIDGE: f64 = 1e-14;

/// A gradient below this share of the largest coefficient is rounding.
const GRADIENT_ROUNDING: f64 = 1e-13;

/// The minimizer of ½ yᵀMy + cᵀy, with y_k ≥ 0 where relation k is an inequality; M is positive
/// semidefinite. A variable of which M knows nothing (M_kk = 0) stays zero.
pub(crate) fn minimize_quadratic(
    matrix: &DMatrix<f64>,
    linear: &DVector<f64>,
    relations: &[Relation],
) -> DVector<f64> {
    let scale = matrix.diagonal().map(inverse_root);
    let scaled = |row: usize, column: usize| {
        let ridge = if row == column { RIDGE } else { 0.0 };
        matrix[(row, column)] * scale[row] * scale[column] + ridge
    };
    let count = linear.len();
    let mut program = Program {
        matrix: DMatrix::from_fn(count, count, scaled),
        linear: linear.component_mul(&scale),
        point: DVector::zeros(count),
        passive: (0..count)
            .filter(|&k| relations[k] == Relation::Equal && scale[k] > 0.0)
            .collect(),
    };
    program.run(relations, &scale);
    program.point.component_mul(&scale)
}

/// 1/√ of an entry of the diagonal, 0 of one that is not positive.
fn inverse_root(entry: f64) -> f64 {
    let root = entry.max(0.0).sqrt();
    if root > 0.0 { 1.0 / root } else { 0.0 }
}

/// A program with a matrix of unit diagonal, and the variables that are not held at zero.
struct Program {
    matrix: DMatrix<f64>,
    linear: DVector<f64>,
    point: DVector<f64>,
    passive: Vec<usize>,
}

impl Program {
    /// Frees the variable that promises most, until none does.
    fn run(&mut self, relations: &[Relation], scale: &DVector<f64>) {
        self.settle(relations);
        let mut refused = vec![false; self.linear.len()];
        let threshold = GRADIENT_ROUNDING * self.linear.amax();
        for _ in 0..4 * self.linear.len() {
            let descent = -(&self.matrix * &self.point + &self.linear);
            let may_enter = |&k: &usize| {
                let held = relations[k] == Relation::AtLeast && !self.passive.contains(&k);
                held && !refused[k] && scale[k] > 0.0 && descent[k] > threshold
            };
            let by_descent = |a: &usize, b: &usize| descent[*a].total_cmp(&descent[*b]);
            let Some(entering) = (0..descent.len()).filter(may_enter).max_by(by_descent) else {
                return;
            };
            self.passive.push(entering);
            self.settle(relations);
            refused[entering] = !self.passive.contains(&entering);
        }
    }

    /// Moves to the minimizer over the passive variables; those that would turn negative on the way are
    /// held at zero.
    fn settle(&mut self, relations: &[Relation]) {
        while let Some(goal) = self.passive_minimizer() {
            let blocks = |k: usize| relations[k] == Relation::AtLeast && goal[k] <= 0.0;
            let share = |k: usize| match self.point[k] - goal[k] {
                0.0 => 0.0,
                way => self.point[k] / way,
            };
            let blocking = self.passive.iter().copied().filter(|&k| blocks(k));
            let first = blocking.min_by(|&a, &b| share(a).total_cmp(&share(b)));
            let Some(first) = first else {
                self.point = goal;
                return;
            };
            let way = (&goal - &self.point) * share(first);
            self.point += way;
            self.point[first] = 0.0;
            self.passive.retain(|&k| k != first);
        }
    }

    /// The minimizer over the passive variables, the others zero; `None` if there are none, or if their
    /// matrix is singular even with its ridge.
    fn passive_minimizer(&self) -> Option<DVector<f64>> {
        let of = &self.passive;
        if of.is_empty() {
            return None;
        }
        let size = of.len();
        let block = DMatrix::from_fn(size, size, |i, j| self.matrix[(of[i], of[j])]);
        let right = DVector::from_fn(size, |i, _| -self.linear[of[i]]);
        let solution = block.cholesky()?.solve(&right);
        let mut goal = DVector::zeros(self.linear.len());
        for (i, &k) in of.iter().enumerate() {
            goal[k] = solution[i];
        }
        Some(goal)
    }
}
