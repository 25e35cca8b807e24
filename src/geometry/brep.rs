//! Solids given by their boundary: plane facets that need be neither convex nor connected.
//!
//! A cell clipped to a solid is of this kind: parts of the cell's facets, perhaps with holes, and
//! convex parts of the solid's triangles. Every edge lies between two facets, which run along it in
//! opposite directions, so that each facet's edges form closed loops.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::facet_polygons::polygons;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;

/// The boundary representation of a bounded solid: its facets, edges and vertices.
#[derive(Clone, Debug, Default)]
pub struct Brep {
    pub(crate) vertices: Vec<Vector3<f64>>,
    pub(crate) facets: Vec<(HalfSpace, Label)>,
    pub(crate) edges: Vec<Edge>,
}

/// An edge: with the solid's outside above, facet `left` lies left of it and `right` right of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    pub(crate) from: u32,
    pub(crate) to: u32,
    pub(crate) left: u32,
    pub(crate) right: u32,
}

/// A part of a cell in a domain.
#[derive(Clone, Copy, Debug)]
pub enum Piece<'a> {
    /// A convex part.
    Convex(&'a Polyhedron),
    /// A part of any shape.
    Brep(&'a Brep),
}

/// How much there is of a solid, and how far its boundary is from closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// The area of all facets (L²).
    pub area: f64,
    /// The sum of all facets' areas times outward normals (L²): zero for a closed boundary.
    pub gap: Vector3<f64>,
    /// The volume (L³).
    pub volume: f64,
}

impl Edge {
    /// The edge between two vertices, with the facets left and right of it.
    #[inline(always)]
    pub(crate) fn new([from, to]: [u32; 2], [left, right]: [u32; 2]) -> Self {
        Self {
            from,
            to,
            left,
            right,
        }
    }
}

impl Brep {
    /// Becomes the empty set, keeping its memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.facets.clear();
        self.edges.clear();
    }

    /// Every edge twice: the facet on its left, from where, to where (vertex numbers).
    pub fn sides(&self) -> impl Iterator<Item = (u32, [u32; 2])> + '_ {
        self.edges.iter().flat_map(|edge| {
            let (from, to) = (edge.from, edge.to);
            [(edge.left, [from, to]), (edge.right, [to, from])]
        })
    }

    /// Every facet as signed triangles from one of its vertices: its number and the triangle.
    fn triangles(&self) -> impl Iterator<Item = (usize, [Vector3<f64>; 3])> {
        let mut anchors = vec![None; self.facets.len()];
        self.sides().map(move |(facet, side)| {
            let [a, b] = side.map_each(|vertex| self.vertices[vertex as usize]);
            let facet = facet as usize;
            (facet, [*anchors[facet].get_or_insert(a), a, b])
        })
    }
}

impl Piece<'_> {
    /// Volume and moments about the origin of its coordinates.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        self.visit_triangles(|triangle| moments.add_cone(triangle));
        moments
    }

    /// Area, gap and volume alone.
    #[must_use]
    pub fn extent(&self) -> Extent {
        let mut extent = Extent::default();
        self.visit_facets(|_, point, area| {
            extent.gap += area;
            extent.area += area.norm();
            extent.volume += point.dot(&area) / 3.0;
        });
        extent
    }

    /// Calls `visit` with the label, a point and the area vector (L²) of every facet.
    pub fn visit_facets(&self, mut visit: impl FnMut(Label, Vector3<f64>, Vector3<f64>)) {
        match self {
            Self::Convex(piece) => {
                for facet in piece.facets() {
                    let point = facet.corners().next().unwrap_or_default();
                    visit(facet.label(), point.coords, facet.area_vector());
                }
            }
            Self::Brep(piece) => {
                let mut areas = vec![(Vector3::zeros(), Vector3::zeros()); piece.facets.len()];
                for (facet, [anchor, a, b]) in piece.triangles() {
                    let (point, area) = &mut areas[facet];
                    *point = anchor;
                    *area += (a - anchor).cross(&(b - anchor)) * 0.5;
                }
                for ((point, area), (_, label)) in areas.into_iter().zip(&piece.facets) {
                    visit(*label, point, area);
                }
            }
        }
    }

    /// Its vertices, relative to the origin of its coordinates (L).
    #[must_use]
    pub fn vertices(&self) -> Vec<Point3<f64>> {
        match self {
            Self::Convex(piece) => piece.vertices().collect(),
            Self::Brep(piece) => piece.vertices.iter().map(|&vertex| vertex.into()).collect(),
        }
    }

    /// Calls `visit` with the label, the outward normal and a loop of vertex numbers, counter-clockwise
    /// from outside, of every polygon of every facet.
    pub fn visit_polygons(&self, mut visit: impl FnMut(Label, &Vector3<f64>, &[u32])) {
        match self {
            Self::Convex(piece) => {
                for facet in piece.facets() {
                    let corners: Vec<u32> = facet.vertex_numbers().map(|v| v as u32).collect();
                    visit(facet.label(), &facet.half_space().normal, &corners);
                }
            }
            Self::Brep(piece) => {
                let mut sides: Vec<(u32, [u32; 2])> = piece.sides().collect();
                sides.sort_unstable();
                for group in sides.chunk_by(|one, other| one.0 == other.0) {
                    let edges: Vec<[u32; 2]> = group.iter().map(|side| side.1).collect();
                    let (half_space, label) = &piece.facets[group[0].0 as usize];
                    for corners in polygons(&edges, &piece.vertices, &half_space.normal) {
                        visit(*label, &half_space.normal, &corners);
                    }
                }
            }
        }
    }

    /// Calls `visit` with every triangle of its facets' signed fans.
    pub fn visit_triangles(&self, mut visit: impl FnMut([Vector3<f64>; 3])) {
        match self {
            Self::Convex(piece) => {
                let triangles = piece.facets().flat_map(|facet| facet.triangles());
                triangles.for_each(visit);
            }
            Self::Brep(piece) => piece.triangles().for_each(|(_, triangle)| visit(triangle)),
        }
    }
}
