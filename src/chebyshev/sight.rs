//! A displacement as the six sectors' distance functions see it.

use nalgebra::Vector3;
use wide::f64x2;

use crate::chebyshev::sector::Sector;

/// A displacement as x, y, z, −x, −y, −z, so that a sector's distance function is a look into a table.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sight([f64; Sector::SLOTS]);

/// A vertex as seen from the center, with its sector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexSight {
    sight: Sight,
    sector: Sector,
}

impl VertexSight {
    /// A vertex at `displacement` from the center.
    #[inline]
    pub(crate) fn of(displacement: &Vector3<f64>) -> Self {
        Self {
            sight: Sight::of(displacement),
            sector: Sector::of(displacement),
        }
    }

    /// Its displacement.
    #[inline]
    pub(crate) fn sight(&self) -> &Sight {
        &self.sight
    }

    /// Its sector.
    #[inline]
    pub(crate) fn sector(&self) -> Sector {
        self.sector
    }
}

impl Sight {
    /// A displacement.
    #[inline]
    pub(crate) fn of(displacement: &Vector3<f64>) -> Self {
        let [x, y, z] = (*displacement).into();
        Self([x, y, z, 0.0, -x, -y, -z, 0.0])
    }

    /// The displacement.
    #[inline]
    pub(crate) fn point(&self) -> Vector3<f64> {
        Vector3::new(self.0[0], self.0[1], self.0[2])
    }

    /// What the sector's distance function is here.
    #[inline]
    pub(crate) fn distance(&self, sector: Sector) -> f64 {
        self.0[sector.number()]
    }

    /// The coordinate along an axis.
    #[inline]
    pub(crate) fn along(&self, axis: usize) -> f64 {
        self.0[axis % Sector::SLOTS]
    }

    /// What the sector's distance function is, and the coordinate along an axis.
    #[inline]
    pub(crate) fn mark(&self, sector: Sector, axis: usize) -> f64x2 {
        f64x2::new([self.distance(sector), self.along(axis)])
    }
}
