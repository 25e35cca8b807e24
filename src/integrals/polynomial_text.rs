//! Parsing of polynomials written as text: `1 + 2*x - 0.5*y*z`, `x^2*(1 - z)/4`.
//!
//! ```text
//! sum     = [+ | −] product { (+ | −) product }
//! product = factor { (* factor) | (/ [+ | −] number) }
//! factor  = { + | − } power
//! power   = atom [ ^ whole number ]
//! atom    = number | x | y | z | ( sum )
//! ```
//!
//! Columns in messages count characters from one.

use crate::integrals::formula::{Formula, Step};
use crate::integrals::polynomial::Polynomial;
use std::str::FromStr;

/// Densities of higher degree than this are refused: their moments would need factorials beyond
/// what f64 holds exactly.
pub const HIGHEST_DEGREE: u32 = 16;

/// Parentheses may nest this deep.
const DEEPEST: usize = 32;

/// Why a text is not a polynomial.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolynomialError {
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
    /// A number that f64 cannot hold or that is no number.
    #[error("column {column}: `{text}` is not a finite number")]
    Number {
        /// One-based column.
        column: usize,
        /// The text.
        text: String,
    },
    /// Division by zero.
    #[error("column {column}: division by zero")]
    DivisionByZero {
        /// One-based column of the divisor.
        column: usize,
    },
    /// The degree passes [`HIGHEST_DEGREE`].
    #[error("column {column}: degree {degree} is above {HIGHEST_DEGREE}, the highest supported")]
    Degree {
        /// One-based column where it passes.
        column: usize,
        /// The degree.
        degree: u64,
    },
    /// A coefficient too large for f64.
    #[error("a coefficient is too large for a 64-bit float")]
    Overflow,
    /// Parentheses nested too deep.
    #[error("column {column}: parentheses nest deeper than {DEEPEST}")]
    Depth {
        /// One-based column.
        column: usize,
    },
}

impl FromStr for Polynomial {
    type Err = PolynomialError;

    fn from_str(text: &str) -> Result<Self, PolynomialError> {
        let mut reader = Reader {
            text,
            rest: text,
            depth: 0,
            steps: Vec::new(),
        };
        reader.sum()?;
        if reader.next().is_some() {
            return Err(reader.unexpected("an operator or the end"));
        }
        let polynomial = Self::of_formula(Formula::of_steps(reader.steps));
        if polynomial.terms().any(|(_, value)| !value.is_finite()) {
            return Err(PolynomialError::Overflow);
        }
        Ok(polynomial)
    }
}

/// Every rule appends its steps and returns the degree of what they leave.
struct Reader<'a> {
    text: &'a str,
    rest: &'a str,
    depth: usize,
    steps: Vec<Step>,
}

impl<'a> Reader<'a> {
    fn sum(&mut self) -> Result<u32, PolynomialError> {
        let sign = self.taken(&['+', '-']);
        let mut degree = self.signed_product(sign)?;
        while let Some(sign) = self.taken(&['+', '-']) {
            degree = degree.max(self.signed_product(Some(sign))?);
            self.steps.push(Step::Add);
        }
        Ok(degree)
    }

    fn signed_product(&mut self, sign: Option<char>) -> Result<u32, PolynomialError> {
        let degree = self.product()?;
        if sign == Some('-') {
            self.steps.push(Step::Negate);
        }
        Ok(degree)
    }

    fn product(&mut self) -> Result<u32, PolynomialError> {
        let mut degree = self.factor()?;
        while let Some(operator) = self.taken(&['*', '/']) {
            let column = self.column();
            if operator == '*' {
                degree += self.factor()?;
                self.steps.push(Step::Multiply);
            } else {
                let divisor = self.divisor()?;
                self.steps.push(Step::DivideBy(divisor));
            }
            check_degree(column, u64::from(degree))?;
        }
        Ok(degree)
    }

    /// A power behind any number of signs.
    fn factor(&mut self) -> Result<u32, PolynomialError> {
        let mut is_negative = false;
        while let Some(sign) = self.taken(&['+', '-']) {
            is_negative ^= sign == '-';
        }
        let degree = self.power()?;
        if is_negative {
            self.steps.push(Step::Negate);
        }
        Ok(degree)
    }

    fn divisor(&mut self) -> Result<f64, PolynomialError> {
        let column = self.column();
        let sign = self.taken(&['+', '-']);
        let divisor = self.number()?;
        if divisor.abs() > 0.0 {
            Ok(if sign == Some('-') { -divisor } else { divisor })
        } else {
            Err(PolynomialError::DivisionByZero { column })
        }
    }

    fn power(&mut self) -> Result<u32, PolynomialError> {
        let base = self.atom()?;
        if self.taken(&['^']).is_none() {
            return Ok(base);
        }
        let column = self.column();
        let digits = self.taken_while(|character| character.is_ascii_digit());
        if digits.is_empty() {
            return Err(self.unexpected("a whole number after `^`"));
        }
        let exponent = digits.parse::<u32>().unwrap_or(u32::MAX);
        check_degree(column, u64::from(base.max(1)) * u64::from(exponent))?;
        self.steps.push(Step::Power(exponent));
        Ok(base * exponent)
    }

