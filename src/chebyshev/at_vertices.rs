//! Which facets meet at a vertex.

use std::fmt;

use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::Lists;
use crate::geometry::small_polyhedron::{SLOTS, SmallPolyhedron};

/// The three facets at each vertex of a convex piece, as they are found in its slots: what is rarely
/// looked up is not worth being renamed.
#[derive(Clone, Default)]
pub(crate) struct AtVertices {
    /// By vertex three planes, after a byte without meaning.
    planes: Vec<[u8; 4]>,
    /// By plane its facet; empty where planes are facets.
    facets: Vec<u8>,
}

impl AtVertices {
    /// Becomes empty.
    pub(crate) fn clear(&mut self) {
        self.planes.clear();
        self.facets.clear();
    }

    /// Becomes those of a piece in which slots are vertices and planes are facets.
    pub(crate) fn assign_dense(&mut self, piece: &SmallPolyhedron, count: usize) {
        self.clear();
        // To copy all of them takes no branch.
        self.planes.extend_from_slice(piece.facets.as_chunks().0);
        self.planes.truncate(count);
    }

    /// Becomes those of a piece in which `lists` tell what is in use.
    pub(crate) fn assign_sparse(&mut self, piece: &SmallPolyhedron, lists: &Lists) {
        self.clear();
        let planes = piece.facets.as_chunks().0;
        let slots = lists.slots.listed().iter();
        self.planes
            .extend(slots.map(|&slot| planes[usize::from(slot) % SLOTS]));
        self.facets
            .extend_from_slice(&lists.facets[..piece.planes.len()]);
    }

    /// Becomes those of a polyhedron, or empty where it has more facets than a byte tells apart.
    pub(crate) fn assign_polyhedron(&mut self, piece: &Polyhedron) {
        self.clear();
        if u8::try_from(piece.planes.len()).is_ok() {
            let all = piece.facets.iter();
            self.planes
                .extend(all.map(|&[a, b, c]| [0, a as u8, b as u8, c as u8]));
        }
    }

    /// Whether they are known, as they are for convex pieces.
    #[inline]
    pub(crate) fn are_known(&self) -> bool {
        !self.planes.is_empty()
    }

    /// The facets at a vertex, where they are known.
    pub(crate) fn facets(&self, vertex: usize) -> [usize; 3] {
        let [_, planes @ ..] = self.planes[vertex];
        let named = |plane: u8| *self.facets.get(usize::from(plane)).unwrap_or(&plane);
        planes.map(|plane| usize::from(named(plane)))
    }
}

impl fmt::Debug for AtVertices {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = (0..self.planes.len()).map(|vertex| self.facets(vertex));
        formatter.debug_list().entries(all).finish()
    }
}
