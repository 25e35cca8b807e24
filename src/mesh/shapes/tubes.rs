//! Tubes around closed curves.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

use crate::mesh::shapes::boxes::split_quad;
use crate::mesh::surface::SurfaceMesh;

/// A torus around the z axis: `around` segments along the ring of radius `ring`, `across`
/// along the tube of radius `tube` (both at least 3).
#[must_use]
pub fn torus(ring: f64, tube: f64, around: u32, across: u32) -> SurfaceMesh {
    let center = |turn: f64| Point3::new(ring * turn.cos(), ring * turn.sin(), 0.0);
    closed_tube(center, tube, around, across)
}

/// A tube of radius `tube` along the trefoil knot (sin t + 2 sin 2t, cos t − 2 cos 2t, −sin 3t),
/// with `around` segments along the knot and `across` along the tube. A radius below 0.5 keeps
/// the tube from touching itself.
#[must_use]
pub fn trefoil(tube: f64, around: u32, across: u32) -> SurfaceMesh {
    let center = |t: f64| {
        let x = t.sin() + 2.0 * (2.0 * t).sin();
        let y = t.cos() - 2.0 * (2.0 * t).cos();
        Point3::new(x, y, -(3.0 * t).sin())
    };
    closed_tube(center, tube, around, across)
}

/// A tube around a closed curve of period 2π, its cross-sections in planes that hold the z-most
/// normal, so that it closes without a twist.
fn closed_tube(
    center: impl Fn(f64) -> Point3<f64>,
    tube: f64,
    around: u32,
    across: u32,
) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for i in 0..around {
        let t = TAU * f64::from(i) / f64::from(around);
        let here = center(t);
        let half_step = TAU / f64::from(around) / 2.0;
        let tangent = (center(t + half_step) - center(t - half_step)).normalize();
        let side = tangent.cross(&Vector3::z()).normalize();
        let up = side.cross(&tangent);
        for j in 0..across {
            let turn = TAU * f64::from(j) / f64::from(across);
            mesh.vertices
                .push(here + (side * turn.cos() + up * turn.sin()) * tube);
        }
    }
    let vertex = |i: u32, j: u32| (i % around) * across + j % across;
    for i in 0..around {
        for j in 0..across {
            let quad = [
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1),
            ];
            mesh.triangles.extend(split_quad(&quad));
        }
    }
    mesh
}
