//! Parsing of formulas written as text: `exp(-distance^2/0.0008)`, `1 + 0.5*sin(20*hypot(x, z))`.
//!
//! ```text
//! sum     = product { (+ | −) product }
//! product = signed { (* | /) signed }
//! signed  = [+ | −] signed | power
//! power   = atom [ ^ signed ]
//! atom    = number | x | y | z | r | distance | pi | e | function ( sum {, sum} ) | ( sum )
//! ```
//!
//! `r` is the distance from the coordinates' origin, `distance` that to the solid's surface.
//! `clamp(low, high, a)` is `min(high, max(low, a))`; `min` and `max` take two operands or more.
//! Columns in messages count characters from one.

use std::f64::consts::{E, PI};
use std::str::FromStr;

use crate::integrals::expression::{BINARY, DEEPEST, Expression, ExpressionStep, UNARY};

/// Why a text is no formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ExpressionError {
    /// Something else is expected there.
    #[error("column {column}: expected {expected}, found {found}")]
    Unexpected {
        /// One-based column.
        column: usize,
        /// What would have been right.
        expected: &'static str,
        /// What is there instead.
        found: String,
    },
    /// A number that f64 cannot hold.
    #[error("column {column}: `{text}` is not a finite number")]
    Number {
        /// One-based column.
        column: usize,
        /// The text.
        text: String,
    },
    /// A function with too few or too many operands.
    #[error("column {column}: `{name}` takes {wanted}, not {given}")]
    Operands {
        /// One-based column.
        column: usize,
        /// The function.
        name: String,
        /// What it takes.
        wanted: &'static str,
        /// How many there are.
        given: usize,
    },
    /// Parentheses nested too deep.
    #[error("column {column}: the formula nests deeper than {DEEPEST} operands")]
    Depth {
        /// One-based column.
        column: usize,
    },
}

impl ExpressionError {
    /// In a text with so many characters before the formula.
    pub(crate) fn shifted(mut self, before: usize) -> Self {
        match &mut self {
            Self::Unexpected { column, .. }
            | Self::Number { column, .. }
            | Self::Operands { column, .. }
            | Self::Depth { column } => *column += before,
        }
        self
    }
}

/// What begins an operand, for messages.
const OPERAND: &str = "a number, `(`, one of `x`, `y`, `z`, `r`, `distance`, `pi`, `e`, or one of the \
     functions sin, cos, tan, asin, acos, atan, atan2, sinh, cosh, tanh, exp, log, log10, sqrt, cbrt, \
     abs, sign, floor, ceil, step, min, max, clamp, pow, hypot, mod";

impl FromStr for Expression {
    type Err = ExpressionError;

    fn from_str(text: &str) -> Result<Self, ExpressionError> {
        let mut reader = ExpressionReader {
            text,
            rest: text,
            open: 0,
            operands: 0,
            steps: Vec::new(),
        };
        reader.sum()?;
        if reader.next().is_some() {
            return Err(reader.unexpected("an operator or the end"));
        }
        Ok(Self::of_steps(reader.steps))
    }
}

/// Every rule appends its steps, which leave one operand.
struct ExpressionReader<'a> {
    text: &'a str,
    rest: &'a str,
    /// Rules within rules.
    open: usize,
    /// Operands on the stack.
    operands: usize,
    steps: Vec<ExpressionStep>,
}

