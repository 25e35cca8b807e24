//! The Chebyshev energy of pieces whose density is a polynomial.
//!
//! In a sector the distance is ± one coordinate difference from the center, so density times a
//! power of the distance is a polynomial in these differences, and so are its derivatives' terms.
//! A tetrahedron of the walk has the center as a corner: the integrals of all its monomials come
//! from one table (`terms`) of the other three corners. Exact for any degree.
//! Gradient and Hessian are those of [`crate::chebyshev::energy`] with the density inside.

use nalgebra::{Point3, Vector3};

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::energy::sums_evaluation;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::terms::{Place, Table, Terms, power};
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::integrals::polynomial::Polynomial;
use crate::minimize::problem::Evaluation;

/// The places of all terms, for densities of one degree and energies of one order.
#[derive(Clone, Debug)]
pub(crate) struct Places {
    terms: Terms,
    /// By how much the power is less than the order (0, 1, 2), and the distance's axis.
    solid: [[Vec<Place>; 3]; 3],
    /// The axis; the power is one less than the order, the integral over a triangle.
    flat: [Vec<Place>; 3],
}

impl Places {
    pub(crate) fn new(degree: u32, order: u32) -> Self {
        let terms = Terms::new(degree, order, 0);
        let places = |dimension: u32, lowered: u32, axis: usize| {
            let lower = order.checked_sub(lowered);
            lower.map_or_else(Vec::new, |lower| {
                terms.places(dimension, power(lower, axis))
            })
        };
        let solid = [0, 1, 2].map(|lowered| [0, 1, 2].map(|axis| places(3, lowered, axis)));
        let flat = [0, 1, 2].map(|axis| places(2, 1, axis));
        Self { terms, solid, flat }
    }

    /// Whether these are the places for such densities and energies.
    pub(crate) fn serve(&self, degree: u32, order: u32) -> bool {
        self.terms.serve(degree, order)
    }
}

/// The sums of a walk about one center.
pub(crate) struct Weighted<'a> {
    places: &'a Places,
    table: Table<'a>,
    value: f64,
    first: [f64; Sector::SLOTS],
    second: [f64; Sector::SLOTS],
    interfaces: [f64; Interface::SLOTS],
}

impl<'a> Weighted<'a> {
    pub(crate) fn new(places: &'a Places, density: &Polynomial, center: &Vector3<f64>) -> Self {
        let seen = density.relative_to(&Point3::from(*center));
        Self {
            places,
            table: Table::new(&places.terms, &seen),
            value: 0.0,
            first: [0.0; Sector::SLOTS],
            second: [0.0; Sector::SLOTS],
            interfaces: [0.0; Interface::SLOTS],
        }
    }

    pub(crate) fn evaluation(&self) -> Evaluation<3> {
        let (order, value) = (self.places.terms.order(), self.value);
        sums_evaluation(order, value, &self.first, &self.second, &self.interfaces)
    }

    /// ∫ density · (± axis)^power over the simplex of the table, per unit of its volume.
    fn sum(&self, places: &[Place], sign: f64, power: u32) -> f64 {
        let sum = self.table.sum(places);
        if power % 2 == 1 { sign * sum } else { sum }
    }

    /// Adds the tetrahedron of the table to the sector's sums.
    fn add(&mut self, sector: Sector, volume: f64) {
        let (sign, axis, order) = (sector.sign(), sector.axis(), self.places.terms.order());
        let [whole, first, second] = [0, 1, 2].map(|lowered| {
            let power = order.saturating_sub(lowered as u32);
            volume * self.sum(&self.places.solid[lowered][axis], sign, power)
        });
        self.value += whole;
        self.first[sector.number()] += first;
        self.second[sector.number()] += second;
    }
}

impl Visit for Weighted<'_> {
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            self.table
                .fill([&facet.anchor(), &ends[0].point, &ends[1].point]);
            self.add(sector, part * doubled_area * facet.height / 6.0);
        }
    }

    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let determinant = interface.determinant(u, v);
        let difference = facet.distance(left) - facet.distance(right);
        let volume = determinant * difference / 6.0;
        let [u, v] = [u, v].map(|mark| interface.point(mark));
        self.table.fill([&facet.anchor(), &u, &v]);
        self.add(left, volume);
        self.add(right, -volume);
        self.table.fill([&u, &v]);
        let power = self.places.terms.order() - 1;
        let mean = self.sum(&self.places.flat[left.axis()], left.sign(), power);
        self.interfaces[interface.number()] += mean * (2.0 * determinant);
    }
}
