//! Volume, first and second moments of a convex polyhedron.
//!
//! Each facet is fanned from its first corner; every triangle (a, b, d) makes the signed
//! tetrahedron with the origin, of volume det(a, b, d)/6. Over a tetrahedron with one corner in
//! the origin ∫ y = V (a+b+d)/4 and ∫ |y|² = V (|a|²+|b|²+|d|²+|a+b+d|²)/20.

use nalgebra::{Point3, Vector3};

use crate::geometry::polyhedron::Polyhedron;

/// Integrals of 1, y and |y|² over a polyhedron, y from the origin of its coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// ∫ 1 dy (L³).
    pub volume: f64,
    /// ∫ y dy (L⁴).
    pub first: Vector3<f64>,
    /// ∫ |y|² dy (L⁵).
    pub second: f64,
}

impl Moments {
    /// The moments of `polyhedron`; zero for the empty set.
    #[must_use]
    pub fn of(polyhedron: &Polyhedron) -> Self {
        let mut moments = Self::default();
        for facet in polyhedron.facets() {
            let mut corners = facet.corners().map(|corner| corner.coords);
            let (Some(anchor), Some(mut last)) = (corners.next(), corners.next()) else {
                continue;
            };
            for corner in corners {
                moments.add_tetrahedron(&anchor, &last, &corner);
                last = corner;
            }
        }
        moments
    }

    /// The mass center; the origin for a volume of zero.
    #[must_use]
    pub fn centroid(&self) -> Point3<f64> {
        if self.volume == 0.0 {
            return Point3::origin();
        }
        Point3::from(self.first / self.volume)
    }

    /// Adds `sign` times the other's moments, both about the same origin.
    pub fn add_signed(&mut self, sign: f64, other: &Self) {
        self.volume += sign * other.volume;
        self.first += other.first * sign;
        self.second += sign * other.second;
    }

    /// ∫ |y − center|² dy by the parallel-axis relation (L⁵).
    #[must_use]
    pub fn second_about(&self, center: &Point3<f64>) -> f64 {
        let shift = center.coords;
        self.second - 2.0 * shift.dot(&self.first) + self.volume * shift.norm_squared()
    }

    pub(crate) fn add_tetrahedron(&mut self, a: &Vector3<f64>, b: &Vector3<f64>, d: &Vector3<f64>) {
        let volume = a.dot(&b.cross(d)) / 6.0;
        let sum = a + b + d;
        self.volume += volume;
        self.first += sum * (volume / 4.0);
        let squares = a.norm_squared() + b.norm_squared() + d.norm_squared() + sum.norm_squared();
        self.second += volume / 20.0 * squares;
    }
}
