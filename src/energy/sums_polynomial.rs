//! Sums for energies of pieces whose density is a polynomial: \[BL\] eq. 6 and 7 with the density inside.
//!
//! In a sector the distance is ± one coordinate difference from the center, so density times a power of
//! the distance is a polynomial in these differences, and so are the terms of derivatives. One table of
//! [`crate::integrals::series`] per simplex holds the integrals of all its monomials: over a triangle, and
//! over its tetrahedron with the center, since a corner at the origin leaves the table as it is. Exact for
//! any degree. Which entry belongs to which term is worked out once for all simplices.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::energy::edge_crossings_simd::{PartQuad, SideQuad};
use crate::energy::prepared::{CenteredPiece, PreparedPiece};
use crate::energy::sector::Sector;
use crate::energy::segments::Segment;
use crate::energy::sums_power::SectorIntegrals;
use crate::energy::surface::{
    FacetIntegrals, SurfaceScratch, SurfaceSums, Triangle, sum_over_surface, visit_segments,
    visit_triangles,
};
use crate::geometry::small_polyhedron::BLOCK;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};

/// By term of the density, the place in the table of the integral of that term times some monomial, and
/// its factor.
type TermPlaces = Vec<(usize, f64)>;

/// The places of all integrals, for densities of one degree and energies of one order p; by the axis of the
/// distance.
#[derive(Clone, Debug)]
pub(crate) struct PolynomialTerms {
    degree: u32,
    order: u32,
    density: Monomials,
    table: Monomials,
    /// Over a tetrahedron, times d^p, d^(p−1) and d^(p−2); the last is empty for p = 1.
    solid: [[TermPlaces; 3]; 3],
    /// Over a triangle at the center, times d^(p−1).
    interface: [TermPlaces; 3],
    facet: Option<FacetPlaces>,
}

/// The places of the integrals over a facet.
#[derive(Clone, Debug)]
struct FacetPlaces {
    /// Over a triangle, times d^p.
    weight: [TermPlaces; 3],
    /// Over a triangle, times d^p and one of the coordinates.
    first: [[TermPlaces; 3]; 3],
}

impl PolynomialTerms {
    /// Those in `kept` if they are for such densities and energies, otherwise new ones.
    fn reused(kept: &mut Option<Self>, degree: u32, order: u32, has_facets: bool) -> Self {
        let kept = kept.take();
        let kept = kept.filter(|terms| (terms.degree, terms.order) == (degree, order));
        kept.unwrap_or_else(|| Self::new(degree, order, has_facets))
    }

    fn new(degree: u32, order: u32, has_facets: bool) -> Self {
        let density = Monomials::up_to(degree);
        let table = Monomials::up_to(degree + order + u32::from(has_facets));
        let places = |dimension: u32, factor: Exponents| -> TermPlaces {
            let place = |term: &Exponents| {
                let exponents = [0, 1, 2].map_each(|axis| term[axis] + factor[axis]);
                let place = table.place(exponents).unwrap_or(0);
                (place, weight(dimension, exponents))
            };
            density.exponents().iter().map(place).collect()
        };
        let by_axis = |dimension: u32, exponent: u32| {
            [0, 1, 2].map_each(|axis| places(dimension, power(exponent, axis)))
        };
        let first = |axis: usize, coordinate: usize| {
            let mut factor = power(order, axis);
            factor[coordinate] += 1;
            places(2, factor)
        };
        Self {
            solid: [0, 1, 2].map_each(|lowered| {
                let exponent = order.checked_sub(lowered);
                exponent.map_or_else(Default::default, |exponent| by_axis(3, exponent))
            }),
            interface: by_axis(2, order - 1),
            facet: has_facets.then(|| FacetPlaces {
                weight: by_axis(2, order),
                first: [0, 1, 2]
                    .map_each(|axis| [0, 1, 2].map_each(|coordinate| first(axis, coordinate))),
            }),
            degree,
            order,
            density,
            table,
        }
    }
}

/// A power of one coordinate.
fn power(exponent: u32, axis: usize) -> Exponents {
    let mut exponents = [0; 3];
    exponents[axis] = exponent;
    exponents
}

