//! A vertex of a cell by its number in the complex and the whole periods at which the cell sees it.

use nalgebra::{Point3, Vector3};

use crate::complex::vertex_key::{Shift, displacement};

/// A vertex where a cell sees it: its number, and in the bits above 32 its shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct LoopCorner(u64);

/// Added to every component of a shift, so that it is a positive number of 10 bits.
const BIAS: i16 = 512;

impl LoopCorner {
    /// The corner at vertex `number`, shifted.
    #[must_use]
    pub(crate) fn new(number: u32, shift: Shift) -> Self {
        let bits = |axis: usize| ((shift[axis] + BIAS) & 0x3ff) as u64;
        Self(u64::from(number) | bits(0) << 32 | bits(1) << 42 | bits(2) << 52)
    }

    /// All of it as one number.
    #[inline]
    #[must_use]
    pub(crate) fn bits(self) -> u64 {
        self.0
    }

    /// The corner of [`LoopCorner::bits`].
    #[inline]
    #[must_use]
    pub(crate) fn of_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// The number of its vertex.
    #[inline]
    #[must_use]
    pub(crate) fn number(self) -> u32 {
        self.0 as u32
    }

    /// The shift of its vertex.
    #[inline]
    #[must_use]
    pub(crate) fn shift(self) -> Shift {
        [32, 42, 52].map(|bits| (self.0 >> bits & 0x3ff) as i16 - BIAS)
    }

    /// The same vertex moved by `by` more periods.
    #[must_use]
    pub(crate) fn shifted(self, by: Shift) -> Self {
        let shift = self.shift();
        Self::new(self.number(), [0, 1, 2].map(|axis| shift[axis] + by[axis]))
    }

    /// The vertex as `origin` sees it from shift zero.
    #[must_use]
    pub(crate) fn relative_to(self, origin: Self) -> Self {
        self.shifted(origin.shift().map(|periods| -periods))
    }

    /// Its place (L).
    #[must_use]
    pub(crate) fn position(self, positions: &[Point3<f64>], periods: &Vector3<f64>) -> Point3<f64> {
        positions[self.number() as usize] + displacement(self.shift(), periods)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::vertex_key::NO_SHIFT;

    #[test]
    fn shifts_are_kept_with_their_signs() {
        let corner = LoopCorner::new(9, [-3, 0, 200]);
        assert_eq!((corner.number(), corner.shift()), (9, [-3, 0, 200]));
        assert_eq!(corner.shifted([3, 1, -200]).shift(), [0, 1, 0]);
        assert_eq!(corner.relative_to(corner).shift(), NO_SHIFT);
        assert_eq!(LoopCorner::of_bits(corner.bits()), corner);
    }
}
