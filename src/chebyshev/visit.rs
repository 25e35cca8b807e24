//! What a walk over a piece's surface reports, and to whom.

use nalgebra::Vector3;

use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::{Interface, Mark};
use crate::chebyshev::sector::Sector;

/// A point as seen from the center of the walk: its displacement from there, as the distance
/// functions of the six sectors see it: x, −x, y, −y, z, −z, and two slots of no meaning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight([f64; Sector::SLOTS]);

impl Sight {
    /// The point `displacement` away from the center.
    #[inline]
    pub(crate) fn new(displacement: &Vector3<f64>) -> Self {
        let [x, y, z] = [displacement.x, displacement.y, displacement.z];
        Self([x, -x, y, -y, z, -z, 0.0, 0.0])
    }

    /// The displacement from the center.
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

    /// The point as the end of a share in `sector`.
    #[inline]
    pub(crate) fn corner(&self, sector: Sector) -> Corner {
        Corner {
            distance: self.distance(sector),
            point: self.point(),
        }
    }
}

/// An end of a share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Its Chebyshev distance from the center.
    pub(crate) distance: f64,
    /// Its displacement from the center.
    pub(crate) point: Vector3<f64>,
}

/// A facet as seen from the center of the walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetView<'a> {
    /// The facet's number in its piece.
    pub(crate) number: usize,
    /// Its piece.
    pub(crate) piece: &'a Integrand,
    /// The point from which the facet is fanned.
    pub(crate) anchor: &'a Sight,
    /// The center's signed height below the facet's plane.
    pub(crate) height: f64,
}

impl FacetView<'_> {
    /// The unit normal.
    #[inline]
    pub(crate) fn normal(&self) -> &Vector3<f64> {
        &self.piece.facets[self.number].normal
    }

    /// Twice the signed area of the triangle (anchor, u, v).
    #[inline]
    pub(crate) fn doubled_area(&self, u: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
        let anchor = self.anchor.point();
        let fan = (u - anchor).cross(&(v - anchor));
        self.normal().dot(&fan)
    }
}

/// A facet beside an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'a> {
    /// The facet.
    pub(crate) facet: FacetView<'a>,
    /// Twice the signed area of the triangle of the facet's anchor and the edge.
    pub(crate) doubled_area: f64,
}

/// Takes what the walk reports. Positions are displacements from the center.
pub(crate) trait Visit {
    /// The share `part` of an edge, from one end to the other, lies in `sector`; it has the same
    /// share in the triangles on both sides.
    fn share(&mut self, sides: &[Side<'_>; 2], sector: Sector, part: f64, ends: [&Corner; 2]);

    /// The directed part (u, v) of the interface lies on the facet.
    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Mark, v: &Mark);
}
