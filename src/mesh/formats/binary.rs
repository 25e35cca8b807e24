//! Decoding of numbers in binary files.

use crate::mesh::formats::error::{ErrorKind, ParseError};

/// The number types of PLY and VTK files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scalar {
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Float32,
    Float64,
}

impl Scalar {
    /// The type with this name in PLY (both generations) or, in small letters, VTK's XML.
    pub(crate) fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::Int8,
            b"uchar" | b"uint8" => Self::UInt8,
            b"short" | b"int16" => Self::Int16,
            b"ushort" | b"uint16" => Self::UInt16,
            b"int" | b"int32" => Self::Int32,
            b"uint" | b"uint32" => Self::UInt32,
            b"int64" => Self::Int64,
            b"uint64" => Self::UInt64,
            b"float" | b"float32" => Self::Float32,
            b"double" | b"float64" => Self::Float64,
            _ => return None,
        })
    }

    /// Bytes per number.
    pub(crate) fn width(self) -> usize {
        match self {
            Self::Int8 | Self::UInt8 => 1,
            Self::Int16 | Self::UInt16 => 2,
            Self::Int32 | Self::UInt32 | Self::Float32 => 4,
            Self::Int64 | Self::UInt64 | Self::Float64 => 8,
        }
    }

    /// The number in the first bytes of `bytes`, which must be enough; integers beyond 2⁵³ are
    /// rounded.
    pub(crate) fn decode(self, bytes: &[u8], big_endian: bool) -> f64 {
        match self {
            Self::Int8 => f64::from(take::<1>(bytes, false)[0].cast_signed()),
            Self::UInt8 => f64::from(take::<1>(bytes, false)[0]),
            Self::Int16 => f64::from(i16::from_le_bytes(take(bytes, big_endian))),
            Self::UInt16 => f64::from(u16::from_le_bytes(take(bytes, big_endian))),
            Self::Int32 => f64::from(i32::from_le_bytes(take(bytes, big_endian))),
            Self::UInt32 => f64::from(u32::from_le_bytes(take(bytes, big_endian))),
            Self::Int64 => i64::from_le_bytes(take(bytes, big_endian)) as f64,
            Self::UInt64 => u64::from_le_bytes(take(bytes, big_endian)) as f64,
            Self::Float32 => f64::from(f32::from_le_bytes(take(bytes, big_endian))),
            Self::Float64 => f64::from_le_bytes(take(bytes, big_endian)),
        }
    }
}

/// The first N bytes in little-endian order.
fn take<const N: usize>(bytes: &[u8], big_endian: bool) -> [u8; N] {
    let mut taken = [0; N];
    taken.copy_from_slice(&bytes[..N]);
    if big_endian {
        taken.reverse();
    }
    taken
}

/// A cursor over binary data.
#[derive(Clone, Debug)]
pub(crate) struct Bytes<'a> {
    bytes: &'a [u8],
    position: usize,
    big_endian: bool,
}

impl<'a> Bytes<'a> {
    /// A cursor at `position` of `bytes`.
    pub(crate) fn new(bytes: &'a [u8], position: usize, big_endian: bool) -> Self {
        Self {
            bytes,
            position,
            big_endian,
        }
    }

    /// How many bytes are left.
    pub(crate) fn left(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The next number.
    pub(crate) fn scalar(
        &mut self,
        kind: Scalar,
        expected: &'static str,
    ) -> Result<f64, ParseError> {
        let rest = &self.bytes[self.position..];
        if rest.len() < kind.width() {
            return Err(self.error(ErrorKind::Truncated { expected }));
        }
        self.position += kind.width();
        Ok(kind.decode(rest, self.big_endian))
    }

    /// The next number, which must be finite.
    pub(crate) fn finite(
        &mut self,
        kind: Scalar,
        expected: &'static str,
    ) -> Result<f64, ParseError> {
        let before = self.position;
        let number = self.scalar(kind, expected)?;
        if number.is_finite() {
            return Ok(number);
        }
        let found = number.to_string();
        Err(ParseError::at_byte(before, ErrorKind::NotFinite { found }))
    }

    /// Passes over `count` bytes.
    pub(crate) fn skip(&mut self, count: usize, expected: &'static str) -> Result<(), ParseError> {
        if self.left() < count {
            return Err(self.error(ErrorKind::Truncated { expected }));
        }
        self.position += count;
        Ok(())
    }

    /// `kind` at the cursor.
    pub(crate) fn error(&self, kind: ErrorKind) -> ParseError {
        ParseError::at_byte(self.position, kind)
    }
}
