//! Tetrahedra of linear density.
//!
//! Inside a tetrahedron the density is the linear function with the values ρ_A … ρ_D at its
//! corners \[BL\] section 2. Mass and mass center are eq. 1 and 2 (derived as eq. 10 and 12);
//! the second moments follow from the same Dirichlet weights (for constant density they are the
//! formulas of Tonon, *Explicit exact formulas for the 3-D tetrahedron inertia tensor*, 2004).
//! A body is the sum of its tetrahedra (eq. 3); its moments are summed about one origin, which
//! replaces the parallel-axis sum of eq. 4.
//!
//! Volumes carry the sign of det(B − A, C − A, D − A), so a body may be a signed sum.

use crate::integrals::lanes::{
    CONSTANT, LINEAR, Lanes, Sums, WIDTH, gathered, named, six_volumes_by_edges, splat,
};
use crate::integrals::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use nalgebra::{Matrix3, Point3};

/// The signed volume of a tetrahedron (L³).
#[must_use]
pub fn volume([a, b, c, d]: &[Point3<f64>; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// M_T: volume times the mean of the corners' densities, \[BL\] eq. 1 and 10.
#[must_use]
pub fn mass(corners: &[Point3<f64>; 4], densities: &[f64; 4]) -> f64 {
    volume(corners) * densities.iter().sum::<f64>() / 4.0
}

/// C_T: the mass center, \[BL\] eq. 2 and 12. Not finite where the densities sum to zero.
#[must_use]
pub fn mass_center(corners: &[Point3<f64>; 4], densities: &[f64; 4]) -> Point3<f64> {
    let [a, edges @ ..] = corners;
    let total: f64 = densities.iter().sum();
    let weighed = edges
        .iter()
        .zip(&densities[1..])
        .map(|(corner, density)| (corner - a) * (1.0 + density / total));
    a + weighed.sum::<nalgebra::Vector3<f64>>() / 5.0
}

/// Θ_T: the inertia tensor about `origin` (mass · L²), off-diagonals negative products.
#[must_use]
pub fn inertia(
    corners: &[Point3<f64>; 4],
    densities: &[f64; 4],
    origin: &Point3<f64>,
) -> Matrix3<f64> {
    moments(corners, &[[0, 1, 2, 3]], densities, origin).inertia()
}

/// The ten moments of tetrahedra of linear density, measured from `origin`; `densities` has one
/// value per vertex.
///
/// # Panics
///
/// If a tetrahedron names a vertex or a density that is not there.
#[must_use]
pub fn moments(
    vertices: &[Point3<f64>],
    tets: &[[u32; 4]],
    densities: &[f64],
    origin: &Point3<f64>,
) -> Moments {
    let origin = splat(origin);
    let density_at = |named: [usize; WIDTH]| Lanes::from(named.map(|vertex| densities[vertex]));
    sum_by_halves(tets.len(), &|range| {
        let mut sums = Sums::default();
        for block in tets[range].chunks(WIDTH) {
            let named = named(block);
            let corners = named.map(|named| gathered(vertices, named, &origin));
            let values = named.map(density_at);
            sums.add_linear(
                six_volumes_by_edges(&corners),
                &corners,
                &values,
                Lanes::ZERO,
            );
        }
        sums.moments(LINEAR)
    })
}

/// The ten moments at density 1, measured from `origin`.
///
/// # Panics
///
/// If a tetrahedron names a vertex that is not there.
#[must_use]
pub fn constant(vertices: &[Point3<f64>], tets: &[[u32; 4]], origin: &Point3<f64>) -> Moments {
    let origin = splat(origin);
    sum_by_halves(tets.len(), &|range| {
        let mut sums = Sums::default();
        for block in tets[range].chunks(WIDTH) {
            let corners = named(block).map(|named| gathered(vertices, named, &origin));
            sums.add_constant(six_volumes_by_edges(&corners), &corners);
        }
        sums.moments(CONSTANT)
    })
}
