//! What a cell's energy gains where its facets move: the integrals of the global objective.
//!
//! F = Σ_i ∫_{C_i} d∞(x_i, y)^p dy changes with a site not only because distances do, but also
//! because the bisectors move (Lévy & Liu, *Lp Centroidal Voronoi Tessellation*, 2010, with their
//! norm at infinity). Under δx_i and δx_j a point y of the facet between C_i and C_j moves outward
//! by [(y − x_i)·δx_i − (y − x_j)·δx_j] / |x_j − x_i|. So a facet f of C_i with the neighbor at r
//! (seen from x_i) pushes
//! - its own site by (1/|r|) ∫_f d∞^p (y − x_i) dA,
//! - its neighbor by −(1/|r|) ∫_f d∞^p (y − x_i − r) dA.
//!
//! On a triangle with corner distances δ, with λ_v the barycentric coordinates,
//! ∫ d^p λ_v dA = 2 A p!/(p+3)! · h_p(δ, δ_v): three weights, whose sum is ∫ d^p dA and whose
//! mean of the corners is ∫ d^p y dA (for p = 1 see `linear_borders`). The energy itself is
//! Σ_f H_f/(3+p) ∫_f d∞^p dA, H_f the site's height below the facet, since d∞^p is homogeneous about
//! the site. Where pieces have a density, the same integrals with it inside come from
//! `weighted_borders`.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::energy::{SignedPiece, tetrahedron};
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::linear_borders::LinearSums;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::chebyshev::walk::{WalkScratch, walk};
use crate::chebyshev::weighted_borders::{BorderPlaces, WeightedSums};
use crate::geometry::label::Label;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::simplex::complete_homogeneous;

/// What one facet does to the sites on its two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// The facet's label.
    pub label: Label,
    /// ∂E/∂x_i by the facet's motion (L^(2+p)).
    pub own: Vector3<f64>,
    /// ∂E/∂x_j, x_j the mirror image of the site in the facet's plane (L^(2+p)).
    pub across: Vector3<f64>,
}

/// A cell's energy about its site and the part of its gradient that comes from distances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inside {
    /// ∫ d∞^p (L^(3+p)).
    pub value: f64,
    /// ∂E/∂x_i with the cell held fixed (L^(2+p)).
    pub gradient: Vector3<f64>,
}

/// The memory of [`borders`], to be reused from one cell to the next.
#[derive(Clone, Debug, Default)]
pub struct BorderScratch {
    facets: Vec<FacetSums>,
    /// For pieces with a density.
    places: Option<BorderPlaces>,
}

/// The energy of order `order` of `pieces` about their site, the origin, and to `visit` what
/// every facet with a label that `is_bisector` would contribute to the gradients.
pub fn borders<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    order: u32,
    (walked, scratch): (&mut WalkScratch, &mut BorderScratch),
    is_bisector: impl Fn(Label) -> bool,
    mut visit: impl FnMut(Push),
) -> Inside {
    let mut total = Inside::default();
    for SignedPiece { sign, integrand } in pieces {
        let (value, slopes) = match &integrand.density {
            None => plain(integrand, order, walked, &mut scratch.facets),
            Some(density) => weighted(integrand, density, order, walked, scratch),
        };
        total.value += sign * value;
        total.gradient += Vector3::from(slopes) * (f64::from(order) * sign);
        let planes = integrand.facets.iter().zip(&integrand.labels);
        for ((plane, &label), sums) in planes.zip(&scratch.facets) {
            let (weight, first) = (sums.weight() * sign, sums.first() * *sign);
            if weight.abs() > 0.0 && is_bisector(label) {
                let distance = 2.0 * plane.offset;
                visit(Push {
                    label,
                    own: first / distance,
                    across: plane.normal * weight - first / distance,
                });
            }
        }
    }
    total
}

/// By axis what the negative sector has more of than the positive one.
pub(crate) fn slopes(sums: &[f64; Sector::SLOTS]) -> [f64; 3] {
    [0, 1, 2].map(|axis: usize| sums[axis + Sector::OPPOSITE] - sums[axis])
}

