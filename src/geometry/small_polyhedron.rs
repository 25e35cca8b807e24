//! Convex polyhedra of at most 64 vertices in fixed slots, for fast repeated clipping.
//!
//! A cell has about 16 facets and 27 vertices, and twice as many are made while it is cut. Its vertices
//! are stored in 64 slots, a bit each: sets of vertices are masks, and no vertex is moved when others
//! are removed. What does not fit is left to [`Polyhedron`].
//!
//! # Convention
//!
//! As in a polyhedron, edge k of a vertex has facet k on its left and facet k + 2 on its right. Edge
//! k of slot s, as it leaves s, is the byte 4 s + k. `twins` holds its twin: the same edge as it
//! leaves its other end. `facets` holds facet k in byte 4 s + k + 1 and facet 2 once more in byte 4 s, so that
//! the facet right of edge e is `facets[e]` and the left one `facets[e + 1]`.

use nalgebra::Point3;
use wide::{f64x4, u8x32};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// Vertices at most: a mask has as many bits.
pub(crate) const SLOTS: usize = 64;

/// Bytes that number edges, one in four unused.
pub(crate) const EDGES: usize = 4 * SLOTS;

/// Planes at most, those that bound nothing any more included: their numbers are bytes.
pub(crate) const PLANES: usize = 256;

/// Slots handled at once.
pub(crate) const BLOCK: usize = 4;

/// Slots handled together: two blocks, so that loop counts vary less.
pub(crate) const ROW: usize = 2 * BLOCK;

/// A convex polyhedron of at most 64 vertices.
#[derive(Clone, Debug)]
pub struct SmallPolyhedron {
    pub(crate) x: [f64; SLOTS],
    pub(crate) y: [f64; SLOTS],
    pub(crate) z: [f64; SLOTS],
    /// Squared distances from the origin; zero in an empty slot.
    pub(crate) square: [f64; SLOTS],
    pub(crate) facets: [u8; EDGES],
    pub(crate) twins: [u8; EDGES],
    /// The slots in use.
    pub(crate) alive: u64,
    pub(crate) planes: Vec<HalfSpace>,
    pub(crate) labels: Vec<Label>,
    layout: Layout,
}

/// The facets and edges of the last polyhedron that was assigned, and the bytes that encode them: most
/// cells start from the same ones.
#[derive(Clone, Debug, Default)]
struct Layout {
    facets: Vec<[u32; 3]>,
    next: Vec<[u32; 3]>,
    /// Per vertex: the bytes of `facets` and of `twins`.
    bytes: Vec<[[u8; 4]; 2]>,
}

impl Default for SmallPolyhedron {
    fn default() -> Self {
        Self {
            x: [0.0; SLOTS],
            y: [0.0; SLOTS],
            z: [0.0; SLOTS],
            square: [0.0; SLOTS],
            facets: [0; EDGES],
            twins: [0; EDGES],
            alive: 0,
            planes: Vec::new(),
            labels: Vec::new(),
            layout: Layout::default(),
        }
    }
}

impl SmallPolyhedron {
    /// Becomes a copy of `other`; returns whether it fits. If it does not, this is empty.
    #[must_use]
    pub fn assign(&mut self, other: &Polyhedron) -> bool {
        self.clear();
        let count = other.vertex_count();
        if count == 0 || count > SLOTS || other.planes.len() > PLANES {
            return false;
        }
        self.layout.assign(other);
        let vertices = other.x.iter().zip(&other.y).zip(&other.z);
        for (slot, ((&x, &y), &z)) in vertices.enumerate().take(SLOTS) {
            (self.x[slot], self.y[slot], self.z[slot]) = (x, y, z);
            self.square[slot] = x * x + y * y + z * z;
        }
        let bytes = self.facets.as_chunks_mut().0.iter_mut();
        let bytes = bytes.zip(self.twins.as_chunks_mut().0);
        for ((facets, twins), layout) in bytes.zip(&self.layout.bytes) {
            [*facets, *twins] = *layout;
        }
        self.alive = u64::MAX >> (SLOTS - count);
        self.planes.extend_from_slice(&other.planes);
        self.labels.extend_from_slice(&other.labels);
        true
    }

