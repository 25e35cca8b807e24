//! The facets of all cells as loops of shared vertices, without what rounding alone made.
//!
//! Contraction leaves loops that visit a vertex twice in a row, run to and fro along an edge, or have
//! two corners: they are shortened or vanish. A vertex with two edges in the whole complex is where
//! nearly coincident planes cross on an edge; some cells have it and others do not, so it goes.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use crate::complex::cell_surface::CellSurface;
use crate::complex::identify::NumberedVertices;
use crate::complex::loop_corner::LoopCorner;
use crate::geometry::label::Label;
use crate::parallel::for_each;

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

    /// Without facets yet, and with memory for so many facets and corners: vectors that grow as they are
    /// filled take half as much again.
    fn with_capacity(facets: usize, corners: usize) -> Self {
        Self {
            facets: Vec::with_capacity(facets),
            corners: Vec::with_capacity(corners),
        }
    }

    /// Gives the facets new corners, without those that have fewer than three.
    fn replace(&mut self, corner: &impl Fn(LoopCorner) -> Option<LoopCorner>) {
        if self.corners.iter().all(|&old| corner(old) == Some(old)) {
            return;
        }
        let mut mapped = Self::with_capacity(self.facets.len(), self.corners.len());
        let mut ring = Vec::new();
        for (label, corners) in self.facets() {
            ring.clear();
            ring.extend(corners.iter().filter_map(|&old| corner(old)));
            mapped.push(label, &mut ring);
        }
        *self = mapped;
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

/// The facets of all cells by the numbers of their vertices. A cell's own vertices are given back as soon as
/// they are numbered.
#[must_use]
pub(crate) fn numbered_loops(
    cells: Vec<CellSurface>,
    vertices: &NumberedVertices,
) -> Vec<CellLoops> {
    let of_cell = |(cell, surface): (usize, CellSurface)| {
        let (facets, corners) = surface.counts();
        let mut loops = CellLoops::with_capacity(facets, corners);
        let mut ring = Vec::new();
        for (label, corners) in surface.facets() {
            ring.clear();
            ring.extend(corners.iter().map(|&vertex| vertices.of(cell, vertex)));
            loops.push(label, &mut ring);
        }
        loops
    };
    let cells = cells.into_par_iter().enumerate();
    cells.map(of_cell).collect()
}

/// Removes the vertices that have two edges only, until there are none.
pub(crate) fn straighten(cells: &mut [CellLoops], count: usize) {
    loop {
        let edges = EdgeEnds::of(cells, count);
        if !edges.any_straight() {
            return;
        }
        let keep = |corner: LoopCorner| (!edges.is_straight(corner)).then_some(corner);
        cells.par_iter_mut().for_each(|cell| cell.replace(&keep));
    }
}

/// Marks an end that is not known yet.
const NO_END: u64 = u64::MAX;

/// The other ends of every vertex's edges, two at most, and whether there are more. Threads add them together:
/// which two come first does not matter, nor does which of them is first.
struct EdgeEnds {
    /// [`LoopCorner::bits`].
    ends: Vec<[AtomicU64; 2]>,
    is_branching: Vec<AtomicBool>,
}

impl EdgeEnds {
    fn of(cells: &[CellLoops], count: usize) -> Self {
        let no_ends = || [NO_END; 2].map(AtomicU64::new);
        let all = Self {
            ends: (0..count).map(|_| no_ends()).collect(),
            is_branching: (0..count).map(|_| AtomicBool::new(false)).collect(),
        };
        for_each(cells.len(), &|cell| {
            for (_, corners) in cells[cell].facets() {
                let next = corners.iter().cycle().skip(1);
                for (&from, &to) in corners.iter().zip(next) {
                    all.add(from, to);
                    all.add(to, from);
                }
            }
        });
        all
    }

    fn add(&self, from: LoopCorner, to: LoopCorner) {
        let is_branching = &self.is_branching[from.number() as usize];
        if is_branching.load(Relaxed) {
            return;
        }
        let end = to.relative_to(from).bits();
        for known in &self.ends[from.number() as usize] {
            let there = match known.load(Relaxed) {
                NO_END => known.compare_exchange(NO_END, end, Relaxed, Relaxed),
                there => Err(there),
            };
            if there.is_ok() || there == Err(end) {
                return;
            }
        }
        is_branching.store(true, Relaxed);
    }

    fn is_straight(&self, corner: LoopCorner) -> bool {
        self.is_straight_at(corner.number() as usize)
    }

    fn is_straight_at(&self, number: usize) -> bool {
        !self.is_branching[number].load(Relaxed) && self.ends[number][1].load(Relaxed) != NO_END
    }

    fn any_straight(&self) -> bool {
        (0..self.ends.len()).any(|number| self.is_straight_at(number))
    }
}

/// Makes one vertex of each of the pairs, the second where the first was.
pub(crate) fn merge(cells: &mut [CellLoops], pairs: &HashMap<u32, LoopCorner>) {
    let moved = |corner: LoopCorner| {
        let target = pairs.get(&corner.number());
        Some(target.map_or(corner, |target| target.shifted(corner.shift())))
    };
    cells.par_iter_mut().for_each(|cell| cell.replace(&moved));
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
}
