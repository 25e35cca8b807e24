//! The part of a convex cell within a closed surface, assembled from its boundary.
//!
//! The boundary of C ∩ Ω consists of the triangles' parts in the cell and of the inner parts of the
//! cell's facets. The first are convex polygons whose borders carry the facet that cut them. Run
//! backwards, these borders bound the second, together with the inner parts of the cell's own
//! edges; and those begin and end exactly at the corners in which a triangle meets the two facets
//! of the edge. Viewed from outside the solid, a corner at which the border passes from facet F to
//! facet G ends the inner part of the edge that has F on its left, and begins it the other way
//! round. So the cell's vertices need not be tested: an edge that the surface crosses determines on
//! which side its ends are, and an edge that it does not cross has both ends on one side.
//!
//! Every step is combinatorial, and every one is checked. A coincidence, or rounding, that breaks
//! the pattern is reported as [`ClipStatus::Inconsistent`]: then the result is not to be used.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::domain::tri_surface::edges::{CellEdges, Crossing};
use crate::domain::tri_surface::indexed::IndexedSurface;
use crate::domain::tri_surface::triangle::{Border, Corner, FacetPlane, Origin, TriangleClip};
use crate::geometry::brep::{Brep, Edge, Extent, Piece};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// How far the boundary may be from closed, and the volume outside its bounds, relative to area
/// and volume. Errors that the checks before do not detect are far larger.
const CLOSED: f64 = 1e-9;

/// What a cell and a solid have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClipStatus {
    /// No triangle touches the cell.
    Disjoint,
    /// The common part is [`ClippedCell::part`].
    Clipped,
    /// No consistent boundary was found.
    Inconsistent,
}

/// The common part of a cell and a solid, and the memory to find it.
#[derive(Clone, Debug, Default)]
pub struct ClippedCell {
    /// The common part, in coordinates relative to the site.
    pub part: Brep,
    candidates: Vec<u32>,
    planes: Vec<FacetPlane>,
    triangle: TriangleClip,
    shared: CornerNumbers,
    /// (edge of the surface, forward, polygon, from, to).
    sides: Vec<(u32, bool, u32, [u32; 2])>,
    crossings: Vec<Crossing>,
    edges: CellEdges,
}

impl ClippedCell {
    /// Finds what `cell`, in coordinates relative to `site`, and the solid within `surface` have in
    /// common.
    pub fn clip(
        &mut self,
        surface: &IndexedSurface,
        site: &Point3<f64>,
        cell: &Polyhedron,
    ) -> ClipStatus {
        if surface.is_clear(site, cell) || !self.find_candidates(surface, site, cell) {
            return ClipStatus::Disjoint;
        }
        self.begin(cell);
        self.clip_triangles(surface, site);
        if self.part.edges.is_empty() && self.sides.is_empty() {
            return ClipStatus::Disjoint;
        }
        let winding = || surface.winding(&(site + cell.vertex(0).coords));
        if self.pair_sides() && self.close(cell, winding) && self.is_sound(cell) {
            ClipStatus::Clipped
        } else {
            ClipStatus::Inconsistent
        }
    }

    /// Lists the triangles that may touch the cell; returns whether there are any.
    fn find_candidates(
        &mut self,
        surface: &IndexedSurface,
        site: &Point3<f64>,
        cell: &Polyhedron,
    ) -> bool {
        self.candidates.clear();
        surface.candidates(site, cell, &mut self.candidates);
        !self.candidates.is_empty()
    }

    /// Removes the last part and lists the cell's facets.
    fn begin(&mut self, cell: &Polyhedron) {
        self.part.clear();
        let facets = cell.planes.iter().copied().zip(cell.labels.iter().copied());
        self.part.facets.extend(facets);
        self.planes.clear();
        let planes = cell.facets();
        self.planes
            .extend(planes.map(|facet| FacetPlane::new(facet.number as u32, facet.half_space())));
        self.shared.clear();
        self.sides.clear();
        self.crossings.clear();
    }

