//! A polynomial density's terms times powers of the distance, and where their integrals stand.
//!
//! In a sector the distance is ± one coordinate difference, so density times a power of it is a
//! polynomial, and one table of [`crate::integrals::series`] per simplex holds the integrals of all
//! its monomials. Which entry belongs to which term is worked out once for all simplices.

use nalgebra::Vector3;

use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};

/// Where the integral of a term times some monomial stands in the table, and by what it is to be
/// multiplied.
pub(crate) type Place = (usize, f64);

/// The terms of densities of one degree, and the table for energies of one order.
#[derive(Clone, Debug)]
pub(crate) struct Terms {
    degree: u32,
    order: u32,
    terms: Monomials,
    monomials: Monomials,
}

impl Terms {
    /// The terms with room in the table for products with monomials up to degree `order + more`.
    pub(crate) fn new(degree: u32, order: u32, more: u32) -> Self {
        Self {
            degree,
            order,
            terms: Monomials::up_to(degree),
            monomials: Monomials::up_to(degree + order + more),
        }
    }

    /// Whether these are the terms for such densities and energies.
    pub(crate) fn serve(&self, degree: u32, order: u32) -> bool {
        (self.degree, self.order) == (degree, order)
    }

    /// The order of the energies.
    pub(crate) fn order(&self) -> u32 {
        self.order
    }

    /// The places of all terms times the monomial of these powers, over simplices of a dimension.
    pub(crate) fn places(&self, dimension: u32, factor: Exponents) -> Vec<Place> {
        let place = |term: &Exponents| {
            let exponents = [0, 1, 2].map(|axis| term[axis] + factor[axis]);
            let place = self.monomials.place(exponents).unwrap_or(0);
            (place, weight(dimension, exponents))
        };
        self.terms.exponents().iter().map(place).collect()
    }
}

/// A power of one coordinate.
pub(crate) fn power(exponent: u32, axis: usize) -> Exponents {
    let mut exponents = [0; 3];
    exponents[axis] = exponent;
    exponents
}

/// A density and the table of one simplex at a time.
#[derive(Debug)]
pub(crate) struct Table<'a> {
    terms: &'a Terms,
    density: Vec<f64>,
    table: Vec<f64>,
}

impl<'a> Table<'a> {
    /// An empty table for `density`, as seen from where the distance is measured.
    pub(crate) fn new(terms: &'a Terms, density: &Polynomial) -> Self {
        Self {
            density: density.coefficients(&terms.terms),
            terms,
            table: Vec::new(),
        }
    }

    /// Takes up the simplex of these corners and, if they are as many as its dimension, the origin.
    pub(crate) fn fill<const K: usize>(&mut self, corners: [&Vector3<f64>; K]) {
        let corners = corners.map(|corner| <[f64; 3]>::from(*corner));
        self.terms.monomials.coefficients(&corners, &mut self.table);
    }

    /// The integral of the density times the monomial of these places over the simplex, per unit of
    /// its volume.
    pub(crate) fn sum(&self, places: &[Place]) -> f64 {
        let terms = self.density.iter().zip(places);
        terms
            .map(|(value, (place, weight))| value * weight * self.table[*place])
            .sum()
    }
}
