//! Preparing a piece straight from the fixed slots in which it was cut.
//!
//! What it comes to is the same, to the bit, as by way of a polyhedron.

use wide::u8x32;

use crate::chebyshev::chunks::Bits;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::sight::Sight;
use crate::geometry::compact::{Compact, EDGES, PLANES, SLOTS, slots};

/// Bytes of edges that are looked at together: those of [`SLOTS_PER_ROW`] slots.
const ROW: usize = 32;
const SLOTS_PER_ROW: usize = ROW / 4;

/// The number of a plane without a facet, until facets are numbered.
const UNSEEN: u8 = u8::MAX;

impl Integrand {
    /// Prepares a convex piece of density 1, keeping the memory of the piece before.
    pub fn assign_compact(&mut self, piece: &Compact) {
        self.density = None;
        let (mut numbers, mut used) = (Numbers::default(), [0; PLANES]);
        self.vertices.clear();
        let used_slots = numbers.count_vertices(piece, &mut used);
        self.vertices.extend(used_slots.iter().map(|&slot| {
            let slot = usize::from(slot) % SLOTS;
            Sight::new(piece.x[slot], piece.y[slot], piece.z[slot])
        }));
        let planes = numbers.count_facets(piece, &mut used);
        let planes = planes.iter().map(|&plane| usize::from(plane));
        self.assign_facets(planes.map(|plane| (&piece.planes[plane], &piece.labels[plane])));
        self.assign_slot_edges(piece, &numbers);
    }

    fn assign_slot_edges(&mut self, piece: &Compact, numbers: &Numbers) {
        self.edges.reserve(self.vertices.len() * 3 / 2);
        let mut six_volumes = 0.0;
        for (row, twins) in piece.twins.as_chunks::<ROW>().0.iter().enumerate() {
            let alive = (piece.alive >> (row * SLOTS_PER_ROW)) as u8;
            for byte in upward(twins, row, alive) {
                let edge = row * ROW + byte;
                let ends = [edge, usize::from(piece.twins[edge])];
                let sides = [(edge + 1) % EDGES, edge].map(|side| piece.facets[side]);
                six_volumes += self.push_edge(
                    ends.map(|end| u32::from(numbers.vertices[end / 4])),
                    sides.map(|plane| u32::from(numbers.facets[usize::from(plane)])),
                );
            }
        }
        self.volume = six_volumes / 6.0;
    }
}

/// What slots and planes are called where all are in use.
struct Numbers {
    /// Per slot: its vertex.
    vertices: [u8; SLOTS],
    /// Per plane: its facet.
    facets: [u8; PLANES],
}

impl Default for Numbers {
    fn default() -> Self {
        Self {
            vertices: [0; SLOTS],
            facets: [UNSEEN; PLANES],
        }
    }
}

impl Numbers {
    /// Numbers the vertices, marks the planes that have facets, and lists the slots in use.
    fn count_vertices<'a>(&mut self, piece: &Compact, used: &'a mut [u8; PLANES]) -> &'a [u8] {
        let mut count = 0;
        for slot in slots(piece.alive) {
            self.vertices[slot] = count as u8;
            used[count] = slot as u8;
            count += 1;
            for byte in 4 * slot..4 * slot + 3 {
                self.facets[usize::from(piece.facets[byte])] = 0;
            }
        }
        &used[..count]
    }

    /// Numbers the facets in the order of their planes, and lists these.
    ///
    /// Which planes have a facet is what a processor cannot foresee: all are listed, and those without
    /// one overwritten.
    fn count_facets<'a>(&mut self, piece: &Compact, used: &'a mut [u8; PLANES]) -> &'a [u8] {
        let mut count = 0;
        for (plane, number) in self.facets.iter_mut().enumerate().take(piece.planes.len()) {
            let is_seen = *number != UNSEEN;
            used[count % PLANES] = plane as u8;
            *number = count as u8;
            count += usize::from(is_seen);
        }
        &used[..count]
    }
}

/// The bytes, within a row, of the edges that lead to a slot of higher number.
#[inline]
fn upward(twins: &[u8; ROW], row: usize, alive: u8) -> Bits {
    const OWN: [u8; ROW] = own_bytes();
    let own = u8x32::new(OWN) + u8x32::splat((row * ROW) as u8);
    let upward = u8x32::new(*twins).simd_gt(own).to_bitmask();
    Bits::of(u64::from(upward & edges_of(alive)))
}

const fn own_bytes() -> [u8; ROW] {
    let mut bytes = [0; ROW];
    let mut byte = 0;
    while byte < ROW {
        bytes[byte] = byte as u8;
        byte += 1;
    }
    bytes
}

/// The bytes of the three edges of each slot of a set.
#[inline]
fn edges_of(alive: u8) -> u32 {
    // Bit k goes to bit 4 k.
    let mut spread = u32::from(alive);
    spread = (spread | spread << 12) & 0x000f_000f;
    spread = (spread | spread << 6) & 0x0303_0303;
    spread = (spread | spread << 3) & 0x1111_1111;
    spread * 0b111
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
    fn sets_of_slots_are_spread_over_their_edges() {
        for alive in 0..=u8::MAX {
            let set = edges_of(alive);
            for bit in 0..32 {
                let is_used = bit % 4 < 3 && alive >> (bit / 4) & 1 == 1;
                assert_eq!(set >> bit & 1 == 1, is_used, "{alive} {bit}");
            }
        }
    }

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
