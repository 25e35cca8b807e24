//! Numbers as bytes that deflate well and travel in a page: planes of bytes, differences, base64.

use std::io::Write;

use flate2::Compression;
use flate2::write::DeflateEncoder;

/// The bits of a coordinate: as many as an `f32` has in its mantissa.
pub(crate) const COORDINATE_BITS: u32 = 24;

/// Bytes of a coordinate.
const COORDINATE_BYTES: usize = 3;

/// Bytes of a whole number or an `f32`.
const NUMBER_BYTES: usize = 4;

/// Arrays of numbers, one after the other; whoever reads them knows how many there are of each.
#[derive(Debug, Default)]
pub(crate) struct NumberPacker {
    bytes: Vec<u8>,
}

impl NumberPacker {
    /// Adds whole numbers: the lowest byte of all, then the next one of all, four in turn.
    pub(crate) fn push(&mut self, numbers: &[u32]) {
        self.push_planes(numbers, NUMBER_BYTES);
    }

    /// Adds real numbers, rounded to `f32`.
    pub(crate) fn push_reals(&mut self, numbers: &[f64]) {
        let bits = numbers.iter().map(|&number| (number as f32).to_bits());
        self.push(&bits.collect::<Vec<_>>());
    }

    /// Adds flags, a byte for each.
    pub(crate) fn push_flags(&mut self, flags: &[bool]) {
        self.bytes.extend(flags.iter().map(|&flag| u8::from(flag)));
    }

    /// Adds coordinates of [`COORDINATE_BITS`], each as the way from the one before, modulo 2^24: 0, −1, 1,
    /// −2, … as 0, 1, 2, 3, …
    pub(crate) fn push_coordinates(&mut self, numbers: &[u32]) {
        const SPARE: u32 = u32::BITS - COORDINATE_BITS;
        let mut last = 0;
        let ways = numbers.iter().map(|&number| {
            let way = (number.wrapping_sub(last) << SPARE).cast_signed() >> SPARE;
            last = number;
            (way << 1 ^ way >> (u32::BITS - 1)).cast_unsigned()
        });
        self.push_planes(&ways.collect::<Vec<_>>(), COORDINATE_BYTES);
    }

    fn push_planes(&mut self, numbers: &[u32], width: usize) {
        for plane in 0..width {
            let byte = |number: &u32| (number >> (8 * plane)) as u8;
            self.bytes.extend(numbers.iter().map(byte));
        }
    }

    /// All arrays, deflated (RFC 1951) and in base64 (RFC 4648).
    #[must_use]
    pub(crate) fn finish(&self) -> String {
        base64(&deflated(&self.bytes))
    }

    /// How many bytes there are before they are deflated.
    #[must_use]
    pub(crate) fn len(&self) -> usize {
        self.bytes.len()
    }
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    // A vector takes all that is written.
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.unwrap_or_default()
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for digit in 0..4 {
            let value = bits >> (18 - 6 * digit) & 63;
            let is_there = digit <= group.len();
            text.push(char::from(if is_there {
                DIGITS[value as usize]
            } else {
                b'='
            }));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        let words = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let expected = [
            "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy",
        ];
        for (word, expected) in words.iter().zip(expected) {
            assert_eq!(base64(word.as_bytes()), expected);
        }
    }

    #[test]
    fn coordinates_are_ways_from_the_one_before() {
        let mut packer = NumberPacker::default();
        packer.push_coordinates(&[5, 4, 4, (1 << 24) - 1, 0]);
        // 5, −1, 0, −5 (modulo 2^24), 1.
        assert_eq!(packer.bytes[..5], [10, 1, 0, 9, 2]);
        assert_eq!(packer.bytes[5..], [0; 10]);
        let mut planes = NumberPacker::default();
        planes.push(&[0x0403_0201, 0x0807_0605]);
        assert_eq!(planes.bytes, [1, 5, 2, 6, 3, 7, 4, 8]);
    }
}
