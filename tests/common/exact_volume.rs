//! Volumes in integer arithmetic: a second opinion without rounding.

use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};

/// A finite number as integer · 2^exponent.
fn parts(number: f64) -> (i64, i32) {
    let bits = number.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as i32;
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let integer = if exponent == 0 {
        fraction
    } else {
        fraction | 1 << 52
    };
    let sign = if number.is_sign_negative() { -1 } else { 1 };
    (sign * integer, exponent.max(1) - 1075)
}

/// Points as integers in a common unit 2^exponent.
pub(crate) struct ExactPoints {
    exponent: i32,
    points: Vec<[BigInt; 3]>,
}

impl ExactPoints {
    pub(crate) fn of(points: &[[f64; 3]]) -> Self {
        let numbers = points.iter().flatten().map(|&number| parts(number));
        let exponent = numbers.filter(|part| part.0 != 0).map(|part| part.1).min();
        let exponent = exponent.unwrap_or(0);
        let integer = |number: f64| {
            let (integer, own) = parts(number);
            BigInt::from(integer) << (own - exponent).max(0) as usize
        };
        let points = points.iter().map(|point| point.map(integer)).collect();
        Self { exponent, points }
    }

    fn arm(&self, from: u32, to: u32) -> [BigInt; 3] {
        let [from, to] = [from, to].map(|point| &self.points[point as usize]);
        [0, 1, 2].map(|axis| &to[axis] - &from[axis])
    }

    /// Six times the signed volume of a tetrahedron, in units.
    fn six_volumes(&self, [a, b, c, d]: [u32; 4]) -> BigInt {
        let [u, v, w] = [b, c, d].map(|corner| self.arm(a, corner));
        let minor = |i: usize, j: usize| &v[i] * &w[j] - &v[j] * &w[i];
        &u[0] * minor(1, 2) + &u[1] * minor(2, 0) + &u[2] * minor(0, 1)
    }

    /// The signed sum of tetrahedra, and the sum of their absolute volumes.
    pub(crate) fn volume(&self, tets: impl IntoIterator<Item = [u32; 4]>) -> (f64, f64) {
        let (mut sum, mut size) = (BigInt::zero(), BigInt::zero());
        for tet in tets {
            let volume = self.six_volumes(tet);
            size += volume.abs();
            sum += volume;
        }
        (self.in_f64(&sum) / 6.0, self.in_f64(&size) / 6.0)
    }

    /// An integer in cubic units as the nearest number, to a few roundings.
    fn in_f64(&self, integer: &BigInt) -> f64 {
        let excess = integer.bits().saturating_sub(64) as i64;
        let leading = (integer >> excess as usize).to_f64().unwrap_or(f64::NAN);
        let exponent = 3 * i64::from(self.exponent) + excess;
        // In two steps, neither of which over- or underflows before the result does.
        let half = (exponent / 2).clamp(-1000, 1000) as i32;
        let rest = (exponent - i64::from(half)).clamp(-2000, 2000) as i32;
        let (one, two) = (rest / 2, rest - rest / 2);
        leading * 2_f64.powi(half) * 2_f64.powi(one) * 2_f64.powi(two)
    }
}

#[test]
fn a_sliver_has_its_exact_volume() {
    let points = ExactPoints::of(&[
        [1e-9, 0.0, 3.0],
        [1.0, 0.0, 3.0],
        [0.0, 0.1, 3.0],
        [0.5, 0.0, 3.0 + 1e-15],
    ]);
    let height = (3.0_f64 + 1e-15) - 3.0;
    let expected = (1.0 - 1e-9) * 0.1 * height / 6.0;
    let (volume, size) = points.volume([[0, 1, 2, 3]]);
    assert!(
        (volume / expected - 1.0).abs() < 1e-14 && size > 0.0,
        "{volume} {expected}"
    );
    let (volume, size) = points.volume([[0, 1, 2, 3], [1, 0, 2, 3]]);
    assert!(volume.abs() < 1e-300 && (size / (2.0 * expected) - 1.0).abs() < 1e-14);
}
