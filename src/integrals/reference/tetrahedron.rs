//! Volume, mass and mass center of one tetrahedron of linear density (\[BL\] section 2).
//!
//! Inside a tetrahedron the density is the linear function with the values ρ_A … ρ_D at its
//! corners. Volumes carry the sign of det(B − A, C − A, D − A).

use nalgebra::{Point3, Vector3};

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
    a + weighed.sum::<Vector3<f64>>() / 5.0
}
