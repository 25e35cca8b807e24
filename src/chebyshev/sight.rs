//! A displacement as the six sectors' distance functions see it.

use nalgebra::Vector3;
use wide::{f64x2, f64x4};

use crate::chebyshev::sector::Sector;

/// A displacement (x, y, z) as x, −x, y, −y, z, −z, so that a sector's distance function is a look
/// into a table. Two lanes more hold what goes with it, and make it whole blocks for the processor.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Sight([f64; Sector::SLOTS]);

impl Sight {
    /// Four displacements, each with two numbers that go with it.
    #[inline(always)]
    pub(crate) fn four([x, y, z]: [f64x4; 3], more: [f64x4; 2]) -> [Self; 4] {
        let one = f64x4::transpose([x, -x, y, -y]).map(f64x4::to_array);
        let two = f64x4::transpose([z, -z, more[0], more[1]]).map(f64x4::to_array);
        [0, 1, 2, 3].map(|lane| {
            let ([a, b, c, d], [e, f, g, h]) = (one[lane], two[lane]);
            Self([a, b, c, d, e, f, g, h])
        })
    }

    /// The two numbers that go with it.
    #[inline]
    pub(crate) fn more(&self) -> [f64; 2] {
        [self.0[6], self.0[7]]
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

    /// What the sector's distance function is, and the coordinate along an axis.
    #[inline]
    pub(crate) fn mark(&self, sector: Sector, axis: usize) -> f64x2 {
        f64x2::new([self.distance(sector), self.along(axis)])
    }
}
