//! The integrals of the global objective over pieces whose density is a polynomial.
//!
//! As in `weighted`, density times a power of the distance is a polynomial in
//! each sector, and one table of [`crate::integrals::series`] holds the integrals of all its
//! monomials: over a triangle of a facet, and over the tetrahedron of that triangle and the site,
//! since a corner at the origin leaves the table as it is. With the density inside, the energy is
//! no longer homogeneous about the site, so it is summed over the tetrahedra.

use nalgebra::Vector3;

use crate::chebyshev::borders::FacetSums;
use crate::chebyshev::interface::{Interface, Mark};
use crate::chebyshev::sector::Sector;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};

/// Where the integral of a density's term times a power of the distance stands in the table, and
/// by what it is to be multiplied.
type Place = (usize, f64);

/// The places of all terms, for densities of one degree and energies of one order, by the axis of
/// the distance.
#[derive(Clone, Debug)]
pub(crate) struct BorderPlaces {
    degree: u32,
    order: u32,
    terms: Monomials,
    monomials: Monomials,
    /// Over a tetrahedron, times d^p.
    whole: [Vec<Place>; 3],
    /// Over a tetrahedron, times d^(p−1).
    slope: [Vec<Place>; 3],
    /// Over a triangle, times d^p.
    flat: [Vec<Place>; 3],
    /// Over a triangle, times d^p and one of the coordinates.
    first: [[Vec<Place>; 3]; 3],
}

impl BorderPlaces {
    pub(crate) fn new(degree: u32, order: u32) -> Self {
        let terms = Monomials::up_to(degree);
        let monomials = Monomials::up_to(degree + order + 1);
        let places = |dimension: u32, factor: Exponents| -> Vec<Place> {
            let place = |term: &Exponents| {
                let exponents = [0, 1, 2].map(|axis| term[axis] + factor[axis]);
                let place = monomials.place(exponents).unwrap_or(0);
                (place, weight(dimension, exponents))
            };
            terms.exponents().iter().map(place).collect()
        };
        let power = |power: u32, axis: usize| {
            let mut factor = [0; 3];
            factor[axis] = power;
            factor
        };
        let first = |axis: usize, coordinate: usize| {
            let mut factor = power(order, axis);
            factor[coordinate] += 1;
            places(2, factor)
        };
        Self {
            degree,
            order,
            whole: [0, 1, 2].map(|axis| places(3, power(order, axis))),
            slope: [0, 1, 2].map(|axis| places(3, power(order - 1, axis))),
            flat: [0, 1, 2].map(|axis| places(2, power(order, axis))),
            first: [0, 1, 2].map(|axis| [0, 1, 2].map(|coordinate| first(axis, coordinate))),
            terms,
            monomials,
        }
    }

    /// Whether these are the places for such densities and energies.
    pub(crate) fn serve(&self, degree: u32, order: u32) -> bool {
        (self.degree, self.order) == (degree, order)
    }
}

/// The sums of a walk about the site: the energy, per sector ∫ ρ d∞^{p−1} dV, and per facet its own.
pub(crate) struct WeightedSums<'a> {
    places: &'a BorderPlaces,
    density: Vec<f64>,
    table: Vec<f64>,
    pub(crate) value: f64,
    pub(crate) slopes: [f64; Sector::SLOTS],
    facets: &'a mut [FacetSums],
}

impl<'a> WeightedSums<'a> {
    pub(crate) fn new(
        places: &'a BorderPlaces,
        density: &Polynomial,
        facets: &'a mut [FacetSums],
    ) -> Self {
        Self {
            density: density.coefficients(&places.terms),
            places,
            table: Vec::new(),
            value: 0.0,
            slopes: [0.0; Sector::SLOTS],
            facets,
        }
    }

    fn fill(&mut self, corners: [&Vector3<f64>; 3]) {
        let corners = corners.map(|corner| <[f64; 3]>::from(*corner));
        self.places
            .monomials
            .coefficients(&corners, &mut self.table);
    }

    /// The integral over the simplex of the table, per unit of its volume.
    fn sum(&self, places: &[Place]) -> f64 {
        let terms = self.density.iter().zip(places);
        terms
            .map(|(value, (place, weight))| value * weight * self.table[*place])
            .sum()
    }

    /// Adds the triangle of the table, of signed area `doubled_area / 2`, as part of `sector`.
    fn add(&mut self, facet: &FacetView<'_>, sector: Sector, doubled_area: f64) {
        let (axis, places) = (sector.axis(), self.places);
        let signed = |power: u32| if power % 2 == 1 { sector.sign() } else { 1.0 };
        let (sign, volume) = (signed(places.order), doubled_area * facet.height / 6.0);
        self.value += volume * sign * self.sum(&places.whole[axis]);
        let slope = volume * signed(places.order - 1) * self.sum(&places.slope[axis]);
        self.slopes[sector.number()] += slope;
        let area = sign * doubled_area / 2.0;
        let weight = area * self.sum(&places.flat[axis]);
        let first = [0, 1, 2].map(|coordinate| self.sum(&places.first[axis][coordinate]));
        let sums = &mut self.facets[facet.number];
        sums.weight += weight;
        sums.first += Vector3::from(first) * area;
    }
}

impl Visit for WeightedSums<'_> {
    fn share(&mut self, sides: &[Side<'_>; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            self.fill([&facet.anchor.point(), &ends[0].point, &ends[1].point]);
            self.add(facet, sector, part * doubled_area);
        }
    }

    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Mark, v: &Mark) {
        let (left, right) = interface.sectors();
        let [u, v] = [u, v].map(|mark| interface.point(mark));
        let doubled_area = facet.doubled_area(&u, &v);
        self.fill([&facet.anchor.point(), &u, &v]);
        self.add(facet, left, doubled_area);
        self.add(facet, right, -doubled_area);
    }
}
