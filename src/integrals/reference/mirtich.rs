//! Mirtich's ten integrals over a polyhedron with polygonal faces, in one loop over its faces.
//!
//! Volume integrals become face integrals by the divergence theorem (\[M\] eq. 29-38), face
//! integrals become integrals over the face's shadow on a coordinate plane (eq. 57-68), and those
//! become sums over edges by Green's theorem (eq. 89-98). The shadow is cast along the largest
//! component of the face's normal, so no division is by less than 1/√3. Faces may be non-convex
//! and may have holes; only their edges are read.
//!
//! Departures: vertices are taken relative to an origin near the body, the normal is the
//! face's vector area normalized (the paper leaves its source open), and faces are summed by
//! halves.

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::reference::polygon::Face;
use nalgebra::{Point3, Vector3};

/// ∫ α^p β^q over a face's shadow, p + q ≤ 3, times the sign of n_γ: \[M\] eq. 89-98, named by the
/// powers.
#[derive(Clone, Copy, Debug, Default)]
struct Projection {
    one: f64,
    a: f64,
    b: f64,
    aa: f64,
    ab: f64,
    bb: f64,
    aaa: f64,
    aab: f64,
    abb: f64,
    bbb: f64,
}

/// The twelve integrals over a face itself that the ten need: \[M\] eq. 43-54, per axis
/// (α, β, γ).
#[derive(Clone, Copy, Debug)]
struct FaceIntegrals {
    /// ∫α, ∫β, ∫γ.
    first: [f64; 3],
    /// ∫α², ∫β², ∫γ².
    second: [f64; 3],
    /// ∫α³, ∫β³, ∫γ³.
    third: [f64; 3],
    /// ∫α²β, ∫β²γ, ∫γ²α.
    mixed: [f64; 3],
}

/// T_1, T_x … T_{zx} (\[M\] eq. 18-27) of the solid bounded by planar `faces`, measured from
/// `origin`: [`Moments::ten`] lists them in the paper's order.
///
/// Negative for a surface turned inside out, meaningless for an open one. Faces without area
/// count nothing.
///
/// # Panics
///
/// If a face names a vertex that is not there.
#[must_use]
pub fn ten_integrals(vertices: &[Point3<f64>], faces: &[Face], origin: &Point3<f64>) -> Moments {
    sum_by_halves(faces.len(), &|range| {
        share_of_faces(vertices, &faces[range], origin)
    })
}

/// `CompVolumeIntegrals`, \[M\] Fig. 4, on some of the faces.
fn share_of_faces(vertices: &[Point3<f64>], faces: &[Face], origin: &Point3<f64>) -> Moments {
    let mut volume = 0.0;
    let (mut first, mut second, mut products) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for face in faces {
        let Some(normal) = face.vector_area(vertices).try_normalize(0.0) else {
            continue;
        };
        let axes = projection_axes(&normal);
        let face = face_integrals(vertices, face, origin, &normal, axes);
        for (place, axis) in axes.into_iter().enumerate() {
            if axis == 0 {
                volume += normal.x * face.first[place];
            }
            first[axis] += normal[axis] * face.second[place];
            second[axis] += normal[axis] * face.third[place];
            products[axis] += normal[axis] * face.mixed[place];
        }
    }
    let [x, y, z] = first.map_each(|sum| sum / 2.0);
    let [xx, yy, zz] = second.map_each(|sum| sum / 3.0);
    let [xy, yz, zx] = products.map_each(|sum| sum / 2.0);
    Moments::from_ten([volume, x, y, z, xx, yy, zz, xy, yz, zx])
}

/// The right-handed permutation (α, β, γ) of the axes with the largest |n_γ|.
fn projection_axes(normal: &Vector3<f64>) -> [usize; 3] {
    let gamma = normal.iamax();
    [(gamma + 1) % 3, (gamma + 2) % 3, gamma]
}

