//! Sites as they stand now, by rank.

use nalgebra::Vector3;

use crate::domain::domain::Domain;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::ranks::{IMAGES, Ranks, image_of};

/// Sites as they stand now. Their ranks are their places in the index.
pub(crate) struct Standing<'a> {
    pub(crate) domain: &'a dyn Domain,
    pub(crate) index: &'a SiteIndex,
    pub(crate) numbers: Ranks<'a>,
    /// Per number of an image: its displacement (L).
    pub(crate) shifts: [Vector3<f64>; IMAGES],
}

impl<'a> Standing<'a> {
    /// Sites in an index, which `ranks` gives per site.
    pub(crate) fn new(domain: &'a dyn Domain, index: &'a SiteIndex, ranks: &'a [u32]) -> Self {
        let periods = domain.periods().map(Option::unwrap_or_default);
        let shift = |number: usize| {
            let copies = image_of(number as u8).map(f64::from);
            Vector3::from([0, 1, 2].map(|axis| copies[axis] * periods[axis]))
        };
        Self {
            domain,
            index,
            numbers: Ranks {
                sites: index.sites(),
                ranks,
            },
            shifts: std::array::from_fn(shift),
        }
    }
}
