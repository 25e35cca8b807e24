//! The moments of the density sin(k|y − p|) + 1 (\[BL\] eq. 5) over a solid, with their derivatives by p and k.
//!
//! With f(y) = sin(k|y − p|) + 1 and a polynomial φ that does not move with p, Gauss's theorem gives
//!
//! ```text
//! ∂/∂p ∫_Ω f φ = −∫_Ω ∇f φ = ∫_Ω f ∇φ − ∮ f φ n dA
//! k ∂/∂k ∫_Ω f φ = ∫_Ω φ r·∇f = ∮ f φ r·n dA − ∫_Ω f (3 φ + r·∇φ),    r = y − p,
//! ```
//!
//! since k ∂f/∂k = ρ ∂f/∂ρ = r·∇f. All of it comes from the triangles: ∫_Ω by `radial`, and what is over the
//! surface at the same nodes.

use std::ops::{Add, Range};

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::gauss_legendre;
use crate::integrals::pairwise::sum_by_halves;
use crate::integrals::radial::RadialKind;

/// Integrals of f(y){1, r, r rᵀ}, r measured from p.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SineJet {
    /// Over the solid.
    pub(crate) volume: Moments,
    /// Over its surface, times each component of the normal.
    pub(crate) normal: [Moments; 3],
    /// Over its surface, times r·n.
    pub(crate) height: Moments,
}

impl Add for SineJet {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            volume: self.volume + other.volume,
            normal: [0, 1, 2].map_each(|axis| self.normal[axis] + other.normal[axis]),
            height: self.height + other.height,
        }
    }
}

/// The jet of a closed surface, by products of Gauss rules of `nodes` nodes on each triangle.
pub(crate) fn sine_jet(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    point: &Point3<f64>,
    k: f64,
    nodes: usize,
) -> SineJet {
    let (rule, kind) = (gauss_legendre(nodes), RadialKind::Sine { k });
    sum_by_halves(triangles.len(), &|range: Range<usize>| {
        let parts = triangles[range].iter().map(|triangle| {
            let corners = triangle.map_each(|vertex| vertices[vertex as usize] - point);
            of_triangle(&corners, &kind, &rule)
        });
        parts.fold(SineJet::default(), |sum, part| sum + part)
    })
}

fn of_triangle([a, b, c]: &[Vector3<f64>; 3], kind: &RadialKind, rule: &[(f64, f64)]) -> SineJet {
    let (second, third) = (b - a, c - a);
    let normal = second.cross(&third);
    let height = a.dot(&normal);
    let (mut volume, mut surface) = (Moments::default(), Moments::default());
    for (u, along) in rule {
        for (v, across) in rule {
            let place = a + second * *u + (third - second) * (u * v);
            let weight = along * across * u;
            let radius = place.norm();
            let square = place * place.transpose();
            let [g0, g1, g2] = kind.along_ray(radius).map_each(|g| weight * height * g);
            volume.mass += g0;
            volume.first += place * g1;
            volume.second += square * g2;
            let value = weight * kind.at(radius);
            surface.mass += value;
            surface.first += place * value;
            surface.second += square * value;
        }
    }
    SineJet {
        volume,
        normal: [0, 1, 2].map_each(|axis| surface * normal[axis]),
        height: surface * height,
    }
}
