//! Five sites whose cells change partners, as the cell that noticed tells the others.

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;
use crate::voronoi::corners::{Corners, Four};

/// Added to the number of a wall where it stands beside numbers of sites.
const WALL: u32 = 1 << 31;

/// An exchange of vertices between the cells of five sites, some of which may be walls instead.
///
/// A vertex is told by the one of the five that is not around it. Whether the vertex of all but the
/// teller is lost or gained, the teller does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Flip {
    /// Sites, and walls behind them ([`WALL`]), in ascending order.
    five: [u32; 5],
    /// The vertices that the teller has lost, as a set of bits.
    lost: u8,
    /// And those that it has gained.
    gained: u8,
}

/// What a cell makes of another's flip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Heard {
    /// It has the same vertices already.
    Known,
    /// It makes the flip as well.
    Followed,
    /// It sees nothing of the kind.
    Denied,
}

impl Flip {
    /// The flip by which the cell of a site has exchanged, among four of its facets, the corners of a
    /// view for the others; none where an image is among them, since labels tell images as they are
    /// seen from that very site.
    pub(crate) fn told(site: u32, four: &Four, view: u8) -> Option<Self> {
        let [a, b, c, d] = four.map(number);
        let of_four = [a?, b?, c?, d?];
        let [a, b, c, d] = of_four;
        let mut five = [a, b, c, d, number(site_label(site))?];
        five.sort_unstable();
        let (mut lost, mut gained) = (0, 0);
        for (place, one) in five.iter().enumerate() {
            if let Some(omitted) = of_four.iter().position(|other| other == one) {
                let was_there = view >> omitted & 1;
                lost |= was_there << place;
                gained |= (1 - was_there) << place;
            }
        }
        Some(Self { five, lost, gained })
    }

    /// Whether it is among the same five.
    pub(crate) fn is_among(&self, other: &Self) -> bool {
        self.five == other.five
    }

    /// Whether another one among the same five, told by another cell, is the same.
    pub(crate) fn agrees(&self, other: &Self) -> bool {
        let lost_and_gained = (self.lost & other.gained) | (self.gained & other.lost);
        self.is_among(other) && lost_and_gained == 0
    }

    /// Whether the cell of a site has told it.
    pub(crate) fn is_told_by(&self, site: u32) -> bool {
        let teller = (self.lost | self.gained).trailing_ones();
        self.five[teller as usize % 5] == site
    }

    /// The sites, walls left out.
    pub(crate) fn sites(&self) -> impl Iterator<Item = u32> {
        self.five.into_iter().filter(|&number| number < WALL)
    }

    /// Lets the cell of one of the sites follow, or compares its vertices if `is_right`.
    ///
    /// A cell has what it had and, since then, every flip that it told or followed: each exchanges what
    /// there is for what there is not. So cells that agreed before and have made the same flips agree.
    pub(crate) fn hear(&self, site: u32, corners: &mut Corners, is_right: bool) -> Heard {
        let Some(place) = self.five.iter().position(|&other| other == site) else {
            return Heard::Denied;
        };
        let four = [0, 1, 2, 3].map(|k| label(self.five[k + usize::from(k >= place)]));
        // The sets without the place of the cell itself.
        let among_four = |set: u8| {
            let below = (1 << place) - 1;
            set & below | set >> 1 & !below
        };
        let (lost, gained) = (among_four(self.lost), among_four(self.gained));
        let view = corners.view(&four) & (lost | gained);
        if is_right && view == gained {
            Heard::Known
        } else if !is_right && view == lost && corners.flip(&four).is_some() {
            Heard::Followed
        } else {
            Heard::Denied
        }
    }
}

fn site_label(site: u32) -> Label {
    let image = [0; 3];
    FacetKind::Neighbor { site, image }.label()
}

/// The number that stands for a site where it is itself, or for a wall.
fn number(label: Label) -> Option<u32> {
    match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => (image == [0; 3] && site < WALL).then_some(site),
        FacetKind::Wall(wall) => (wall < WALL).then_some(WALL + wall),
        FacetKind::Inner => None,
    }
}

fn label(number: u32) -> Label {
    if number < WALL {
        site_label(number)
    } else {
        FacetKind::Wall(number - WALL).label()
    }
}
