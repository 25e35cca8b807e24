//! Clipping a [`Compact`] polyhedron: the algorithm of [`clip`](crate::geometry::clip), with masks.
//!
//! The tolerance policy is the same: no epsilon, and a flood where rounding alone decides. Branches
//! on geometry are what a processor cannot foresee, so lists are written in full and their lengths
//! counted up by conditions.

use wide::f64x4;

use crate::geometry::clip::Clip;
use crate::geometry::compact::{BLOCK, Compact, EDGES, PLANES, SLOTS, slots};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;

/// There is no room for the new vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

/// The memory of [`Compact::clip`]: numbers by slot, then what is known of the crossings, the edges
/// from a kept to a cut vertex.
#[derive(Clone, Debug)]
pub struct CompactScratch {
    /// offset − normal · vertex: negative where a vertex is cut.
    slack: [f64; SLOTS],
    /// The edges as they leave the cut vertices.
    edges: [u8; EDGES],
    positions: [[f64; 3]; SLOTS],
    /// The edges as they leave the kept vertices.
    kept: [u8; SLOTS],
    /// The facets on their left and right, seen from the kept vertices.
    left: [u8; SLOTS],
    right: [u8; SLOTS],
    /// Per facet: the crossing in which its counter-clockwise walk leaves the half-space. What an
    /// earlier clip has left here is recognized by its left facet.
    exit: [u8; PLANES],
    /// The crossings around the new facet.
    ring: [u8; SLOTS],
    /// Where the new vertices of the ring go.
    places: [u8; SLOTS],
}

impl Default for CompactScratch {
    fn default() -> Self {
        Self {
            slack: [0.0; SLOTS],
            edges: [0; EDGES],
            positions: [[0.0; 3]; SLOTS],
            kept: [0; SLOTS],
            left: [0; SLOTS],
            right: [0; SLOTS],
            exit: [0; PLANES],
            ring: [0; SLOTS],
            places: [0; SLOTS],
        }
    }
}

impl Compact {
    /// Clips by `half_space`; the new facet carries the label, asked for only then.
    ///
    /// # Errors
    /// When there is no room: the polyhedron then is as before.
    #[inline]
    pub fn clip(
        &mut self,
        half_space: &HalfSpace,
        label: impl FnOnce() -> Label,
        scratch: &mut CompactScratch,
    ) -> Result<Clip, Full> {
        let cut = self.classify(half_space, scratch);
        if cut == 0 {
            return Ok(Clip::Unchanged);
        }
        if cut == self.alive {
            self.free(cut);
            return Ok(Clip::Emptied);
        }
        self.cut(cut, half_space, label(), scratch)?;
        Ok(Clip::Cut)
    }

    /// Computes all slacks and returns the slots where they are negative.
    #[inline]
    fn classify(&self, half_space: &HalfSpace, scratch: &mut CompactScratch) -> u64 {
        let [a, b, c] = [0, 1, 2].map(|axis| f64x4::splat(half_space.normal[axis]));
        let offset = f64x4::splat(half_space.offset);
        let [x, y, z] = [&self.x, &self.y, &self.z].map(|all| all.as_chunks::<BLOCK>().0);
        let slack = scratch.slack.as_chunks_mut::<BLOCK>().0;
        let mut cut = 0;
        for block in 0..self.block_count() {
            let [x, y, z] = [x, y, z].map(|all| f64x4::new(all[block]));
            let room = offset - (a * x + b * y + c * z);
            slack[block] = room.to_array();
            cut |= u64::from(room.to_bitmask()) << (BLOCK * block);
        }
        cut & self.alive
    }

    #[inline(never)]
    fn cut(
        &mut self,
        mut cut: u64,
        half_space: &HalfSpace,
        label: Label,
        scratch: &mut CompactScratch,
    ) -> Result<(), Full> {
        let mut count = self.find_crossings(cut, scratch)?;
        if !is_single_cycle(count, scratch) {
            cut = self.repair(cut, scratch);
            count = self.find_crossings(cut, scratch)?;
            let sound = is_single_cycle(count, scratch);
            debug_assert!(sound, "{self:?}");
        }
        let added = self.find_places(cut, count, scratch)?;
        let facet = self.planes.len() as u8;
        self.planes.push(*half_space);
        self.labels.push(label);
        self.join(facet, count, scratch);
        self.free(cut & !added);
        self.alive |= added;
        Ok(())
    }