    /// Makes `other` a copy of this, with the facets that have vertices.
    pub fn write(&self, other: &mut Polyhedron) {
        other.clear();
        let lists = Lists::of(self);
        let planes = lists.planes.numbers();
        let kept = planes.clone().map(|plane| self.planes[plane]);
        other.planes.extend(kept);
        other.labels.extend(planes.map(|plane| self.labels[plane]));
        let slots = lists.slots.numbers().map(|slot| slot % SLOTS);
        other.x.extend(slots.clone().map(|slot| self.x[slot]));
        other.y.extend(slots.clone().map(|slot| self.y[slot]));
        other.z.extend(slots.clone().map(|slot| self.z[slot]));
        let facet = |byte: usize| u32::from(lists.facets[usize::from(self.facets[byte])]);
        let end = |byte: usize| u32::from(lists.vertices[usize::from(self.twins[byte] / 4)]);
        let facets = slots
            .clone()
            .map(|slot| [1, 2, 3].map_each(|byte| facet(4 * slot + byte)));
        other.facets.extend(facets);
        let next = slots.map(|slot| [0, 1, 2].map_each(|byte| end(4 * slot + byte)));
        other.next.extend(next);
    }

    /// The greatest squared distance of a vertex from the origin (L²).
    #[must_use]
    pub fn radius_squared(&self) -> f64 {
        let rows = &self.square.as_chunks::<ROW>().0[..self.row_count()];
        let far = rows.iter().fold([f64x4::ZERO; 2], |far, row| {
            let [one, other] = blocks(row);
            [far[0].fast_max(one), far[1].fast_max(other)]
        });
        let [a, b, c, d] = far[0].fast_max(far[1]).to_array();
        let greater = |a: f64, b: f64| if a > b { a } else { b };
        greater(greater(a, b), greater(c, d))
    }

    /// The least axis-aligned box around the vertices and the origin.
    #[must_use]
    pub fn bounds_about_origin(&self) -> Bounds<3> {
        let axes = [&self.x, &self.y, &self.z].map_each(|all| all.as_chunks::<BLOCK>().0);
        let (mut min, mut max) = ([f64x4::ZERO; 3], [f64x4::ZERO; 3]);
        let squares = &self.square.as_chunks::<BLOCK>().0[..self.row_count() * (ROW / BLOCK)];
        for (block, square) in squares.iter().enumerate() {
            // Empty slots, and vertices at the origin, count as the origin.
            let is_away = f64x4::new(*square).simd_gt(f64x4::ZERO);
            for axis in 0..3 {
                let along = f64x4::new(axes[axis][block]) & is_away;
                min[axis] = min[axis].fast_min(along);
                max[axis] = max[axis].fast_max(along);
            }
        }
        let least = |lanes: f64x4| lanes.to_array().into_iter().fold(0.0, f64::min);
        let most = |lanes: f64x4| lanes.to_array().into_iter().fold(0.0, f64::max);
        Bounds {
            min: Point3::from(min.map_each(least)),
            max: Point3::from(max.map_each(most)),
        }
    }

    /// The slots in use whose vertices lie farther from the origin than the root of `square`.
    pub(crate) fn beyond(&self, square: f64) -> impl Iterator<Item = usize> + '_ {
        slots(self.alive).filter(move |&slot| self.square[slot] > square)
    }

    /// Whether the slots in use come first and every plane has a facet: then, by Euler's formula, there
    /// are V = 2 F − 4 vertices.
    pub(crate) fn is_dense(&self) -> bool {
        self.alive & self.alive.wrapping_add(1) == 0
            && self.alive.count_ones() as usize + 4 == 2 * self.planes.len()
    }

    /// How many rows hold all slots in use.
    pub(crate) fn row_count(&self) -> usize {
        (SLOTS - self.alive.leading_zeros() as usize).div_ceil(ROW)
    }

    /// Measures how far the vertices in use are from the origin.
    pub(crate) fn measure(&mut self) {
        for slot in 0..SLOTS {
            let [x, y, z] = [self.x[slot], self.y[slot], self.z[slot]];
            let is_alive = self.alive >> slot & 1 == 1;
            self.square[slot] = if is_alive { x * x + y * y + z * z } else { 0.0 };
        }
    }

    /// Becomes empty.
    pub(crate) fn clear(&mut self) {
        self.square = [0.0; SLOTS];
        self.alive = 0;
        self.planes.clear();
        self.labels.clear();
    }
}

