//! Second derivatives from the areas of interfaces.

use std::ops::{Add, Sub};

use nalgebra::Matrix3;

use crate::chebyshev::family::Family;
use crate::chebyshev::interface::Interface;

/// Σ A w wᵀ over the interfaces, A their areas and w = s_i e_i − s_j e_j: the entries xx, yy, zz, xy,
/// xz and yz.
#[inline(always)]
pub(crate) fn bend<T>(areas: &[T; Interface::SLOTS]) -> [T; 6]
where
    T: Copy + Add<Output = T> + Sub<Output = T>,
{
    let family = |number: usize| {
        let area = |place: usize| areas[Family::SIZE * number + place];
        // On + + and − − the directions of w differ, on + − and − + they agree.
        let (same, opposite) = (area(0) + area(3), area(1) + area(2));
        (same + opposite, opposite - same)
    };
    let [(xy, beside_xy), (xz, beside_xz), (yz, beside_yz)] = [0, 1, 2].map(family);
    [xy + xz, xy + yz, xz + yz, beside_xy, beside_xz, beside_yz]
}

/// The symmetric matrix of these entries.
#[inline(always)]
pub(crate) fn symmetric([xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Matrix3<f64> {
    Matrix3::new(
        xx, xy, xz, //
        xy, yy, yz, //
        xz, yz, zz,
    )
}

/// Σ (A/√2) w wᵀ over the interfaces, from 4/√2 times their areas.
pub(crate) fn interface_hessian(areas: &[f64; Interface::SLOTS]) -> Matrix3<f64> {
    symmetric(bend(areas).map(|entry| 0.25 * entry))
}
