//! What a walk over a piece's surface reports, and to whom.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::detours::Detours;
use crate::chebyshev::endpoints::{Endpoints, Found};
use crate::chebyshev::four::FourEdges;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::seen::Seen;
use crate::chebyshev::sight::Sight;
use crate::geometry::small_polyhedron::BLOCK;

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

/// A facet as seen from the center of the walk. It is fanned from its anchor, the foot of the
/// perpendicular from the center.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetView {
    /// The facet's number in its piece.
    pub(crate) number: usize,
    /// The unit normal.
    pub(crate) normal: Vector3<f64>,
    /// The center's signed height below the facet's plane.
    pub(crate) height: f64,
}

impl FacetView {
    /// The anchor's displacement from the center.
    #[inline]
    pub(crate) fn anchor(&self) -> Vector3<f64> {
        self.normal * self.height
    }

    /// What a sector's distance function is at the anchor.
    #[inline]
    pub(crate) fn distance(&self, sector: Sector) -> f64 {
        sector.distance(&self.normal) * self.height
    }

    /// Twice the signed area of the triangle (anchor, u, v).
    #[inline]
    pub(crate) fn doubled_area(&self, u: &Vector3<f64>, v: &Vector3<f64>) -> f64 {
        self.normal.dot(&u.cross(v))
    }
}

/// A facet beside an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// The facet.
    pub(crate) facet: FacetView,
    /// Twice the signed area of the triangle of the facet's anchor and the edge.
    pub(crate) doubled_area: f64,
}

/// Takes what the walk reports. Positions are displacements from the center.
pub(crate) trait Visit {
    /// The share `part` of an edge, from one end to the other, lies in `sector`; it has the same
    /// share in the triangles on both sides.
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]);

    /// The directed part (u, v) of the interface lies on the facet.
    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found);

    /// The shares of all edges that are whole or told.
    #[inline(always)]
    fn edges(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>) {
        let [known, told] = [four.are_known(), four.are_told].map(f64x4::to_bitmask);
        let passages = four.passages.alone(&four.sectors);
        for lane in (0..BLOCK).filter(|lane| known >> lane & 1 == 1) {
            let passage = (told >> lane & 1 == 1).then_some(passages[lane]);
            seen.report_passages(&four.edges[lane], passage, |_| {}, self);
        }
    }

    /// The shares of all edges with a detour that is told.
    #[inline(always)]
    fn detours(&mut self, seen: &Seen<'_>, four: &FourEdges<'_>, detours: &Detours) {
        let told = detours.are_told.to_bitmask();
        let sectors = detours.sectors(four);
        let [into, out] = [0, 1].map(|end: usize| detours.passages[end].alone(&sectors[end]));
        for lane in (0..BLOCK).filter(|lane| told >> lane & 1 == 1) {
            let passages = [into[lane], out[lane]];
            seen.report_passages(&four.edges[lane], passages, |_| {}, self);
        }
    }

    /// As [`Visit::segment`] for four facets and interfaces, if they are any.
    #[inline(always)]
    fn segments(
        &mut self,
        seen: &Seen<'_>,
        endpoints: &Endpoints,
        four: [(usize, Interface); BLOCK],
    ) {
        for (facet, interface) in four {
            if interface != Interface::NONE {
                let [u, v] = endpoints.ends(facet, interface).map(Found::of_lanes);
                self.segment(&seen.facet(facet), interface, &u, &v);
            }
        }
    }
}
