//! Numbers of 106 bits as the unevaluated sum of two `f64`.
//!
//! Sums and products lose at most a few units in 2⁻¹⁰⁴ (Dekker, *A floating-point technique for extending
//! the available precision*, 1971; Knuth, *The Art of Computer Programming* 2, section 4.2.2, for the
//! exact sum). What is too large for `f64` becomes infinite or NaN.

use std::ops::{Add, Div, Mul, Neg};

/// high + low, |low| at most half a unit in the last place of high.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// The nearest `f64`.
    #[must_use]
    pub(crate) fn rounded(self) -> f64 {
        self.high
    }

    /// a + b with |a| ≥ |b|, exactly.
    fn of_sorted(a: f64, b: f64) -> Self {
        let high = a + b;
        let low = b - (high - a);
        Self { high, low }
    }

    /// a + b, exactly.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let of_b = high - a;
        let low = (a - (high - of_b)) + (b - of_b);
        Self { high, low }
    }

    /// a · b, exactly.
    fn product(a: f64, b: f64) -> Self {
        let high = a * b;
        let low = a.mul_add(b, -high);
        Self { high, low }
    }
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let high = Self::sum(self.high, other.high);
        let low = Self::sum(self.low, other.low);
        let sum = Self::of_sorted(high.high, high.low + low.high);
        Self::of_sorted(sum.high, sum.low + low.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = Self::product(self.high, other.high);
        let rest = self.high * other.low + self.low * other.high;
        Self::of_sorted(product.high, product.low + rest)
    }
}

impl Div<f64> for DoubleDouble {
    type Output = Self;

    fn div(self, divisor: f64) -> Self {
        let first = self.high / divisor;
        let rest = self + -Self::product(first, divisor);
        let second = rest.high / divisor;
        let rest = rest + -Self::product(second, divisor);
        Self::of_sorted(first, second) + Self::from(rest.high / divisor)
    }
}
