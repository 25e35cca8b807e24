//! Polynomials as they are written, not multiplied out.
//!
//! (x − 10⁶)⁸ multiplied out has terms of 10⁴⁸ that cancel to 1 beside x = 10⁶: no digit is left. So a
//! formula keeps its operations and is expanded about a place near the body only: x becomes x' + x₀
//! first, x₀ − 10⁶ is formed next, and powers are taken of what is left. Coefficients are carried with
//! 106 bits ([`DoubleDouble`]) and rounded once.
//!
//! Promised: about a place x₀ every coefficient is right to an ulp and 2⁻¹⁰⁰ times what the operations,
//! in the order written, cancel. A product of differences of a coordinate and a number, be it of degree
//! 8 a million units from the origin, cancels nothing more and so keeps all digits; a text that is
//! already multiplied out has about 30 digits to lose. Numbers are read as the nearest `f64`.

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::integrals::double_double::DoubleDouble;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::Exponents;

/// A polynomial in x, y and z as operations on a stack.
///
/// Reads from text such as `1 + (x - 1e6)^8` by [`str::parse`].
///
/// # Examples
/// ```
/// use chebloyd::integrals::formula::Formula;
///
/// let formula: Formula = "(x - 1000000)^8".parse().expect("a polynomial");
/// let near = formula.about(&[1000000.5, 0.0, 0.0].into());
/// assert_eq!(near.at(&[0.5, 0.0, 0.0].into()), 1.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    steps: Vec<Step>,
}

/// An operation on the stack of operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Step {
    /// Puts a number on the stack.
    Number(f64),
    /// Puts a coordinate on the stack: 0, 1, 2 for x, y, z.
    Coordinate(usize),
    /// Replaces the two uppermost operands by their sum.
    Add,
    /// Replaces the two uppermost operands by their product.
    Multiply,
    /// Divides the uppermost operand by a number.
    DivideBy(f64),
    /// Multiplies the uppermost operand by itself so many times, 0 for one.
    Power(u32),
    /// Changes the sign of the uppermost operand.
    Negate,
}

impl Formula {
    /// The formula of these steps, which leave one operand.
    pub(crate) fn of_steps(steps: Vec<Step>) -> Self {
        Self { steps }
    }

    /// The polynomial in y − `origin` with the values of the formula at y.
    #[must_use]
    pub fn about(&self, origin: &Point3<f64>) -> Polynomial {
        let mut stack: Vec<Terms> = Vec::new();
        for step in &self.steps {
            match *step {
                Step::Number(value) => stack.push(Terms::constant(value.into())),
                Step::Coordinate(axis) => stack.push(Terms::coordinate(axis, origin[axis])),
                Step::Add | Step::Multiply => {
                    let upper = stack.pop().unwrap_or_default();
                    let lower = stack.pop().unwrap_or_default();
                    let is_sum = *step == Step::Add;
                    stack.push(if is_sum {
                        lower.plus(upper)
                    } else {
                        lower.times(&upper)
                    });
                }
                Step::DivideBy(number) => change(&mut stack, |value| value / number),
                Step::Negate => change(&mut stack, |value| -value),
                Step::Power(exponent) => {
                    let base = stack.pop().unwrap_or_default();
                    stack.push(base.power(exponent));
                }
            }
        }
        let terms = stack.pop().unwrap_or_default().0.into_iter();
        Polynomial::from_sorted(terms.map(|(exponents, value)| (exponents, value.rounded())))
    }

    /// The value at a point.
    #[must_use]
    pub fn at(&self, point: &Point3<f64>) -> f64 {
        self.about(point).at(&Point3::origin())
    }

    /// The highest total degree of a term that the operations may leave.
    #[must_use]
    pub fn degree(&self) -> u32 {
        self.about(&Point3::origin()).degree()
    }
}

impl From<Polynomial> for Formula {
    /// The sum of the terms: with coefficients about the origin only terms that cancel by no more than
    /// fifteen digits in the body keep twelve.
    fn from(polynomial: Polynomial) -> Self {
        Self::from(&polynomial)
    }
}

