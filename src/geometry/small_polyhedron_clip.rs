//! Clipping a [`SmallPolyhedron`] by a half-space: the algorithm of [`clip`](crate::geometry::clip), with masks.
//!
//! The tolerance policy is the same: no epsilon, and a flood where rounding alone decides. Branches
//! on geometry are mispredicted, so every entry of a list is written, and the list's length grows by
//! the condition.

use wide::f64x4;

use crate::arrays::MapEach;
use crate::geometry::clip::Clip;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::small_polyhedron::{
    BLOCK, EDGES, PLANES, ROW, SLOTS, SmallPolyhedron, blocks, slots,
};

/// The new vertices do not fit into the fixed slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Full;

/// The memory of [`SmallPolyhedron::clip`].
#[derive(Clone, Debug)]
pub struct SmallClipScratch {
    /// Per slot: offset − normal · vertex, negative where a vertex is cut.
    slack: [f64; SLOTS],
    /// The crossings: edges from a kept to a cut vertex, as they leave the cut one.
    edges: [u8; EDGES],
    /// Per facet: the crossing in which its counter-clockwise boundary leaves the half-space. Entries of
    /// earlier clips are recognized by the facet on their left. The second half takes the entries of
    /// edges that are no crossings.
    exit: [u8; 2 * PLANES],
}

impl Default for SmallClipScratch {
    fn default() -> Self {
        Self {
            slack: [0.0; SLOTS],
            edges: [0; EDGES],
            exit: [0; 2 * PLANES],
        }
    }
}

impl SmallPolyhedron {
    /// Clips by `half_space`; the new facet carries the label, which is made only then.
    ///
    /// # Errors
    /// When the new vertices do not fit: the polyhedron then is as before.
    #[inline]
    pub fn clip(
        &mut self,
        half_space: &HalfSpace,
        label: impl FnOnce() -> Label,
        scratch: &mut SmallClipScratch,
    ) -> Result<Clip, Full> {
        let cut = self.classify(half_space, scratch);
        if cut == 0 {
            return Ok(Clip::Unchanged);
        }
        if cut == self.alive {
            self.clear();
            return Ok(Clip::Emptied);
        }
        self.cut(cut, half_space, label(), scratch)?;
        Ok(Clip::Cut)
    }

    /// Computes all slacks and returns the slots where they are negative.
    #[inline]
    fn classify(&self, half_space: &HalfSpace, scratch: &mut SmallClipScratch) -> u64 {
        let [a, b, c] = [0, 1, 2].map_each(|axis| f64x4::splat(half_space.normal[axis]));
        let offset = f64x4::splat(half_space.offset);
        let [x, y, z] = [&self.x, &self.y, &self.z].map_each(|all| all.as_chunks::<ROW>().0);
        let slack = scratch.slack.as_chunks_mut::<ROW>().0;
        let mut cut = 0;
        for row in 0..self.row_count() {
            let [x, y, z] = [x[row], y[row], z[row]].map_each(|all| blocks(&all));
            for block in 0..ROW / BLOCK {
                let slacks = offset - (a * x[block] + b * y[block] + c * z[block]);
                slack[row][BLOCK * block..][..BLOCK].copy_from_slice(&slacks.to_array());
                cut |= u64::from(slacks.to_bitmask()) << (ROW * row + BLOCK * block);
            }
        }
        cut & self.alive
    }

    #[inline(never)]
    fn cut(
        &mut self,
        mut cut: u64,
        half_space: &HalfSpace,
        label: Label,
        scratch: &mut SmallClipScratch,
    ) -> Result<(), Full> {
        let mut count = self.find_crossings(cut, scratch)?;
        let mut added = self.join(count, scratch);
        if added == 0 {
            self.undo_join(count, scratch);
            cut = self.repair(cut, scratch);
            count = self.find_crossings(cut, scratch)?;
            added = self.join(count, scratch);
            debug_assert!(added != 0, "{self:?}");
        }
        self.planes.push(*half_space);
        self.labels.push(label);
        self.alive = self.alive & !cut | added;
        Ok(())
    }

