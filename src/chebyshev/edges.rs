//! Edges in blocks of four, for a processor to work on together.

use crate::geometry::compact::BLOCK;
use crate::geometry::faceted::Edge;

/// Fills the last block. Between a vertex and itself there is no area.
pub(crate) const NONE: Edge = Edge {
    from: 0,
    to: 0,
    left: 0,
    right: 0,
};

/// A list of edges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Edges {
    /// Whole blocks.
    list: Vec<Edge>,
}

impl Edges {
    /// Becomes a list of edges.
    #[inline(always)]
    pub(crate) fn assign(&mut self, edges: impl Iterator<Item = Edge>) {
        self.list.clear();
        edges.for_each(|edge| self.list.push(edge));
        let whole = self.list.len().next_multiple_of(BLOCK);
        self.list.resize(whole, NONE);
    }

    /// All of them in blocks, the last one filled up with edges without length.
    #[inline]
    pub(crate) fn blocks(&self) -> &[[Edge; BLOCK]] {
        self.list.as_chunks().0
    }
}
