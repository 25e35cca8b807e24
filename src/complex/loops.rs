//! The facets of all cells as loops of shared vertices, without what rounding alone made.
//!
//! Contraction leaves loops that visit a vertex twice in a row, run to and fro along an edge, or have
//! two corners: they are shortened or vanish. A vertex with two edges in the whole complex is where
//! nearly coincident planes cross on an edge; some cells have it and others do not, so it goes.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::complex::cell_surface::CellSurface;
use crate::complex::identify::NumberedVertices;
use crate::complex::vertex_key::{Shift, displacement};
use crate::geometry::label::Label;
use crate::parallel::map;

/// A vertex where a cell sees it: its number, and in the bits above 32 its shift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct LoopCorner(u64);

/// Added to every component of a shift, so that it is a positive number of 10 bits.
const BIAS: i16 = 512;

impl LoopCorner {
    /// The corner at vertex `number`, shifted.
    #[must_use]
    pub(crate) fn new(number: u32, shift: Shift) -> Self {
        let bits = |axis: usize| ((shift[axis] + BIAS) & 0x3ff) as u64;
        Self(u64::from(number) | bits(0) << 32 | bits(1) << 42 | bits(2) << 52)
    }

    /// The number of its vertex.
    #[inline]
    #[must_use]
    pub(crate) fn number(self) -> u32 {
        self.0 as u32
    }

    /// The shift of its vertex.
    #[inline]
    #[must_use]
    pub(crate) fn shift(self) -> Shift {
        [32, 42, 52].map(|bits| (self.0 >> bits & 0x3ff) as i16 - BIAS)
    }

    /// The same vertex moved by `by` more periods.
    #[must_use]
    pub(crate) fn shifted(self, by: Shift) -> Self {
        let shift = self.shift();
        Self::new(self.number(), [0, 1, 2].map(|axis| shift[axis] + by[axis]))
    }

    /// The vertex as `origin` sees it from shift zero.
    fn relative_to(self, origin: Self) -> Self {
        self.shifted(origin.shift().map(|periods| -periods))
    }

    /// Its place (L).
    #[must_use]
    pub(crate) fn position(self, positions: &[Point3<f64>], periods: &Vector3<f64>) -> Point3<f64> {
        positions[self.number() as usize] + displacement(self.shift(), periods)
    }
}

/// The facets of a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellLoops {
    /// The label and the end in `corners` of every facet.
    facets: Vec<(Label, u32)>,
    corners: Vec<LoopCorner>,
}

impl CellLoops {
    /// The facets: labels and loops, counter-clockwise from outside.
    pub(crate) fn facets(&self) -> impl Iterator<Item = (Label, &[LoopCorner])> {
        let mut start = 0;
        self.facets.iter().map(move |&(label, end)| {
            let corners = &self.corners[start as usize..end as usize];
            start = end;
            (label, corners)
        })
    }

    /// The connected piece of the boundary to which every facet belongs, from zero.
    #[must_use]
    pub(crate) fn pieces(&self) -> Vec<u32> {
        let mut pieces: Vec<usize> = (0..self.facets.len()).collect();
        let mut first_at: HashMap<LoopCorner, usize> = HashMap::new();
        for (facet, (_, corners)) in self.facets().enumerate() {
            for &corner in corners {
                let other = *first_at.entry(corner).or_insert(facet);
                let [one, other] = [facet, other].map(|facet| root(&pieces, facet));
                pieces[one.max(other)] = one.min(other);
            }
        }
        let mut numbers = HashMap::new();
        let number = |facet: usize| {
            let count = numbers.len() as u32;
            *numbers.entry(root(&pieces, facet)).or_insert(count)
        };
        (0..pieces.len()).map(number).collect()
    }

    /// The facets with new corners, without those that have fewer than three.
    fn mapped(&self, mut corner: impl FnMut(LoopCorner) -> Option<LoopCorner>) -> Self {
        let mut mapped = Self::default();
        let mut ring = Vec::new();
        for (label, corners) in self.facets() {
            ring.clear();
            ring.extend(corners.iter().filter_map(|&old| corner(old)));
            mapped.push(label, &mut ring);
        }
        mapped
    }

    /// Adds a facet as it is.
    pub(crate) fn push_as_is(&mut self, label: Label, ring: impl Iterator<Item = LoopCorner>) {
        self.corners.extend(ring);
        self.facets.push((label, self.corners.len() as u32));
    }

    /// Adds a facet, shortened to what encloses an area, if anything does. A loop that touches itself
    /// in a vertex becomes two.
    fn push(&mut self, label: Label, ring: &mut Vec<LoopCorner>) {
        shorten(ring);
        if ring.len() < 3 {
            return;
        }
        let again = |place: &usize| ring[..*place].contains(&ring[*place]);
        if let Some(second) = (0..ring.len()).find(again) {
            let first = ring.iter().position(|&corner| corner == ring[second]);
            let mut part: Vec<LoopCorner> = ring.drain(first.unwrap_or(0)..second).collect();
            self.push(label, &mut part);
            return self.push(label, ring);
        }
        self.corners.extend_from_slice(ring);
        self.facets.push((label, self.corners.len() as u32));
    }
}

/// The first facet of a piece.
fn root(pieces: &[usize], mut facet: usize) -> usize {
    while pieces[facet] != facet {
        facet = pieces[facet];
    }
    facet
}

