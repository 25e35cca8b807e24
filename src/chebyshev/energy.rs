//! The Chebyshev energy of convex pieces about a center, with exact gradient and Hessian.
//!
//! E(c) = ∫ d∞(c, y)^p dy over the signed pieces \[BL\] eq. 6 and 7. In each sector the distance is
//! linear, so that every tetrahedron (c, q, a, b) of the walk contributes
//! V · 3! p!/(3+p)! · h_p(0, δ_q, δ_a, δ_b): for p = 1 the mass of \[BL\] eq. 1.
//!
//! - Gradient: ∂E/∂c_k = p (∫_{F−k} d∞^{p−1} − ∫_{F+k} d∞^{p−1}); for p = 1 the difference of
//!   volumes of opposite fragments.
//! - Hessian: p (p−1) ∫_{F±k} d∞^{p−2} on the diagonal, and over the twelve interfaces
//!   (p/√2) ∫ d∞^{p−1} dA · w wᵀ with w = s_i e_i − s_j e_j.

use nalgebra::{Matrix3, Vector3};

use crate::chebyshev::bend::interface_hessian;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::linear::Linear;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::chebyshev::walk::{WalkScratch, walk};
use crate::chebyshev::weighted::{Places, Weighted};
use crate::integrals::simplex::complete_homogeneous;
use crate::minimize::problem::{Evaluation, Jet};

/// A convex piece and the sign with which it counts.
#[derive(Clone, Debug)]
pub struct SignedPiece {
    /// +1 or −1.
    pub sign: f64,
    /// The piece, prepared.
    pub integrand: Integrand,
}

impl SignedPiece {
    /// The integrand of the numbered piece, which counts with `sign`; there may be one more than before.
    pub(crate) fn place(pieces: &mut Vec<Self>, number: usize, sign: f64) -> &mut Integrand {
        if number == pieces.len() {
            let integrand = Integrand::default();
            pieces.push(Self { sign, integrand });
        }
        let piece = &mut pieces[number];
        piece.sign = sign;
        &mut piece.integrand
    }
}

/// Energy (L^(3+p)), gradient (L^(2+p)) and Hessian (L^(1+p)) of `pieces` about `center`, which is
/// in the pieces' coordinates and may lie anywhere. `order` is p ≥ 1.
#[must_use]
pub fn energy<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut WalkScratch,
) -> Evaluation<3> {
    energy_jet(pieces, center, order, scratch).evaluation
}

/// As [`energy`], for p = 1 and no density with the third derivative (L).
///
/// It is not finite where the center lies in the plane of a facet.
#[must_use]
pub fn energy_jet<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut WalkScratch,
) -> Jet<3> {
    let mut pieces = pieces.into_iter();
    let mut total = match pieces.next() {
        Some(SignedPiece { sign, integrand }) if *sign > 0.0 => {
            energy_of_piece(integrand, center, order, scratch)
        }
        first => {
            let mut total = none();
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

/// No energy at all.
fn none() -> Jet<3> {
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
    SignedPiece { sign, integrand }: &SignedPiece,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut WalkScratch,
) {
    let volume = scratch.volume;
    let part = energy_of_piece(integrand, center, order, scratch);
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
    integrand: &Integrand,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut WalkScratch,
) -> Jet<3> {
    scratch.volume = None;
    if let Some(density) = &integrand.density {
        let degree = density.degree();
        let kept = scratch
            .places
            .take()
            .filter(|places| places.serve(degree, order));
        let places = kept.unwrap_or_else(|| Places::new(degree, order));
        let mut sums = Weighted::new(&places, density, center);
        walk(integrand, center, scratch, &mut sums);
        let part = sums.evaluation();
        scratch.places = Some(places);
        part.into()
    } else if order == 1 {
        let mut sums = Linear::default();
        walk(integrand, center, scratch, &mut sums);
        scratch.slides = sums.slides();
        scratch.volume = Some(sums.volume());
        sums.jet()
    } else {
        let mut sums = Power::new(order);
        walk(integrand, center, scratch, &mut sums);
        sums.evaluation().into()
    }
}

/// The sums for any p: per sector ∫ d∞^p, ∫ d∞^{p−1}, ∫ d∞^{p−2}, and per interface
/// 4/√2 ∫ d∞^{p−1} dA.
struct Power {
    order: u32,
    value: f64,
    first: [f64; Sector::SLOTS],
    second: [f64; Sector::SLOTS],
    interfaces: [f64; Interface::SLOTS],
}

/// ∫ of the m-th power of the distance over a tetrahedron at the center, per six times its volume:
/// m!/(m+3)! · h_m.
pub(crate) fn tetrahedron(power: u32, distances: &[f64; 3]) -> f64 {
    let m = f64::from(power);
    complete_homogeneous(power, distances) / ((m + 1.0) * (m + 2.0) * (m + 3.0))
}

impl Power {
    fn new(order: u32) -> Self {
        Self {
            order,
            value: 0.0,
            first: [0.0; Sector::SLOTS],
            second: [0.0; Sector::SLOTS],
            interfaces: [0.0; Interface::SLOTS],
        }
    }

    fn add(&mut self, sector: Sector, volume: f64, distances: &[f64; 3]) {
        self.value += volume * tetrahedron(self.order, distances);
        self.first[sector.number()] += volume * tetrahedron(self.order - 1, distances);
        if self.order >= 2 {
            self.second[sector.number()] += volume * tetrahedron(self.order - 2, distances);
        }
    }

    fn evaluation(&self) -> Evaluation<3> {
        let (first, second) = (&self.first, &self.second);
        sums_evaluation(self.order, self.value, first, second, &self.interfaces)
    }
}

/// Energy, gradient and Hessian from the integrals of d∞^p in all, of d∞^{p−1} and d∞^{p−2} per
/// sector, and 4/√2 times those of d∞^{p−1} per interface.
pub(crate) fn sums_evaluation(
    order: u32,
    value: f64,
    first: &[f64; Sector::SLOTS],
    second: &[f64; Sector::SLOTS],
    interfaces: &[f64; Interface::SLOTS],
) -> Evaluation<3> {
    let p = f64::from(order);
    let gradient = Vector3::from([0, 1, 2].map(|k| first[k + Sector::OPPOSITE] - first[k])) * p;
    let bulk = Vector3::from([0, 1, 2].map(|k| second[k] + second[k + Sector::OPPOSITE]));
    Evaluation {
        value,
        gradient,
        hessian: interface_hessian(interfaces) * p
            + Matrix3::from_diagonal(&bulk) * (p * (p - 1.0)),
    }
}

impl Visit for Power {
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            let [a, b] = ends.map(|end| end.distance);
            let distances = [facet.distance(sector), a, b];
            self.add(sector, part * doubled_area * facet.height, &distances);
        }
    }

    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let [on_left, on_right] = [left, right].map(|sector| facet.distance(sector));
        let determinant = interface.determinant(u, v);
        let volume = determinant * (on_left - on_right);
        let ends = [u.distance, v.distance];
        self.add(left, volume, &[on_left, ends[0], ends[1]]);
        self.add(right, -volume, &[on_right, ends[0], ends[1]]);
        // Over a triangle at the center ∫ d^m dA = A · 2 m!/(m+2)! · h_m.
        let m = f64::from(self.order - 1);
        let mean = complete_homogeneous(self.order - 1, &ends) * 2.0 / ((m + 1.0) * (m + 2.0));
        self.interfaces[interface.number()] += mean * (2.0 * determinant);
    }
}
