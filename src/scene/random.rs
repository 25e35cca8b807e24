//! Uniform random numbers and points, the same on every machine.
//!
//! ChaCha8 seeded by its `seed_from_u64` gives the bits; the upper 53 of every 64 become a
//! number in [0, 1) here and not in a distribution crate, so that a seed keeps its sites when
//! such a crate changes.

use nalgebra::Point;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::geometry::bounds::Bounds;

/// A stream of numbers uniform in [0, 1), fixed by its seed.
#[derive(Clone, Debug)]
pub struct Uniform(ChaCha8Rng);

impl Uniform {
    /// The stream of `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// The next number: a multiple of 2⁻⁵³ in [0, 1).
    pub fn number(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// The next point of a box, axis by axis.
    pub fn point<const D: usize>(&mut self, bounds: &Bounds<D>) -> Point<f64, D> {
        let extent = bounds.extent();
        let mut point = bounds.min;
        for axis in 0..D {
            point[axis] += self.number() * extent[axis];
        }
        bounds.clamp(&point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fill_the_unit_interval_evenly() {
        let mut uniform = Uniform::new(3);
        let mut bins = [0_u32; 10];
        for _ in 0..10_000 {
            bins[(uniform.number() * 10.0) as usize] += 1;
        }
        // The standard deviation of a bin is 30.
        assert!(bins.iter().all(|&bin| bin.abs_diff(1000) < 150), "{bins:?}");
    }
}
