//! What a walk over a piece's surface reports, and to whom.

use nalgebra::Vector3;

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::Sight;

/// An end of a share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Its Chebyshev distance from the center.
    pub(crate) distance: f64,
    /// Its displacement from the center.
    pub(crate) point: Vector3<f64>,
}

impl Corner {
    /// A point of `sector`.
    #[inline]
    pub(crate) fn new(sight: &Sight, sector: Sector) -> Self {
        Self {
            distance: sight.distance(sector),
            point: sight.point(),
        }
    }
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
    /// One over it, infinite in the plane.
    pub(crate) per_height: f64,
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
    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Found, v: &Found);
}
