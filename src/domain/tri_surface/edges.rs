//! The parts of a cell's edges inside a surface, from the surface's crossings with them.
//!
//! The crossings on an edge must alternate between ends and beginnings of inner parts. They determine
//! on which side of the surface the edge's vertices are. Along edges that are not crossed the side
//! stays the same; since the edges of a convex polyhedron are connected, all vertices are reached. Every step returns whether
//! the crossings are consistent so far.

use nalgebra::Vector3;

use crate::arrays::MapEach;
use crate::domain::tri_surface::triangle::Border;
use crate::geometry::brep::{Brep, Edge};
use crate::geometry::polyhedron::Polyhedron;

/// Where a triangle meets two facets of the cell, in their order along the triangle's boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub(crate) before: u32,
    pub(crate) after: u32,
    pub(crate) vertex: u32,
}

impl Crossing {
    /// The crossing in a vertex from facet `before` to the one of the next border, if that lies on one.
    pub(crate) fn between(before: u32, next: Border, vertex: u32) -> Option<Self> {
        let Border::Plane(after) = next else {
            return None;
        };
        Some(Self {
            before,
            after,
            vertex,
        })
    }
}

/// A crossing on an edge of the cell.
#[derive(Clone, Copy, Debug)]
struct EdgeCut {
    /// The edge's number in the order of [`edges`].
    edge: u32,
    /// Where along the edge.
    along: f64,
    /// Whether an inner part ends here.
    ends: bool,
    vertex: u32,
}

/// The crossings of a cell's edges, and the sides of its vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellEdges {
    cuts: Vec<EdgeCut>,
    inside: Vec<Option<bool>>,
    crossed: Vec<[bool; 3]>,
    /// The numbers in the part of the cell's vertices.
    numbers: Vec<u32>,
    stack: Vec<u32>,
}

const UNNUMBERED: u32 = u32::MAX;

/// Where two cuts of an edge are closer than this share of its length, as where it touches an edge of the surface,
/// their order may be the wrong one, which would turn inside into outside.
const APART: f64 = 1e-9;

impl CellEdges {
    /// Finds every crossing's place on an edge of the cell, and the sides of the ends of crossed edges.
    pub(crate) fn cut(
        &mut self,
        crossings: &[Crossing],
        vertices: &[Vector3<f64>],
        cell: &Polyhedron,
    ) -> bool {
        let (cuts, inside, crossed) = (&mut self.cuts, &mut self.inside, &mut self.crossed);
        cuts.clear();
        inside.clear();
        inside.resize(cell.vertex_count(), None);
        crossed.clear();
        crossed.resize(cell.vertex_count(), [false; 3]);
        if crossings.is_empty() {
            return true;
        }
        for (number, edge) in edges(cell).enumerate() {
            let CellEdge { from, slot, to, .. } = edge;
            let [start, end] = [from, to].map_each(|vertex| cell.vertex(vertex as usize).coords);
            let place = |vertex: u32| (end - start).dot(&(vertices[vertex as usize] - start));
            let first = cuts.len();
            let found = crossings.iter().filter_map(|crossing| edge.cut(crossing));
            cuts.extend(found.map(|(ends, vertex)| EdgeCut {
                edge: number as u32,
                along: place(vertex),
                ends,
                vertex,
            }));
            let on_edge = &mut cuts[first..];
            on_edge.sort_by(|one, other| one.along.total_cmp(&other.along));
            let (Some(first), Some(last)) = (on_edge.first(), on_edge.last()) else {
                continue;
            };
            let apart = APART * (end - start).norm_squared();
            let in_order = on_edge
                .windows(2)
                .all(|pair| pair[0].ends != pair[1].ends && pair[1].along - pair[0].along > apart);
            if !(in_order
                && agree(&mut inside[from as usize], first.ends)
                && agree(&mut inside[to as usize], !last.ends))
            {
                return false;
            }
            crossed[from as usize][slot] = true;
            crossed[to as usize][cell.slot(to as usize, edge.right)] = true;
        }
        cuts.len() == crossings.len()
    }

