//! Integrals of monomials over polygonal faces given as loops, and over the solids they bound.
//!
//! A face is a planar region bounded by loops of vertices: the outer one runs counter-clockwise
//! seen from the side its normal points to, holes run clockwise. The region is the signed sum of
//! the triangles (first vertex, v_i, v_{i+1}) of every loop (\[CP\] section 2, "Algorithm
//! preview"): edges that are not the face's cancel, so neither convexity nor a triangulation that
//! respects the holes is needed.

use crate::arrays::MapEach;
use crate::integrals::reference::cattani_paoluzzi;
use crate::integrals::series::{Exponents, over_simplex};
use nalgebra::{Point3, Vector3};

/// A planar face: loops of vertex numbers, the outer counter-clockwise, holes clockwise.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Face {
    /// The loops; a loop's last vertex joins its first.
    pub loops: Vec<Vec<u32>>,
}

impl Face {
    /// A face without holes.
    #[must_use]
    pub fn simple(vertices: impl Into<Vec<u32>>) -> Self {
        Self {
            loops: vec![vertices.into()],
        }
    }

    /// The triangles whose signed sum is the face; those of a reflex corner or a hole run
    /// backwards.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.loops.iter().flat_map(|vertices| {
            vertices
                .windows(2)
                .skip(1)
                .map(|edge| [vertices[0], edge[0], edge[1]])
        })
    }

    /// The vector area (L²): the face's normal, as long as the face's area.
    ///
    /// # Panics
    ///
    /// If a loop names a vertex that is not there.
    #[must_use]
    pub fn vector_area(&self, vertices: &[Point3<f64>]) -> Vector3<f64> {
        self.triangles()
            .map(|triangle| vector_area(&corners(vertices, triangle)))
            .sum()
    }
}

/// ∫ x^α y^β z^γ dA over a planar face with holes.
///
/// # Panics
///
/// If a loop names a vertex that is not there.
#[must_use]
pub fn face(vertices: &[Point3<f64>], face: &Face, exponents: Exponents) -> f64 {
    let triangles: Vec<_> = face.triangles().collect();
    let normal = face.vector_area(vertices);
    cattani_paoluzzi::planar_surface(vertices, &triangles, &normal, exponents)
}

/// ∫ x^α y^β z^γ dV over the solid bounded by planar faces with holes, by the divergence theorem
/// as in \[CP\] eq. 15.
///
/// # Panics
///
/// If a loop names a vertex that is not there.
#[must_use]
pub fn solid(vertices: &[Point3<f64>], faces: &[Face], exponents: Exponents) -> f64 {
    let [alpha, beta, gamma] = exponents;
    let raised = [alpha + 1, beta, gamma];
    let flux = faces.iter().flat_map(Face::triangles).map(|triangle| {
        let corners = corners(vertices, triangle);
        let measure = vector_area(&corners).x;
        over_simplex(measure, corners.map_each(|corner| corner.coords), raised)
    });
    flux.sum::<f64>() / f64::from(alpha + 1)
}

fn corners(vertices: &[Point3<f64>], triangle: [u32; 3]) -> [Point3<f64>; 3] {
    triangle.map_each(|vertex| vertices[vertex as usize])
}

fn vector_area([a, b, c]: &[Point3<f64>; 3]) -> Vector3<f64> {
    0.5 * (b - a).cross(&(c - a))
}
