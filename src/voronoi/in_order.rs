//! Sites by distance, one after the other, however the index lies.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::geometry::label::Label;
use crate::voronoi::candidate::{Candidate, Subtree};

/// No site in a box is nearer than the box by more than rounding, which this share is far above.
const SURELY: f64 = 1.0 - 1e-12;

/// What comes next.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Next {
    /// A site that no other one precedes.
    Candidate(Candidate),
    /// Sites that may be nearer than all others.
    Subtree(Subtree),
}

/// What has still to be looked at.
#[derive(Clone, Debug, Default)]
pub(crate) struct Queue {
    heap: BinaryHeap<Entry>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The squared distance of a candidate, or one that no site in a subtree falls below (L²).
    square: f64,
    /// The candidate's label. Subtrees have none and come first.
    label: Option<Label>,
    next: Next,
}

impl Queue {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.heap.clear();
    }

    /// Adds a site and its label.
    pub(crate) fn push_candidate(&mut self, candidate: Candidate, label: Label) {
        self.heap.push(Entry {
            square: candidate.distance_squared,
            label: Some(label),
            next: Next::Candidate(candidate),
        });
    }

    /// Adds a subtree.
    pub(crate) fn push_subtree(&mut self, subtree: Subtree) {
        self.heap.push(Entry {
            square: SURELY * subtree.gap_squared,
            label: None,
            next: Next::Subtree(subtree),
        });
    }

    /// Takes out what comes next.
    pub(crate) fn pop(&mut self) -> Option<Next> {
        self.heap.pop().map(|entry| entry.next)
    }
}

impl Ord for Entry {
    /// The nearest is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        let by_square = other.square.total_cmp(&self.square);
        by_square.then_with(|| other.label.cmp(&self.label))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}
