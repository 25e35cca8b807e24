//! Sums and products of vectors in four SIMD lanes.

use wide::f64x4;

/// The sum of all lanes.
#[inline(always)]
pub(crate) fn sum(lanes: f64x4) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// The scalar products of four pairs of vectors, by axis.
#[inline(always)]
pub(crate) fn dot(a: &[f64x4; 3], b: &[f64x4; 3]) -> f64x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross products.
#[inline(always)]
pub(crate) fn cross(a: &[f64x4; 3], b: &[f64x4; 3]) -> [f64x4; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
