//! Solids given by their boundary: plane facets that need be neither convex nor connected.
//!
//! A cell clipped to a solid is of this kind: parts of the cell's facets, perhaps with holes, and
//! convex parts of the solid's triangles. Every edge lies between two facets, which run along it in
//! opposite directions, so that each facet's edges form closed loops.

use nalgebra::{Point3, Vector3};

use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;

/// A bounded solid by its facets, edges and vertices.
#[derive(Clone, Debug, Default)]
pub struct Faceted {
    pub(crate) vertices: Vec<Vector3<f64>>,
    pub(crate) facets: Vec<(HalfSpace, Label)>,
    pub(crate) edges: Vec<Edge>,
}

/// An edge: facet `left` lies left of it, seen from outside, and `right` right of it.
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
    Faceted(&'a Faceted),
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

impl Faceted {
    /// Becomes the empty set, keeping its memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.facets.clear();
        self.edges.clear();
    }

    /// The positions of the vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Point3<f64>> + '_ {
        self.vertices.iter().map(|vertex| Point3::from(*vertex))
    }

    /// How many facets there are; some may have no edges.
    #[must_use]
    pub fn facet_count(&self) -> usize {
        self.facets.len()
    }

    /// A facet's label.
    ///
    /// # Panics
    /// If there is no such facet.
    #[must_use]
    pub fn label(&self, facet: usize) -> Label {
        self.facets[facet].1
    }

    /// Every edge twice: the facet on its left, from where, to where (vertex numbers).
    pub fn sides(&self) -> impl Iterator<Item = (u32, [u32; 2])> + '_ {
        self.edges.iter().flat_map(|edge| {
            let Edge {
                from,
                to,
                left,
                right,
            } = *edge;
            [(left, [from, to]), (right, [to, from])]
        })
    }

    /// Per facet its area times its outward normal (L²), in the order of the facets.
    #[must_use]
    pub fn area_vectors(&self) -> Vec<Vector3<f64>> {
        let mut areas = vec![Vector3::zeros(); self.facets.len()];
        for (facet, anchor, [a, b]) in self.fans() {
            areas[facet as usize] += (a - anchor).cross(&(b - anchor)) * 0.5;
        }
        areas
    }

    /// Area, gap and volume in one walk.
    #[must_use]
    pub fn extent(&self) -> Extent {
        let mut facets = vec![(Vector3::zeros(), Vector3::zeros()); self.facets.len()];
        for (facet, anchor, [a, b]) in self.fans() {
            let (base, doubled) = &mut facets[facet as usize];
            *base = anchor;
            *doubled += (a - anchor).cross(&(b - anchor));
        }
        let mut extent = Extent::default();
        for (base, doubled) in facets {
            extent.gap += doubled * 0.5;
            extent.area += doubled.norm() * 0.5;
            extent.volume += base.dot(&doubled) / 6.0;
        }
        extent
    }

    /// Volume and moments about the origin of its coordinates.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        for (_, anchor, [a, b]) in self.fans() {
            moments.add_tetrahedron(&anchor, &a, &b);
        }
        moments
    }

    /// Every facet as signed triangles: the facet, its anchor and a directed edge of it.
    fn fans(&self) -> impl Iterator<Item = (u32, Vector3<f64>, [Vector3<f64>; 2])> {
        let mut anchors = vec![None; self.facets.len()];
        self.sides().map(move |(facet, side)| {
            let [a, b] = side.map(|vertex| self.vertices[vertex as usize]);
            let anchor: Vector3<f64> = *anchors[facet as usize].get_or_insert(a);
            (facet, anchor, [a, b])
        })
    }
}

impl Piece<'_> {
    /// Volume and moments about the origin of its coordinates.
    #[must_use]
    pub fn moments(&self) -> Moments {
        match self {
            Self::Convex(piece) => Moments::of(piece),
            Self::Faceted(piece) => piece.moments(),
        }
    }

    /// Calls `visit` with the label and the area vector (L²) of every facet.
    pub fn visit_areas(&self, mut visit: impl FnMut(Label, Vector3<f64>)) {
        match self {
            Self::Convex(piece) => {
                for facet in piece.facets() {
                    visit(facet.label(), facet.area_vector());
                }
            }
            Self::Faceted(piece) => {
                let areas = piece.area_vectors().into_iter();
                for (area, (_, label)) in areas.zip(&piece.facets) {
                    visit(*label, area);
                }
            }
        }
    }

    /// Calls `visit` with every triangle (anchor, a, b) of its facets' signed fans.
    pub fn visit_fans(&self, mut visit: impl FnMut(Vector3<f64>, Vector3<f64>, Vector3<f64>)) {
        match self {
            Self::Convex(piece) => {
                for facet in piece.facets() {
                    let mut corners = facet.corners().map(|corner| corner.coords);
                    let (Some(anchor), Some(mut last)) = (corners.next(), corners.next()) else {
                        continue;
                    };
                    for corner in corners {
                        visit(anchor, last, corner);
                        last = corner;
                    }
                }
            }
            Self::Faceted(piece) => {
                for (_, anchor, [a, b]) in piece.fans() {
                    visit(anchor, a, b);
                }
            }
        }
    }
}