/// The integrals of a piece with a density about a center, and those over its facets where these are given;
/// `terms` is kept from one piece to the next. `None` without a density.
pub(crate) fn polynomial_integrals(
    piece: &PreparedPiece,
    (center, order): (&Vector3<f64>, u32),
    facets: Option<&mut [FacetIntegrals]>,
    surface: &mut SurfaceScratch,
    terms: &mut Option<PolynomialTerms>,
) -> Option<SectorIntegrals> {
    let density = piece.density.as_ref()?;
    let kept = PolynomialTerms::reused(terms, density.degree(), order, facets.is_some());
    let mut sums = PolynomialSums::new(&kept, density, center, facets);
    sum_over_surface(piece, center, surface, &mut sums);
    let integrals = sums.integrals;
    *terms = Some(kept);
    Some(integrals)
}

/// The sums for one density about one center.
struct PolynomialSums<'a> {
    terms: &'a PolynomialTerms,
    density: Vec<f64>,
    /// Of one simplex at a time.
    table: Vec<f64>,
    integrals: SectorIntegrals,
    /// Where these are wanted, second derivatives are not.
    facets: Option<&'a mut [FacetIntegrals]>,
}

impl<'a> PolynomialSums<'a> {
    /// Sums for the energy's derivatives, or for the integrals over its facets.
    fn new(
        terms: &'a PolynomialTerms,
        density: &Polynomial,
        center: &Vector3<f64>,
        facets: Option<&'a mut [FacetIntegrals]>,
    ) -> Self {
        let centered = density.relative_to(&Point3::from(*center));
        Self {
            density: centered.coefficients(&terms.density),
            terms,
            table: Vec::new(),
            integrals: SectorIntegrals::default(),
            facets,
        }
    }

    /// Computes the table of the simplex of these corners and, if they are as many as its dimension, the
    /// center.
    fn fill<const K: usize>(&mut self, corners: [&Vector3<f64>; K]) {
        let corners = corners.map(|corner| <[f64; 3]>::from(*corner));
        self.terms.table.coefficients(&corners, &mut self.table);
    }

    /// The integral of the density times the monomial of these places over the simplex of the table, per
    /// unit of its volume.
    fn mean(&self, places: &TermPlaces) -> f64 {
        let terms = self.density.iter().zip(places);
        terms
            .map(|(value, (place, weight))| value * weight * self.table[*place])
            .sum()
    }

    fn add(&mut self, triangle: &Triangle<'_>) {
        self.fill(triangle.corners.each_ref());
        let (terms, axis) = (self.terms, triangle.sector.axis());
        let (order, volume) = (terms.order, triangle.six_volume() / 6.0);
        let solid = |lowered: usize| {
            let sign = sign(triangle.sector, order.saturating_sub(lowered as u32));
            volume * sign * self.mean(&terms.solid[lowered][axis])
        };
        let (value, first) = (solid(0), solid(1));
        let second = self.facets.as_ref().map_or_else(|| solid(2), |_| 0.0);
        let integrals = &mut self.integrals;
        integrals.value += value;
        integrals.first[triangle.sector.number()] += first;
        integrals.second[triangle.sector.number()] += second;
        if let Some(places) = &terms.facet {
            let area = sign(triangle.sector, order) * triangle.doubled_area / 2.0;
            let weight = area * self.mean(&places.weight[axis]);
            let first = places.first[axis]
                .each_ref()
                .map_each(|places| self.mean(places));
            if let Some(facets) = &mut self.facets {
                facets[triangle.facet.number].add(weight, &(Vector3::from(first) * area));
            }
        }
    }
}

/// The sign of a power of the sector's axis where its distance is positive.
fn sign(sector: Sector, power: u32) -> f64 {
    if power % 2 == 1 { sector.sign() } else { 1.0 }
}

impl SurfaceSums for PolynomialSums<'_> {
    fn add_parts<const N: usize>(&mut self, sides: &[SideQuad; 2], parts: &[PartQuad; N]) {
        visit_triangles(sides, parts, |triangle| self.add(triangle));
    }

    fn add_segments(&mut self, view: &CenteredPiece<'_>, segments: &[Segment; BLOCK]) {
        visit_segments(view, segments, |both, interface, ends| {
            both.iter().for_each(|triangle| self.add(triangle));
            if self.facets.is_some() {
                return;
            }
            let [_, u, v] = &both[0].corners;
            self.fill([u, v]);
            let left = both[0].sector;
            let mean = self.mean(&self.terms.interface[left.axis()]);
            let determinant = interface.determinant(&ends[0], &ends[1]);
            self.integrals.interfaces[interface.number()] +=
                sign(left, self.terms.order - 1) * mean * (2.0 * determinant);
        });
    }
}
