//! Numbers of a legacy VTK file, from text or from binary data, which are big-endian.

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::words::{Words, shown};

/// A cursor over the numbers; keywords and the lines that announce arrays are text in either kind.
#[derive(Clone, Debug)]
pub(crate) struct VtkInput<'a> {
    pub(crate) words: Words<'a>,
    pub(crate) is_binary: bool,
}

impl VtkInput<'_> {
    /// The type of binary numbers by its name; of a text file any.
    pub(crate) fn kind(&self, name: &[u8]) -> Result<Scalar, ParseError> {
        let name = name.to_ascii_lowercase();
        let kind = match name.as_slice() {
            b"unsigned_char" => Scalar::UInt8,
            b"char" | b"signed_char" => Scalar::Int8,
            b"unsigned_short" => Scalar::UInt16,
            b"short" => Scalar::Int16,
            b"unsigned_int" | b"vtktypeuint32" => Scalar::UInt32,
            // Numbers of points and cells are written as 32-bit integers.
            b"int" | b"vtkidtype" | b"vtktypeint32" => Scalar::Int32,
            b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => Scalar::UInt64,
            b"long" | b"long_long" | b"vtktypeint64" => Scalar::Int64,
            b"float" => Scalar::Float32,
            b"double" => Scalar::Float64,
            _ if !self.is_binary => Scalar::Float64,
            _ => {
                let what = format!("binary data of type {}", shown(&name));
                return Err(self.error(ErrorKind::unsupported(what, "export the file as ASCII")));
            }
        };
        Ok(kind)
    }

    /// Moves to where binary data begin: behind the end of the line.
    pub(crate) fn start_data(&mut self) {
        if self.is_binary {
            self.words.next_line();
        }
    }

    /// The next number of a binary file.
    fn binary(&mut self, kind: Scalar, expected: &'static str) -> Result<f64, ParseError> {
        let truncated = self.error(ErrorKind::Truncated { expected });
        let bytes = self.words.take(kind.width()).ok_or(truncated)?;
        Ok(kind.decode(bytes, true))
    }

    /// A number that must be finite.
    pub(crate) fn finite(
        &mut self,
        kind: Scalar,
        expected: &'static str,
    ) -> Result<f64, ParseError> {
        if !self.is_binary {
            return self.words.number(expected);
        }
        let number = self.binary(kind, expected)?;
        if number.is_finite() {
            return Ok(number);
        }
        let found = number.to_string();
        Err(self.error(ErrorKind::NotFinite { found }))
    }

    /// A number that need not be finite.
    pub(crate) fn value(&mut self, kind: Scalar) -> Result<f64, ParseError> {
        match self.is_binary {
            true => self.binary(kind, "a value"),
            false => self.words.value(),
        }
    }

    /// A non-negative integer.
    pub(crate) fn count(
        &mut self,
        kind: Scalar,
        expected: &'static str,
    ) -> Result<usize, ParseError> {
        if !self.is_binary {
            return self.words.count(expected);
        }
        let number = self.binary(kind, expected)?;
        if number >= 0.0 {
            return Ok(number as usize);
        }
        Err(self.error(ErrorKind::expected(expected, number.to_string())))
    }

    /// The zero-based index of a vertex.
    pub(crate) fn vertex(&mut self, kind: Scalar, vertices: usize) -> Result<u32, ParseError> {
        if !self.is_binary {
            return self.words.vertex(vertices, 0);
        }
        let index = self.binary(kind, "a vertex index")? as i64;
        ErrorKind::check_vertex(index, vertices, 0).map_err(|kind| self.error(kind))
    }

    /// Passes over `count` values of the type of this name, at the start of its data.
    pub(crate) fn skip_values(&mut self, name: &[u8], count: usize) -> Result<(), ParseError> {
        if !self.is_binary {
            return self.skip_words(name, count);
        }
        self.start_data();
        if is_text(name) {
            return (0..count).try_for_each(|_| self.skip_string());
        }
        let size = match name.eq_ignore_ascii_case(b"bit") {
            true => count.div_ceil(8),
            false => count.saturating_mul(self.kind(name)?.width()),
        };
        self.skip_bytes(size)
    }

    fn skip_bytes(&mut self, count: usize) -> Result<(), ParseError> {
        let expected = "the rest of an array";
        let truncated = self.error(ErrorKind::Truncated { expected });
        self.words.take(count).map(drop).ok_or(truncated)
    }

    /// A text of a binary file: its length in 1, 2, 4 or 8 bytes, as the first two bits say.
    fn skip_string(&mut self) -> Result<(), ParseError> {
        let first = self.binary(Scalar::UInt8, "a text's length")? as usize;
        let more = [7, 3, 1, 0][first >> 6];
        let mut length = first & 63;
        for _ in 0..more {
            length = length << 8 | self.binary(Scalar::UInt8, "a text's length")? as usize;
        }
        self.skip_bytes(length)
    }

    /// In a text file, texts stand one a line, which may be empty.
    fn skip_words(&mut self, name: &[u8], count: usize) -> Result<(), ParseError> {
        if is_text(name) {
            for _ in 0..=count {
                if !self.words.next_line() {
                    break;
                }
            }
            return Ok(());
        }
        (0..count).try_for_each(|_| self.words.some_word("a value").map(drop))
    }

    /// `kind` on the cursor's line, or at its byte.
    pub(crate) fn error(&self, kind: ErrorKind) -> ParseError {
        match self.is_binary {
            true => ParseError::at_byte(self.words.position(), kind),
            false => self.words.error(kind),
        }
    }
}

/// Whether values of this type are text.
pub(crate) fn is_text(kind: &[u8]) -> bool {
    ["string", "utf8_string", "unicode_string", "variant"]
        .iter()
        .any(|text| kind.eq_ignore_ascii_case(text.as_bytes()))
}
