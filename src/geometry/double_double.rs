//! Determinants of differences of coordinates, to full precision whatever cancels.
//!
//! A *double-double* is an unevaluated sum of two numbers, the second at most half an ulp of the
//! first: about 106 bits. Sums and products follow Dekker, *A floating-point technique for extending
//! the available precision*, 1971, with the product's error from one fused multiply-add, which is
//! rounded alike on every processor. A difference of two coordinates is exact in this form, so the
//! six-fold volume of a tetrahedron with edges up to L has an error of about 2⁻¹⁰² L³: a rod of
//! width 10⁻⁸ and length 1 keeps every digit of its volume 10⁻¹⁶.

use std::ops::{Add, Mul, Sub};

use crate::arrays::MapEach;
use nalgebra::Point3;

/// The sum of both numbers.
#[derive(Clone, Copy, Debug)]
struct DoubleDouble(f64, f64);

impl DoubleDouble {
    /// a − b, exactly.
    fn difference(a: f64, b: f64) -> Self {
        let (sum, error) = two_sum(a, -b);
        Self(sum, error)
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, error) = two_sum(self.0, other.0);
        let (low, lower) = two_sum(self.1, other.1);
        let (high, error) = two_sum(high, error + low);
        let (high, error) = two_sum(high, error + lower);
        Self(high, error)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.add(Self(-other.0, -other.1))
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let error = self.0.mul_add(other.0, -product);
        let (high, low) = two_sum(product, error + (self.0 * other.1 + self.1 * other.0));
        Self(high, low)
    }
}

/// The rounded sum and its error: Knuth, *The Art of Computer Programming* 2, section 4.2.2,
/// theorem B.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// Six times the signed volume of the tetrahedron (apex, a, b, c): positive where a, b, c turn
/// counter-clockwise seen from the side away from the apex.
#[must_use]
pub(crate) fn six_volume(apex: &Point3<f64>, [a, b, c]: [&Point3<f64>; 3]) -> f64 {
    let arm = |end: &Point3<f64>| [0, 1, 2].map_each(|k| DoubleDouble::difference(end[k], apex[k]));
    let [a, b, c] = [arm(a), arm(b), arm(c)];
    let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
    let DoubleDouble(high, low) = a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1);
    high + low
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;
    use num_traits::ToPrimitive;
    use proptest::prelude::*;

    fn by_fractions(points: &[Point3<f64>; 4]) -> BigRational {
        let fraction = |x: f64| BigRational::from_float(x).expect("finite");
        let arm = |p: &Point3<f64>| [0, 1, 2].map(|k| fraction(p[k]) - fraction(points[0][k]));
        let [a, b, c] = [arm(&points[1]), arm(&points[2]), arm(&points[3])];
        let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
        &a[0] * minor(1, 2) + &a[1] * minor(2, 0) + &a[2] * minor(0, 1)
    }

    proptest! {
        /// Nearly flat tetrahedra far from the origin keep all digits that fractions give.
        #[test]
        fn flat_tetrahedra_keep_their_volumes(
            numbers in proptest::collection::vec(-1.0..1.0_f64, 12), flatness in -12..0_i32, away in 0..3_i32
        ) {
            let shift = 10_f64.powi(3 * away);
            let point = |k: usize| {
                let [x, y] = [numbers[3 * k], numbers[3 * k + 1]];
                let z = 0.7 * x - 0.3 * y + 10_f64.powi(flatness) * numbers[3 * k + 2];
                Point3::new(x + shift, y, z)
            };
            let points = [0, 1, 2, 3].map(point);
            let [apex, a, b, c] = &points;
            let exact = by_fractions(&points).to_f64().expect("finite");
            let got = six_volume(apex, [a, b, c]);
            prop_assert!((got - exact).abs() <= 1e-15 * exact.abs() + 1e-29, "{got} {exact}");
        }
    }
}
