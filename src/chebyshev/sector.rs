//! Space about a center, split by the largest coordinate difference into six cones.

use nalgebra::Vector3;
use wide::f64x4;

/// One of the six cones in which a coordinate difference of one sign is the largest: the axis, plus
/// four for the negative side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sector(u8);

impl Sector {
    /// All six: +x, −x, +y, −y, +z, −z.
    pub const ALL: [Self; 6] = [Self(0), Self(4), Self(1), Self(5), Self(2), Self(6)];

    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 8;

    /// How far apart the numbers of an axis's two sectors are.
    pub(crate) const OPPOSITE: usize = 4;

    /// The sector in which `displacement` from the center lies; on ties the first of its kind.
    #[must_use]
    #[inline]
    pub fn of(displacement: &Vector3<f64>) -> Self {
        // Numbers without sign are ordered as their bits are, and those are compared faster.
        const SIGN: u64 = 1 << 63;
        let [x, y, z] = [displacement.x, displacement.y, displacement.z].map(f64::to_bits);
        let number = |axis: u64, along: u64| axis | (along >> 63) << 2;
        let (mut sector, mut most) = (number(0, x), x & !SIGN);
        if y & !SIGN > most {
            (sector, most) = (number(1, y), y & !SIGN);
        }
        if z & !SIGN > most {
            sector = number(2, z);
        }
        Self(sector as u8)
    }

    /// [`Sector::of`] for four displacements, by axis: the numbers, in the last bits of floats.
    #[inline]
    pub(crate) fn codes_of_four(displacements: &[f64x4; 3]) -> f64x4 {
        FourSectors::of(displacements).codes(0) | f64x4::ONE
    }

    /// The one of a number.
    #[inline]
    pub(crate) const fn of_number(number: usize) -> Self {
        Self(number as u8)
    }

    /// The axis, plus four for the negative side.
    #[must_use]
    #[inline]
    pub fn number(self) -> usize {
        usize::from(self.0) % Self::SLOTS
    }

    /// The four sectors of the other axes, which have an interface with this one.
    #[must_use]
    #[inline]
    pub fn beside(self) -> [Self; 4] {
        const BESIDE: [[Sector; 4]; 3] = [
            [Sector(1), Sector(5), Sector(2), Sector(6)],
            [Sector(0), Sector(4), Sector(2), Sector(6)],
            [Sector(0), Sector(4), Sector(1), Sector(5)],
        ];
        BESIDE[self.axis()]
    }

    /// 0, 1, 2 for x, y, z.
    #[must_use]
    #[inline]
    pub fn axis(self) -> usize {
        usize::from(self.0) % Self::OPPOSITE
    }

    /// +1 or −1.
    #[must_use]
    #[inline]
    pub fn sign(self) -> f64 {
        if self.is_negative() { -1.0 } else { 1.0 }
    }

    /// The linear function that is the Chebyshev distance within the sector (L).
    #[must_use]
    #[inline]
    pub fn distance(self, displacement: &Vector3<f64>) -> f64 {
        let along = match self.axis() {
            0 => displacement.x,
            1 => displacement.y,
            _ => displacement.z,
        };
        if self.is_negative() { -along } else { along }
    }

    fn is_negative(self) -> bool {
        usize::from(self.0) >= Self::OPPOSITE
    }
}

/// The sectors of four displacements, side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FourSectors {
    /// Whether y is the axis unless z is.
    is_y: f64x4,
    is_z: f64x4,
    is_negative: f64x4,
    distance: f64x4,
}

impl FourSectors {
    /// [`Sector::of`] for four displacements, by axis.
    #[inline(always)]
    pub(crate) fn of(displacements: &[f64x4; 3]) -> Self {
        let [x, y, z] = displacements.each_ref().map(|all| all.abs());
        let is_y = y.simd_gt(x);
        let is_z = z.simd_gt(x.fast_max(y));
        let along = is_z.select(
            displacements[2],
            is_y.select(displacements[1], displacements[0]),
        );
        Self {
            is_y,
            is_z,
            is_negative: along.simd_lt(f64x4::ZERO),
            distance: along.abs(),
        }
    }