/// `CompFaceIntegrals`, \[M\] Fig. 5.
fn face_integrals(
    vertices: &[Point3<f64>],
    face: &Face,
    origin: &Point3<f64>,
    normal: &Vector3<f64>,
    [alpha, beta, gamma]: [usize; 3],
) -> FaceIntegrals {
    let mut pi = Projection::default();
    let mut on_plane = Vector3::zeros();
    for vertices_of_loop in &face.loops {
        let at = |vertex: &u32| vertices[*vertex as usize] - origin;
        let next = vertices_of_loop.iter().cycle().skip(1);
        for (start, end) in vertices_of_loop.iter().map(at).zip(next.map(at)) {
            pi.add_edge([start[alpha], start[beta]], [end[alpha], end[beta]]);
            on_plane = start;
        }
    }
    let pi = pi.scaled();
    let (na, nb, w) = (normal[alpha], normal[beta], -normal.dot(&on_plane));
    let k1 = 1.0 / normal[gamma];
    let (k2, k3, k4) = (k1 * k1, k1 * k1 * k1, k1 * k1 * k1 * k1);
    let gamma_first = -k2 * (na * pi.a + nb * pi.b + w * pi.one);
    let gamma_second = k3
        * (na * na * pi.aa
            + 2.0 * na * nb * pi.ab
            + nb * nb * pi.bb
            + w * (2.0 * (na * pi.a + nb * pi.b) + w * pi.one));
    let gamma_third = -k4
        * (na * na * (na * pi.aaa + 3.0 * nb * pi.aab)
            + nb * nb * (3.0 * na * pi.abb + nb * pi.bbb)
            + 3.0 * w * (na * na * pi.aa + 2.0 * na * nb * pi.ab + nb * nb * pi.bb)
            + w * w * (3.0 * (na * pi.a + nb * pi.b) + w * pi.one));
    let beta_beta_gamma = -k2 * (na * pi.abb + nb * pi.bbb + w * pi.bb);
    let gamma_gamma_alpha = k3
        * (na * na * pi.aaa
            + 2.0 * na * nb * pi.aab
            + nb * nb * pi.abb
            + w * (2.0 * (na * pi.aa + nb * pi.ab) + w * pi.a));
    FaceIntegrals {
        first: [k1 * pi.a, k1 * pi.b, gamma_first],
        second: [k1 * pi.aa, k1 * pi.bb, gamma_second],
        third: [k1 * pi.aaa, k1 * pi.bbb, gamma_third],
        mixed: [k1 * pi.aab, beta_beta_gamma, gamma_gamma_alpha],
    }
}

impl Projection {
    /// One edge's share of the sums of `CompProjectionIntegrals`, \[M\] Fig. 6.
    fn add_edge(&mut self, [a0, b0]: [f64; 2], [a1, b1]: [f64; 2]) {
        let (da, db) = (a1 - a0, b1 - b0);
        let (a0_2, b0_2, a1_2, b1_2) = (a0 * a0, b0 * b0, a1 * a1, b1 * b1);
        let (a0_3, b0_3, a1_3, b1_3) = (a0_2 * a0, b0_2 * b0, a1_2 * a1, b1_2 * b1);
        let c1 = a1 + a0;
        let ca = a1 * c1 + a0_2;
        let caa = a1 * ca + a0_3;
        let caaa = a1 * caa + a0_3 * a0;
        let cb = b1 * (b1 + b0) + b0_2;
        let cbb = b1 * cb + b0_3;
        let cbbb = b1 * cbb + b0_3 * b0;
        let cab = 3.0 * a1_2 + 2.0 * a1 * a0 + a0_2;
        let kab = a1_2 + 2.0 * a1 * a0 + 3.0 * a0_2;
        let caab = a0 * cab + 4.0 * a1_3;
        let kaab = a1 * kab + 4.0 * a0_3;
        let cabb = 4.0 * b1_3 + 3.0 * b1_2 * b0 + 2.0 * b1 * b0_2 + b0_3;
        let kabb = b1_3 + 2.0 * b1_2 * b0 + 3.0 * b1 * b0_2 + 4.0 * b0_3;
        self.one += db * c1;
        self.a += db * ca;
        self.aa += db * caa;
        self.aaa += db * caaa;
        self.b += da * cb;
        self.bb += da * cbb;
        self.bbb += da * cbbb;
        self.ab += db * (b1 * cab + b0 * kab);
        self.aab += db * (b1 * caab + b0 * kaab);
        self.abb += da * (a1 * cabb + a0 * kabb);
    }

    /// The constant factors of eq. 89-98.
    fn scaled(self) -> Self {
        Self {
            one: self.one / 2.0,
            a: self.a / 6.0,
            aa: self.aa / 12.0,
            aaa: self.aaa / 20.0,
            b: -self.b / 6.0,
            bb: -self.bb / 12.0,
            bbb: -self.bbb / 20.0,
            ab: self.ab / 24.0,
            aab: self.aab / 60.0,
            abb: -self.abb / 60.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_projection_axis_is_the_largest_and_the_triple_right_handed() {
        for (normal, axes) in [
            ([0.9, 0.1, -0.2], [1, 2, 0]),
            ([0.3, -0.8, 0.2], [2, 0, 1]),
            ([0.3, 0.2, -0.7], [0, 1, 2]),
        ] {
            assert_eq!(projection_axes(&normal.into()), axes);
        }
    }
}