impl ExpressionReader<'_> {
    fn sum(&mut self) -> Result<(), ExpressionError> {
        self.chain(["+", "-"], Self::product)
    }

    fn product(&mut self) -> Result<(), ExpressionError> {
        self.chain(["*", "/"], Self::signed)
    }

    /// Operands of one rule between two operators of one rank.
    fn chain(
        &mut self,
        operators: [&str; 2],
        operand: fn(&mut Self) -> Result<(), ExpressionError>,
    ) -> Result<(), ExpressionError> {
        operand(self)?;
        while let Some(operator) = operators.into_iter().find(|it| self.takes(it)) {
            operand(self)?;
            self.binary(operator);
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), ExpressionError> {
        self.deeper()?;
        if self.takes("-") {
            self.signed()?;
            self.steps.push(ExpressionStep::Unary(0));
        } else if self.takes("+") {
            self.signed()?;
        } else {
            self.power()?;
        }
        self.open -= 1;
        Ok(())
    }

    fn power(&mut self) -> Result<(), ExpressionError> {
        self.atom()?;
        if self.takes("^") {
            self.signed()?;
            self.binary("pow");
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), ExpressionError> {
        match self.next() {
            Some('0'..='9' | '.') => self.number(),
            Some('(') => {
                self.takes("(");
                self.sum()?;
                self.expect(")", "an operator or `)`")
            }
            Some(letter) if letter.is_alphabetic() => self.name(),
            _ => Err(self.unexpected(OPERAND)),
        }
    }

    fn number(&mut self) -> Result<(), ExpressionError> {
        let column = self.column();
        let text = &self.rest[..number_length(self.rest)];
        let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
        let value = value.ok_or_else(|| ExpressionError::Number {
            column,
            text: text.into(),
        })?;
        self.rest = &self.rest[text.len()..];
        self.push(ExpressionStep::Number(value))
    }

    fn name(&mut self) -> Result<(), ExpressionError> {
        let column = self.column();
        let is_part = |c: char| c.is_alphanumeric() || c == '_';
        let length = self.rest.find(|c| !is_part(c)).unwrap_or(self.rest.len());
        let name = &self.rest[..length];
        let variable = match name.to_ascii_lowercase().as_str() {
            "x" => ExpressionStep::Coordinate(0),
            "y" => ExpressionStep::Coordinate(1),
            "z" => ExpressionStep::Coordinate(2),
            "r" => ExpressionStep::Radius,
            "distance" => ExpressionStep::Distance,
            "pi" => ExpressionStep::Number(PI),
            "e" => ExpressionStep::Number(E),
            function => return self.function(function, length, column),
        };
        self.rest = &self.rest[length..];
        self.push(variable)
    }

    fn function(
        &mut self,
        name: &str,
        length: usize,
        column: usize,
    ) -> Result<(), ExpressionError> {
        let one = (1..UNARY.len()).find(|&place| UNARY[place].0 == name);
        let two = (4..BINARY.len()).find(|&place| BINARY[place].0 == name);
        if one.is_none() && two.is_none() && name != "clamp" {
            let found = format!("`{name}`");
            return Err(ExpressionError::Unexpected {
                column,
                expected: OPERAND,
                found,
            });
        }
        self.rest = &self.rest[length..];
        self.expect("(", "`(` after a function's name")?;
        let mut given = 1;
        self.sum()?;
        while self.takes(",") {
            self.sum()?;
            given += 1;
            if matches!(name, "min" | "max") {
                self.binary(name);
            }
        }
        self.expect(")", "`,`, an operator or `)`")?;
        let refused = |wanted| ExpressionError::Operands {
            column,
            name: name.into(),
            wanted,
            given,
        };
        self.apply(name, one, given).map_err(refused)
    }

    /// The function of the uppermost `given` operands, or how many it takes.
    fn apply(
        &mut self,
        name: &str,
        unary: Option<usize>,
        given: usize,
    ) -> Result<(), &'static str> {
        match (name, unary) {
            ("min" | "max", _) if given >= 2 => {}
            ("min" | "max", _) => return Err("two operands or more"),
            ("clamp", _) if given == 3 => {
                // Of low, high and a on the stack: max(low, min(high, a)).
                self.binary("min");
                self.binary("max");
            }
            ("clamp", _) => return Err("three operands, low, high and what is clamped"),
            (_, Some(place)) if given == 1 => self.steps.push(ExpressionStep::Unary(place)),
            (_, Some(_)) => return Err("one operand"),
            (_, None) if given == 2 => self.binary(name),
            (_, None) => return Err("two operands"),
        }
        Ok(())
    }

    /// The operator or function of two operands of this name.
    fn binary(&mut self, name: &str) {
        let place = BINARY.iter().position(|(known, _)| *known == name);
        self.steps.extend(place.map(ExpressionStep::Binary));
        self.operands -= 1;
    }

    /// Puts an operand on the stack.
    fn push(&mut self, step: ExpressionStep) -> Result<(), ExpressionError> {
        self.operands += 1;
        if self.operands > DEEPEST {
            let column = self.column();
            return Err(ExpressionError::Depth { column });
        }
        self.steps.push(step);
        Ok(())
    }

    fn deeper(&mut self) -> Result<(), ExpressionError> {
        self.open += 1;
        if self.open > DEEPEST {
            let column = self.column();
            return Err(ExpressionError::Depth { column });
        }
        Ok(())
    }

    /// The next character that is not a blank, left where it is.
    fn next(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    /// Whether `sign` is next; then it is read. `**` is read as `^`, never as two `*`.
    fn takes(&mut self, sign: &str) -> bool {
        self.next();
        let is_power = self.rest.starts_with("**");
        let rest = match sign {
            "^" if is_power => self.rest.strip_prefix("**"),
            "*" if is_power => None,
            _ => self.rest.strip_prefix(sign),
        };
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn expect(&mut self, sign: &str, expected: &'static str) -> Result<(), ExpressionError> {
        if self.takes(sign) {
            return Ok(());
        }
        Err(self.unexpected(expected))
    }

    /// The column of the next character that is not a blank.
    fn column(&mut self) -> usize {
        self.next();
        let read = &self.text[..self.text.len() - self.rest.len()];
        read.chars().count() + 1
    }

    fn unexpected(&mut self, expected: &'static str) -> ExpressionError {
        ExpressionError::Unexpected {
            column: self.column(),
            expected,
            found: match self.next() {
                Some(found) => format!("`{found}`"),
                None => "the end".into(),
            },
        }
    }
}

/// How long the number at a text's beginning is: digits, a point, an exponent such as `e-3`.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| {
        let rest = &text[from..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        from + end.unwrap_or(rest.len())
    };
    let mantissa = digits(0);
    let Some(exponent) = text[mantissa..].strip_prefix(['e', 'E']) else {
        return mantissa;
    };
    let signed = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    if signed.starts_with(|c: char| c.is_ascii_digit()) {
        digits(text.len() - signed.len())
    } else {
        mantissa
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn value(text: &str) -> f64 {
        let expression: Expression = text.parse().expect(text);
        expression.at(&Point3::new(0.5, -2.0, 3.0), 0.25)
    }

    #[test]
    fn formulas_have_the_values_of_their_operations() {
        let (x, y, z, d) = (0.5_f64, -2.0_f64, 3.0_f64, 0.25_f64);
        let r = (x * x + y * y + z * z).sqrt();
        for (text, expected) in [
            ("1 + 2*x - 0.5*y*z", 1.0 + 2.0 * x - 0.5 * y * z),
            ("-x^2", -(x * x)),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("2**3", 8.0),
            ("(-2)^3", -8.0),
            ("6/2/3", 1.0),
            ("6 - 2 - 3", 1.0),
            ("2*-3", -6.0),
            (
                "exp(-distance^2/(2*0.02^2))",
                (-d * d / (2.0 * 0.02 * 0.02)).exp(),
            ),
            ("sin(20*r) + 1", (20.0 * r).sin() + 1.0),
            ("max(x, y, z)", z),
            ("min(x, y, z)", y),
            ("clamp(1, 2, z)", 2.0),
            ("clamp(1, 2, x)", 1.0),
            ("clamp(1, 2, 1.5)", 1.5),
            ("hypot(z, 4)", 5.0),
            ("atan2(1, 0)", std::f64::consts::FRAC_PI_2),
            ("pow(2, 0.5)", 2.0_f64.sqrt()),
            ("mod(y, 3)", 1.0),
            ("ln(e) + cos(pi)", 0.0),
            ("sqrt(abs(y)) + step(x)", 2.0_f64.sqrt() + 1.0),
            ("1e2 + 1.5E-1", 100.15),
        ] {
            assert!(
                (value(text) - expected).abs() < 1e-14,
                "{text}: {}",
                value(text)
            );
        }
    }

    #[test]
    fn what_is_no_formula_is_refused_with_its_column() {
        for (text, part) in [
            ("sin x", "column 5: expected `(` after"),
            ("1 + foo", "column 5: expected a number"),
            ("1 + foo", "found `foo`"),
            ("sin(1, 2)", "column 1: `sin` takes one operand, not 2"),
            ("pow(1)", "`pow` takes two operands, not 1"),
            ("clamp(1, 2)", "three operands"),
            ("min(1)", "two operands or more"),
            (
                "2 x",
                "column 3: expected an operator or the end, found `x`",
            ),
            ("(1", "column 3: expected an operator or `)`, found the end"),
            ("", "column 1: expected a number"),
            ("1e999", "`1e999` is not a finite number"),
        ] {
            let message = text.parse::<Expression>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
        let deep = "(".repeat(100) + "1" + &")".repeat(100);
        assert!(
            deep.parse::<Expression>()
                .unwrap_err()
                .to_string()
                .contains("deeper")
        );
        let long = "1+(".repeat(70) + "1" + &")".repeat(70);
        assert!(long.parse::<Expression>().is_err());
    }
}
