//! Mass and its moments for pieces whose density is a polynomial.

use nalgebra::Vector3;

use crate::geometry::faceted::Piece;
use crate::geometry::moments::Moments;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Monomials, weight};

/// ∫ ρ, ∫ ρ y and ∫ ρ |y|² over the piece, `density` and y about the origin of its coordinates.
/// `volume` of the answer is the mass.
#[must_use]
pub fn mass_moments(piece: Piece<'_>, density: &Polynomial) -> Moments {
    let monomials = Monomials::up_to(density.degree() + 2);
    let mut sums = vec![0.0; monomials.exponents().len()];
    let mut table = Vec::new();
    piece.visit_fans(|anchor, a, b| {
        let volume = anchor.dot(&a.cross(&b)) / 6.0;
        let corners = [anchor, a, b].map(<[f64; 3]>::from);
        monomials.coefficients(&corners, &mut table);
        for (sum, coefficient) in sums.iter_mut().zip(&table) {
            *sum += volume * coefficient;
        }
    });
    let integral = |powers: [u32; 3]| {
        let terms = density.terms().map(|(term, value)| {
            let exponents = [0, 1, 2].map(|axis| term[axis] + powers[axis]);
            let place = monomials.place(exponents);
            value * place.map_or(0.0, |place| weight(3, exponents) * sums[place])
        });
        terms.sum::<f64>()
    };
    Moments {
        volume: integral([0; 3]),
        first: Vector3::new(
            integral([1, 0, 0]),
            integral([0, 1, 0]),
            integral([0, 0, 1]),
        ),
        second: integral([2, 0, 0]) + integral([0, 2, 0]) + integral([0, 0, 2]),
    }
}
