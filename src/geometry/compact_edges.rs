//! The edges of a [`Compact`], one by one.
//!
//! Which end of an edge has the higher number is what a processor cannot foresee: so all edges are
//! compared with their twins at once, and sets of bits tell.

use wide::u8x32;

use crate::geometry::compact::{Compact, EDGES, SLOTS, slots};

/// Edges compared with their twins at once.
const LANES: usize = 32;

/// Slots the edges of which, and the unused bytes between, are one set of bits.
const SLOTS_PER_SET: usize = 2 * LANES / 4;

/// The numbers of all edges.
static NUMBERS: [[u8; LANES]; EDGES / LANES] = numbers();

const fn numbers() -> [[u8; LANES]; EDGES / LANES] {
    let mut all = [[0; LANES]; EDGES / LANES];
    let mut edge = 0;
    while edge < EDGES {
        all[edge / LANES][edge % LANES] = edge as u8;
        edge += 1;
    }
    all
}

impl Compact {
    /// The edges that lead to a slot of higher number, in ascending order.
    #[inline]
    pub(crate) fn upward(&self) -> impl Iterator<Item = usize> {
        let rows = self.twins.as_chunks::<LANES>().0.as_chunks::<2>().0.iter();
        let rows = rows.zip(NUMBERS.as_chunks::<2>().0).enumerate();
        let used = SLOTS - self.alive.leading_zeros() as usize;
        let rows = rows.take(used.div_ceil(SLOTS_PER_SET));
        rows.flat_map(move |(row, (twins, numbers))| {
            let [low, high] = [0, 1].map(|half| {
                let is_upward = u8x32::new(twins[half]).simd_gt(u8x32::new(numbers[half]));
                u64::from(is_upward.to_bitmask())
            });
            let alive = edges_of((self.alive >> (row * SLOTS_PER_SET)) as u16);
            slots((low | high << LANES) & alive).map(move |bit| row * 2 * LANES + bit)
        })
    }
}

/// The edges that leave some slots.
#[inline]
fn edges_of(slots: u16) -> u64 {
    let spread = |bits: u64, by: u32, kept: u64| (bits | bits << by) & kept;
    let bits = spread(u64::from(slots), 24, 0x0000_00ff_0000_00ff);
    let bits = spread(bits, 12, 0x000f_000f_000f_000f);
    let bits = spread(bits, 6, 0x0303_0303_0303_0303);
    7 * spread(bits, 3, 0x1111_1111_1111_1111)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_leave_their_slots() {
        for slots in [0, 1, 0x8000, 0x5a3c, 0xffff] {
            let edges = edges_of(slots);
            for edge in 0..64 {
                let leaves = edge % 4 < 3 && slots >> (edge / 4) & 1 == 1;
                assert_eq!(edges >> edge & 1 == 1, leaves, "{slots:x} {edge}");
            }
        }
    }
}
