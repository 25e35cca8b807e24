//! ∫∫ and ∫∫∫ of all monomials up to a degree over a surface or a solid, and of polynomials.
//!
//! All are summed in one pass about the middle of the bounding box, where they are as small as they
//! can be, and moved to the origin of the coordinates afterwards, with 106 bits: x^α y^β z^γ is a
//! polynomial in the distances from the middle. So an error is some roundings of the integral of the
//! monomial's absolute value, wherever the body lies.

use std::ops::Add;

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::simd::{cross, dot, sum};
use crate::integrals::formula::Formula;
use crate::integrals::lanes::{LanePoint, Lanes, WIDTH, gathered, named, splat};
use crate::integrals::mesh_moments::monomials_of_solid;
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};

/// The integrals of all monomials up to a degree over one body.
#[derive(Clone, Debug)]
pub(crate) struct MonomialIntegrals {
    monomials: Monomials,
    /// In the order of the monomials, about the center.
    about_center: Vec<f64>,
    center: Point3<f64>,
}

impl MonomialIntegrals {
    /// Over a triangulated surface, open or closed: \[CP\] eq. 12. With a `side`, a triangle counts
    /// positive if it shows its front to it, negative if its back, not at all on edge.
    #[must_use]
    pub(crate) fn over_surface(
        vertices: &[Point3<f64>],
        triangles: &[[u32; 3]],
        degree: u32,
        side: Option<&Vector3<f64>>,
    ) -> Self {
        let monomials = Monomials::up_to(degree);
        let center = center(vertices, triangles);
        let sums = surface_sums(vertices, triangles, &monomials, &center, side);
        let weighed = monomials.exponents().iter().zip(sums.0);
        let about_center = weighed.map(|(&exponents, sum)| weight(2, exponents) / 2.0 * sum);
        Self {
            about_center: about_center.collect(),
            monomials,
            center,
        }
    }

    /// Over the solid within a closed surface (`K` = 3) or over tetrahedra (`K` = 4).
    #[must_use]
    pub(crate) fn over_solid<const K: usize>(
        vertices: &[Point3<f64>],
        simplices: &[[u32; K]],
        degree: u32,
    ) -> Self {
        let monomials = Monomials::up_to(degree);
        let center = center(vertices, simplices);
        Self {
            about_center: monomials_of_solid(vertices, simplices, &monomials, &center),
            monomials,
            center,
        }
    }

    /// The monomials.
    pub(crate) fn exponents(&self) -> &[Exponents] {
        self.monomials.exponents()
    }

    /// ∫ x^α y^β z^γ.
    #[must_use]
    pub(crate) fn of(&self, exponents: Exponents) -> f64 {
        let term = Formula::of_terms([(exponents, 1.0)].into_iter());
        self.of_polynomial(&Polynomial::of_formula(term))
    }

    /// The integral of a polynomial, whose degree is not above that of the monomials.
    #[must_use]
    pub(crate) fn of_polynomial(&self, polynomial: &Polynomial) -> f64 {
        let moved = polynomial.relative_to(&self.center);
        let terms = moved.coefficients(&self.monomials);
        let terms = terms.into_iter().zip(&self.about_center);
        terms.map(|(value, integral)| value * integral).sum()
    }
}

/// The middle of the bounding box of the vertices that are used.
fn center<const K: usize>(vertices: &[Point3<f64>], simplices: &[[u32; K]]) -> Point3<f64> {
    let used = simplices.iter().flatten();
    Bounds::of(used.map(|&vertex| &vertices[vertex as usize])).center()
}

/// Σ doubled area · coefficient per monomial.
struct SurfaceSums(Vec<f64>);

impl Add for SurfaceSums {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (sum, term) in self.0.iter_mut().zip(other.0) {
            *sum += term;
        }
        self
    }
}

fn surface_sums(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    monomials: &Monomials,
    origin: &Point3<f64>,
    side: Option<&Vector3<f64>>,
) -> SurfaceSums {
    let apex = splat(origin);
    sum_by_halves(triangles.len(), &|range| {
        let mut sums = vec![Lanes::ZERO; monomials.exponents().len()];
        let mut table = Vec::new();
        for block in triangles[range].chunks(WIDTH) {
            let corners = named(block).map_each(|named| gathered(vertices, named, &apex));
            let doubled_areas = doubled_areas(&corners, side);
            monomials.coefficients(&corners, &mut table);
            for (sum, coefficient) in sums.iter_mut().zip(&table) {
                *sum += doubled_areas * *coefficient;
            }
        }
        SurfaceSums(sums.into_iter().map(sum).collect())
    })
}

/// Twice the areas of four triangles, with the sign they show to `side` if there is one.
fn doubled_areas([a, b, c]: &[LanePoint; 3], side: Option<&Vector3<f64>>) -> Lanes {
    let edge = |to: &LanePoint| [0, 1, 2].map_each(|axis| to[axis] - a[axis]);
    let normals = cross(&edge(b), &edge(c));
    let areas = dot(&normals, &normals).sqrt();
    let Some(side) = side else { return areas };
    let shown = dot(&normals, &splat(&Point3::from(*side))).to_array();
    let sign = |shown: f64| if shown == 0.0 { 0.0 } else { shown.signum() };
    areas * Lanes::from(shown.map_each(sign))
}
