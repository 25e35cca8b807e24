//! The frames in which cells measure distances.
//!
//! \[BL\] names individually oriented cells as future work. Cells are cut by bisectors of the
//! Euclidean distance, which no rotation changes, so a frame touches nothing but d∞: a cell's pieces
//! are turned into its frame, integrated there, and what comes out is turned back. Frames belong to
//! sites, not to places: while sites move, each keeps its own, and so the energy of all cells has an
//! exact gradient.

use nalgebra::Rotation3;

/// The rotation that takes the axes of a cell's frame to where they point in space.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Frames {
    /// The axes of space, for all cells.
    #[default]
    Axes,
    /// One frame for all cells.
    One(Rotation3<f64>),
    /// A frame for every site, in site order; sites beyond the end use the axes of space.
    PerSite(Vec<Rotation3<f64>>),
}

impl Frames {
    /// The frame of a site; none for the axes of space.
    #[must_use]
    pub fn of(&self, site: u32) -> Option<&Rotation3<f64>> {
        match self {
            Self::Axes => None,
            Self::One(frame) => Some(frame),
            Self::PerSite(frames) => frames.get(site as usize),
        }
    }
}