    fn clip_triangles(&mut self, surface: &IndexedSurface, site: &Point3<f64>) {
        let mut clip = std::mem::take(&mut self.triangle);
        let candidates = std::mem::take(&mut self.candidates);
        for &triangle in &candidates {
            let corners = surface.triangle(triangle, site);
            let polygon = clip.clip(&corners, &self.planes);
            if polygon.is_empty() {
                continue;
            }
            let [a, b, c] = corners.map_each(|corner| corner.position);
            let normal = (b - a).cross(&(c - a));
            let half_space = HalfSpace {
                normal,
                offset: normal.dot(&a),
            };
            self.part.facets.push((half_space, surface.label(triangle)));
            self.push_polygon(polygon, surface, triangle);
        }
        (self.triangle, self.candidates) = (clip, candidates);
    }

    /// Adds the edges of a triangle's part, and the crossings at its corners.
    fn push_polygon(&mut self, polygon: &[Corner], surface: &IndexedSurface, triangle: u32) {
        let facet = self.part.facets.len() as u32 - 1;
        let first = self.number(&polygon[0]);
        let mut from = first;
        for (place, corner) in polygon.iter().enumerate() {
            let following = polygon.get(place + 1);
            let to = following.map_or(first, |corner| self.number(corner));
            match corner.border {
                Border::Side(edge) => {
                    let forward = surface.runs_forward(triangle, edge);
                    self.sides.push((edge, forward, facet, [from, to]));
                }
                Border::Plane(plane) => {
                    self.part.edges.push(Edge::new([from, to], [facet, plane]));
                    let (vertex, following) = (to, following.unwrap_or(&polygon[0]));
                    self.crossings
                        .extend(Crossing::between(plane, following.border, vertex));
                }
            }
            from = to;
        }
    }

    fn number(&mut self, corner: &Corner) -> u32 {
        let vertices = &mut self.part.vertices;
        self.shared.of(corner.origin, || {
            vertices.push(corner.position);
            vertices.len() as u32 - 1
        })
    }

    /// Joins the sides that run along one edge of the surface in opposite directions.
    fn pair_sides(&mut self) -> bool {
        self.sides.sort_unstable();
        for group in self.sides.chunk_by(|one, other| one.0 == other.0) {
            let split = group.partition_point(|side| !side.1);
            let (backward, forward) = group.split_at(split);
            if backward.len() != forward.len() {
                return false;
            }
            for (one, other) in forward.iter().zip(backward) {
                let [from, to] = one.3;
                if other.3 != [to, from] {
                    return false;
                }
                self.part
                    .edges
                    .push(Edge::new([from, to], [one.2, other.2]));
            }
        }
        true
    }

    /// Adds the inner parts of the cell's edges. Where the surface crosses none of them, the
    /// `winding` number of vertex 0 gives its side.
    fn close(&mut self, cell: &Polyhedron, winding: impl Fn() -> Option<i32>) -> bool {
        let (edges, part) = (&mut self.edges, &mut self.part);
        edges.cut(&self.crossings, &part.vertices, cell)
            && edges.propagate(cell, winding)
            && edges.push_inner(cell, part)
    }

    /// Whether the boundary is closed and its volume between nothing and the cell's.
    fn is_sound(&self, cell: &Polyhedron) -> bool {
        let Extent { area, gap, volume } = Piece::Brep(&self.part).extent();
        let whole = Piece::Convex(cell).extent().volume;
        gap.norm() <= CLOSED * area && (-CLOSED * whole..=whole * (1.0 + CLOSED)).contains(&volume)
    }
}

/// The numbers of the corners that triangles share within a cell, by what made the corner.
#[derive(Clone, Debug, Default)]
struct CornerNumbers {
    numbers: HashMap<u64, u32, BuildHasherDefault<FibonacciHasher>>,
}

impl CornerNumbers {
    fn clear(&mut self) {
        self.numbers.clear();
    }

    /// The number of the corner, which `make` gives to a new one. A corner within one triangle is
    /// always new.
    fn of(&mut self, origin: Origin, make: impl FnOnce() -> u32) -> u32 {
        let key = match origin {
            Origin::Within => return make(),
            Origin::Vertex(vertex) => u64::from(vertex),
            Origin::Side { edge, plane } => {
                1 << 63 | u64::from(edge) << 31 | u64::from(plane & 0x7fff_ffff)
            }
        };
        *self.numbers.entry(key).or_insert_with(make)
    }
}

/// Fibonacci hashing: a cell looks up many numbers, and those of a mesh need no protection.
#[derive(Clone, Copy, Debug, Default)]
struct FibonacciHasher(u64);

impl Hasher for FibonacciHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        let mixed = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 32);
    }
}