    /// What belongs to the axis.
    #[inline(always)]
    pub(crate) fn of_axis(&self, [x, y, z]: [f64x4; 3]) -> f64x4 {
        self.is_z.select(z, self.is_y.select(y, x))
    }

    /// What the sectors' distance functions are at other displacements.
    #[inline(always)]
    pub(crate) fn distance(&self, displacements: &[f64x4; 3]) -> f64x4 {
        self.signed(self.of_axis(*displacements))
    }

    /// The distances of the four displacements themselves.
    #[inline(always)]
    pub(crate) fn own_distance(&self) -> f64x4 {
        self.distance
    }

    /// Numbers, with the other sign on the negative side.
    #[inline(always)]
    pub(crate) fn signed(&self, numbers: f64x4) -> f64x4 {
        numbers ^ self.is_negative & f64x4::splat(-0.0)
    }

    /// Where the axis is x, where y and where z.
    #[inline(always)]
    pub(crate) fn by_axis(&self, numbers: f64x4) -> [f64x4; 3] {
        let z = self.is_z & numbers;
        let rest = numbers ^ z;
        let y = self.is_y & rest;
        [rest ^ y, y, z]
    }

    /// The axes that belong to neither these sectors nor to others.
    #[inline(always)]
    pub(crate) fn third_axes(&self, others: &Self) -> ThirdAxes {
        let [y, other_y] = [self, others].map(|four| four.is_y ^ four.is_y & four.is_z);
        let (z, other_z) = (self.is_z, others.is_z);
        ThirdAxes {
            is_y_taken: y | other_y,
            is_z_taken: z | other_z,
            are_sound: y ^ other_y | z ^ other_z,
            is_start: other_z | (other_y ^ other_y & z),
        }
    }

    /// Where these are others.
    #[inline(always)]
    pub(crate) fn differ(&self, others: &Self) -> f64x4 {
        self.third_axes(others).are_sound | self.is_negative ^ others.is_negative
    }

    /// The numbers, from the bit `shift` on of floats.
    #[inline(always)]
    pub(crate) fn codes(&self, shift: usize) -> f64x4 {
        let bits = |number: usize| f64x4::splat(f64::from_bits((number as u64) << shift));
        let axes = self.of_axis([0, 1, 2].map(bits));
        axes | self.is_negative & bits(Sector::OPPOSITE)
    }
}

/// The axes that belong to neither of two sectors, side by side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThirdAxes {
    is_y_taken: f64x4,
    is_z_taken: f64x4,
    /// Where the sectors are of two axes.
    pub(crate) are_sound: f64x4,
    /// Where the axis of the first sector comes before that of the second.
    pub(crate) is_start: f64x4,
}

impl ThirdAxes {
    /// The sectors of these axes on whose sides displacements with these coordinates are.
    #[inline(always)]
    pub(crate) fn sectors(&self, along: f64x4) -> FourSectors {
        FourSectors {
            is_y: !self.is_y_taken,
            is_z: !self.is_z_taken,
            is_negative: along.simd_lt(f64x4::ZERO),
            distance: along.abs(),
        }
    }

    /// The coordinates along them.
    #[inline(always)]
    pub(crate) fn along(&self, [x, y, z]: &[f64x4; 3]) -> f64x4 {
        let rest = self.is_y_taken.select(*x, *y);
        self.is_z_taken.select(rest, *z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_sectors_at_once_are_those_of_each() {
        let values = [-1.0, -0.5, 0.0, 0.5, 1.0];
        for (x, y) in values.iter().flat_map(|&x| values.map(|y| (x, y))) {
            let z = [-1.0, 0.25, 0.5, 1.0];
            let away = [f64x4::splat(x), f64x4::splat(y), f64x4::new(z)];
            let codes = Sector::codes_of_four(&away).to_array();
            for (code, z) in codes.into_iter().zip(z) {
                let number = code.to_bits() as usize % Sector::SLOTS;
                assert_eq!(number, Sector::of(&Vector3::new(x, y, z)).number());
            }
        }
    }

    #[test]
    fn the_sector_holds_the_largest_difference() {
        assert_eq!(Sector::of(&Vector3::new(1.0, -1.0, 1.0)), Sector::ALL[0]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, 1.0)), Sector::ALL[3]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, -1.5)), Sector::ALL[5]);
    }
}
