//! Numbers of a Gmsh file, from text or from binary data of either byte order.

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::words::Words;

/// How a binary file writes its numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GmshBinary {
    pub(crate) big_endian: bool,
    /// Counts and, in version 4.1, the numbers of nodes and elements.
    pub(crate) size: Scalar,
}

/// A cursor over the numbers; section names and the lines of some headers are text in either kind.
#[derive(Clone, Debug)]
pub(crate) struct GmshInput<'a> {
    pub(crate) words: Words<'a>,
    /// `None` for a text file.
    pub(crate) binary: Option<GmshBinary>,
}

impl GmshInput<'_> {
    /// A number that text writes as such and a binary file in the type that `of` chooses.
    fn binary_number(
        &mut self,
        of: impl Fn(GmshBinary) -> Scalar,
        expected: &'static str,
    ) -> Option<Result<f64, ParseError>> {
        let binary = self.binary?;
        let kind = of(binary);
        let truncated = self.error(ErrorKind::Truncated { expected });
        let bytes = self.words.take(kind.width()).ok_or(truncated);
        Some(bytes.map(|bytes| kind.decode(bytes, binary.big_endian)))
    }

    /// A 32-bit integer.
    pub(crate) fn integer(&mut self, expected: &'static str) -> Result<i64, ParseError> {
        match self.binary_number(|_| Scalar::Int32, expected) {
            Some(number) => Ok(number? as i64),
            None => self.words.integer(expected),
        }
    }

    /// A non-negative 32-bit integer.
    pub(crate) fn count(&mut self, expected: &'static str) -> Result<usize, ParseError> {
        match self.binary_number(|_| Scalar::Int32, expected) {
            Some(number) => self.whole(number?, expected),
            None => self.words.count(expected),
        }
    }

    /// A count of the width that the file's header says.
    pub(crate) fn size(&mut self, expected: &'static str) -> Result<usize, ParseError> {
        match self.binary_number(|binary| binary.size, expected) {
            Some(number) => self.whole(number?, expected),
            None => self.words.count(expected),
        }
    }

    /// The number of a corner: on the element's line in text; `is_wide` where a binary file writes a
    /// size.
    pub(crate) fn corner(&mut self, is_wide: bool) -> Result<usize, ParseError> {
        let expected = "a node's number";
        match (self.binary, is_wide) {
            (None, _) => self.words.count_on_line(expected),
            (Some(_), true) => self.size(expected),
            (Some(_), false) => self.count(expected),
        }
    }

    /// Three coordinates and, in a binary file, so many parameters behind them; in text what else is
    /// on the line.
    pub(crate) fn point(&mut self, parameters: usize) -> Result<nalgebra::Point3<f64>, ParseError> {
        if self.binary.is_none() {
            let point = self.words.point_on_line()?;
            self.words.next_line();
            return Ok(point);
        }
        let mut point = nalgebra::Point3::origin();
        for axis in 0..3 {
            point[axis] = self.finite()?;
        }
        for _ in 0..parameters {
            self.value()?;
        }
        Ok(point)
    }

    fn finite(&mut self) -> Result<f64, ParseError> {
        let number = self.value()?;
        if number.is_finite() {
            return Ok(number);
        }
        let found = number.to_string();
        Err(self.error(ErrorKind::NotFinite { found }))
    }

    /// A floating-point number, in text on this line, that need not be finite.
    pub(crate) fn value(&mut self) -> Result<f64, ParseError> {
        match self.binary_number(|_| Scalar::Float64, "a value") {
            Some(number) => number,
            None => self.words.value_on_line(),
        }
    }

    /// Moves to where binary data begin: behind the end of the line.
    pub(crate) fn start_data(&mut self) {
        if self.binary.is_some() {
            self.words.next_line();
        }
    }

    /// Passes over what else is on the line of a text file.
    pub(crate) fn end_line(&mut self) {
        if self.binary.is_none() {
            self.words.next_line();
        }
    }

    /// `kind` on the cursor's line, or at its byte.
    pub(crate) fn error(&self, kind: ErrorKind) -> ParseError {
        match self.binary {
            Some(_) => ParseError::at_byte(self.words.position(), kind),
            None => self.words.error(kind),
        }
    }

    fn whole(&self, number: f64, expected: &'static str) -> Result<usize, ParseError> {
        if number >= 0.0 {
            return Ok(number as usize);
        }
        Err(self.error(ErrorKind::expected(expected, number.to_string())))
    }
}
