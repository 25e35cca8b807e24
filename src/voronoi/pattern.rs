//! The pattern of a cell: which neighbors and walls bound it and how its facets hang together,
//! without a single length.
//!
//! It is what two diagrams of sites that moved a little have in common. Everything in it has one
//! possible order, whatever cuts have led to it: facets by label, the three facets of a vertex
//! counter-clockwise from the first, vertices by their facets as a set. So the cell that is
//! [realized](crate::voronoi::realize) from a pattern and the sites does not depend, to the bit, on
//! how the pattern was found.

use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;
use crate::geometry::small_polyhedron::Lists;
use crate::geometry::small_polyhedron::{EDGES, PLANES, SLOTS, SmallPolyhedron, slots};

/// Vertices at most, and so facets; a handful of cells in 10⁵ have more and no pattern.
pub(crate) const MOST: usize = SLOTS;

/// A cell's facets, vertices and edges.
#[derive(Clone, Debug)]
pub(crate) struct Pattern {
    pub(crate) labels: [Label; MOST],
    pub(crate) facet_count: usize,
    /// The facets around the vertices, as in the first slots.
    pub(crate) facets: [u8; EDGES],
    /// The edges that leave the vertices, as in the first slots.
    pub(crate) twins: [u8; EDGES],
    pub(crate) vertex_count: usize,
    /// Memory in which edges find their other ends.
    pub(crate) sides: Sides,
}

impl Default for Pattern {
    fn default() -> Self {
        Self {
            labels: [0; MOST],
            facet_count: 0,
            facets: [0; EDGES],
            twins: [0; EDGES],
            vertex_count: 0,
            sides: Sides::default(),
        }
    }
}

/// Per pair of facets: the edge with one on its left and the other on its right, as far as there is one.
#[derive(Clone, Debug)]
pub(crate) struct Sides(Box<[[u8; MOST]; MOST]>);

impl Default for Sides {
    fn default() -> Self {
        Self(Box::new([[0; MOST]; MOST]))
    }
}

impl Sides {
    fn put(&mut self, left: u8, right: u8, edge: u8) {
        self.0[usize::from(left) % MOST][usize::from(right) % MOST] = edge;
    }

    fn get(&self, left: u8, right: u8) -> usize {
        usize::from(self.0[usize::from(left) % MOST][usize::from(right) % MOST])
    }
}

impl Pattern {
    /// Becomes the pattern of the cell of `site`; returns whether it has one: no two facets on the
    /// same neighbor, none on an image of the site itself, no two vertices on the same facets.
    #[must_use]
    pub(crate) fn assign(&mut self, cell: &SmallPolyhedron, site: u32) -> bool {
        let Some(numbers) = self.number_facets(cell, site) else {
            return false;
        };
        let corners = slots(cell.alive);
        self.assign_corners(corners.map(|slot| {
            let facet = |byte: usize| usize::from(cell.facets[4 * slot + byte]);
            [1, 2, 3].map(|byte| numbers[facet(byte)])
        }))
    }

    /// Takes up corners, each given by the facets around it, counter-clockwise; returns whether every
    /// edge has two ends and no two corners are alike.
    #[must_use]
    pub(crate) fn assign_corners(&mut self, corners: impl Iterator<Item = [u8; 3]>) -> bool {
        let sides = &mut self.sides;
        let mut order = [0; MOST];
        self.vertex_count = 0;
        for (entry, [a, b, c]) in order.iter_mut().zip(corners) {
            let (low, middle, high) = sorted(a, b, c);
            let follows = [[a, b], [b, c], [c, a]].contains(&[low, middle]);
            *entry = key(low, middle, high) << 1 | u32::from(follows);
            self.vertex_count += 1;
        }
        let order = &mut order[..self.vertex_count];
        order.sort_unstable();
        if order.windows(2).any(|pair| pair[0] >> 1 == pair[1] >> 1) {
            return false;
        }
        let vertices = self.facets.as_chunks_mut::<4>().0.iter_mut();
        for (place, (vertex, entry)) in vertices.zip(order).enumerate() {
            let [low, middle, high] = [17, 9, 1].map(|shift| (*entry >> shift) as u8);
            let [b, c] = if *entry & 1 == 1 {
                [middle, high]
            } else {
                [high, middle]
            };
            *vertex = [c, low, b, c];
            let at = 4 * place as u8;
            sides.put(low, c, at);
            sides.put(b, low, at + 1);
            sides.put(c, b, at + 2);
        }
        // What is left in the sides of other patterns leads astray.
        let is_edge = |edge: usize, left: u8, right: u8| {
            let [right_of, left_of] = [edge, edge + 1].map(|byte| self.facets[byte % EDGES]);
            edge < 4 * self.vertex_count && [left_of, right_of] == [left, right]
        };
        let mut are_sound = true;
        let vertices = self.facets.as_chunks::<4>().0[..self.vertex_count].iter();
        for ((place, vertex), twins) in vertices.enumerate().zip(self.twins.as_chunks_mut::<4>().0)
        {
            for edge in 0..3 {
                let (left, right) = (vertex[edge + 1], vertex[edge]);
                let twin = sides.get(right, left);
                are_sound &=
                    is_edge(twin, right, left) & (sides.get(left, right) == 4 * place + edge);
                twins[edge] = twin as u8;
            }
        }
        are_sound
    }

