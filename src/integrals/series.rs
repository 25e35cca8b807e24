//! Integrals of all monomials x^α y^β z^γ up to a degree over a simplex, by one recurrence.
//!
//! Over a d-simplex with corners v_0 … v_d, Dirichlet's integral of the barycentric monomials
//! gives
//!
//! ∫ x^α y^β z^γ = vol · d! α! β! γ! / (d + α + β + γ)! · c_{αβγ},
//!
//! c_{αβγ} the coefficient of s^α t^β u^γ in Π_k 1 / (1 − x_k s − y_k t − z_k u). Multiplying a
//! series by 1/(1 − x s − y t − z u) is one sweep c_{αβγ} += x c_{α−1,β,γ} + y c_{α,β−1,γ} +
//! z c_{α,β,γ−1} in ascending order, so a whole table costs three multiplications an entry and
//! corner. It is the complete homogeneous polynomial of the [`simplex`](crate::integrals::simplex)
//! file for three linear functions at once, has the value of the six-fold sum of \[CP\] eq. 10,
//! and loses no digits where coordinates share a sign. A corner at the origin leaves the series
//! as it is, which is why a cone costs no more than its base.

use crate::arrays::MapEach;
use nalgebra::Vector3;
use std::collections::HashMap;
use std::ops::{Add, Mul};

/// The powers (α, β, γ) of x, y and z in a monomial.
pub type Exponents = [u32; 3];

/// α + β + γ.
#[must_use]
pub fn degree(exponents: Exponents) -> u32 {
    exponents.iter().sum()
}

/// d! α! β! γ! / (d + α + β + γ)!: the integral over a d-simplex of volume 1 for each unit of the
/// series' coefficient.
#[must_use]
pub fn weight(dimension: u32, exponents: Exponents) -> f64 {
    let factorial = |n: u32| (1..=n).fold(1.0, |product, k| product * f64::from(k));
    let powers = exponents
        .into_iter()
        .fold(factorial(dimension), |product, power| {
            product * factorial(power)
        });
    powers / factorial(dimension + degree(exponents))
}

/// A set of monomials that holds with each its divisors, in ascending degree: the shape of a
/// table of coefficients.
#[derive(Clone, Debug)]
pub struct Monomials {
    exponents: Vec<Exponents>,
    /// The places of the monomial divided by x, y and z; the length where it is not divisible.
    divided: Vec<[usize; 3]>,
}

impl Monomials {
    /// All monomials of total degree at most `highest`.
    #[must_use]
    pub fn up_to(highest: u32) -> Self {
        Self::below([highest; 3], highest)
    }

    /// All monomials in x and y of total degree at most `highest`, within a degree by falling powers
    /// of x.
    #[must_use]
    pub(crate) fn in_plane(highest: u32) -> Self {
        Self::below([highest, highest, 0], highest)
    }

    /// The divisors of one monomial.
    #[must_use]
    pub fn dividing(exponents: Exponents) -> Self {
        Self::below(exponents, degree(exponents))
    }

    fn below(limits: Exponents, highest: u32) -> Self {
        let exponents = exponents_below(limits, highest);
        let places: HashMap<Exponents, usize> = exponents.iter().copied().zip(0..).collect();
        let divided = exponents
            .iter()
            .map(|&monomial| {
                [0, 1, 2].map_each(|axis| {
                    let mut lower = monomial;
                    lower[axis] = lower[axis].wrapping_sub(1);
                    places.get(&lower).copied().unwrap_or(exponents.len())
                })
            })
            .collect();
        Self { exponents, divided }
    }

    /// The monomials in the order of the table.
    #[must_use]
    pub fn exponents(&self) -> &[Exponents] {
        &self.exponents
    }

    /// The place of a monomial in the table.
    #[must_use]
    pub fn place(&self, exponents: Exponents) -> Option<usize> {
        self.exponents.iter().position(|&other| other == exponents)
    }

    /// Fills `table` with the coefficients c of the simplex with these corners, for one simplex
    /// (`f64`) or several at a time (SIMD lanes).
    ///
    /// The table grows to one entry more than there are monomials: the last, 0, stands for
    /// quotients that do not exist.
    pub fn coefficients<T>(&self, corners: &[[T; 3]], table: &mut Vec<T>)
    where
        T: Copy + From<f64> + Add<Output = T> + Mul<Output = T>,
    {
        let count = self.exponents.len();
        table.clear();
        table.resize(count + 1, T::from(0.0));
        table[0] = T::from(1.0);
        for [x, y, z] in corners {
            for (entry, [by_x, by_y, by_z]) in self.divided.iter().enumerate().skip(1) {
                let step = *x * table[*by_x] + *y * table[*by_y] + *z * table[*by_z];
                table[entry] = table[entry] + step;
            }
        }
    }
}

/// The exponents up to `limits` and of degree at most `highest`, by ascending degree.
fn exponents_below(limits: Exponents, highest: u32) -> Vec<Exponents> {
    let mut exponents = Vec::new();
    for total in 0..=highest {
        for x in (0..=limits[0].min(total)).rev() {
            for y in (0..=limits[1].min(total - x)).rev() {
                let z = total - x - y;
                if z <= limits[2] {
                    exponents.push([x, y, z]);
                }
            }
        }
    }
    exponents
}

/// ∫ x^α y^β z^γ over a simplex of known d-dimensional `volume`, d one less than the corners.
#[must_use]
pub fn over_simplex<const K: usize>(
    volume: f64,
    corners: [Vector3<f64>; K],
    exponents: Exponents,
) -> f64 {
    let mut table = Vec::new();
    let monomials = Monomials::dividing(exponents);
    monomials.coefficients(&corners.map(Into::into), &mut table);
    let dimension = u32::try_from(corners.len().saturating_sub(1)).unwrap_or(u32::MAX);
    volume * weight(dimension, exponents) * table[monomials.exponents().len() - 1]
}
