//! Classes of numbered places that are one, where a place may lie whole periods from its number's.

use nalgebra::{Point3, Vector3};

use crate::complex::vertex_key::{NO_SHIFT, Shift, difference, displacement, sum};

/// A number, and the shift by whole periods at which it is seen.
pub(crate) type ShiftedNumber = (u32, Shift);

/// Classes of numbers that are one place; a number stands at a shift from the first of its class.
#[derive(Debug)]
pub(crate) struct ShiftedUnion {
    /// Per number: a lower one of its class, or itself, and the shift from there.
    above: Vec<ShiftedNumber>,
}

impl ShiftedUnion {
    /// `count` numbers, each a class of its own.
    #[must_use]
    pub(crate) fn new(count: usize) -> Self {
        let above = (0..count as u32).map(|number| (number, NO_SHIFT));
        Self {
            above: above.collect(),
        }
    }

    /// The first of the class of a place's number, and the shift at which that stands there.
    #[must_use]
    pub(crate) fn resolved(&self, place: ShiftedNumber) -> ShiftedNumber {
        let (mut number, mut shift) = place;
        loop {
            let (above, by) = self.above[number as usize];
            if above == number {
                return (number, shift);
            }
            (number, shift) = (above, sum(shift, by));
        }
    }

    /// Makes one of two places.
    pub(crate) fn unite(&mut self, one: ShiftedNumber, other: ShiftedNumber) {
        let [one, other] = [one, other].map(|place| self.resolved(place));
        let (low, high) = if one.0 <= other.0 {
            (one, other)
        } else {
            (other, one)
        };
        if low.0 != high.0 {
            // Where `high` stands at its shift, `low` stands at its own.
            self.above[high.0 as usize] = (low.0, difference(low.1, high.1));
        }
    }

    /// Gives every class the place of the one in which most walls meet, the first of several.
    pub(crate) fn settle(
        &mut self,
        mut walls: Vec<u8>,
        positions: &mut [Point3<f64>],
        periods: &Vector3<f64>,
    ) {
        for number in 0..self.above.len() {
            let (root, shift) = self.resolved((number as u32, NO_SHIFT));
            self.above[number] = (root, shift);
            let root = root as usize;
            if walls[number] > walls[root] {
                walls[root] = walls[number];
                // The number stands at shift zero where its root stands at `shift`.
                positions[root] = positions[number] - displacement(shift, periods);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shifts_add_up_along_a_class() {
        let mut classes = ShiftedUnion::new(4);
        classes.unite((2, [1, 0, 0]), (3, NO_SHIFT));
        classes.unite((3, [0, 2, 0]), (1, [0, 0, 5]));
        // Where 3 stands at 0, 2 stands at (1, 0, 0); where 3 stands at (0, 2, 0), 1 at (0, 0, 5).
        assert_eq!(classes.resolved((3, NO_SHIFT)), (1, [0, -2, 5]));
        assert_eq!(classes.resolved((2, [1, 0, 0])), (1, [0, -2, 5]));
        assert_eq!(classes.resolved((0, [7, 0, 0])), (0, [7, 0, 0]));
    }
}
