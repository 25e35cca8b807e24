//! Edges that pass from one sector to another by way of a third, four at a time.
//!
//! Where the distances of the sectors at an edge's ends agree, one of the third axis may be larger: then
//! its sector comes between. With convexity, no other does unless that distance is negative.

use wide::f64x4;

use crate::chebyshev::four::{FourEdges, FourPassages};
use crate::chebyshev::sector::FourSectors;

/// Where edges pass into a third sector and out of it.
#[derive(Debug)]
pub(crate) struct Detours {
    /// The sectors between.
    pub(crate) between: FourSectors,
    /// Into them and out of them.
    pub(crate) passages: [FourPassages; 2],
    /// Which can be told.
    pub(crate) are_told: f64x4,
}

impl Detours {
    /// Those of edges that begin and end in different sectors.
    #[inline(always)]
    pub(crate) fn new(four: &FourEdges<'_>) -> Self {
        let FourEdges {
            ends: [a, b],
            sectors: [from, to],
            passages: direct,
            ..
        } = four;
        let [distance, along, ..] = direct.found;
        let between = from.third_axes(to).sectors(along);
        let [a_between, b_between] = [a, b].map(|end| between.distance(end));
        let into = FourPassages::new([a, b], [from, &between], [from.own_distance(), b_between]);
        let out = FourPassages::new([a, b], [&between, to], [a_between, to.own_distance()]);
        let is_ahead = |number: f64x4| number.simd_ge(f64x4::ZERO);
        let are_told = four.are_parted
            & direct.are_sound
            & is_ahead(distance)
            & into.are_sound
            & is_ahead(into.leads[1])
            & out.are_sound
            & is_ahead(out.leads[0])
            & into.shares.simd_le(out.shares);
        Self {
            between,
            passages: [into, out],
            are_told,
        }
    }

    /// The sectors before and after either passage.
    #[inline(always)]
    pub(crate) fn sectors(&self, four: &FourEdges<'_>) -> [[FourSectors; 2]; 2] {
        let [from, to] = four.sectors;
        [[from, self.between], [self.between, to]]
    }
}