    /// Lists the crossings and enters each at the facet on its left.
    #[inline]
    fn find_crossings(&self, cut: u64, scratch: &mut CompactScratch) -> Result<usize, Full> {
        let mut count = 0;
        for slot in slots(cut) {
            for edge in 4 * slot..4 * slot + 3 {
                scratch.edges[count % EDGES] = edge as u8;
                count += usize::from(cut >> (self.twins[edge] / 4) & 1 == 0);
            }
        }
        if count > SLOTS {
            return Err(Full);
        }
        for number in 0..count {
            let edge = scratch.edges[number];
            let back = self.twins[usize::from(edge)];
            let (cut, kept) = (usize::from(edge / 4), usize::from(back / 4));
            // The edge runs from the kept to the cut vertex: its sides are those of the way back.
            let left = self.facets[usize::from(edge)];
            scratch.left[number] = left;
            scratch.right[number] = self.facets[(usize::from(edge) + 1) % EDGES];
            scratch.kept[number] = back;
            scratch.exit[usize::from(left)] = number as u8;
            let inner = scratch.slack[kept];
            let share = inner / (inner - scratch.slack[cut]);
            let along = |all: &[f64; SLOTS]| all[kept] + (all[cut] - all[kept]) * share;
            scratch.positions[number] = [along(&self.x), along(&self.y), along(&self.z)];
        }
        Ok(count)
    }

    /// Makes the cut vertices one connected part with a connected rest, and returns them.
    #[cold]
    fn repair(&self, cut: u64, scratch: &mut CompactScratch) -> u64 {
        let deepest = |mask: u64, sign: f64, slack: &[f64; SLOTS]| {
            slots(mask).reduce(|best, slot| {
                let deeper = sign * slack[slot] > sign * slack[best];
                if deeper { slot } else { best }
            })
        };
        let first = deepest(cut, -1.0, &scratch.slack);
        let reached = first.map_or(0, |first| self.flood(first, cut));
        for slot in slots(cut & !reached) {
            scratch.slack[slot] = 0.0;
        }
        let rest = self.alive & !reached;
        let first = deepest(rest, 1.0, &scratch.slack);
        let kept = first.map_or(0, |first| self.flood(first, rest));
        for slot in slots(rest & !kept) {
            scratch.slack[slot] = -f64::MIN_POSITIVE;
        }
        self.alive & !kept
    }

    /// The slots of a mask that are joined to `first`.
    fn flood(&self, first: usize, mask: u64) -> u64 {
        let mut reached = 1 << first;
        let mut edge = reached;
        while edge != 0 {
            let ends = slots(edge).fold(0, |ends, slot| {
                let twins = &self.twins[4 * slot..][..3];
                twins.iter().fold(ends, |ends, twin| ends | 1 << (twin / 4))
            });
            edge = ends & mask & !reached;
            reached |= edge;
        }
        reached
    }

    /// Finds room for the new vertices, the lowest slots first, and returns these.
    #[inline]
    fn find_places(
        &self,
        cut: u64,
        count: usize,
        scratch: &mut CompactScratch,
    ) -> Result<u64, Full> {
        let free = cut | !self.alive;
        let mut room = free;
        for place in &mut scratch.places[..count] {
            if room == 0 {
                return Err(Full);
            }
            *place = room.trailing_zeros() as u8;
            room &= room - 1;
        }
        if self.planes.len() == PLANES {
            return Err(Full);
        }
        Ok(free & !room)
    }

    /// Puts a new vertex on every crossing and closes the ring.
    #[inline]
    fn join(&mut self, facet: u8, count: usize, scratch: &CompactScratch) {
        let mut last = scratch.places[count - 1];
        for step in 0..count {
            let number = usize::from(scratch.ring[step]) % SLOTS;
            let place = scratch.places[step];
            let following = scratch.places[if step + 1 < count { step + 1 } else { 0 }];
            let slot = usize::from(place) % SLOTS;
            let [x, y, z] = scratch.positions[number];
            (self.x[slot], self.y[slot], self.z[slot]) = (x, y, z);
            self.square[slot] = x * x + y * y + z * z;
            let (left, right, kept) = (
                scratch.left[number],
                scratch.right[number],
                scratch.kept[number],
            );
            let first = 4 * slot;
            self.facets[first..first + 4].copy_from_slice(&[right, facet, left, right]);
            // Edge 0 of a new vertex leads to the following one, whose edge 1 leads back.
            self.twins[first..first + 4].copy_from_slice(&[4 * following + 1, 4 * last, kept, 0]);
            self.twins[usize::from(kept)] = 4 * place + 2;
            last = place;
        }
    }
}

/// Whether the crossings, each followed by the next around the new facet, form one cycle.
#[inline]
fn is_single_cycle(count: usize, scratch: &mut CompactScratch) -> bool {
    let mut number = 0;
    for step in 0..count {
        scratch.ring[step] = number as u8;
        let right = scratch.right[number];
        number = usize::from(scratch.exit[usize::from(right)]) % SLOTS;
        let closed = number == 0 && step + 1 < count;
        if number >= count || scratch.left[number] != right || closed {
            return false;
        }
    }
    number == 0 && count > 0
}
