//! The structure products of Cattani & Paoluzzi: monomials over triangles, surfaces and solids.
//!
//! A *structure product* is the integral of x^α y^β z^γ over a simplicial complex \[CP\]. Surfaces
//! are sums of triangles (eq. 12), solids sums over their boundary triangles by the divergence
//! theorem with the field (x^{α+1} y^β z^γ / (α+1), 0, 0) (eq. 15).
//!
//! Departures: the triangle's six-fold sum (eq. 10) is evaluated through its generating series
//! (the [`series`](crate::integrals::series) file), which has the same value in O(αβγ) steps
//! without alternating terms; the unit triangle (eq. 6) through its closed form.
//!
//! Coordinates are measured from zero, so products of high degree far from the origin are large
//! numbers by definition; mass properties use the routines that take an origin.

use crate::arrays::MapEach;
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::series::{Exponents, Monomials, over_simplex, weight};
use nalgebra::{Point2, Point3, Vector3};

/// ∫∫ u^α v^β over the unit triangle (0,0), (1,0), (0,1): \[CP\] eq. 6 = α! β! / (α + β + 2)!.
#[must_use]
pub fn unit_triangle(alpha: u32, beta: u32) -> f64 {
    0.5 * weight(2, [alpha, beta, 0])
}

/// ∫∫ x^α y^β over a polygon in the plane, positive if it runs counter-clockwise: \[CP\] eq. 3-4,
/// as the sum of the signed triangles (0, p_i, p_{i+1}).
///
/// Works for non-convex polygons; a clockwise loop added to its outer one is a hole.
#[must_use]
pub fn polygon(points: &[Point2<f64>], alpha: u32, beta: u32) -> f64 {
    let flat = |point: &Point2<f64>| Vector3::new(point.x, point.y, 0.0);
    let next = points.iter().cycle().skip(1);
    points
        .iter()
        .zip(next)
        .map(|(a, b)| {
            let area = 0.5 * (a.x * b.y - a.y * b.x);
            over_simplex(area, [flat(a), flat(b), Vector3::zeros()], [alpha, beta, 0])
        })
        .sum()
}

/// ∫ x^α y^β z^γ dA over a triangle in space: \[CP\] eq. 9-10. The area element is positive
/// whichever way the triangle runs.
#[must_use]
pub fn triangle(corners: &[Point3<f64>; 3], exponents: Exponents) -> f64 {
    let area = 0.5 * doubled_area(corners).norm();
    over_simplex(area, corners.map_each(|corner| corner.coords), exponents)
}

/// ∫ x^α y^β z^γ dV over a tetrahedron, with the sign of det(b − a, c − a, d − a).
#[must_use]
pub fn tetrahedron(corners: &[Point3<f64>; 4], exponents: Exponents) -> f64 {
    let [a, b, c, d] = corners;
    let volume = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
    over_simplex(volume, corners.map_each(|corner| corner.coords), exponents)
}

/// ∫ x^α y^β z^γ dA over a triangulated surface, open or closed: \[CP\] eq. 12.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn surface(vertices: &[Point3<f64>], triangles: &[[u32; 3]], exponents: Exponents) -> f64 {
    sum_over_triangles(vertices, triangles, exponents, |normal| normal.norm())
}

/// The same over triangles in one plane, each counted with the sign it shows to `normal`: the
/// integral over a non-convex polygon fanned from one of its vertices (\[CP\] section 3.1,
/// `signed`). `normal`, of any length, must be perpendicular to the plane; zero gives zero.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn planar_surface(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    normal: &Vector3<f64>,
    exponents: Exponents,
) -> f64 {
    let unit = normal.try_normalize(0.0).unwrap_or_default();
    sum_over_triangles(vertices, triangles, exponents, |doubled| doubled.dot(&unit))
}

/// ∫ x^α y^β z^γ dV over the solid inside a closed triangulated surface: \[CP\] eq. 15.
///
/// Negative for a surface turned inside out; meaningless for an open one.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn solid(vertices: &[Point3<f64>], triangles: &[[u32; 3]], exponents: Exponents) -> f64 {
    let [alpha, beta, gamma] = exponents;
    let raised = [alpha + 1, beta, gamma];
    sum_over_triangles(vertices, triangles, raised, |normal| normal.x) / f64::from(alpha + 1)
}

/// Σ over the triangles of `measure`(a × b) ∫∫ x^α y^β z^γ du dv, a and b two edges, u and v as
/// in \[CP\] eq. 7.
fn sum_over_triangles(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    exponents: Exponents,
    measure: impl Fn(&Vector3<f64>) -> f64 + Sync,
) -> f64 {
    let monomials = Monomials::dividing(exponents);
    let last = monomials.exponents().len() - 1;
    let sum = sum_by_halves(triangles.len(), &|range| {
        let mut table = Vec::new();
        triangles[range].iter().fold(0.0, |sum, named| {
            let corners = named.map_each(|vertex| vertices[vertex as usize]);
            monomials.coefficients(&corners.map_each(|corner| corner.coords.into()), &mut table);
            sum + measure(&doubled_area(&corners)) * table[last]
        })
    });
    0.5 * weight(2, exponents) * sum
}

/// The normal of a triangle, twice its area long.
fn doubled_area([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a))
}