impl From<&Polynomial> for Formula {
    fn from(polynomial: &Polynomial) -> Self {
        let mut steps = vec![Step::Number(0.0)];
        for (exponents, value) in polynomial.terms() {
            steps.push(Step::Number(value));
            for (axis, exponent) in exponents.into_iter().enumerate() {
                if exponent > 0 {
                    steps.push(Step::Coordinate(axis));
                    steps.extend([Step::Power(exponent), Step::Multiply]);
                }
            }
            steps.push(Step::Add);
        }
        Self { steps }
    }
}

/// Changes all coefficients of the uppermost operand.
fn change(stack: &mut [Terms], new: impl Fn(DoubleDouble) -> DoubleDouble) {
    let coefficients = stack.last_mut().map(|terms| terms.0.values_mut());
    for value in coefficients.into_iter().flatten() {
        *value = new(*value);
    }
}

/// Coefficients by exponents.
#[derive(Clone, Debug, Default)]
struct Terms(BTreeMap<Exponents, DoubleDouble>);

impl Terms {
    fn constant(value: DoubleDouble) -> Self {
        Self(BTreeMap::from([([0; 3], value)]))
    }

    /// The coordinate measured from `origin` on, plus that.
    fn coordinate(axis: usize, origin: f64) -> Self {
        let mut terms = Self::constant(origin.into());
        let mut exponents = [0; 3];
        exponents[axis] = 1;
        terms.0.insert(exponents, 1.0.into());
        terms
    }

    fn plus(mut self, other: Self) -> Self {
        for (exponents, value) in other.0 {
            let sum = self.0.entry(exponents).or_default();
            *sum = *sum + value;
        }
        self
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for (a, left) in &self.0 {
            for (b, right) in &other.0 {
                let exponents = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
                let sum = product.0.entry(exponents).or_default();
                *sum = *sum + *left * *right;
            }
        }
        product
    }

    fn power(&self, exponent: u32) -> Self {
        (0..exponent).fold(Self::constant(1.0.into()), |power, _| power.times(self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// a/b for comparison in whole numbers.
    fn value(text: &str, place: [f64; 3]) -> f64 {
        let formula: Formula = text.parse().expect(text);
        formula.at(&place.into())
    }

    #[test]
    fn differences_keep_all_digits_a_million_units_away() {
        for offset in [1e2_f64, 1e3, 1e6] {
            let middle = Point3::new(offset + 0.5, offset + 0.5, offset + 0.5);
            let text = format!("(x - {offset})^8*3 + (x - {offset})^4*(y - {offset})^3*(z-{offset}) + 1");
            let formula: Formula = text.parse().expect("a polynomial");
            let near = formula.about(&middle);
            // On sixteenths all is exact in f64.
            for [x, y, z] in [[1.0, 3.0, 16.0], [5.0, 8.0, 2.0], [16.0, 16.0, 16.0]] {
                let [x, y, z] = [x, y, z].map(|share: f64| share / 16.0);
                let exact = x.powi(8) * 3.0 + x.powi(4) * y.powi(3) * z + 1.0;
                let here = Point3::new(offset + x, offset + y, offset + z);
                assert!((formula.at(&here) / exact - 1.0).abs() < 1e-15);
                let relative = Point3::from(here - middle);
                assert!((near.at(&relative) / exact - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn thirty_digits_may_cancel_where_a_text_is_multiplied_out() {
        let text = "x^2 - 2000000*x + 1000000000000";
        assert!((value(text, [1e6 + 0.25, 0.0, 0.0]) - 0.0625).abs() < 1e-15);
        let polynomial = Polynomial::from_terms([
            ([2, 0, 0], 1.0),
            ([1, 0, 0], -2e6),
            ([0, 0, 0], 1e12),
        ]);
        let near = Formula::from(polynomial).about(&Point3::new(1e6, 0.0, 0.0));
        assert!((near.at(&Point3::new(0.25, 0.0, 0.0)) - 0.0625).abs() < 1e-15);
        assert!((value("x/3 - 333333", [1e6, 0.0, 0.0]) - 1.0 / 3.0).abs() < 1e-16);
    }
}
