//! Space about a center, split by the largest coordinate difference into six cones.

use nalgebra::Vector3;
use wide::f64x4;

/// One of the six cones in which a coordinate difference of one sign is the largest: twice the
/// axis, plus one for the negative side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sector(u8);

impl Sector {
    /// All six: +x, −x, +y, −y, +z, −z.
    pub const ALL: [Self; 6] = [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5)];

    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 8;

    /// The sector in which `displacement` from the center lies; on ties the first of its kind.
    #[must_use]
    #[inline]
    pub fn of(displacement: &Vector3<f64>) -> Self {
        // Numbers without sign are ordered as their bits are, and those are compared faster.
        const SIGN: u64 = 1 << 63;
        let [x, y, z] = [displacement.x, displacement.y, displacement.z].map(f64::to_bits);
        let (mut sector, mut most) = (x >> 63, x & !SIGN);
        if y & !SIGN > most {
            (sector, most) = (2 | y >> 63, y & !SIGN);
        }
        if z & !SIGN > most {
            sector = 4 | z >> 63;
        }
        Self(sector as u8)
    }

    /// [`Sector::of`] for four displacements, by axis; see [`Sector::of_code`].
    #[inline]
    pub(crate) fn codes_of_four(displacements: &[f64x4; 3]) -> f64x4 {
        let [x, y, z] = displacements
            .each_ref()
            .map(|displacement| displacement.abs());
        let along = |axis: u64| {
            let [positive, negative] = [0, 1].map(|side| f64x4::splat(code(2 * axis + side)));
            let is_negative = displacements[axis as usize].simd_lt(f64x4::ZERO);
            is_negative.select(negative, positive)
        };
        let is_higher = y.simd_gt(x);
        let most = is_higher.select(y, x);
        let sector = is_higher.select(along(1), along(0));
        z.simd_gt(most).select(along(2), sector)
    }

    /// The sector of a code: its number in the last bits of a float.
    #[inline]
    pub(crate) fn of_code(code: f64) -> Self {
        Self(code.to_bits() as u8)
    }

    /// Its place in [`Sector::ALL`].
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
            [Sector(2), Sector(3), Sector(4), Sector(5)],
            [Sector(0), Sector(1), Sector(4), Sector(5)],
            [Sector(0), Sector(1), Sector(2), Sector(3)],
        ];
        BESIDE[self.axis()]
    }

    /// 0, 1, 2 for x, y, z.
    #[must_use]
    #[inline]
    pub fn axis(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// +1 or −1.
    #[must_use]
    #[inline]
    pub fn sign(self) -> f64 {
        1.0 - 2.0 * f64::from(self.0 & 1)
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
        if self.0 & 1 == 0 { along } else { -along }
    }
}

/// See [`Sector::of_code`].
fn code(number: u64) -> f64 {
    f64::from_bits(1.0_f64.to_bits() | number)
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
                assert_eq!(Sector::of_code(code), Sector::of(&Vector3::new(x, y, z)));
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
