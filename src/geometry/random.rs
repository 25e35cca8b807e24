//! Seeded random numbers that are the same on every machine.
//!
//! ChaCha8 seeded by its `seed_from_u64` gives the bits; the upper 53 of every 64 become a
//! number in [0, 1) here and not in a distribution crate, so that a seed keeps its numbers when
//! such a crate changes.

use std::f64::consts::TAU;

use nalgebra::Point;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use crate::geometry::bounds::Bounds;

/// A stream of numbers fixed by its seed.
#[derive(Clone, Debug)]
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    /// The stream of `seed`.
    #[must_use]
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// One of the seed's many streams, of which none needs those before it; the one of number 0 is
    /// [`Random::new`]'s.
    #[must_use]
    pub(crate) fn stream(seed: u64, number: u64) -> Self {
        let mut random = Self::new(seed);
        random.0.set_stream(number);
        random
    }

    /// Uniform in [0, 1): a multiple of 2⁻⁵³.
    pub(crate) fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1_u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * STEP
    }

    /// Normal with mean 0 and deviation 1 (Box & Muller).
    pub(crate) fn gaussian(&mut self) -> f64 {
        let (radius, turn) = (1.0 - self.uniform(), self.uniform());
        (-2.0 * radius.ln()).sqrt() * (TAU * turn).cos()
    }

    /// Uniform in a box, axis by axis.
    pub(crate) fn point<const D: usize>(&mut self, bounds: &Bounds<D>) -> Point<f64, D> {
        let extent = bounds.extent();
        let mut point = bounds.min;
        for axis in 0..D {
            point[axis] += self.uniform() * extent[axis];
        }
        bounds.clamp(&point)
    }
}

/// A source of random points.
pub(crate) type PointSource<'a, const D: usize> = Box<dyn Fn(&mut Random) -> Point<f64, D> + 'a>;

/// So many draws in a row may miss a set before they are made otherwise: it then fills less than a
/// few thousandths of a percent of its bounding box.
const MISSES_IN_BOX: u64 = 100_000;

/// So many draws in a row may miss a set altogether.
const MISSES_ALLOWED: u64 = 10_000_000;

/// `count` points uniform over a set, by rejection from its box. From a set that the box misses
/// 100 000 times in a row they are drawn from what `closer` returns, a source of points uniform over
/// some smaller set around this one, if there is one.
///
/// # Errors
/// The number of draws in a row that missed the set, when it fills next to nothing of either.
pub(crate) fn points_inside<'a, const D: usize>(
    count: usize,
    seed: u64,
    bounds: &'a Bounds<D>,
    contains: impl Fn(&Point<f64, D>) -> bool,
    closer: impl FnOnce() -> Option<PointSource<'a, D>>,
) -> Result<Vec<Point<f64, D>>, u64> {
    let mut random = Random::new(seed);
    let (mut points, mut misses) = (Vec::new(), 0);
    let mut closer = Some(closer);
    let mut source: PointSource<'a, D> = Box::new(|random| random.point(bounds));
    while points.len() < count {
        let point = source(&mut random);
        if contains(&point) {
            points.push(point);
            misses = 0;
            continue;
        }
        misses += 1;
        if misses == MISSES_IN_BOX
            && let Some(found) = closer.take().and_then(|closer| closer())
        {
            source = found;
        }
        if misses > MISSES_ALLOWED {
            return Err(misses);
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fill_the_unit_interval_evenly() {
        let mut random = Random::new(3);
        let mut bins = [0_u32; 10];
        for _ in 0..10_000 {
            bins[(random.uniform() * 10.0) as usize] += 1;
        }
        // The standard deviation of a bin is 30.
        assert!(bins.iter().all(|&bin| bin.abs_diff(1000) < 150), "{bins:?}");
    }

    #[test]
    fn the_first_stream_is_the_seeds_own() {
        let (mut one, mut other) = (Random::new(5), Random::stream(5, 0));
        let (one, other) = (one.uniform(), other.uniform());
        assert_eq!(one.to_bits(), other.to_bits());
        assert_ne!(one.to_bits(), Random::stream(5, 1).uniform().to_bits());
    }
}
