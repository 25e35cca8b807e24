//! Closed half-spaces n·y ≤ d, and bisectors.

use crate::arrays::MapEach;
use nalgebra::{Point3, Vector3};
use wide::f64x4;

/// The closed half-space n·y ≤ d. The normal points out of it and need not be of unit length.
///
/// # Examples
/// ```
/// use chebloyd::HalfSpace;
///
/// let below = HalfSpace { normal: [0.0, 0.0, 1.0].into(), offset: 2.0 };
/// assert!(below.excess(&[5.0, 5.0, 1.0].into()) < 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// The outward normal n.
    pub normal: Vector3<f64>,
    /// The offset d, in L times the normal's length.
    pub offset: f64,
}

impl HalfSpace {
    /// The points at least as near to the origin as to `displacement`.
    ///
    /// The normal is the displacement itself, so that nothing but one product is rounded, however
    /// near the two points lie.
    #[must_use]
    pub fn bisector(displacement: Vector3<f64>) -> Self {
        Self {
            offset: 0.5 * displacement.norm_squared(),
            normal: displacement,
        }
    }

    /// n·y − d: positive outside, in L times the normal's length.
    #[must_use]
    pub fn excess(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }

    /// The same half-space with a unit normal; unchanged where the normal is zero.
    #[must_use]
    pub fn normalized(&self) -> Self {
        let length = self.normal.norm();
        if length > 0.0 {
            Self {
                normal: self.normal / length,
                offset: self.offset / length,
            }
        } else {
            *self
        }
    }

    /// Four half-spaces with unit normals, but for those that are zero, by coordinate.
    #[inline(always)]
    pub(crate) fn units([x, y, z, offset]: [f64x4; 4]) -> [f64x4; 4] {
        let length = (x * x + y * y + z * z).sqrt();
        let is_long = length.simd_gt(f64x4::ZERO);
        let scale = is_long.select(f64x4::ONE / length, f64x4::ONE);
        [x, y, z, offset].map_each(|all| all * scale)
    }

    /// The half-space moved by `displacement`.
    #[must_use]
    pub fn translated(&self, displacement: &Vector3<f64>) -> Self {
        Self {
            normal: self.normal,
            offset: self.offset + self.normal.dot(displacement),
        }
    }
}
