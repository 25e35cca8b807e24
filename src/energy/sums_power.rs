//! Sums for the energy of any order p ≥ 1, triangle by triangle: \[BL\] eq. 6 and 7.
//!
//! In each sector the distance is linear. So over a tetrahedron of volume V with the center as one corner
//! and distances δ_v at the others ∫ d∞^p = V · 3! p!/(3+p)! · h_p(δ), h_p the complete homogeneous
//! symmetric polynomial; and over a triangle of area A, with λ_v the barycentric coordinates,
//! ∫ d∞^p λ_v dA = 2 A p!/(p+3)! · h_p(δ, δ_v): three weights, whose sum is ∫ d∞^p dA and whose mean of the
//! corners is ∫ d∞^p y dA.

use nalgebra::{Matrix3, Vector3};

use crate::arrays::MapEach;
use crate::energy::edge_crossings_simd::{PartQuad, SideQuad};
use crate::energy::prepared::CenteredPiece;
use crate::energy::sector::{Interface, Sector, negative_minus_positive};
use crate::energy::segments::Segment;
use crate::energy::sums_linear::hessian_from_areas;
use crate::energy::surface::{
    FacetIntegrals, SurfaceSums, Triangle, visit_segments, visit_triangles,
};
use crate::geometry::small_polyhedron::BLOCK;
use crate::integrals::simplex::complete_homogeneous;
use crate::minimize::problem::Evaluation;

/// The integrals of which energies of order p and their derivatives consist.
#[derive(Clone, Debug, Default)]
pub(crate) struct SectorIntegrals {
    /// ∫ d∞^p.
    pub(crate) value: f64,
    /// By sector ∫ d∞^(p−1).
    pub(crate) first: [f64; Sector::SLOTS],
    /// By sector ∫ d∞^(p−2).
    pub(crate) second: [f64; Sector::SLOTS],
    /// By interface 4/√2 ∫ d∞^(p−1) dA.
    pub(crate) interfaces: [f64; Interface::SLOTS],
}

impl SectorIntegrals {
    /// The gradient p (∫_{F−k} d∞^(p−1) − ∫_{F+k} d∞^(p−1)), F±k the fragments of axis k.
    pub(crate) fn gradient(&self, order: u32) -> Vector3<f64> {
        negative_minus_positive(&self.first) * f64::from(order)
    }

    /// Energy, gradient and Hessian: p (p−1) ∫_{F±k} d∞^(p−2) on the diagonal, and over the twelve
    /// interfaces (p/√2) ∫ d∞^(p−1) dA · w wᵀ with w = s_i e_i − s_j e_j.
    pub(crate) fn evaluation(&self, order: u32) -> Evaluation<3> {
        let (p, second) = (f64::from(order), &self.second);
        let bulk = [0, 1, 2].map_each(|k: usize| second[k] + second[k + Sector::OPPOSITE]);
        Evaluation {
            value: self.value,
            gradient: self.gradient(order),
            hessian: hessian_from_areas(&self.interfaces) * p
                + Matrix3::from_diagonal(&bulk.into()) * (p * (p - 1.0)),
        }
    }
}

/// The sums for one order.
pub(crate) struct PowerSums<'a> {
    order: u32,
    pub(crate) integrals: SectorIntegrals,
    /// Where these are wanted, second derivatives are not.
    facets: Option<&'a mut [FacetIntegrals]>,
}

impl<'a> PowerSums<'a> {
    /// Sums for the energy's derivatives, or for the integrals over its facets.
    pub(crate) fn new(order: u32, facets: Option<&'a mut [FacetIntegrals]>) -> Self {
        Self {
            order,
            integrals: SectorIntegrals::default(),
            facets,
        }
    }

    fn add(&mut self, triangle: &Triangle<'_>) {
        let (sector, volume) = (triangle.sector.number(), triangle.six_volume());
        let (order, distances) = (self.order, &triangle.distances);
        self.integrals.value += volume * tetrahedron_mean(order, distances);
        self.integrals.first[sector] += volume * tetrahedron_mean(order - 1, distances);
        if let Some(facets) = &mut self.facets {
            let [a, b, c] = *distances;
            let weights = distances.map_each(|distance| {
                let sum = complete_homogeneous(order, &[a, b, c, distance]);
                triangle.doubled_area * sum / rising_product(order)
            });
            let corners = triangle.corners.iter().zip(weights);
            let first = corners.fold(Vector3::zeros(), |sum, (at, weight)| sum + at * weight);
            facets[triangle.facet.number].add(weights.iter().sum(), &first);
        } else if order >= 2 {
            self.integrals.second[sector] += volume * tetrahedron_mean(order - 2, distances);
        }
    }
}

/// (m+1) (m+2) (m+3) = (m+3)!/m!.
fn rising_product(power: u32) -> f64 {
    let m = f64::from(power);
    (m + 1.0) * (m + 2.0) * (m + 3.0)
}

/// ∫ of the m-th power of the distance over a tetrahedron at the center, per six times its volume:
/// m!/(m+3)! · h_m.
fn tetrahedron_mean(power: u32, distances: &[f64; 3]) -> f64 {
    complete_homogeneous(power, distances) / rising_product(power)
}

impl SurfaceSums for PowerSums<'_> {
    fn add_parts<const N: usize>(&mut self, sides: &[SideQuad; 2], parts: &[PartQuad; N]) {
        visit_triangles(sides, parts, |triangle| self.add(triangle));
    }

    fn add_segments(&mut self, view: &CenteredPiece<'_>, segments: &[Segment; BLOCK]) {
        visit_segments(view, segments, |both, interface, ends| {
            both.iter().for_each(|triangle| self.add(triangle));
            // Over a triangle at the center ∫ d^m dA = A · 2 m!/(m+2)! · h_m.
            let m = f64::from(self.order - 1);
            let distances = ends.each_ref().map_each(|end| end.distance);
            let sum = complete_homogeneous(self.order - 1, &distances);
            let mean = sum * 2.0 / ((m + 1.0) * (m + 2.0));
            let determinant = interface.determinant(&ends[0], &ends[1]);
            self.integrals.interfaces[interface.number()] += mean * (2.0 * determinant);
        });
    }
}
