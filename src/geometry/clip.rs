//! Clipping of a convex polyhedron by a half-space.
//!
//! # Tolerance policy
//!
//! There is no epsilon. A vertex is cut when its excess over the half-space is strictly positive
//! as computed; a vertex on the plane stays. A new vertex is interpolated along the cut edge, which
//! is stable where a solve of three nearly parallel planes is not. Whatever rounding does to the
//! signs, the result is a simple polytope again: if the cut vertices are not exactly one connected
//! part with a connected rest (this happens where rounding alone decides, as in exact lattices),
//! the signs are repaired by flooding from the farthest vertex on either side, which moves the
//! boundary by no more than that rounding.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// What a clip did to a polyhedron.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clip {
    /// It lies in the half-space already.
    Unchanged,
    /// It has lost vertices and gained a facet.
    Cut,
    /// Nothing is left.
    Emptied,
}

/// The memory of [`clip`], to be reused from one clip to the next.
#[derive(Clone, Debug, Default)]
pub struct ClipScratch {
    excess: Vec<f64>,
    cut: Vec<u32>,
    crossings: Vec<CutEdge>,
    /// Per facet: the crossing in which its counter-clockwise boundary leaves the half-space.
    exit: Vec<u32>,
    /// Per facet: the crossing in which it enters the half-space again.
    entry: Vec<u32>,
    reached: Vec<bool>,
    stack: Vec<u32>,
}

impl ClipScratch {
    /// Marks a vertex as reached by the flood, which goes on from there.
    fn reach(&mut self, vertex: u32) {
        self.reached[vertex as usize] = true;
        self.stack.push(vertex);
    }
}

/// An edge that runs from a kept vertex to a cut one, with `left` and `right` of it.
#[derive(Clone, Copy, Debug)]
struct CutEdge {
    position: Point3<f64>,
    kept: u32,
    kept_slot: u32,
    left: u32,
    right: u32,
}

const NONE: u32 = u32::MAX;

/// Clips `polyhedron` by `half_space`; the new facet carries `label`.
pub(crate) fn clip(
    polyhedron: &mut Polyhedron,
    half_space: &HalfSpace,
    label: Label,
    scratch: &mut ClipScratch,
) -> Clip {
    classify(polyhedron, half_space, scratch);
    if scratch.cut.is_empty() {
        return Clip::Unchanged;
    }
    if scratch.cut.len() == polyhedron.vertex_count() {
        polyhedron.clear();
        return Clip::Emptied;
    }
    find_cycle(polyhedron, scratch);
    let facet = polyhedron.planes.len() as u32;
    polyhedron.planes.push(*half_space);
    polyhedron.labels.push(label);
    join(polyhedron, facet, scratch);
    Clip::Cut
}

/// Finds the crossings, after a repair of the signs where they do not form a single cycle.
#[inline]
fn find_cycle(polyhedron: &Polyhedron, scratch: &mut ClipScratch) {
    find_crossings(polyhedron, scratch);
    if !is_single_cycle(polyhedron, scratch) {
        repair(polyhedron, scratch);
        find_crossings(polyhedron, scratch);
        debug_assert!(is_single_cycle(polyhedron, scratch), "{polyhedron:?}");
    }
}

/// Computes all excesses, and lists the vertices where they are positive.
fn classify(polyhedron: &Polyhedron, half_space: &HalfSpace, scratch: &mut ClipScratch) {
    let positions = [&polyhedron.x[..], &polyhedron.y[..], &polyhedron.z[..]];
    scratch.excess.resize(polyhedron.vertex_count(), 0.0);
    scratch.cut.clear();
    if any_excess(half_space, positions, &mut scratch.excess) {
        for (vertex, &excess) in scratch.excess.iter().enumerate() {
            if excess > 0.0 {
                scratch.cut.push(vertex as u32);
            }
        }
    }
}

/// Computes all excesses and returns whether one is positive. Most planes that are tried cut nothing.
/// Not inlined, so that the compiler knows that the slices do not overlap and vectorizes the loop.
#[inline(never)]
fn any_excess(half_space: &HalfSpace, [x, y, z]: [&[f64]; 3], excess: &mut [f64]) -> bool {
    let HalfSpace { normal, offset } = *half_space;
    for (((excess, x), y), z) in excess.iter_mut().zip(x).zip(y).zip(z) {
        *excess = normal.x * x + normal.y * y + normal.z * z - offset;
    }
    let positive: u64 = excess.iter().map(|&excess| u64::from(excess > 0.0)).sum();
    positive > 0
}

/// Lists the crossings and enters each at the two facets beside it.
fn find_crossings(polyhedron: &Polyhedron, scratch: &mut ClipScratch) {
    scratch.crossings.clear();
    scratch.exit.clear();
    scratch.exit.resize(polyhedron.planes.len(), NONE);
    scratch.entry.clear();
    scratch.entry.resize(polyhedron.planes.len(), NONE);
    for &cut in &scratch.cut {
        for slot in 0..3 {
            if let Some(crossing) = crossing(polyhedron, &scratch.excess, cut as usize, slot) {
                let number = scratch.crossings.len() as u32;
                scratch.exit[crossing.left as usize] = number;
                scratch.entry[crossing.right as usize] = number;
                scratch.crossings.push(crossing);
            }
        }
    }
}