/// The energy of a piece of density 1, and by axis by how much more ∫ d∞^{p−1} dV is in the negative
/// sector than in the positive one.
fn plain(
    integrand: &Integrand,
    order: u32,
    walked: &mut WalkScratch,
    facets: &mut Vec<FacetSums>,
) -> (f64, [f64; 3]) {
    reset(facets, integrand);
    let slopes = if order == 1 {
        let mut sums = LinearSums::new(facets);
        walk(integrand, &Vector3::zeros(), walked, &mut sums);
        sums.slopes()
    } else {
        let mut sums = Sums {
            order,
            volumes: [0.0; Sector::SLOTS],
            facets,
        };
        walk(integrand, &Vector3::zeros(), walked, &mut sums);
        slopes(&sums.volumes)
    };
    let planes = integrand.facets.iter().zip(facets);
    let heights = planes.map(|(plane, sums)| sums.weight() * plane.offset);
    let value = heights.sum::<f64>() / (3.0 + f64::from(order));
    (value, slopes)
}

/// The same with the density inside.
fn weighted(
    integrand: &Integrand,
    density: &Polynomial,
    order: u32,
    walked: &mut WalkScratch,
    scratch: &mut BorderScratch,
) -> (f64, [f64; 3]) {
    reset(&mut scratch.facets, integrand);
    let degree = density.degree();
    let kept = scratch.places.take();
    let kept = kept.filter(|places| places.serve(degree, order));
    let places = kept.unwrap_or_else(|| BorderPlaces::new(degree, order));
    let mut sums = WeightedSums::new(&places, density, &mut scratch.facets);
    walk(integrand, &Vector3::zeros(), walked, &mut sums);
    let found = (sums.value, slopes(&sums.slopes));
    scratch.places = Some(places);
    found
}

fn reset(facets: &mut Vec<FacetSums>, integrand: &Integrand) {
    facets.clear();
    facets.resize(integrand.facets.len(), FacetSums::default());
}

/// ∫ d∞^p y dA and ∫ d∞^p dA over one facet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FacetSums(pub(crate) f64x4);

impl FacetSums {
    /// Adds to both.
    pub(crate) fn add(&mut self, weight: f64, first: &Vector3<f64>) {
        self.0 += f64x4::new([first.x, first.y, first.z, weight]);
    }

    fn weight(&self) -> f64 {
        self.0.to_array()[3]
    }

    fn first(&self) -> Vector3<f64> {
        let [x, y, z, _] = self.0.to_array();
        Vector3::new(x, y, z)
    }
}

/// The sums of a walk: per sector ∫ d∞^{p−1} dV, and per facet its own.
struct Sums<'a> {
    order: u32,
    volumes: [f64; Sector::SLOTS],
    facets: &'a mut Vec<FacetSums>,
}

impl Sums<'_> {
    /// Adds a triangle of a facet, for any order.
    fn add(
        &mut self,
        facet: &FacetView,
        sector: Sector,
        doubled_area: f64,
        corners: [&Vector3<f64>; 3],
    ) {
        let distances = corners.map(|corner| sector.distance(corner));
        let (weights, slope) = self.weights_of_power(doubled_area, distances);
        self.volumes[sector.number()] += doubled_area * facet.height * slope;
        let sums = &mut self.facets[facet.number];
        let first = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        sums.add(weights[0] + weights[1] + weights[2], &first);
    }

    fn weights_of_power(&self, doubled_area: f64, distances: [f64; 3]) -> ([f64; 3], f64) {
        let p = f64::from(self.order);
        let share = doubled_area / ((p + 1.0) * (p + 2.0) * (p + 3.0));
        let [a, b, c] = distances;
        let weight = |d: f64| share * complete_homogeneous(self.order, &[a, b, c, d]);
        (
            distances.map(weight),
            tetrahedron(self.order - 1, &distances),
        )
    }
}

impl Visit for Sums<'_> {
    fn share(&mut self, sides: &[Side; 2], sector: Sector, part: f64, ends: [&Corner; 2]) {
        for Side {
            facet,
            doubled_area,
        } in sides
        {
            let corners = [&facet.anchor(), &ends[0].point, &ends[1].point];
            self.add(facet, sector, part * doubled_area, corners);
        }
    }

    fn segment(&mut self, facet: &FacetView, interface: Interface, u: &Found, v: &Found) {
        let [u, v] = [&u.mark, &v.mark];
        let (left, right) = interface.sectors();
        let [u, v] = [u, v].map(|mark| interface.point(mark));
        let (doubled_area, anchor) = (facet.doubled_area(&u, &v), facet.anchor());
        let corners = [&anchor, &u, &v];
        self.add(facet, left, doubled_area, corners);
        self.add(facet, right, -doubled_area, corners);
    }
}
