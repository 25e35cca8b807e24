//! The integrals of the global objective over pieces whose density is a polynomial.
//!
//! As in `weighted`, density times a power of the distance is a polynomial in each sector, and one
//! table (`terms`) holds the integrals of all its monomials: over a triangle of a facet, and over the
//! tetrahedron of that triangle and the site, since a corner at the origin leaves the table as it is.
//! With the density inside, the energy is no longer homogeneous about the site, so it is summed over
//! the tetrahedra.

use nalgebra::Vector3;

use crate::chebyshev::borders::FacetSums;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::terms::{Place, Table, Terms, power};
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::integrals::polynomial::Polynomial;

/// The places of all terms, for densities of one degree and energies of one order, by the axis of
/// the distance.
#[derive(Clone, Debug)]
pub(crate) struct BorderPlaces {
    terms: Terms,
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
        let terms = Terms::new(degree, order, 1);
        let places = |dimension: u32, exponent: u32| {
            [0, 1, 2].map(|axis| terms.places(dimension, power(exponent, axis)))
        };
        let first = |axis: usize, coordinate: usize| {
            let mut factor = power(order, axis);
            factor[coordinate] += 1;
            terms.places(2, factor)
        };
        Self {
            whole: places(3, order),
            slope: places(3, order - 1),
            flat: places(2, order),
            first: [0, 1, 2].map(|axis| [0, 1, 2].map(|coordinate| first(axis, coordinate))),
            terms,
        }
    }

    /// Whether these are the places for such densities and energies.
    pub(crate) fn serve(&self, degree: u32, order: u32) -> bool {
        self.terms.serve(degree, order)
    }
}

/// The sums of a walk about the site: the energy, per sector ∫ ρ d∞^{p−1} dV, and per facet its own.
pub(crate) struct WeightedSums<'a> {
    places: &'a BorderPlaces,
    table: Table<'a>,
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
            places,
            table: Table::new(&places.terms, density),
            value: 0.0,
            slopes: [0.0; Sector::SLOTS],
            facets,
        }
    }

    /// Adds the triangle of the table, of signed area `doubled_area / 2`, as part of `sector`.
    fn add(&mut self, facet: &FacetView, sector: Sector, doubled_area: f64) {
        let (axis, places) = (sector.axis(), self.places);
        let order = places.terms.order();
        let signed = |power: u32| if power % 2 == 1 { sector.sign() } else { 1.0 };
        let (sign, volume) = (signed(order), doubled_area * facet.height / 6.0);
        self.value += volume * sign * self.table.sum(&places.whole[axis]);
        let slope = volume * signed(order - 1) * self.table.sum(&places.slope[axis]);
        self.slopes[sector.number()] += slope;
        let area = sign * doubled_area / 2.0;
        let weight = area * self.table.sum(&places.flat[axis]);
        let first = [0, 1, 2].map(|coordinate| self.table.sum(&places.first[axis][coordinate]));
        self.facets[facet.number].add(weight, &(Vector3::from(first) * area));
    }
}

impl Visit for WeightedSums<'_> {
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            self.table
                .fill([&facet.anchor(), &ends[0].point, &ends[1].point]);
            self.add(facet, sector, part * doubled_area);
        }
    }

    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let [u, v] = [u, v].map(|mark| interface.point(mark));
        let doubled_area = facet.doubled_area(&u, &v);
        self.table.fill([&facet.anchor(), &u, &v]);
        self.add(facet, left, doubled_area);
        self.add(facet, right, -doubled_area);
    }
}
