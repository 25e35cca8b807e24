//! A displacement as the six sectors' distance functions see it.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::sector::Sector;

/// A displacement (x, y, z) as x, −x, y, −y, z, −z, so that a sector's distance function is a look
/// into a table. Two lanes more, of no meaning, make it whole blocks for the processor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight([f64; Sector::SLOTS]);

impl Sight {
    #[inline]
    pub(crate) fn new(x: f64, y: f64, z: f64) -> Self {
        Self([x, -x, y, -y, z, -z, 0.0, 0.0])
    }

    #[inline]
    pub(crate) fn of(displacement: &Vector3<f64>) -> Self {
        Self::new(displacement.x, displacement.y, displacement.z)
    }

    /// The same point as seen from `center`, both seen from one origin until now.
    #[inline]
    pub(crate) fn from(&self, center: &Self) -> Self {
        let mut lanes = self.0;
        for (lane, shift) in lanes.iter_mut().zip(center.0) {
            *lane -= shift;
        }
        Self(lanes)
    }

    /// Whether no sector's distance function is greater than that of `sector` where the point is as
    /// seen from `center`.
    #[inline]
    pub(crate) fn stays_in(&self, sector: Sector, center: &Self) -> bool {
        let most = f64x4::splat(self.distance(sector) - center.distance(sector));
        let lanes = self.0.as_chunks().0.iter().zip(center.0.as_chunks().0);
        // Lanes of no meaning are zero, and one of the others is not less.
        let are_less = |(lanes, center): (&[f64; 4], &[f64; 4])| {
            (f64x4::new(*lanes) - f64x4::new(*center)).simd_le(most)
        };
        lanes
            .map(are_less)
            .fold(f64x4::splat(f64::from_bits(u64::MAX)), |all, one| all & one)
            .to_bitmask()
            == 0b1111
    }

    /// The displacement.
    #[inline]
    pub(crate) fn point(&self) -> Vector3<f64> {
        Vector3::new(self.0[0], self.0[2], self.0[4])
    }

    /// What the sector's distance function is here.
    #[inline]
    pub(crate) fn distance(&self, sector: Sector) -> f64 {
        self.0[sector.number()]
    }

    /// The coordinate along an axis.
    #[inline]
    pub(crate) fn along(&self, axis: usize) -> f64 {
        self.0[2 * axis % Sector::SLOTS]
    }

    /// The sector in which the point lies.
    #[inline]
    pub(crate) fn sector(&self) -> Sector {
        Sector::of(&self.point())
    }
}
