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
use crate::integrals::series::Exponents;

/// A polynomial in x, y and z as operations on a stack, which leave one operand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Formula(Vec<Step>);

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
        Self(steps)
    }

    /// The sum of terms.
    pub(crate) fn of_terms(terms: impl Iterator<Item = (Exponents, f64)>) -> Self {
        let mut steps = vec![Step::Number(0.0)];
        for (exponents, value) in terms {
            steps.push(Step::Number(value));
            for (axis, exponent) in exponents.into_iter().enumerate() {
                if exponent > 0 {
                    steps.push(Step::Coordinate(axis));
                    steps.extend([Step::Power(exponent), Step::Multiply]);
                }
            }
            steps.push(Step::Add);
        }
        Self(steps)
    }

    /// The formula with another as second operand of `step`.
    pub(crate) fn with(mut self, other: Self, step: Step) -> Self {
        self.0.extend(other.0);
        self.followed_by(step)
    }

    /// The formula changed by `step`.
    pub(crate) fn followed_by(mut self, step: Step) -> Self {
        self.0.push(step);
        self
    }

    /// The coefficients of the polynomial in y − `origin` with the values of the formula at y.
    #[must_use]
    pub(crate) fn about(&self, origin: &Point3<f64>) -> BTreeMap<Exponents, f64> {
        let mut stack: Vec<Terms> = Vec::new();
        for step in &self.0 {
            match *step {
                Step::Number(value) => stack.push(Terms::constant(value.into())),
                Step::Coordinate(axis) => stack.push(Terms::coordinate(axis, origin[axis])),
                Step::Add => merge(&mut stack, Terms::plus),
                Step::Multiply => merge(&mut stack, |lower, upper| lower.times(&upper)),
                Step::DivideBy(number) => change(&mut stack, |value| value / number),
                Step::Negate => change(&mut stack, |value| -value),
                Step::Power(exponent) => {
                    let base = stack.pop().unwrap_or_default();
                    stack.push(base.power(exponent));
                }
            }
        }
        let terms = stack.pop().unwrap_or_default().0.into_iter();
        terms
            .map(|(exponents, value)| (exponents, value.rounded()))
            .collect()
    }
}

/// Replaces the two uppermost operands.
fn merge(stack: &mut Vec<Terms>, of_both: impl FnOnce(Terms, Terms) -> Terms) {
    let upper = stack.pop().unwrap_or_default();
    let lower = stack.pop().unwrap_or_default();
    stack.push(of_both(lower, upper));
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