impl Layout {
    fn assign(&mut self, of: &Polyhedron) {
        if self.facets == of.facets && self.next == of.next {
            return;
        }
        self.facets.clone_from(&of.facets);
        self.next.clone_from(&of.next);
        self.bytes.clear();
        let vertices = of.facets.iter().zip(&of.next);
        self.bytes.extend(vertices.map(|(facets, next)| {
            let [a, b, c] = facets.map_each(|facet| facet as u8);
            let twin = |edge: usize| {
                // The facet on the right of the edge is on the left of its twin, the opposite half-edge.
                let end = next[edge] as usize;
                (4 * end + of.slot(end, facets[(edge + 2) % 3])) as u8
            };
            [[c, a, b, c], [twin(0), twin(1), twin(2), 0]]
        }));
    }
}

/// The blocks of a row.
#[inline]
pub(crate) fn blocks(row: &[f64; ROW]) -> [f64x4; ROW / BLOCK] {
    let [a, b, c, d, e, f, g, h] = *row;
    [f64x4::new([a, b, c, d]), f64x4::new([e, f, g, h])]
}

/// The slots of a mask, in ascending order.
#[inline]
pub(crate) fn slots(mask: u64) -> Slots {
    Slots { mask }
}

/// The iterator of [`slots`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slots {
    mask: u64,
}

impl Iterator for Slots {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.mask == 0 {
            return None;
        }
        let slot = self.mask.trailing_zeros() as usize % SLOTS;
        self.mask &= self.mask - 1;
        Some(slot)
    }
}

/// Marks planes without a facet until facets are numbered.
const UNUSED: u8 = u8::MAX;

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
    /// Adds a byte, which the next one overwrites unless it is wanted.
    #[inline(always)]
    fn push_if(&mut self, byte: u8, is_wanted: bool) {
        self.bytes[self.count % EDGES] = byte;
        self.count += usize::from(is_wanted);
    }

    /// All of them, as numbers.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> impl Iterator<Item = usize> + Clone + '_ {
        self.bytes[..self.count]
            .iter()
            .map(|&byte| usize::from(byte))
    }
}

/// The slots and planes in use, and their numbers among those.
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
            facets: [UNUSED; PLANES],
        }
    }
}

impl Lists {
    /// Those of `piece`.
    #[inline]
    pub(crate) fn of(piece: &SmallPolyhedron) -> Self {
        let mut lists = Self::default();
        lists.fill(piece);
        lists
    }

    fn fill(&mut self, piece: &SmallPolyhedron) {
        for slot in slots(piece.alive) {
            self.vertices[slot] = self.slots.count as u8;
            self.slots.push_if(slot as u8, true);
            for edge in 4 * slot..4 * slot + 3 {
                self.facets[usize::from(piece.facets[edge])] = 0;
            }
        }
        for (plane, number) in self.facets.iter_mut().enumerate().take(piece.planes.len()) {
            let is_used = *number != UNUSED;
            *number = self.planes.count as u8;
            self.planes.push_if(plane as u8, is_used);
        }
    }
}

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

impl SmallPolyhedron {
    /// The edges that lead to a slot of higher number, in ascending order.
    #[inline]
    pub(crate) fn upward(&self) -> impl Iterator<Item = usize> {
        let rows = self.twins.as_chunks::<LANES>().0.as_chunks::<2>().0.iter();
        let rows = rows.zip(NUMBERS.as_chunks::<2>().0).enumerate();
        let used = SLOTS - self.alive.leading_zeros() as usize;
        let rows = rows.take(used.div_ceil(SLOTS_PER_SET));
        rows.flat_map(move |(row, (twins, numbers))| {
            let [low, high] = [0, 1].map_each(|half| {
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
