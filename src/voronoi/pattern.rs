//! The pattern of a cell: which neighbors and walls bound it and how its facets hang together,
//! without a single length.
//!
//! It is what two diagrams of sites that moved a little have in common. Everything in it has one
//! possible order, whatever cuts have led to it: facets by label, the three facets of a vertex
//! counter-clockwise from the first, vertices by their facets as a set. So the cell that is
//! [realized](crate::voronoi::realize) from a pattern and the sites does not depend, to the bit, on
//! how the pattern was found.

use crate::domain::beyond::Beyond;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// Vertices at most, and so facets; a handful of cells in 10⁵ have more and no pattern.
pub(crate) const MOST: usize = 64;

/// A cell's facets, vertices and edges.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    pub(crate) labels: [Label; MOST],
    pub(crate) facet_count: usize,
    /// Per vertex: its facets, as in a polyhedron.
    pub(crate) facets: [[u8; 3]; MOST],
    /// Per vertex: its neighbors, as in a polyhedron.
    pub(crate) next: [[u8; 3]; MOST],
    pub(crate) vertex_count: usize,
}

impl Default for Pattern {
    fn default() -> Self {
        Self {
            labels: [0; MOST],
            facet_count: 0,
            facets: [[0; 3]; MOST],
            next: [[0; 3]; MOST],
            vertex_count: 0,
        }
    }
}

impl Pattern {
    /// Becomes the pattern of the cell of `site`; returns whether it has one: no two facets on the
    /// same neighbor, none on an image of the site itself, no two vertices on the same facets.
    #[must_use]
    pub(crate) fn assign(&mut self, cell: &Polyhedron, site: u32) -> bool {
        let Some(numbers) = self.number_facets(cell, site) else {
            return false;
        };
        let count = cell.vertex_count();
        let mut order = [0_u32; MOST];
        let mut firsts = [0_u8; MOST];
        for vertex in 0..count {
            let [a, b, c] = cell.facets[vertex].map(|facet| numbers[facet as usize]);
            let first = if a < b && a < c {
                0
            } else if b < c {
                1
            } else {
                2
            };
            let (low, middle, high) = sorted(a, b, c);
            firsts[vertex] = first;
            order[vertex] = key(low, middle, high) << 8 | vertex as u32;
        }
        order[..count].sort_unstable();
        if order[..count].windows(2).any(|w| w[0] >> 8 == w[1] >> 8) {
            return false;
        }
        let mut places = [0_u8; MOST];
        for (place, entry) in order[..count].iter().enumerate() {
            places[(entry & 0xff) as usize] = place as u8;
        }
        self.vertex_count = count;
        for (place, entry) in order[..count].iter().enumerate() {
            let vertex = (entry & 0xff) as usize;
            let first = usize::from(firsts[vertex]);
            let slots = [first, (first + 1) % 3, (first + 2) % 3];
            let facets = &cell.facets[vertex];
            let next = &cell.next[vertex];
            self.facets[place] = slots.map(|slot| numbers[facets[slot] as usize]);
            self.next[place] = slots.map(|slot| places[next[slot] as usize]);
        }
        true
    }

    /// Sorts the labels of the facets that have vertices; returns the facets' new numbers.
    fn number_facets(&mut self, cell: &Polyhedron, site: u32) -> Option<[u8; 4 * MOST]> {
        let mut numbers = [u8::MAX; 4 * MOST];
        if cell.planes.len() > numbers.len() || !(4..=MOST).contains(&cell.vertex_count()) {
            return None;
        }
        for facet in cell.facets.iter().flatten() {
            numbers[*facet as usize] = 0;
        }
        let mut order = [(0, 0_u8); MOST];
        let mut count = 0;
        for (facet, &label) in cell.labels.iter().enumerate() {
            if numbers[facet] == 0 {
                if count == MOST || !may_bound(label, site) {
                    return None;
                }
                order[count] = (label, facet as u8);
                count += 1;
            }
        }
        order[..count].sort_unstable();
        if order[..count].windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        for (number, (label, facet)) in order[..count].iter().enumerate() {
            self.labels[number] = *label;
            numbers[usize::from(*facet)] = number as u8;
        }
        self.facet_count = count;
        Some(numbers)
    }

    /// The labels of the facets.
    pub(crate) fn labels(&self) -> &[Label] {
        &self.labels[..self.facet_count]
    }

    /// How many facets lie on neighbors. They come before the walls.
    pub(crate) fn neighbor_count(&self) -> usize {
        let is_neighbor = |&&label: &&Label| matches!(Beyond::of(label), Beyond::Neighbor { .. });
        self.labels().iter().take_while(is_neighbor).count()
    }

    /// Calls `found` with the labels around every vertex that `self` or `other` has and the other
    /// one has not.
    pub(crate) fn visit_differences(&self, other: &Self, mut found: impl FnMut([Label; 3])) {
        let (mut one, mut two) = (0, 0);
        let around = |pattern: &Self, vertex: usize| {
            let [a, b, c] = pattern.facets[vertex];
            let (low, middle, high) = sorted(a, b, c);
            [low, middle, high].map(|facet| pattern.labels[usize::from(facet)])
        };
        let is_same = self.labels() == other.labels()
            && self.facets[..self.vertex_count] == other.facets[..other.vertex_count];
        if is_same {
            return;
        }
        while one < self.vertex_count || two < other.vertex_count {
            if one == self.vertex_count {
                found(around(other, two));
                two += 1;
                continue;
            }
            if two == other.vertex_count {
                found(around(self, one));
                one += 1;
                continue;
            }
            let (here, there) = (around(self, one), around(other, two));
            if here <= there {
                one += 1;
            }
            if there <= here {
                two += 1;
            }
            if here != there {
                found(here.min(there));
            }
        }
    }
}

/// Whether a facet with this label can be found again from the sites alone.
fn may_bound(label: Label, cell_site: u32) -> bool {
    match Beyond::of(label) {
        Beyond::Neighbor { site, .. } => site != cell_site,
        Beyond::Wall(_) => true,
        Beyond::Inner => false,
    }
}

fn sorted(a: u8, b: u8, c: u8) -> (u8, u8, u8) {
    let (low, high) = (a.min(b), a.max(b));
    let (low, rest) = (low.min(c), low.max(c));
    (low, rest.min(high), rest.max(high))
}

/// A number that orders vertices.
fn key(low: u8, middle: u8, high: u8) -> u32 {
    u32::from(low) << 16 | u32::from(middle) << 8 | u32::from(high)
}