    /// The facets around every vertex, counter-clockwise.
    pub(crate) fn around(&self) -> impl Iterator<Item = [u8; 3]> + '_ {
        let (vertices, _) = self.facets().as_chunks();
        vertices.iter().map(|&[_, a, b, c]| [a, b, c])
    }

    /// Lays the pattern out in a cell's slots, with room for the planes.
    pub(crate) fn write(&self, cell: &mut SmallPolyhedron) {
        cell.clear();
        cell.alive = u64::MAX >> (SLOTS - self.vertex_count);
        (cell.facets, cell.twins) = (self.facets, self.twins);
        cell.labels.extend_from_slice(self.labels());
        cell.planes.reserve(self.facet_count);
    }

    /// Sorts the labels of the facets that have vertices; returns the facets' new numbers.
    fn number_facets(&mut self, cell: &SmallPolyhedron, site: u32) -> Option<[u8; PLANES]> {
        if cell.alive.count_ones() < 4 {
            return None;
        }
        let Lists { planes, .. } = Lists::of(cell);
        let label = |plane: u8| cell.labels[usize::from(plane)];
        let facets = planes.listed().iter().map(|&plane| (label(plane), plane));
        if facets.clone().any(|(label, _)| !may_bound(label, site)) {
            return None;
        }
        self.assign_labels(facets)
    }

    /// Takes up facets, each given by its label and an old number, in the order of the labels; returns
    /// their new numbers by the old ones. No label may come twice.
    pub(crate) fn assign_labels(
        &mut self,
        facets: impl ExactSizeIterator<Item = (Label, u8)>,
    ) -> Option<[u8; PLANES]> {
        let mut order = [(0, 0_u8); MOST];
        let count = facets.len();
        if count > MOST {
            return None;
        }
        for (entry, facet) in order.iter_mut().zip(facets) {
            *entry = facet;
        }
        order[..count].sort_unstable();
        if order[..count].windows(2).any(|pair| pair[0].0 == pair[1].0) {
            return None;
        }
        let mut numbers = [0_u8; PLANES];
        for (number, (label, old)) in order[..count].iter().enumerate() {
            self.labels[number] = *label;
            numbers[usize::from(*old)] = number as u8;
        }
        self.facet_count = count;
        Some(numbers)
    }

    /// The labels of the facets.
    pub(crate) fn labels(&self) -> &[Label] {
        &self.labels[..self.facet_count]
    }

    /// The facets around the vertices.
    fn facets(&self) -> &[u8] {
        &self.facets[..4 * self.vertex_count]
    }

    /// Calls `found` with the labels around every vertex that `self` or `other` has and the other
    /// one has not.
    pub(crate) fn visit_differences(&self, other: &Self, mut found: impl FnMut([Label; 3])) {
        let (mut one, mut two) = (0, 0);
        let around = |pattern: &Self, vertex: usize| {
            let [a, b, c] = [1, 2, 3].map(|byte| pattern.facets[4 * vertex + byte]);
            let (low, middle, high) = sorted(a, b, c);
            [low, middle, high].map(|facet| pattern.labels[usize::from(facet)])
        };
        let is_same = self.labels() == other.labels() && self.facets() == other.facets();
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
    match FacetKind::of(label) {
        FacetKind::Neighbor { site, .. } => site != cell_site,
        FacetKind::Wall(_) => true,
        FacetKind::Inner => false,
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
