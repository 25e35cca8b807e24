//! What may cut a cell: a site, or a subtree of sites.

use nalgebra::{Point3, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;
use crate::voronoi::index::SiteIndex;

/// A site, or a periodic image of one, near another.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Candidate {
    /// The way to it (L).
    pub(crate) displacement: Vector3<f64>,
    /// The squared distance (L²).
    pub(crate) distance_squared: f64,
    /// Its place in the index.
    pub(crate) place: u32,
    /// The number of its image among the index's shifts.
    pub(crate) shift: u32,
}

/// A subtree of the index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subtree {
    /// The squared distance of its box from whoever looks (L²).
    pub(crate) gap_squared: f64,
    /// Its node.
    pub(crate) node: u32,
    /// The number of its image among the index's shifts.
    pub(crate) shift: u32,
}

impl Subtree {
    /// All sites, in the image of a number.
    #[inline]
    pub(crate) fn whole(shift: usize) -> Self {
        Self {
            gap_squared: 0.0,
            node: 1,
            shift: shift as u32,
        }
    }

    /// The children, the nearer one first.
    #[inline]
    pub(crate) fn children(&self, index: &SiteIndex, here: &Point3<f64>) -> [Self; 2] {
        let gaps = index.gaps_squared(self.node, here);
        let child = |side: u32| Self {
            gap_squared: gaps[side as usize],
            node: 2 * self.node + side,
            shift: self.shift,
        };
        let far = u32::from(gaps[0] <= gaps[1]);
        [child(1 - far), child(far)]
    }
}

impl Candidate {
    /// The image of the site in `place`, moved `by`, as seen from `here`.
    #[inline]
    #[must_use]
    pub(crate) fn new(
        index: &SiteIndex,
        here: &Point3<f64>,
        (place, shift): (usize, u32),
        by: &Vector3<f64>,
    ) -> Self {
        let displacement = index.position(place) - here + by;
        Self {
            displacement,
            distance_squared: displacement.norm_squared(),
            place: place as u32,
            shift,
        }
    }

    /// What lies beyond a facet towards it.
    pub(crate) fn label(&self, index: &SiteIndex) -> Label {
        let beyond = FacetKind::Neighbor {
            site: index.site(self.place as usize),
            image: index.shifts()[self.shift as usize].image,
        };
        beyond.label()
    }
}