    /// Lists the crossings and enters each at the facet on its left; the cut vertices lose their
    /// distances.
    #[inline]
    fn find_crossings(&mut self, cut: u64, scratch: &mut SmallClipScratch) -> Result<usize, Full> {
        let mut count = 0;
        for slot in slots(cut) {
            self.square[slot] = 0.0;
            for edge in 4 * slot..4 * slot + 3 {
                let is_inner = cut >> (self.twins[edge] / 4) & 1;
                // The edge runs from the kept to the cut vertex: its sides are those of the opposite half-edge.
                let left = usize::from(self.facets[edge]) | (PLANES * is_inner as usize);
                scratch.edges[count % EDGES] = edge as u8;
                scratch.exit[left] = count as u8;
                count += 1 - is_inner as usize;
            }
        }
        if count > self.alive.count_zeros() as usize || self.planes.len() == PLANES {
            self.measure();
            return Err(Full);
        }
        Ok(count)
    }

    /// Adds a vertex at every crossing, in their order around the new facet, and returns their slots:
    /// none if the crossings, each followed by the next one around, are not a single cycle.
    #[inline]
    fn join(&mut self, count: usize, scratch: &SmallClipScratch) -> u64 {
        let facet = self.planes.len() as u8;
        let mut free = !self.alive;
        let first = free.trailing_zeros() as u8;
        let (mut number, mut place, mut last) = (0_u8, first, first);
        for step in 1..=count {
            let edge = scratch.edges[usize::from(number)];
            let right = self.facets[(usize::from(edge) + 1) % EDGES];
            number = scratch.exit[usize::from(right)];
            free &= free - 1;
            let is_last = number == 0;
            // Not used after the last crossing.
            let next = (free.trailing_zeros() as usize % SLOTS) as u8;
            let following = if is_last { first } else { next };
            self.add_vertex(place, edge, scratch);
            let at = 4 * (usize::from(place) % SLOTS);
            let left = self.facets[usize::from(edge)];
            self.facets[at..at + 4].copy_from_slice(&[right, facet, left, right]);
            // Edge 0 of a new vertex leads to the following one, whose edge 1 leads back.
            let back = self.twins[usize::from(edge)];
            self.twins[at..at + 4].copy_from_slice(&[4 * following + 1, 4 * last, back, 0]);
            self.twins[usize::from(back)] = 4 * place + 2;
            let follows = self.facets[usize::from(scratch.edges[usize::from(number)])] == right;
            if !follows || usize::from(number) >= count {
                return 0;
            }
            if is_last {
                self.twins[(4 * usize::from(first) + 1) % EDGES] = 4 * place;
                return if step == count {
                    !self.alive & !free
                } else {
                    0
                };
            }
            (last, place) = (place, following);
        }
        0
    }

    /// Adds the vertex in which an edge that leaves a cut vertex crosses the plane.
    #[inline]
    fn add_vertex(&mut self, place: u8, edge: u8, scratch: &SmallClipScratch) {
        let back = self.twins[usize::from(edge)];
        let (cut, kept) = (usize::from(edge / 4), usize::from(back / 4));
        let inner = scratch.slack[kept];
        let share = inner / (inner - scratch.slack[cut]);
        let along = |all: &[f64; SLOTS]| all[kept] + (all[cut] - all[kept]) * share;
        let [x, y, z] = [along(&self.x), along(&self.y), along(&self.z)];
        let slot = usize::from(place) % SLOTS;
        (self.x[slot], self.y[slot], self.z[slot]) = (x, y, z);
        self.square[slot] = x * x + y * y + z * z;
    }

    /// Restores the edges of the vertices in use after an attempt to join that failed.
    #[cold]
    fn undo_join(&mut self, count: usize, scratch: &SmallClipScratch) {
        for &edge in &scratch.edges[..count] {
            let back = self.twins[usize::from(edge)];
            self.twins[usize::from(back)] = edge;
        }
        self.measure();
    }

    /// Makes the cut vertices one connected part with a connected rest, and returns them.
    #[cold]
    fn repair(&self, cut: u64, scratch: &mut SmallClipScratch) -> u64 {
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
}
