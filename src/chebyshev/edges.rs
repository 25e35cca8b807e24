//! Edges in blocks of four, for a processor to work on together.

use std::fmt;

use crate::geometry::brep::Edge;
use crate::geometry::small_polyhedron::BLOCK;

/// Fills the last block. Between a vertex and itself there is no area.
pub(crate) const NONE: Edge = Edge {
    from: 0,
    to: 0,
    left: 0,
    right: 0,
};

/// A list of edges.
#[derive(Clone, Default)]
pub(crate) struct Edges {
    /// Memory for them.
    list: Vec<Edge>,
    /// How much of it is used: whole blocks.
    used: usize,
}

impl Edges {
    /// Becomes a list of at most `most` edges.
    #[inline(always)]
    pub(crate) fn assign(&mut self, edges: impl Iterator<Item = Edge>, most: usize) {
        let room = most.next_multiple_of(BLOCK);
        if self.list.len() < room {
            self.list.resize(room, NONE);
        }
        let (list, mut count) = (self.list.as_mut_slice(), 0);
        edges.for_each(|edge| {
            list[count] = edge;
            count += 1;
        });
        self.used = count.next_multiple_of(BLOCK);
        list[count..self.used].fill(NONE);
    }

    /// All of them in blocks, the last one filled up with edges without length.
    #[inline]
    pub(crate) fn blocks(&self) -> &[[Edge; BLOCK]] {
        self.list[..self.used].as_chunks().0
    }
}

impl fmt::Debug for Edges {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_list().entries(self.blocks()).finish()
    }
}
