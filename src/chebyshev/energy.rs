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

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
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
    let mut total = Jet {
        evaluation: Evaluation {
            value: 0.0,
            gradient: Vector3::zeros(),
            hessian: Matrix3::zeros(),
        },
        third: Some([Matrix3::zeros(); 3]),
    };
    for SignedPiece { sign, integrand } in pieces {
        let part = energy_of_piece(integrand, center, order, scratch);
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
    total
}

fn energy_of_piece(
    integrand: &Integrand,
    center: &Vector3<f64>,
    order: u32,
    scratch: &mut WalkScratch,
) -> Jet<3> {
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
        scratch.slides = sums.segments.map(|sums| sums[6]);
        sums.jet()
    } else {
        let mut sums = Power::new(order);
        walk(integrand, center, scratch, &mut sums);
        sums.evaluation().into()
    }
}

/// The sums for p = 1, kept apart by sector and by interface, so that additions need not wait for
/// each other.
#[derive(Default)]
struct Linear {
    /// Of the shares in a sector: 24 E and 6 V.
    shares: [[f64; 2]; Sector::SLOTS],
    /// Of the segments on an interface: 24 E, 6 V for the first sector and against the second, √2 of
    /// the interface's area A, and three components of 1/(2√2) of its loss by the center's motion:
    /// −∂A/∂c = Σ |v−u|/|n∥| n, n∥ the part of the facet's normal n along the interface; and what
    /// `quartic` makes of how crossings slide.
    segments: [[f64; 7]; Interface::SLOTS],
}

impl Visit for Linear {
    #[inline]
    fn share(&mut self, sides: &[Side<'_>; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        let [left, right] = sides.map(|side| side.doubled_area * side.facet.height);
        let [on_left, on_right] = sides.map(|side| side.facet.anchor.distance(sector));
        let both = left + right;
        let around = left * on_left + right * on_right;
        let sums = &mut self.shares[sector.number()];
        sums[0] += part * (both * (ends[0].distance + ends[1].distance) + around);
        sums[1] += part * both;
    }

    #[inline]
    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Found, v: &Found) {
        let (left, right) = interface.sectors();
        let determinant = interface.determinant(&u.mark, &v.mark);
        let slide = interface.determinant(&u.drift, &v.drift);
        let difference = facet.anchor.distance(left) - facet.anchor.distance(right);
        let volume = determinant * difference;
        let loss = facet.normal() * (determinant * facet.per_height);
        // In the energy, both distances at u and v agree and cancel.
        let terms = [
            volume * difference,
            volume,
            determinant,
            loss.x,
            loss.y,
            loss.z,
            slide,
        ];
        let sums = &mut self.segments[interface.number()];
        for (sum, term) in sums.iter_mut().zip(terms) {
            *sum += term;
        }
    }
}

impl Linear {
    fn jet(&self) -> Jet<3> {
        let shares = self.shares.iter().map(|[value, _]| value);
        let segments = self.segments.iter().map(|[value, ..]| value);
        let value = shares.chain(segments).sum::<f64>();
        let mut volumes = self.shares.map(|[_, volume]| volume);
        for interface in Interface::all() {
            let (left, right) = interface.sectors();
            let volume = self.segments[interface.number()][1];
            volumes[left.number()] += volume;
            volumes[right.number()] -= volume;
        }
        let per_interface = |place: usize| self.segments.map(|sums| sums[place]);
        let evaluation = Evaluation {
            value: value / 24.0,
            gradient: Vector3::from([0, 1, 2].map(|k| volumes[2 * k + 1] - volumes[2 * k])) / 6.0,
            hessian: interface_hessian(&per_interface(2)) * 2.0,
        };
        let third = [3, 4, 5].map(|place| interface_hessian(&per_interface(place)) * -4.0);
        Jet {
            evaluation,
            third: Some(third),
        }
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
    let gradient = Vector3::from([0, 1, 2].map(|k| first[2 * k + 1] - first[2 * k])) * p;
    let bulk = Vector3::from([0, 1, 2].map(|k| second[2 * k] + second[2 * k + 1]));
    Evaluation {
        value,
        gradient,
        hessian: interface_hessian(interfaces) * p
            + Matrix3::from_diagonal(&bulk) * (p * (p - 1.0)),
    }
}

impl Visit for Power {
    fn share(&mut self, sides: &[Side<'_>; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            let [a, b] = ends.map(|end| end.distance);
            let distances = [facet.anchor.distance(sector), a, b];
            self.add(sector, part * doubled_area * facet.height, &distances);
        }
    }

    fn segment(&mut self, facet: &FacetView<'_>, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let [on_left, on_right] = [left, right].map(|sector| facet.anchor.distance(sector));
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

/// Σ (A/√2) w wᵀ over the interfaces, from 4/√2 times their areas.
pub(crate) fn interface_hessian(areas: &[f64; Interface::SLOTS]) -> Matrix3<f64> {
    let mut hessian = Matrix3::zeros();
    for (number, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
        // On + + and − − the directions of w differ, on + − and − + they agree.
        let [same, opposite] =
            [[0, 3], [1, 2]].map(|[k, l]| areas[4 * number + k] + areas[4 * number + l]);
        hessian[(i, i)] += 0.25 * (same + opposite);
        hessian[(j, j)] += 0.25 * (same + opposite);
        hessian[(i, j)] = 0.25 * (opposite - same);
    }
    hessian.fill_lower_triangle_with_upper_triangle();
    hessian
}
