//! The pairs of a limited-memory quasi-Newton method and their dot products.
//!
//! A pair is `s = x₊ − x` and `y = ∇f(x₊) − ∇f(x)`. The model of the curvature is made of the last
//! few of them (Byrd, Nocedal & Schnabel, Math. Programming 63, 1994, section 3). Their products are
//! kept from step to step, at O(memory · n) a step; since `dot` is symmetric to the bit, those of
//! pairs read from a checkpoint are the same.

use crate::minimize::blas1::dot;

/// A pair is kept if `s·y` exceeds this share of `|s| |y|`. \[B\] eq. 3.9 compares with `y·y`
/// instead, which depends on the units: it would drop every pair of a stiff function.
const LEAST_CURVATURE: f64 = f64::EPSILON;

/// The last pairs `(s, y)`, oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct History {
    steps: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
    products: Products,
}

/// Dot products of the pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Products {
    /// `s_i · s_j`.
    pub(crate) steps: Vec<Vec<f64>>,
    /// `s_i · y_j`.
    pub(crate) mixed: Vec<Vec<f64>>,
    /// `y_i · y_j`.
    pub(crate) changes: Vec<Vec<f64>>,
}

impl History {
    /// A history of given pairs, oldest first; surplus steps or changes are dropped.
    #[must_use]
    pub(crate) fn from_parts(steps: Vec<Vec<f64>>, changes: Vec<Vec<f64>>) -> Self {
        let mut history = Self::default();
        for (step, change) in steps.into_iter().zip(changes) {
            history.append(step, change);
        }
        history
    }

    /// Adds a pair and its products with those before it.
    fn append(&mut self, step: Vec<f64>, change: Vec<f64>) {
        self.steps.push(step);
        self.changes.push(change);
        let Self {
            steps,
            changes,
            products,
        } = self;
        extend(&mut products.steps, steps, steps);
        extend(&mut products.mixed, steps, changes);
        extend(&mut products.changes, changes, changes);
    }

    /// The dot products of the pairs.
    pub(crate) fn products(&self) -> &Products {
        &self.products
    }

    /// The steps `s`, oldest first.
    #[must_use]
    pub(crate) fn steps(&self) -> &[Vec<f64>] {
        &self.steps
    }

    /// The changes of the gradient `y`, oldest first.
    #[must_use]
    pub(crate) fn changes(&self) -> &[Vec<f64>] {
        &self.changes
    }

    /// How many pairs there are.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.steps.len()
    }

    /// Drops the oldest pairs until at most `memory` are left.
    pub(crate) fn shorten(&mut self, memory: usize) {
        let surplus = self.len().saturating_sub(memory);
        self.steps.drain(..surplus);
        self.changes.drain(..surplus);
        let Products {
            steps,
            mixed,
            changes,
        } = &mut self.products;
        for table in [steps, mixed, changes] {
            table.drain(..surplus);
            for row in table {
                row.drain(..surplus);
            }
        }
    }

    /// Adds a pair if the curvature along it is positive, and says whether it did.
    pub(crate) fn push(&mut self, step: Vec<f64>, change: Vec<f64>, memory: usize) -> bool {
        let lengths = dot(&step, &step).sqrt() * dot(&change, &change).sqrt();
        let positive = dot(&step, &change) > LEAST_CURVATURE * lengths;
        if !positive {
            return false;
        }
        self.shorten(memory.saturating_sub(1));
        self.append(step, change);
        true
    }
}

/// Adds the row and the column of the last vectors to a table of products.
fn extend(table: &mut Vec<Vec<f64>>, left: &[Vec<f64>], right: &[Vec<f64>]) {
    let (Some(last_left), Some(last_right)) = (left.last(), right.last()) else {
        return;
    };
    for (row, vector) in table.iter_mut().zip(left) {
        row.push(dot(vector, last_right));
    }
    table.push(right.iter().map(|vector| dot(last_left, vector)).collect());
}
