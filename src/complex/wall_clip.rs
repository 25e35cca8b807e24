//! Cells that share their vertices, clipped by a wall of a convex solid so that they still do.
//!
//! Which side of the wall a vertex is on, and where an edge crosses it, is computed once for all cells. On the
//! line in which a facet's plane crosses the wall, edges that leave and edges that come back alternate: the
//! segments between them close the facet, and, run back, bound the part of the wall that is the cell's. The
//! cell beyond the facet finds the same segments.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::complex::loop_corner::LoopCorner;
use crate::complex::numbered_facets::NumberedFacet;
use crate::complex::vertex_key::NO_SHIFT;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;

/// A wall, and the vertices of all cells, none of them periodic.
#[derive(Debug)]
pub(crate) struct WallClip<'a> {
    wall: HalfSpace,
    label: Label,
    positions: &'a mut Vec<Point3<f64>>,
    /// How far (L) every vertex is beyond the wall; zero on it.
    excess: Vec<f64>,
    /// The vertices on edges, by their ends.
    crossings: HashMap<[u32; 2], u32>,
}

/// Where an edge of a facet passes the wall.
#[derive(Clone, Copy, Debug)]
struct Passage {
    vertex: LoopCorner,
    /// Along the line in which the planes cross.
    along: f64,
    /// Whether the edge leaves, so that a segment begins here.
    leaves: bool,
}

impl<'a> WallClip<'a> {
    /// A wall that vertices up to `reach` (L) away are on.
    pub(crate) fn new(
        wall: HalfSpace,
        label: Label,
        reach: f64,
        positions: &'a mut Vec<Point3<f64>>,
    ) -> Self {
        let excess = |position| {
            let excess = wall.excess(position);
            if excess.abs() <= reach { 0.0 } else { excess }
        };
        Self {
            excess: positions.iter().map(excess).collect(),
            wall,
            label,
            positions,
            crossings: HashMap::new(),
        }
    }

    /// The facets of the part of a cell on this side of the wall; none where rounding has mixed up the order
    /// of vertices on a line.
    pub(crate) fn clip(&mut self, facets: Vec<NumberedFacet>) -> Option<Vec<NumberedFacet>> {
        let (mut kept, mut rim) = (Vec::with_capacity(facets.len() + 1), Vec::new());
        for mut facet in facets {
            facet.edges = self.clip_facet(&facet, &mut rim)?;
            if !facet.edges.is_empty() {
                kept.push(facet);
            }
        }
        cancel(&mut rim);
        if !rim.is_empty() {
            kept.push(NumberedFacet {
                label: self.label,
                normal: self.wall.normal,
                edges: rim,
            });
        }
        Some(kept)
    }

    /// The edges of the part of a facet on this side; those along the wall are added to the `rim`, run back.
    fn clip_facet(
        &mut self,
        facet: &NumberedFacet,
        rim: &mut Vec<[LoopCorner; 2]>,
    ) -> Option<Vec<[LoopCorner; 2]>> {
        let (mut kept, mut passages) = (Vec::with_capacity(facet.edges.len()), Vec::new());
        let line = facet.normal.cross(&self.wall.normal);
        for &[from, to] in &facet.edges {
            let [leaves, comes] = [to, from].map(|end| self.excess_of(end) > 0.0);
            if leaves && comes {
                continue;
            }
            let mut edge = [from, to];
            if leaves != comes {
                let [inner, outer] = if leaves { [from, to] } else { [to, from] };
                let vertex = self.crossing(inner, outer);
                edge[usize::from(leaves)] = vertex;
                passages.push(Passage {
                    vertex,
                    along: line.dot(&self.position(vertex).coords),
                    leaves,
                });
            }
            if edge[0] != edge[1] {
                kept.push(edge);
            }
        }
        for [from, to] in self.segments(facet, passages)? {
            kept.push([from, to]);
            rim.push([to, from]);
        }
        cancel(&mut kept);
        Some(kept)
    }

    /// The segments between passages, divided at all vertices of the facet that lie on them.
    fn segments(
        &self,
        facet: &NumberedFacet,
        mut passages: Vec<Passage>,
    ) -> Option<Vec<[LoopCorner; 2]>> {
        let mut segments = Vec::new();
        if passages.is_empty() {
            return Some(segments);
        }
        let line = facet.normal.cross(&self.wall.normal);
        let along = |corner: LoopCorner| line.dot(&self.position(corner).coords);
        let starts = facet.edges.iter().map(|edge| edge[0]);
        let on_wall = starts.filter(|start| self.excess_of(*start) == 0.0);
        let mut on_wall: Vec<_> = on_wall.map(|start| (along(start), start)).collect();
        on_wall.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        on_wall.dedup();
        passages.sort_by(|one, other| {
            let by_place = one.along.total_cmp(&other.along);
            by_place.then(one.vertex.cmp(&other.vertex))
        });
        for number in 0..passages.len() {
            // Two of one vertex in the order that alternates.
            let next = passages.get(number + 1);
            let is_wrong = passages[number].leaves != number.is_multiple_of(2);
            if is_wrong && next.is_some_and(|next| next.vertex == passages[number].vertex) {
                passages.swap(number, number + 1);
            }
        }
        let (pairs, rest) = passages.as_chunks::<2>();
        for [start, end] in pairs {
            if !start.leaves || end.leaves {
                return None;
            }
            let between = on_wall.iter();
            let between = between.filter(|(at, _)| start.along < *at && *at < end.along);
            let mut from = start.vertex;
            for to in between.map(|(_, corner)| *corner).chain([end.vertex]) {
                if from != to {
                    segments.push([from, to]);
                }
                from = to;
            }
        }
        rest.is_empty().then_some(segments)
    }

    fn position(&self, corner: LoopCorner) -> &Point3<f64> {
        &self.positions[corner.number() as usize]
    }

    fn excess_of(&self, corner: LoopCorner) -> f64 {
        self.excess[corner.number() as usize]
    }

    /// Where an edge passes the wall: its inner end if that is on it.
    fn crossing(&mut self, inner: LoopCorner, outer: LoopCorner) -> LoopCorner {
        if self.excess_of(inner) >= 0.0 {
            return inner;
        }
        let [low, high] = [inner.min(outer), inner.max(outer)];
        let [below, above] = [low, high].map(|corner| self.excess_of(corner));
        let [from, to] = [low, high].map(|corner| *self.position(corner));
        let Self {
            positions,
            excess,
            crossings,
            ..
        } = self;
        let key = [low.number(), high.number()];
        let number = *crossings.entry(key).or_insert_with(|| {
            positions.push(from + (to - from) * (below / (below - above)));
            excess.push(0.0);
            positions.len() as u32 - 1
        });
        LoopCorner::new(number, NO_SHIFT)
    }
}

/// Removes edges that run both ways.
fn cancel(edges: &mut Vec<[LoopCorner; 2]>) {
    let mut number = 0;
    while number < edges.len() {
        let [from, to] = edges[number];
        match edges.iter().position(|edge| *edge == [to, from]) {
            Some(other) => {
                edges.swap_remove(number.max(other));
                edges.swap_remove(number.min(other));
            }
            None => number += 1,
        }
    }
}
