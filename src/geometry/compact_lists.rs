//! What of a [`Compact`]'s slots and planes is in use, and what it is called where all is.
//!
//! Which planes have facets is what a processor cannot foresee: so all are listed, and those that are
//! not wanted overwritten.

use crate::geometry::compact::{Compact, EDGES, PLANES, SLOTS, slots};

/// The number of a plane without a facet, until facets are numbered.
const UNSEEN: u8 = u8::MAX;

/// Some bytes.
pub(crate) struct List {
    bytes: [u8; EDGES],
    count: usize,
}

impl Default for List {
    fn default() -> Self {
        Self {
            bytes: [0; EDGES],
            count: 0,
        }
    }
}

impl List {
    /// Adds a byte, to be overwritten by the next if it is not wanted.
    #[inline(always)]
    fn push_if(&mut self, byte: u8, is_wanted: bool) {
        self.bytes[self.count % EDGES] = byte;
        self.count += usize::from(is_wanted);
    }

    /// All of them.
    pub(crate) fn listed(&self) -> &[u8] {
        &self.bytes[..self.count]
    }
}

/// What is in use, and what it is called where all is.
pub(crate) struct Lists {
    /// The slots in use, in ascending order.
    pub(crate) slots: List,
    /// The planes that have facets, in the order in which they were added.
    pub(crate) planes: List,
    /// Per slot in use: its vertex.
    pub(crate) vertices: [u8; SLOTS],
    /// Per plane that has one: its facet.
    pub(crate) facets: [u8; PLANES],
}

impl Default for Lists {
    fn default() -> Self {
        Self {
            slots: List::default(),
            planes: List::default(),
            vertices: [0; SLOTS],
            facets: [UNSEEN; PLANES],
        }
    }
}

impl Lists {
    /// Those of `piece`.
    #[inline]
    pub(crate) fn of(piece: &Compact) -> Self {
        let mut lists = Self::default();
        lists.fill(piece);
        lists
    }

    fn fill(&mut self, piece: &Compact) {
        for slot in slots(piece.alive) {
            self.vertices[slot] = self.slots.count as u8;
            self.slots.push_if(slot as u8, true);
            for edge in 4 * slot..4 * slot + 3 {
                self.facets[usize::from(piece.facets[edge])] = 0;
            }
        }
        for (plane, number) in self.facets.iter_mut().enumerate().take(piece.planes.len()) {
            let is_seen = *number != UNSEEN;
            *number = self.planes.count as u8;
            self.planes.push_if(plane as u8, is_seen);
        }
    }
}