    fn atom(&mut self) -> Result<u32, PolynomialError> {
        match self.next() {
            Some('x' | 'X') => Ok(self.variable(0)),
            Some('y' | 'Y') => Ok(self.variable(1)),
            Some('z' | 'Z') => Ok(self.variable(2)),
            Some('(') => self.parenthesis(),
            Some('0'..='9' | '.') => {
                let number = self.number()?;
                self.steps.push(Step::Number(number));
                Ok(0)
            }
            Some(first) if first.is_alphabetic() => Err(self.unknown_name()),
            _ => Err(self.unexpected("a number, `x`, `y`, `z` or `(`")),
        }
    }

    fn unknown_name(&mut self) -> PolynomialError {
        let column = self.column();
        let name = self.taken_while(|c| c.is_alphanumeric() || c == '_');
        PolynomialError::Unexpected {
            column,
            expected: "a number, `x`, `y`, `z` or `(` (a polynomial has no functions)",
            found: format!("`{name}`, which is not known"),
        }
    }

    fn variable(&mut self, axis: usize) -> u32 {
        self.rest = &self.rest[1..];
        self.steps.push(Step::Coordinate(axis));
        1
    }

    fn parenthesis(&mut self) -> Result<u32, PolynomialError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            let column = self.column();
            return Err(PolynomialError::Depth { column });
        }
        self.rest = &self.rest[1..];
        let degree = self.sum()?;
        if self.taken(&[')']).is_none() {
            return Err(self.unexpected("an operator or `)`"));
        }
        self.depth -= 1;
        Ok(degree)
    }

    /// Digits, a point, an exponent such as `e-3`.
    fn number(&mut self) -> Result<f64, PolynomialError> {
        let column = self.column();
        let start = self.rest;
        let is_digit = |character: char| character.is_ascii_digit();
        if self.taken_while(|c| is_digit(c) || c == '.').is_empty() {
            return Err(self.unexpected("a number"));
        }
        if let Some(exponent) = self.rest.strip_prefix(['e', 'E']) {
            self.rest = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
            self.taken_while(is_digit);
        }
        let text = &start[..start.len() - self.rest.len()];
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(PolynomialError::Number {
                column,
                text: text.into(),
            }),
        }
    }

    /// The next character that is not a blank, left where it is.
    fn next(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    fn taken(&mut self, wanted: &[char]) -> Option<char> {
        let character = self.next().filter(|character| wanted.contains(character))?;
        self.rest = &self.rest[character.len_utf8()..];
        Some(character)
    }

    fn taken_while(&mut self, is_wanted: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest;
        self.rest = rest.trim_start_matches(is_wanted);
        &rest[..rest.len() - self.rest.len()]
    }

    /// The column of the next character that is not a blank.
    fn column(&mut self) -> usize {
        self.next();
        let read = &self.text[..self.text.len() - self.rest.len()];
        read.chars().count() + 1
    }

    fn unexpected(&mut self, expected: &'static str) -> PolynomialError {
        PolynomialError::Unexpected {
            column: self.column(),
            expected,
            found: match self.next() {
                Some(found) => format!("`{found}`"),
                None => "the end".into(),
            },
        }
    }
}

fn check_degree(column: usize, degree: u64) -> Result<(), PolynomialError> {
    if degree > u64::from(HIGHEST_DEGREE) {
        Err(PolynomialError::Degree { column, degree })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn signs_follow_operators() {
        let at = |text: &str| {
            let polynomial: Polynomial = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
            polynomial.at(&Point3::new(2.0, 3.0, 5.0))
        };
        for (text, value) in [
            ("5+-0.1*x", 4.8),
            ("5--0.1*x", 5.2),
            ("2*-x^2", -8.0),
            ("-x*-y", 6.0),
            ("x/-4", -0.5),
            ("+-+z", -5.0),
            ("1 - -(x + -y)", 0.0),
        ] {
            assert!((at(text) - value).abs() < 1e-15, "{text}: {}", at(text));
        }
        assert!("5+-".parse::<Polynomial>().is_err() && "x*/2".parse::<Polynomial>().is_err());
    }

    #[test]
    fn names_that_are_no_coordinates_are_told() {
        for (text, name, column) in [
            ("1 + exp(-x)", "exp", 5),
            ("2*r", "r", 3),
            ("sin(x)", "sin", 1),
        ] {
            let message = text.parse::<Polynomial>().unwrap_err().to_string();
            assert!(
                message.starts_with(&format!("column {column}: expected")),
                "{message}"
            );
            assert!(
                message.contains(&format!("`{name}`, which is not known")),
                "{message}"
            );
        }
    }
}
