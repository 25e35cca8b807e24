//! The kinds of facets, and their encoding as labels.

use crate::arrays::MapEach;
use crate::geometry::label::Label;

/// What a facet of a cell or piece borders on.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Diagram, FacetKind};
///
/// let cube = Cuboid::unit();
/// let kinds = Diagram::new(&cube, &[[0.5; 3]])?.map_cells(|cell| {
///     cell.facets().iter().map(|facet| facet.kind).collect::<Vec<_>>()
/// })?;
/// assert!(kinds[0].iter().all(|kind| matches!(kind, FacetKind::Wall(_))));
/// # Ok::<(), chebloyd::DiagramError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum FacetKind {
    /// The cell of another site, or of an image of one.
    Neighbor {
        /// The neighbor's index.
        site: u32,
        /// Which periodic copy of it: its position is moved by `image[k]` periods along axis k.
        image: [i8; 3],
    },
    /// The outside of the domain, through the wall of this number.
    Wall(u32),
    /// Another piece of the same cell: neither wall nor bisector.
    Inner,
}

const WALL: u64 = 1 << 62;
const INNER: u64 = 2 << 62;

impl FacetKind {
    /// The label that stands for it.
    #[must_use]
    pub const fn label(self) -> Label {
        match self {
            Self::Neighbor { site, image } => {
                let [x, y, z] = [image[0] as u8, image[1] as u8, image[2] as u8];
                site as u64 | (x as u64) << 32 | (y as u64) << 40 | (z as u64) << 48
            }
            Self::Wall(number) => WALL | number as u64,
            Self::Inner => INNER,
        }
    }

    /// The kind that `label` stands for.
    #[must_use]
    pub fn of(label: Label) -> Self {
        match label & (3 << 62) {
            WALL => Self::Wall(label as u32),
            0 => Self::Neighbor {
                site: label as u32,
                image: [32, 40, 48].map_each(|shift| (label >> shift) as u8 as i8),
            },
            _ => Self::Inner,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_read_back() {
        let neighbor = |site, image| FacetKind::Neighbor { site, image };
        for kind in [
            neighbor(0, [0, 0, 0]),
            neighbor(u32::MAX, [-1, 1, -1]),
            FacetKind::Wall(7),
            FacetKind::Inner,
        ] {
            assert_eq!(FacetKind::of(kind.label()), kind);
        }
    }
}
