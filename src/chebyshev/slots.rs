//! Preparing a piece straight from the fixed slots in which it was cut.
//!
//! What it comes to is the same, to the bit, as by way of a polyhedron. Which planes have facets, and
//! which edges lead upward, is what a processor cannot foresee: so all are listed, and those that are
//! not wanted overwritten.

use crate::chebyshev::integrand::{EdgeConstants, FacetConstants, Integrand};
use crate::chebyshev::sight::Sight;
use crate::geometry::compact::{Compact, EDGES, PLANES, SLOTS, slots};

/// The number of a plane without a facet, until facets are numbered.
const UNSEEN: u8 = u8::MAX;

impl Integrand {
    /// Prepares a convex piece of density 1, keeping the memory of the piece before.
    pub fn assign_compact(&mut self, piece: &Compact) {
        self.density = None;
        let mut lists = Lists::default();
        lists.fill(piece);
        self.vertices.clear();
        let slots = lists.slots.listed().iter();
        self.vertices.extend(slots.map(|&slot| {
            let slot = usize::from(slot) % SLOTS;
            Sight::new(piece.x[slot], piece.y[slot], piece.z[slot])
        }));
        let planes = lists.planes.listed();
        self.facets.clear();
        let facets = planes
            .iter()
            .map(|&plane| &piece.planes[usize::from(plane)]);
        self.facets.extend(facets.map(FacetConstants::new));
        self.labels.clear();
        let labels = planes.iter().map(|&plane| piece.labels[usize::from(plane)]);
        self.labels.extend(labels);
        let (mut six_volumes, facets) = (0.0, &self.facets);
        self.edges.clear();
        self.edges.extend(lists.edges.listed().iter().map(|&edge| {
            let constants = lists.edge(piece, facets, usize::from(edge));
            six_volumes += constants.six_volumes(facets);
            constants
        }));
        self.volume = six_volumes / 6.0;
    }
}

/// Some bytes.
struct List {
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

    fn listed(&self) -> &[u8] {
        &self.bytes[..self.count]
    }
}

/// What is in use, and what it is called where all is.
struct Lists {
    slots: List,
    planes: List,
    /// The edges that lead to a slot of higher number.
    edges: List,
    /// Per slot: its vertex.
    vertices: [u8; SLOTS],
    /// Per plane: its facet.
    facets: [u8; PLANES],
}

impl Default for Lists {
    fn default() -> Self {
        Self {
            slots: List::default(),
            planes: List::default(),
            edges: List::default(),
            vertices: [0; SLOTS],
            facets: [UNSEEN; PLANES],
        }
    }
}

impl Lists {
    fn fill(&mut self, piece: &Compact) {
        for slot in slots(piece.alive) {
            self.vertices[slot] = self.slots.count as u8;
            self.slots.push_if(slot as u8, true);
            for edge in 4 * slot..4 * slot + 3 {
                self.facets[usize::from(piece.facets[edge])] = 0;
                self.edges
                    .push_if(edge as u8, usize::from(piece.twins[edge]) > edge);
            }
        }
        for (plane, number) in self.facets.iter_mut().enumerate().take(piece.planes.len()) {
            let is_seen = *number != UNSEEN;
            *number = self.planes.count as u8;
            self.planes.push_if(plane as u8, is_seen);
        }
    }

    /// The constants of an edge that leaves its slot.
    #[inline(always)]
    fn edge(&self, piece: &Compact, facets: &[FacetConstants], edge: usize) -> EdgeConstants {
        let ends = [edge / 4, usize::from(piece.twins[edge % EDGES] / 4)];
        let sides = [(edge + 1) % EDGES, edge % EDGES];
        let [left, right] = sides.map(|side| self.facets[usize::from(piece.facets[side])]);
        let [a, b] = ends.map(|slot| piece.vertex(slot % SLOTS));
        let [from, to] = ends.map(|slot| self.vertices[slot % SLOTS]);
        EdgeConstants::new(
            [from, to].map(u32::from),
            [left, right].map(u32::from),
            [a, b],
            facets,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::compact_clip::CompactScratch;
    use crate::geometry::half_space::HalfSpace;
    use crate::geometry::polyhedron::Polyhedron;
    use nalgebra::{Point3, Vector3};

    #[test]
    fn slots_give_the_integrand_of_the_polyhedron() {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut compact = Compact::default();
        assert!(compact.assign(&Polyhedron::cuboid(&bounds, [1, 2, 3, 4, 5, 6])));
        let (mut straight, mut polyhedron) = (Integrand::default(), Polyhedron::default());
        for number in 0..40 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let bisector = HalfSpace::bisector(away.normalize() * (1.8 - 0.02 * turn));
            let scratch = &mut CompactScratch::default();
            compact
                .clip(&bisector, || 7 + number as u64, scratch)
                .unwrap();
            straight.assign_compact(&compact);
            compact.write(&mut polyhedron);
            let detour = Integrand::new(&polyhedron);
            assert_eq!(format!("{straight:?}"), format!("{detour:?}"));
        }
        assert!(polyhedron.planes.len() < 46 && straight.volume() > 0.0);
    }
}
