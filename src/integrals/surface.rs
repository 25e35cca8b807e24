//! The ten moments of the solid inside a closed triangulated surface.
//!
//! Each triangle t and the origin o span a tetrahedron, counted with the sign its triangle shows
//! to o; the signed sum of these cones is the solid, wherever o lies. That is the divergence
//! theorem with the field y f(y) / (3 + n) for every homogeneous part f of degree n, so no
//! tetrahedron is ever built and none need lie inside. Time is linear in the triangles.

use crate::integrals::lanes::{
    CONSTANT, LINEAR, LanePoint, Lanes, Sums, WIDTH, gathered, named, six_volumes, splat,
    sum_of_lanes,
};
use crate::integrals::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use nalgebra::{Point3, Vector3};

/// A density that is linear in space: `value` at the origin of the routine that takes it, growing
/// by `gradient` per length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDensity {
    /// The density at the origin (mass / L³).
    pub value: f64,
    /// The density's gradient (mass / L⁴).
    pub gradient: Vector3<f64>,
}

/// The ten moments at density 1, measured from `origin`: \[M\] eq. 18-27 on triangles.
///
/// Negative for a surface turned inside out, meaningless for an open one.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn constant(vertices: &[Point3<f64>], triangles: &[[u32; 3]], origin: &Point3<f64>) -> Moments {
    let origin = splat(origin);
    sum_by_halves(triangles.len(), &|range| {
        let mut sums = Sums::default();
        for block in triangles[range].chunks(WIDTH) {
            let corners = named(block).map(|named| gathered(vertices, named, &origin));
            sums.add_constant(six_volumes(&corners), &corners);
        }
        sums.moments(CONSTANT)
    })
}

/// The ten moments at a density linear in space, measured from `origin`: \[BL\] eq. 1-4 summed
/// over the cones.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn linear(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    density: &LinearDensity,
    origin: &Point3<f64>,
) -> Moments {
    let origin = splat(origin);
    let gradient = splat(&density.gradient.into());
    let apex = Lanes::splat(density.value);
    let density_at =
        |y: &LanePoint| apex + (gradient[0] * y[0] + gradient[1] * y[1] + gradient[2] * y[2]);
    sum_by_halves(triangles.len(), &|range| {
        let mut sums = Sums::default();
        for block in triangles[range].chunks(WIDTH) {
            let corners = named(block).map(|named| gathered(vertices, named, &origin));
            let densities = corners.each_ref().map(density_at);
            sums.add_linear(six_volumes(&corners), &corners, &densities, apex);
        }
        sums.moments(LINEAR)
    })
}

/// The volume (L³) alone, measured from `origin`: \[M\] eq. 18.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn volume(vertices: &[Point3<f64>], triangles: &[[u32; 3]], origin: &Point3<f64>) -> f64 {
    let origin = splat(origin);
    let six = sum_by_halves(triangles.len(), &|range| {
        let cones = triangles[range].chunks(WIDTH).map(|block| {
            six_volumes(&named(block).map(|named| gathered(vertices, named, &origin)))
        });
        sum_of_lanes(cones.fold(Lanes::ZERO, |sum, cone| sum + cone))
    });
    six / 6.0
}

/// The area (L²) of a surface, open or closed: \[CP\] eq. 11-12.
///
/// # Panics
///
/// If a triangle names a vertex that is not there.
#[must_use]
pub fn area(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    0.5 * sum_by_halves(triangles.len(), &|range| {
        triangles[range].iter().fold(0.0, |sum, triangle| {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            sum + (b - a).cross(&(c - a)).norm()
        })
    })
}
