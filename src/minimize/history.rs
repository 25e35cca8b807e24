//! The last steps of a quasi-Newton run and how the gradient answered them.
//!
//! A pair is `s = x₊ − x` and `y = ∇f(x₊) − ∇f(x)`. All that L-BFGS knows of the function's
//! curvature is in the last few of them, and so is all that a run needs to be taken up again.

use crate::minimize::slices::dot;

/// A pair is kept if `s·y` exceeds this share of `|s| |y|`. \[B\] eq. 3.9 compares with `y·y`
/// instead, which depends on the units: it would drop every pair of a stiff function.
const LEAST_CURVATURE: f64 = f64::EPSILON;

/// The last pairs `(s, y)`, oldest first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    steps: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
}

impl History {
    /// A history of given pairs, oldest first; surplus steps or changes are dropped.
    #[must_use]
    pub fn from_parts(mut steps: Vec<Vec<f64>>, mut changes: Vec<Vec<f64>>) -> Self {
        let count = steps.len().min(changes.len());
        steps.truncate(count);
        changes.truncate(count);
        Self { steps, changes }
    }

    /// The steps `s`, oldest first.
    #[must_use]
    pub fn steps(&self) -> &[Vec<f64>] {
        &self.steps
    }

    /// The changes of the gradient `y`, oldest first.
    #[must_use]
    pub fn changes(&self) -> &[Vec<f64>] {
        &self.changes
    }

    /// How many pairs there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Drops the oldest pairs until at most `memory` are left.
    pub(crate) fn shorten(&mut self, memory: usize) {
        let surplus = self.len().saturating_sub(memory);
        self.steps.drain(..surplus);
        self.changes.drain(..surplus);
    }

    /// Adds a pair if the curvature along it is positive, and says whether it did.
    pub(crate) fn push(&mut self, step: Vec<f64>, change: Vec<f64>, memory: usize) -> bool {
        let lengths = dot(&step, &step).sqrt() * dot(&change, &change).sqrt();
        let positive = dot(&step, &change) > LEAST_CURVATURE * lengths;
        if !positive {
            return false;
        }
        self.shorten(memory.saturating_sub(1));
        self.steps.push(step);
        self.changes.push(change);
        true
    }
}