/// Removes repetitions (a a) and spikes (a b a) from a closed loop.
fn shorten(ring: &mut Vec<LoopCorner>) {
    let mut kept = 0;
    for place in 0..ring.len() {
        let corner = ring[place];
        if kept > 0 && ring[kept - 1] == corner {
            continue;
        }
        if kept > 1 && ring[kept - 2] == corner {
            kept -= 1;
            continue;
        }
        ring[kept] = corner;
        kept += 1;
    }
    ring.truncate(kept);
    // The same across the seam.
    loop {
        match ring[..] {
            [first, .., last] if first == last => {
                ring.pop();
            }
            [first, second, .., last] if second == last && first != last => {
                ring.remove(0);
            }
            [first, .., before, _] if first == before => {
                ring.pop();
            }
            _ => return,
        }
    }
}

/// The same loop from its least corner on.
#[must_use]
pub(crate) fn least_first(corners: &[LoopCorner]) -> Vec<LoopCorner> {
    let least = (0..corners.len()).min_by_key(|&place| corners[place]);
    let (before, after) = corners.split_at(least.unwrap_or(0));
    [after, before].concat()
}

/// The facets of all cells by the numbers of their vertices.
#[must_use]
pub(crate) fn numbered_loops(cells: &[CellSurface], vertices: &NumberedVertices) -> Vec<CellLoops> {
    let of_cell = |cell: usize| {
        let surface = &cells[cell];
        let mut loops = CellLoops::default();
        let mut ring = Vec::new();
        for (label, corners) in surface.facets() {
            ring.clear();
            ring.extend(corners.iter().map(|&vertex| {
                let (number, shift) = vertices.of(cell, vertex);
                LoopCorner::new(number, shift)
            }));
            loops.push(label, &mut ring);
        }
        loops
    };
    map(cells.len(), &of_cell)
}

/// Removes the vertices that have two edges only, until there are none.
pub(crate) fn straighten(cells: &mut [CellLoops], count: usize) {
    loop {
        let edges = EdgeEnds::of(cells, count);
        if !edges.any_straight() {
            return;
        }
        let keep = |corner: LoopCorner| (!edges.is_straight(corner)).then_some(corner);
        cells
            .par_iter_mut()
            .for_each(|cell| *cell = cell.mapped(keep));
    }
}

/// The other ends of every vertex's edges, two at most, and whether there are more.
struct EdgeEnds {
    ends: Vec<[Option<LoopCorner>; 2]>,
    is_branching: Vec<bool>,
}

impl EdgeEnds {
    fn of(cells: &[CellLoops], count: usize) -> Self {
        let mut all = Self {
            ends: vec![[None; 2]; count],
            is_branching: vec![false; count],
        };
        for (_, corners) in cells.iter().flat_map(CellLoops::facets) {
            let next = corners.iter().cycle().skip(1);
            for (&from, &to) in corners.iter().zip(next) {
                all.add(from, to);
                all.add(to, from);
            }
        }
        all
    }

    fn add(&mut self, from: LoopCorner, to: LoopCorner) {
        let number = from.number() as usize;
        if self.is_branching[number] {
            return;
        }
        let end = to.relative_to(from);
        for known in &mut self.ends[number] {
            if *known.get_or_insert(end) == end {
                return;
            }
        }
        self.is_branching[number] = true;
    }

    fn is_straight(&self, corner: LoopCorner) -> bool {
        let number = corner.number() as usize;
        !self.is_branching[number] && self.ends[number][1].is_some()
    }

    fn any_straight(&self) -> bool {
        let ends = self.ends.iter().zip(&self.is_branching);
        ends.into_iter()
            .any(|(ends, branches)| !branches && ends[1].is_some())
    }
}

/// Makes one vertex of each of the pairs, the second where the first was.
pub(crate) fn merge(cells: &mut [CellLoops], pairs: &HashMap<u32, LoopCorner>) {
    let moved = |corner: LoopCorner| {
        let target = pairs.get(&corner.number());
        Some(target.map_or(corner, |target| target.shifted(corner.shift())))
    };
    cells
        .par_iter_mut()
        .for_each(|cell| *cell = cell.mapped(moved));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::vertex_key::NO_SHIFT;

    fn shortened(numbers: &[u32]) -> Vec<u32> {
        let mut ring: Vec<LoopCorner> = numbers
            .iter()
            .map(|&n| LoopCorner::new(n, NO_SHIFT))
            .collect();
        shorten(&mut ring);
        ring.iter().map(|corner| corner.number()).collect()
    }

    #[test]
    fn repetitions_and_spikes_vanish_also_across_the_seam() {
        assert_eq!(shortened(&[1, 1, 2, 3, 3, 1]), [1, 2, 3]);
        assert_eq!(shortened(&[1, 2, 3, 2, 4]), [1, 2, 4]);
        assert_eq!(shortened(&[5, 1, 2, 3, 1]), [1, 2, 3]);
        assert_eq!(shortened(&[1, 2, 3, 1, 5]), [1, 2, 3]);
        assert!(shortened(&[1, 2, 1, 2]).len() < 3);
        assert!(shortened(&[1, 2]).len() < 3);
    }

    #[test]
    fn shifts_are_kept_with_their_signs() {
        let corner = LoopCorner::new(9, [-3, 0, 200]);
        assert_eq!((corner.number(), corner.shift()), (9, [-3, 0, 200]));
        assert_eq!(corner.shifted([3, 1, -200]).shift(), [0, 1, 0]);
        assert_eq!(corner.relative_to(corner).shift(), NO_SHIFT);
    }
}
