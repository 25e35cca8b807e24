//! The identity of a vertex: the sites and walls whose planes meet in it.
//!
//! A vertex of a cell lies on three of its facets. With the cell's own site these are four
//! generators (sites, images of sites, walls), and every other cell at the vertex names the same
//! four. Across a periodic side it names other images; so a key is normalized: its least generator is
//! a site, and that site stands at image zero.

use nalgebra::Vector3;

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;

/// A displacement by whole periods along each axis.
pub(crate) type Shift = [i16; 3];

/// No displacement.
pub(crate) const NO_SHIFT: Shift = [0; 3];

/// The displacement (L) of a shift by whole periods.
#[must_use]
pub(crate) fn displacement(shift: Shift, periods: &Vector3<f64>) -> Vector3<f64> {
    Vector3::from(shift.map(f64::from)).component_mul(periods)
}

/// One shift after the other.
#[must_use]
pub(crate) fn sum(one: Shift, other: Shift) -> Shift {
    [0, 1, 2].map(|axis| one[axis] + other[axis])
}

/// The shift from `other` to `one`.
#[must_use]
pub(crate) fn difference(one: Shift, other: Shift) -> Shift {
    [0, 1, 2].map(|axis| one[axis] - other[axis])
}

/// Marks walls, so that they come after all sites.
const WALL: u64 = 1 << 63;

/// Marks what is neither site nor wall: the cell's start, and places of a key that are not used.
const NOTHING: u64 = u64::MAX;

/// Image numbers are stored with this added to them, so that they sort like numbers with signs.
const BIAS: i16 = 128;

/// The generators of a vertex in ascending order: a site in the bits above 24 and its image in the
/// three bytes below, or a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct VertexKey([u64; 4]);

impl VertexKey {
    /// The key of the vertex in which three facets of the cell of `site` meet, and the image at which
    /// that cell sees the key's first site.
    #[must_use]
    pub(crate) fn new(site: u32, facets: [Label; 3]) -> (Self, Shift) {
        let own = FacetKind::Neighbor {
            site,
            image: [0; 3],
        };
        let mut generators = [own.label(), facets[0], facets[1], facets[2]].map(generator);
        generators.sort_unstable();
        let shift = image_of(generators[0]);
        let is_site = |generator: u64| generator & WALL == 0;
        let normalized = |generator: u64| match is_site(generator) && shift != NO_SHIFT {
            true => moved(generator, shift),
            false => generator,
        };
        (Self(generators.map(normalized)), shift)
    }

    /// How many sites and images have a cell at the vertex.
    #[must_use]
    pub(crate) fn site_count(&self) -> usize {
        self.0
            .iter()
            .filter(|&generator| generator & WALL == 0)
            .count()
    }

    /// How many walls meet in the vertex.
    #[must_use]
    pub(crate) fn wall_count(&self) -> u8 {
        let is_wall = |&generator: &u64| generator & WALL != 0 && generator != NOTHING;
        self.0
            .map(|generator| u8::from(is_wall(&generator)))
            .iter()
            .sum()
    }
}

/// The generator that a facet's label names.
fn generator(label: Label) -> u64 {
    match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => {
            let byte = |axis: usize| (i16::from(image[axis]) + BIAS) as u64;
            u64::from(site) << 24 | byte(0) << 16 | byte(1) << 8 | byte(2)
        }
        FacetKind::Wall(number) => WALL | u64::from(number),
        FacetKind::Inner => NOTHING,
    }
}

/// The image of a site.
fn image_of(generator: u64) -> Shift {
    [16, 8, 0].map(|bits| (generator >> bits & 0xff) as i16 - BIAS)
}

/// A site as it is seen from where `by` is image zero.
fn moved(generator: u64, by: Shift) -> u64 {
    let image = image_of(generator);
    let byte = |axis: usize| ((image[axis] - by[axis] + BIAS) & 0xff) as u64;
    generator & !0xff_ffff | byte(0) << 16 | byte(1) << 8 | byte(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn site(site: u32, image: [i8; 3]) -> Label {
        FacetKind::Neighbor { site, image }.label()
    }

    #[test]
    fn all_cells_at_a_vertex_give_it_the_same_key() {
        let wall = FacetKind::Wall(3).label();
        let seen = [
            VertexKey::new(7, [site(2, [0; 3]), wall, site(9, [0; 3])]),
            VertexKey::new(2, [site(9, [0; 3]), site(7, [0; 3]), wall]),
            VertexKey::new(9, [wall, site(7, [0; 3]), site(2, [0; 3])]),
        ];
        assert!(seen.iter().all(|other| *other == seen[0]));
        assert_eq!(seen[0].0.wall_count(), 1);
        assert_eq!(seen[0].1, NO_SHIFT);
    }

    #[test]
    fn images_are_counted_from_the_first_site() {
        // Site 5 sees site 1 one period down along x, and its own image one period up.
        let (one, shift) = VertexKey::new(
            5,
            [site(1, [-1, 0, 0]), site(5, [1, 0, 0]), site(8, [0, 1, 0])],
        );
        assert_eq!(shift, [-1, 0, 0]);
        // The same vertex as site 1 sees it: everything one period up.
        let (other, shift) = VertexKey::new(
            1,
            [site(5, [1, 0, 0]), site(5, [2, 0, 0]), site(8, [1, 1, 0])],
        );
        assert_eq!((one, shift), (other, NO_SHIFT));
    }
}
