//! What a walk over a piece's surface reports, and to whom.

use nalgebra::Vector3;

use crate::chebyshev::sector::{Interface, Sector};

/// A facet as seen from the center of the walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetView {
    /// The facet's number in its piece.
    pub(crate) number: u32,
    /// The anchor's displacement from the center.
    pub(crate) anchor: Vector3<f64>,
    /// The center's signed height below the facet's plane.
    pub(crate) height: f64,
}

/// Takes what the walk reports. Positions are displacements from the center.
pub(crate) trait Visit {
    /// The part (a, b) of an edge lies in `sector`; the triangle with the anchor has the signed
    /// area `doubled_area / 2`.
    fn share(
        &mut self,
        facet: &FacetView,
        sector: Sector,
        doubled_area: f64,
        a: &Vector3<f64>,
        b: &Vector3<f64>,
    );

    /// The directed part (u, v) of the interface lies on the facet.
    fn segment(
        &mut self,
        facet: &FacetView,
        interface: Interface,
        doubled_area: f64,
        u: &Vector3<f64>,
        v: &Vector3<f64>,
    );
}
