//! A displacement as the six sectors' distance functions see it.

use nalgebra::Vector3;

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
