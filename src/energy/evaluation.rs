//! The Chebyshev energy of convex pieces about a center, with exact gradient and Hessian.
//!
//! E(c) = ∫ d∞(c, y)^p dy over the signed pieces (\[BL\] eq. 6 and 7), summed over the tetrahedra that the
//! subdivided surface (`surface`) makes with the center: by `sums_linear` for p = 1, by `sums_power` for
//! any p, by `sums_polynomial` where there is a density.

use nalgebra::{Matrix3, Vector3};

use crate::energy::prepared::PreparedPiece;
use crate::energy::sector::Interface;
use crate::energy::sums_linear::LinearSums;
use crate::energy::sums_polynomial::{PolynomialTerms, polynomial_integrals};
use crate::energy::sums_power::PowerSums;
use crate::energy::surface::{SurfaceScratch, sum_over_surface};
use crate::minimize::problem::{Evaluation, Jet};

/// A convex piece and the sign with which it counts.
#[derive(Clone, Debug)]
pub(crate) struct SignedPiece {
    /// +1 or −1.
    pub sign: f64,
    /// The piece, prepared.
    pub piece: PreparedPiece,
}

impl SignedPiece {
    /// The piece of that number, which is added if it is the next one, with its sign set.
    pub(crate) fn place(pieces: &mut Vec<Self>, number: usize, sign: f64) -> &mut PreparedPiece {
        if number == pieces.len() {
            let piece = PreparedPiece::default();
            pieces.push(Self { sign, piece });
        }
        let signed = &mut pieces[number];
        signed.sign = sign;
        &mut signed.piece
    }
}

/// The memory of evaluations, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct EnergyScratch {
    pub(crate) surface: SurfaceScratch,
    /// For pieces with a density.
    terms: Option<PolynomialTerms>,
    /// The last center, and of the last piece for p = 1 the determinants of edge velocities by interface
    /// (see `prediction`).
    pub(crate) center: Vector3<f64>,
    pub(crate) velocity_determinants: [f64; Interface::SLOTS],
    volume: Option<f64>,
}

impl EnergyScratch {
    /// The volume of the pieces that were evaluated last (L³), if that was for p = 1 and without density.
    pub(crate) fn volume(&self) -> Option<f64> {
        self.volume
    }
}

/// Energy (L^(3+p)), gradient (L^(2+p)) and Hessian (L^(1+p)) of `pieces` about `center`, which is
/// in the pieces' coordinates and may lie anywhere. `order` is p ≥ 1.
#[must_use]
pub(crate) fn energy<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut EnergyScratch,
) -> Evaluation<3> {
    energy_jet(pieces, center, order, scratch).evaluation
}

/// As [`energy`], for p = 1 and no density with the third derivative (L).
///
/// It is not finite where the center lies in the plane of a facet.
#[must_use]
pub(crate) fn energy_jet<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut EnergyScratch,
) -> Jet<3> {
    let mut pieces = pieces.into_iter();
    scratch.center = *center;
    let mut total = match pieces.next() {
        Some(SignedPiece { sign, piece }) if *sign > 0.0 => {
            energy_of_piece(piece, center, order, scratch)
        }
        first => {
            let mut total = zero();
            scratch.volume = Some(0.0);
            if let Some(first) = first {
                add(&mut total, first, center, order, scratch);
            }
            total
        }
    };
    for piece in pieces {
        add(&mut total, piece, center, order, scratch);
    }
    total
}

/// The energy of nothing.
fn zero() -> Jet<3> {
    Jet {
        evaluation: Evaluation {
            value: 0.0,
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
        },
        third: Some([Matrix3::zeros(); 3]),
    }
}

/// Adds a piece.
fn add(
    total: &mut Jet<3>,
    SignedPiece { sign, piece }: &SignedPiece,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut EnergyScratch,
) {
    let volume = scratch.volume;
    let part = energy_of_piece(piece, center, order, scratch);
    let both = volume.zip(scratch.volume);
    scratch.volume = both.map(|(all, own)| all + sign * own);
    total.evaluation.value += sign * part.evaluation.value;
    total.evaluation.gradient += part.evaluation.gradient * *sign;
    total.evaluation.hessian += part.evaluation.hessian * *sign;
    total.third = total.third.zip(part.third).map(|(mut total, part)| {
        for (total, part) in total.iter_mut().zip(part) {
            *total += part * *sign;
        }
        total
    });
}

fn energy_of_piece(
    piece: &PreparedPiece,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut EnergyScratch,
) -> Jet<3> {
    let (surface, terms) = (&mut scratch.surface, &mut scratch.terms);
    scratch.volume = None;
    if let Some(sums) = polynomial_integrals(piece, (center, order), None, surface, terms) {
        sums.evaluation(order).into()
    } else if order == 1 {
        let mut sums = LinearSums::default();
        sum_over_surface(piece, center, surface, &mut sums);
        scratch.velocity_determinants = sums.velocity_determinants();
        scratch.volume = Some(sums.volume());
        sums.jet()
    } else {
        let mut sums = PowerSums::new(order, None);
        sum_over_surface(piece, center, surface, &mut sums);
        sums.integrals.evaluation(order).into()
    }
}
