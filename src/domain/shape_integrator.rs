//! Integrals over what a shape has in common with a box, and points of it.

use nalgebra::{Point3, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::mesh_moments::mass_of_piece;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::Monomials;

/// How far a vertex of a part is drawn towards the part's middle, so that rounding leaves it inside.
const INWARD: f64 = 1e-9;

/// A shape with the convex polyhedron around it from which the cell of the middle of its bounds
/// would be cut, relative to that middle.
pub(crate) struct ShapeIntegrator<'a> {
    pub(crate) shape: &'a dyn DomainShape,
    middle: Point3<f64>,
    start: Polyhedron,
}

impl<'a> ShapeIntegrator<'a> {
    pub(crate) fn new(shape: &'a dyn DomainShape) -> Self {
        let (middle, mut start) = (shape.bounds().center(), Polyhedron::default());
        shape.start(&middle, 0, &mut start);
        Self {
            shape,
            middle,
            start,
        }
    }

    /// Visits the signed pieces of what the shape, the box and the half-spaces have in common, in
    /// coordinates relative to `origin`.
    fn pieces_within(
        &self,
        (bounds, planes): (&Bounds<3>, &[HalfSpace]),
        origin: &Point3<f64>,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        let (mut part, mut scratch) = (Polyhedron::default(), PieceScratch::default());
        part.assign_translated(&self.start, &(self.middle - origin));
        if clip_to_box(&mut part, origin, bounds, &mut scratch.clip)
            && clip_to_planes(&mut part, origin, planes, &mut scratch.clip)
        {
            let shape = self.shape;
            shape.signed_pieces(origin, &part, false, &mut scratch, visit);
        }
    }

    /// ∫ density over what the shape and the box have in common; `density` is relative to `origin`.
    pub(crate) fn mass_within(
        &self,
        bounds: &Bounds<3>,
        origin: &Point3<f64>,
        density: &Polynomial,
    ) -> f64 {
        let monomials = Monomials::up_to(density.degree());
        self.mass_of_terms((bounds, &[]), origin, density, &monomials)
    }

    /// The same within half-spaces too, where all terms are in `monomials`.
    pub(crate) fn mass_of_terms(
        &self,
        within: (&Bounds<3>, &[HalfSpace]),
        origin: &Point3<f64>,
        density: &Polynomial,
        monomials: &Monomials,
    ) -> f64 {
        let mut mass = 0.0;
        self.pieces_within(within, origin, &mut |sign, piece| {
            mass += sign * mass_of_piece(piece, density, monomials);
        });
        mass
    }

    /// The middle of the shape's bounds.
    pub(crate) fn middle(&self) -> &Point3<f64> {
        &self.middle
    }

    /// Whether the shape fills a part of the box, however small beyond rounding.
    pub(crate) fn fills_some(&self, bounds: &Bounds<3>) -> bool {
        let volume = self.mass_within(bounds, &self.middle, &Polynomial::constant(1.0));
        let rounding = f64::EPSILON * self.shape.bounds().volume();
        volume > rounding
    }

    /// Points of the shape in the box: corners of their common part, a trifle inward; none where
    /// nothing is in common.
    pub(crate) fn points_within(&self, bounds: &Bounds<3>) -> Vec<Point3<f64>> {
        let mut points = Vec::new();
        self.pieces_within((bounds, &[]), &self.middle, &mut |_, piece| {
            let vertices = piece.vertices();
            let sum: Vector3<f64> = vertices.iter().map(|vertex| vertex.coords).sum();
            let inner = sum / vertices.len().max(1) as f64;
            let drawn = |vertex: &Point3<f64>| vertex + (inner - vertex.coords) * INWARD;
            let placed = |vertex: &Point3<f64>| self.middle + drawn(vertex).coords;
            points.extend(vertices.iter().map(placed));
            points.push(self.middle + inner);
        });
        points
    }
}

/// Clips `part`, in coordinates relative to `site`, to the box, whose infinite sides cut nothing,
/// and returns whether anything is left.
pub(crate) fn clip_to_box(
    part: &mut Polyhedron,
    site: &Point3<f64>,
    bounds: &Bounds<3>,
    scratch: &mut ClipScratch,
) -> bool {
    for axis in 0..3 {
        let mut normal = Vector3::zeros();
        normal[axis] = 1.0;
        let upper = bounds.max[axis] - site[axis];
        let lower = site[axis] - bounds.min[axis];
        for (normal, offset) in [(normal, upper), (-normal, lower)] {
            let side = HalfSpace { normal, offset };
            let label = FacetKind::Inner.label();
            if offset.is_finite() && clip(part, &side, label, scratch) == Clip::Emptied {
                return false;
            }
        }
    }
    true
}

/// Clips `part`, in coordinates relative to `site`, to half-spaces, and returns whether anything is left.
pub(crate) fn clip_to_planes(
    part: &mut Polyhedron,
    site: &Point3<f64>,
    planes: &[HalfSpace],
    scratch: &mut ClipScratch,
) -> bool {
    let label = FacetKind::Inner.label();
    planes.iter().all(|plane| {
        let side = plane.translated(&-site.coords);
        clip(part, &side, label, scratch) != Clip::Emptied
    })
}
