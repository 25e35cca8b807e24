//! How carried sites and their images are numbered.

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;

/// The images within one period to either side.
pub(crate) const IMAGES: usize = 27;

/// In place of the number of an image: the facet is a wall.
const WALL: u8 = u8::MAX;

/// What lies beyond a facet, in the numbers of the carried sites.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Across {
    /// The site's rank, or the number of a wall.
    pub(crate) number: u32,
    /// The number of the site's image, or [`WALL`].
    pub(crate) image: u8,
}

impl Across {
    /// The site's rank and the number of its image, if it is one.
    #[inline]
    pub(crate) fn site(self) -> Option<(u32, u8)> {
        (self.image != WALL).then_some((self.number, self.image))
    }

    /// The site's rank, if it is one.
    pub(crate) fn rank(self) -> Option<u32> {
        self.site().map(|(rank, _)| rank)
    }
}

/// How sites are numbered where they are carried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ranks<'a> {
    /// Per rank: the site.
    pub(crate) sites: &'a [u32],
    /// Per site: the rank.
    pub(crate) ranks: &'a [u32],
}

impl Ranks<'_> {
    /// What the label stands for.
    pub(crate) fn across(&self, label: Label) -> Across {
        match FacetKind::of(label) {
            FacetKind::Neighbor { site, image } => Across {
                number: self.ranks[site as usize],
                image: image_number(image),
            },
            FacetKind::Wall(_) | FacetKind::Inner => Across {
                number: label as u32,
                image: WALL,
            },
        }
    }

    /// The label that stands for it.
    #[inline]
    pub(crate) fn label(&self, across: Across) -> Label {
        match across.site() {
            Some((rank, image)) => {
                OF_SITE_0[usize::from(image) % IMAGES] | Label::from(self.sites[rank as usize])
            }
            None => FacetKind::Wall(across.number).label(),
        }
    }
}

/// The number of an image within one period to either side.
fn image_number(image: [i8; 3]) -> u8 {
    let [x, y, z] = image.map(|copies| (copies + 1) as u8);
    x + 3 * y + 9 * z
}

/// The image with this number.
pub(crate) const fn image_of(number: u8) -> [i8; 3] {
    [
        (number % 3) as i8 - 1,
        (number / 3 % 3) as i8 - 1,
        (number / 9) as i8 - 1,
    ]
}

/// Per number of an image: the label of that image of site 0. Labels of other sites differ in the bits
/// that are zero here.
static OF_SITE_0: [Label; IMAGES] = labels_table();

const fn labels_table() -> [Label; IMAGES] {
    let mut table = [0; IMAGES];
    let mut number = 0;
    while number < IMAGES {
        let image = image_of(number as u8);
        table[number] = FacetKind::Neighbor { site: 0, image }.label();
        number += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_read_back() {
        for number in 0..IMAGES as u8 {
            assert_eq!(image_number(image_of(number)), number);
        }
    }
}
