//! Merging vertices with equal coordinates.

use nalgebra::Point3;

/// The share of filled slots at which the table grows: above it, linear probing slows down.
const FULL: f64 = 0.5;

/// Gives equal points equal indices, in order of first appearance. Equality is by bits, except
/// that −0 equals 0: nothing is merged that merely lies close. An open-addressing table of
/// 32-bit slots, several times lighter than a `HashMap` of coordinates.
#[derive(Clone, Debug)]
pub struct Welder {
    points: Vec<Point3<f64>>,
    slots: Vec<u32>,
}

const VACANT: u32 = u32::MAX;

impl Welder {
    /// A welder that expects about `points` distinct points.
    #[must_use]
    pub fn with_capacity(points: usize) -> Self {
        let slots = ((points as f64 / FULL) as usize).next_power_of_two();
        Self {
            points: Vec::with_capacity(points),
            slots: vec![VACANT; slots.max(16)],
        }
    }

    /// The index of `point`, a new one if it was not seen before.
    pub fn index(&mut self, point: &Point3<f64>) -> u32 {
        // Adding zero turns −0 into 0.
        let point = point.map(|coordinate| coordinate + 0.0);
        let slot = self.slot(&point);
        if self.slots[slot] != VACANT {
            return self.slots[slot];
        }
        let index = self.points.len() as u32;
        self.slots[slot] = index;
        self.points.push(point);
        if self.points.len() as f64 > FULL * self.slots.len() as f64 {
            self.grow();
        }
        index
    }

    /// The distinct points in order of first appearance.
    #[must_use]
    pub fn into_points(self) -> Vec<Point3<f64>> {
        self.points
    }

    /// The slot that holds `point` or should.
    fn slot(&self, point: &Point3<f64>) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(point) as usize & mask;
        loop {
            let index = self.slots[slot];
            if index == VACANT || same_bits(&self.points[index as usize], point) {
                return slot;
            }
            slot = (slot + 1) & mask;
        }
    }

    fn grow(&mut self) {
        self.slots = vec![VACANT; self.slots.len() * 2];
        for index in 0..self.points.len() {
            let slot = self.slot(&self.points[index]);
            self.slots[slot] = index as u32;
        }
    }
}

fn same_bits(one: &Point3<f64>, other: &Point3<f64>) -> bool {
    (0..3).all(|axis| one[axis].to_bits() == other[axis].to_bits())
}

/// Multiply-and-fold over the three bit patterns; the constants are odd 64-bit digits of π
/// and e. Points of a lattice differ in few high bits, hence the folding of the high half.
fn hash(point: &Point3<f64>) -> u64 {
    let mut hash = 0x243f_6a88_85a3_08d3_u64;
    for coordinate in point.iter() {
        hash = (hash ^ coordinate.to_bits()).wrapping_mul(0xb7e1_5162_8aed_2a6b);
        hash ^= hash >> 32;
    }
    hash
}
