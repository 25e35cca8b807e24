//! Solids whose density is a polynomial in x, y and z.
//!
//! A monomial f of degree n is the divergence of y f(y) / (n + 3), so its integral over a solid
//! is a sum over the boundary triangles alone. Each triangle contributes the table of all
//! monomials of its cone from the origin (the [`series`](crate::integrals::series) file: a corner
//! at 0 costs nothing); density times {1, y, y yᵀ} is then read off the summed table once. Time:
//! triangles × (n + 5 choose 3) for a density of degree n.

use crate::integrals::lanes::{
    LanePoint, Lanes, WIDTH, gathered, named, six_volumes, six_volumes_by_edges, splat,
    sum_of_lanes,
};
use crate::integrals::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, Monomials, weight};
use nalgebra::Point3;
use std::ops::Add;

/// {1, x, y, z, x², y², z², xy, yz, zx} as exponents, in the order of [`Moments::from_ten`].
const TEN: [Exponents; 10] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [2, 0, 0],
    [0, 2, 0],
    [0, 0, 2],
    [1, 1, 0],
    [0, 1, 1],
    [1, 0, 1],
];

/// The ten moments of the solid inside a closed surface, measured from `origin`; `density` is a
/// polynomial in the coordinates of the vertices (not relative to `origin`).
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn solid(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    density: &Polynomial,
    origin: &Point3<f64>,
) -> Moments {
    integrated(vertices, triangles, density, origin, six_volumes)
}

/// The ten moments of tetrahedra (signed volumes) of polynomial density, measured from `origin`.
///
/// # Panics
///
/// If a tetrahedron names a vertex that is not there.
#[must_use]
pub fn tetrahedra(
    vertices: &[Point3<f64>],
    tets: &[[u32; 4]],
    density: &Polynomial,
    origin: &Point3<f64>,
) -> Moments {
    integrated(vertices, tets, density, origin, six_volumes_by_edges)
}

/// Both of the above: `measure` is six times the volume spanned by `K` corners, and by the origin
/// if K = 3.
fn integrated<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    density: &Polynomial,
    origin: &Point3<f64>,
    measure: impl Fn(&[LanePoint; K]) -> Lanes + Sync,
) -> Moments {
    let monomials = Monomials::up_to(density.degree() + 2);
    let lane_origin = splat(origin);
    let sums = sum_by_halves(simplices.len(), &|range| {
        let mut sums = vec![Lanes::ZERO; monomials.exponents().len()];
        let mut table = Vec::new();
        for block in simplices[range].chunks(WIDTH) {
            let corners = named(block).map(|named| gathered(vertices, named, &lane_origin));
            let six_volumes = measure(&corners);
            monomials.coefficients(&corners, &mut table);
            for (sum, coefficient) in sums.iter_mut().zip(&table) {
                *sum += six_volumes * *coefficient;
            }
        }
        Table(sums.into_iter().map(sum_of_lanes).collect())
    });
    weighed(&monomials, &sums, &density.seen_from(origin))
}

/// Σ 6·volume · coefficient per monomial.
#[derive(Debug)]
struct Table(Vec<f64>);

impl Add for Table {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        for (sum, term) in self.0.iter_mut().zip(other.0) {
            *sum += term;
        }
        self
    }
}

/// Σ over the density's terms of the integrals of term × {1, x, …, zx}.
fn weighed(monomials: &Monomials, sums: &Table, density: &Polynomial) -> Moments {
    let integral = |exponents: Exponents| {
        let place = monomials.place(exponents);
        place.map_or(0.0, |place| weight(3, exponents) / 6.0 * sums.0[place])
    };
    Moments::from_ten(TEN.map(|ten| {
        density
            .terms()
            .map(|(term, value)| {
                value * integral([term[0] + ten[0], term[1] + ten[1], term[2] + ten[2]])
            })
            .sum()
    }))
}
