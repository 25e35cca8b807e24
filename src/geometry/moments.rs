//! Mass, first and second moments of a body: the ten numbers of every mass property.
//!
//! Over a tetrahedron with corners 0, a, b, c and volume V = det(a, b, c)/6, with s = a + b + c,
//! ∫ y = V s/4 and ∫ y yᵀ = V (a aᵀ + b bᵀ + c cᵀ + s sᵀ)/20. A closed surface of triangles bounds
//! the signed sum of these cones.

use std::ops::{Add, AddAssign, Mul};

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

/// ∫ρ dV, ∫ρ y dV and ∫ρ y yᵀ dV of a body of density ρ, y measured from an origin the caller
/// keeps: the integrals of \[M\] eq. 18-27, weighted.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Diagram};
///
/// let cube = Cuboid::unit();
/// let moments = Diagram::new(&cube, &[[0.5; 3]])?.map_cells(|cell| cell.moments())?;
/// assert!((moments[0].second[(0, 0)] - 1.0 / 12.0).abs() < 1e-15);
/// # Ok::<(), chebloyd::DiagramError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// ∫ρ dV (mass; the volume where ρ = 1).
    pub mass: f64,
    /// ∫ρ y dV (mass · L).
    pub first: Vector3<f64>,
    /// ∫ρ y yᵀ dV, symmetric (mass · L²).
    pub second: Matrix3<f64>,
}

impl Moments {
    /// From ∫ρ·{1, x, y, z, x², y², z², xy, yz, zx}, the order of \[M\] Table 1.
    #[must_use]
    pub fn from_ten(ten: [f64; 10]) -> Self {
        let [mass, x, y, z, xx, yy, zz, xy, yz, zx] = ten;
        Self {
            mass,
            first: Vector3::new(x, y, z),
            second: Matrix3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz),
        }
    }

    /// ∫ρ·{1, x, y, z, x², y², z², xy, yz, zx}, the order of \[M\] Table 1.
    #[must_use]
    pub fn ten(&self) -> [f64; 10] {
        let (f, s) = (&self.first, &self.second);
        [
            self.mass, f.x, f.y, f.z, s.m11, s.m22, s.m33, s.m12, s.m23, s.m13,
        ]
    }

    /// Adds the cone of density 1 over a triangle, with the sign of det(a, b, c).
    pub fn add_cone(&mut self, [a, b, c]: [Vector3<f64>; 3]) {
        let volume = a.dot(&b.cross(&c)) / 6.0;
        let sum = a + b + c;
        self.mass += volume;
        self.first += sum * (volume / 4.0);
        for corner in [a, b, c, sum] {
            self.second += corner * corner.transpose() * (volume / 20.0);
        }
    }

    /// The mass center's offset from the origin (L); not finite for a body without mass.
    #[must_use]
    pub fn center(&self) -> Vector3<f64> {
        self.first / self.mass
    }

    /// The mass center as a point; the origin for a body without mass.
    #[must_use]
    pub fn centroid(&self) -> Point3<f64> {
        if self.mass == 0.0 {
            return Point3::origin();
        }
        Point3::from(self.center())
    }

    /// ∫ρ |y − center|² dV (mass · L²) by the parallel-axis relation.
    #[must_use]
    pub fn second_about(&self, center: &Point3<f64>) -> f64 {
        let shift = center.coords;
        self.second.trace() - 2.0 * shift.dot(&self.first) + self.mass * shift.norm_squared()
    }

    /// The inertia tensor about the origin (mass · L²), \[M\] eq. 3 and 6-11: off-diagonals are
    /// the negative products of inertia.
    #[must_use]
    pub fn inertia(&self) -> Matrix3<f64> {
        Matrix3::from_diagonal_element(self.second.trace()) - self.second
    }

    /// The same body moved by `offset`; equally, the same body measured from an origin moved by
    /// −`offset`.
    #[must_use]
    pub fn translated(&self, offset: &Vector3<f64>) -> Self {
        let mixed = self.first * offset.transpose();
        Self {
            mass: self.mass,
            first: self.first + offset * self.mass,
            second: self.second
                + mixed
                + mixed.transpose()
                + offset * offset.transpose() * self.mass,
        }
    }

    /// The same body rotated about the origin.
    #[must_use]
    pub fn rotated(&self, rotation: &Rotation3<f64>) -> Self {
        Self {
            mass: self.mass,
            first: rotation * self.first,
            second: rotation * self.second * rotation.matrix().transpose(),
        }
    }
}

impl Add for Moments {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }
}

impl AddAssign for Moments {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for Moments {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            mass: self.mass * factor,
            first: self.first * factor,
            second: self.second * factor,
        }
    }
}
