//! Formulas of position with the usual functions, and their values.
//!
//! A formula is kept as operations on a stack (reverse Polish): `2*sin(x)` is 2, x, sin, ×. What has no
//! real value is NaN, as in IEEE 754.

use nalgebra::Point3;

/// The stack has room for so many operands; the parser refuses formulas that need more.
pub(crate) const DEEPEST: usize = 64;

/// A formula of x, y, z, of r = |y| and of the distance to a surface.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expression {
    /// They leave one operand and never more than [`DEEPEST`].
    steps: Vec<ExpressionStep>,
    uses_distance: bool,
}

/// An operation on the stack of operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ExpressionStep {
    /// Puts a number on the stack.
    Number(f64),
    /// Puts a coordinate on the stack: 0, 1, 2 for x, y, z.
    Coordinate(usize),
    /// Puts the distance from the coordinates' origin on the stack.
    Radius,
    /// Puts the distance to the surface on the stack.
    Distance,
    /// Replaces the uppermost operand by a function of it: the place in [`UNARY`].
    Unary(usize),
    /// Replaces the two uppermost operands by a function of them: the place in [`BINARY`].
    Binary(usize),
}

/// A function of one number.
type Unary = fn(f64) -> f64;
/// A function of two numbers.
type Binary = fn(f64, f64) -> f64;

/// Functions of one operand by name; the first is the sign's change, which has none.
pub(crate) const UNARY: [(&str, Unary); 21] = [
    ("", |a| -a),
    ("sin", f64::sin),
    ("cos", f64::cos),
    ("tan", f64::tan),
    ("asin", f64::asin),
    ("acos", f64::acos),
    ("atan", f64::atan),
    ("sinh", f64::sinh),
    ("cosh", f64::cosh),
    ("tanh", f64::tanh),
    ("exp", f64::exp),
    ("log", f64::ln),
    ("ln", f64::ln),
    ("log10", f64::log10),
    ("sqrt", f64::sqrt),
    ("cbrt", f64::cbrt),
    ("abs", f64::abs),
    ("sign", |a| if a == 0.0 { 0.0 } else { a.signum() }),
    ("floor", f64::floor),
    ("ceil", f64::ceil),
    ("step", |a| f64::from(u8::from(a >= 0.0))),
];

/// Functions of two operands by name; the first ones are the operators.
pub(crate) const BINARY: [(&str, Binary); 10] = [
    ("+", |a, b| a + b),
    ("-", |a, b| a - b),
    ("*", |a, b| a * b),
    ("/", |a, b| a / b),
    ("pow", power),
    ("min", f64::min),
    ("max", f64::max),
    ("hypot", f64::hypot),
    ("atan2", f64::atan2),
    ("mod", f64::rem_euclid),
];

/// a^b; whole exponents by multiplication, so that a negative base has its power.
fn power(a: f64, b: f64) -> f64 {
    let is_whole = b.abs() <= 64.0 && b.trunc().total_cmp(&b).is_eq();
    if is_whole {
        a.powi(b as i32)
    } else {
        a.powf(b)
    }
}

impl Expression {
    /// The formula of these steps, which leave one operand and never more than [`DEEPEST`].
    pub(crate) fn of_steps(steps: Vec<ExpressionStep>) -> Self {
        let uses_distance = steps.contains(&ExpressionStep::Distance);
        Self {
            steps,
            uses_distance,
        }
    }

    /// Whether it depends on the distance to a surface.
    pub(crate) fn uses_distance(&self) -> bool {
        self.uses_distance
    }

    /// The value at a point that lies `distance` from the surface.
    pub(crate) fn at(&self, point: &Point3<f64>, distance: f64) -> f64 {
        let mut stack = [f64::NAN; DEEPEST];
        let mut top = 0;
        for step in &self.steps {
            let pushed = match *step {
                ExpressionStep::Number(value) => value,
                ExpressionStep::Coordinate(axis) => point[axis],
                ExpressionStep::Radius => point.coords.norm(),
                ExpressionStep::Distance => distance,
                ExpressionStep::Unary(function) => {
                    stack[top - 1] = UNARY[function].1(stack[top - 1]);
                    continue;
                }
                ExpressionStep::Binary(function) => {
                    top -= 1;
                    stack[top - 1] = BINARY[function].1(stack[top - 1], stack[top]);
                    continue;
                }
            };
            stack[top] = pushed;
            top += 1;
        }
        stack[0]
    }
}