    /// Propagates the sides of the vertices along the edges that are not crossed. Where none is
    /// crossed, the `winding` number of vertex 0 gives its side.
    pub(crate) fn propagate(
        &mut self,
        cell: &Polyhedron,
        winding: impl Fn() -> Option<i32>,
    ) -> bool {
        if self.cuts.is_empty() {
            match winding() {
                Some(winding @ 0..=1) => self.inside[0] = Some(winding == 1),
                _ => return false,
            }
        }
        let (stack, inside, crossed) = (&mut self.stack, &mut self.inside, &self.crossed);
        stack.clear();
        stack.extend((0..inside.len() as u32).filter(|&v| inside[v as usize].is_some()));
        while let Some(vertex) = stack.pop() {
            let Some(side) = inside[vertex as usize] else {
                continue;
            };
            for slot in 0..3 {
                if crossed[vertex as usize][slot] {
                    continue;
                }
                let neighbor = cell.next[vertex as usize][slot];
                let known = &mut inside[neighbor as usize];
                if known.is_none() {
                    stack.push(neighbor);
                }
                if !agree(known, side) {
                    return false;
                }
            }
        }
        true
    }

    /// Adds the inner parts of the cell's edges.
    pub(crate) fn push_inner(&mut self, cell: &Polyhedron, part: &mut Brep) -> bool {
        self.numbers.clear();
        self.numbers.resize(cell.vertex_count(), UNNUMBERED);
        let mut cut = 0;
        for (number, edge) in edges(cell).enumerate() {
            let is_inside = |vertex: u32| self.inside[vertex as usize] == Some(true);
            let [from_inside, to_inside] = [edge.from, edge.to].map_each(is_inside);
            let mut begun = from_inside.then(|| self.number(cell, edge.from, part));
            while let Some(&EdgeCut { ends, vertex, .. }) =
                self.cuts.get(cut).filter(|cut| cut.edge == number as u32)
            {
                cut += 1;
                if !ends {
                    begun = Some(vertex);
                } else if !push(part, begun.take(), vertex, &edge) {
                    return false;
                }
            }
            if to_inside {
                let to = self.number(cell, edge.to, part);
                if !push(part, begun, to, &edge) {
                    return false;
                }
            }
        }
        true
    }

    /// The number in the part of a vertex of the cell.
    fn number(&mut self, cell: &Polyhedron, vertex: u32, part: &mut Brep) -> u32 {
        let number = &mut self.numbers[vertex as usize];
        if *number == UNNUMBERED {
            *number = part.vertices.len() as u32;
            part.vertices.push(cell.vertex(vertex as usize).coords);
        }
        *number
    }
}

/// Adds the part of the edge from the vertex `begun` to `to`; returns whether there is such a vertex.
fn push(part: &mut Brep, begun: Option<u32>, to: u32, edge: &CellEdge) -> bool {
    let facets = [edge.left, edge.right];
    let inner = begun.map(|from| Edge::new([from, to], facets));
    part.edges.extend(inner);
    begun.is_some()
}

/// An edge of the cell: it leaves vertex `from` in `slot`.
#[derive(Clone, Copy, Debug)]
struct CellEdge {
    from: u32,
    slot: usize,
    to: u32,
    left: u32,
    right: u32,
}

impl CellEdge {
    /// Whether an inner part ends at a crossing, and its vertex, if it lies on this edge.
    fn cut(&self, crossing: &Crossing) -> Option<(bool, u32)> {
        let ends = (crossing.before, crossing.after) == (self.left, self.right);
        let begins = (crossing.after, crossing.before) == (self.left, self.right);
        (ends || begins).then_some((ends, crossing.vertex))
    }
}

/// Every edge of the cell once.
fn edges(cell: &Polyhedron) -> impl Iterator<Item = CellEdge> + '_ {
    let ends = cell.next.iter().zip(&cell.facets).zip(0..);
    ends.flat_map(|((next, facets), from)| {
        let edge = move |slot: usize| CellEdge {
            from,
            slot,
            to: next[slot],
            left: facets[slot],
            right: facets[(slot + 2) % 3],
        };
        [0, 1, 2]
            .map_each(edge)
            .into_iter()
            .filter(|edge| edge.from < edge.to)
    })
}

/// Sets the side if it is unknown; returns whether it agrees with `side`.
fn agree(known: &mut Option<bool>, side: bool) -> bool {
    *known.get_or_insert(side) == side
}