/// The crossing on the edge that leaves a cut vertex in `slot`, if its other end is kept.
#[inline]
fn crossing(polyhedron: &Polyhedron, excess: &[f64], cut: usize, slot: usize) -> Option<CutEdge> {
    let kept = polyhedron.next[cut][slot];
    let inner = excess[kept as usize];
    if inner > 0.0 {
        return None;
    }
    // From the cut vertex, `slot` lies left of the edge; from the kept one, right.
    let right = polyhedron.facets[cut][slot];
    let left = polyhedron.facets[cut][(slot + 2) % 3];
    let share = inner / (inner - excess[cut]);
    let [from, to] = [kept as usize, cut].map_each(|vertex| polyhedron.vertex(vertex));
    Some(CutEdge {
        position: from + (to - from) * share,
        kept,
        kept_slot: polyhedron.slot(kept as usize, left) as u32,
        left,
        right,
    })
}

/// Whether the crossings, each followed by the next around the new facet, form one cycle.
fn is_single_cycle(polyhedron: &Polyhedron, scratch: &ClipScratch) -> bool {
    let Some(first) = scratch.crossings.first() else {
        return false;
    };
    let mut length = 1;
    let mut facet = first.right;
    while facet != first.left {
        let following = scratch.exit[facet as usize];
        if following == NONE || length > polyhedron.vertex_count() {
            return false;
        }
        facet = scratch.crossings[following as usize].right;
        length += 1;
    }
    length == scratch.crossings.len()
}

/// Makes the cut vertices one connected part with a connected rest.
fn repair(polyhedron: &Polyhedron, scratch: &mut ClipScratch) {
    flood(polyhedron, scratch, true);
    for vertex in 0..polyhedron.vertex_count() {
        if scratch.excess[vertex] > 0.0 && !scratch.reached[vertex] {
            scratch.excess[vertex] = 0.0;
        }
    }
    flood(polyhedron, scratch, false);
    for vertex in 0..polyhedron.vertex_count() {
        if scratch.excess[vertex] <= 0.0 && !scratch.reached[vertex] {
            scratch.excess[vertex] = f64::MIN_POSITIVE;
        }
    }
    let vertices = 0..polyhedron.vertex_count() as u32;
    scratch.cut.clear();
    let excess = &scratch.excess;
    scratch
        .cut
        .extend(vertices.filter(|&v| excess[v as usize] > 0.0));
}

/// Marks the vertices on one side that are joined to the farthest one there.
fn flood(polyhedron: &Polyhedron, scratch: &mut ClipScratch, cut_side: bool) {
    let sign = if cut_side { 1.0 } else { -1.0 };
    let mut farthest = 0;
    for vertex in 1..polyhedron.vertex_count() {
        if sign * scratch.excess[vertex] > sign * scratch.excess[farthest] {
            farthest = vertex;
        }
    }
    scratch.reached.clear();
    scratch.reached.resize(polyhedron.vertex_count(), false);
    scratch.stack.clear();
    scratch.reach(farthest as u32);
    while let Some(vertex) = scratch.stack.pop() {
        for neighbor in polyhedron.next[vertex as usize] {
            let same_side = (scratch.excess[neighbor as usize] > 0.0) == cut_side;
            if same_side && !scratch.reached[neighbor as usize] {
                scratch.reach(neighbor);
            }
        }
    }
}

/// Puts a new vertex on every crossing, in the places of cut vertices first, and closes the ring.
fn join(polyhedron: &mut Polyhedron, facet: u32, scratch: &ClipScratch) {
    let old_count = polyhedron.vertex_count() as u32;
    let place = |number: u32| match scratch.cut.get(number as usize) {
        Some(&freed) => freed,
        None => old_count + number - scratch.cut.len() as u32,
    };
    for (number, crossing) in scratch.crossings.iter().enumerate() {
        let vertex = place(number as u32);
        let facets = [facet, crossing.left, crossing.right];
        let next = [
            place(scratch.exit[crossing.right as usize]),
            place(scratch.entry[crossing.left as usize]),
            crossing.kept,
        ];
        polyhedron.next[crossing.kept as usize][crossing.kept_slot as usize] = vertex;
        if vertex < old_count {
            polyhedron.replace(vertex as usize, crossing.position, facets, next);
        } else {
            polyhedron.push(crossing.position, facets, next);
        }
    }
    for &hole in scratch.cut.iter().skip(scratch.crossings.len()).rev() {
        remove(polyhedron, hole as usize);
    }
}

/// Fills the hole with the last vertex. Holes must be removed from the last to the first.
fn remove(polyhedron: &mut Polyhedron, hole: usize) {
    let last = polyhedron.vertex_count() - 1;
    if hole != last {
        for slot in 0..3 {
            let neighbor = polyhedron.next[last][slot] as usize;
            let shared = polyhedron.facets[last][(slot + 2) % 3];
            let back = polyhedron.slot(neighbor, shared);
            polyhedron.next[neighbor][back] = hole as u32;
        }
    }
    polyhedron.x.swap_remove(hole);
    polyhedron.y.swap_remove(hole);
    polyhedron.z.swap_remove(hole);
    polyhedron.facets.swap_remove(hole);
    polyhedron.next.swap_remove(hole);
}
