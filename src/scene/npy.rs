//! Reader of sites from a NumPy array (`.npy`, format versions 1 to 3).
//!
//! Layout (NEP 1, `numpy.lib.format`): `\x93NUMPY`, the version's two bytes, the header's length in
//! little-endian (two bytes in version 1, four later), the header, the numbers. The header is a
//! Python literal such as `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }`.

use std::path::Path;

use nalgebra::Point;

use crate::scene::error::Error;

/// Parses a `.npy` file; `path` is for messages only.
///
/// # Errors
/// [`Error::File`] when it is no array of `D` columns of floats, its length is not the announced
/// one, or it holds a number that is not finite (its row is named).
pub fn parse<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    rows(bytes).map_err(|message| Error::File {
        path: path.to_owned(),
        message,
    })
}

fn rows<const D: usize>(bytes: &[u8]) -> Result<Vec<Point<f64, D>>, String> {
    let (header, data) = split(bytes).ok_or("not a .npy file: it does not begin with a header")?;
    let damaged = || format!("not a .npy file: its header {header:?} is damaged");
    let header = NpyHeader::parse(header).ok_or_else(damaged)?;
    let (values, rest) = header.numbers(data)?;
    let count = header.row_count::<D>()?;
    let expected = count.saturating_mul(D);
    if values.len() < expected {
        return Err(format!("ends after {} of {expected} numbers", values.len()));
    }
    if values.len() > expected || !rest.is_empty() {
        return Err(format!("holds more than its {expected} numbers"));
    }
    let point = |row: usize| {
        let coordinates: [f64; D] = std::array::from_fn(|axis| match header.is_fortran {
            false => values[row * D + axis],
            true => values[axis * count + row],
        });
        match coordinates.iter().all(|value| value.is_finite()) {
            true => Ok(Point::from(coordinates)),
            false => Err(format!(
                "row {row} (counted from 0) is {coordinates:?}; sites need finite coordinates"
            )),
        }
    };
    (0..count).map(point).collect()
}

/// The header's text and the bytes of the numbers.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let (version, rest) = bytes.strip_prefix(b"\x93NUMPY")?.split_at_checked(2)?;
    let width = if version[0] == 1 { 2 } else { 4 };
    let (length, rest) = rest.split_at_checked(width)?;
    let length = length
        .iter()
        .rev()
        .fold(0, |sum, &byte| sum << 8 | usize::from(byte));
    let (header, data) = rest.split_at_checked(length)?;
    Some((std::str::from_utf8(header).ok()?, data))
}

/// What a header says; `descr` as it is written there.
#[derive(Debug, Default)]
struct NpyHeader<'a> {
    descr: &'a str,
    is_fortran: bool,
    shape: Vec<u64>,
}

impl<'a> NpyHeader<'a> {
    /// Reads the dictionary: exactly the three keys, in any order.
    fn parse(text: &'a str) -> Option<Self> {
        let mut rest = text.trim().strip_prefix('{')?.strip_suffix('}')?.trim();
        let mut header = Self::default();
        let mut keys = Vec::new();
        while !rest.is_empty() {
            let quote = rest.chars().next().filter(|first| "'\"".contains(*first))?;
            let (key, after) = rest[1..].split_once(quote)?;
            let after = after.trim_start().strip_prefix(':')?;
            let (value, after) = after.split_at(end_of_value(after));
            match (key, value.trim()) {
                ("descr", descr) => header.descr = descr,
                ("fortran_order", "True") => header.is_fortran = true,
                ("fortran_order", "False") => {}
                ("shape", shape) => header.shape = tuple(shape)?,
                _ => return None,
            }
            keys.push(key);
            rest = after.strip_prefix(',').unwrap_or(after).trim_start();
        }
        keys.sort_unstable();
        (keys == ["descr", "fortran_order", "shape"]).then_some(header)
    }

    /// The numbers in storage order, as many as there are, and the bytes after them.
    fn numbers<'b>(&self, data: &'b [u8]) -> Result<(Vec<f64>, &'b [u8]), String> {
        match self.descr.trim_matches(['\'', '"']) {
            "<f8" => Ok(numbers(data, f64::from_le_bytes)),
            ">f8" => Ok(numbers(data, f64::from_be_bytes)),
            "<f4" => Ok(numbers(data, |bytes| f32::from_le_bytes(bytes).into())),
            ">f4" => Ok(numbers(data, |bytes| f32::from_be_bytes(bytes).into())),
            _ => Err(format!(
                "the array's type is {} where f8 or f4 is expected",
                self.descr
            )),
        }
    }

    fn row_count<const D: usize>(&self) -> Result<usize, String> {
        match self.shape[..] {
            [count, width] if width == D as u64 => {
                usize::try_from(count).map_err(|_| format!("{count} rows are too many"))
            }
            _ => Err(format!(
                "the array's shape is {:?} where [n, {D}] is expected",
                self.shape
            )),
        }
    }
}

/// Where a value of a dictionary ends: at the first comma outside quotes and brackets.
fn end_of_value(text: &str) -> usize {
    let (mut depth, mut quote) = (0_i32, None);
    for (place, sign) in text.char_indices() {
        match (quote, sign) {
            (Some(open), _) if open == sign => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(sign),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => return place,
            (None, _) => {}
        }
    }
    text.len()
}

/// Whole numbers in round brackets; a comma may follow the last.
fn tuple(text: &str) -> Option<Vec<u64>> {
    let inner = text.strip_prefix('(')?.strip_suffix(')')?.trim();
    let inner = inner.strip_suffix(',').unwrap_or(inner);
    let numbers = inner.split(',').filter(|_| !inner.is_empty());
    numbers.map(|number| number.trim().parse().ok()).collect()
}

/// As many numbers as the bytes hold, and those that remain.
fn numbers<const WIDTH: usize>(
    data: &[u8],
    number: impl Fn([u8; WIDTH]) -> f64,
) -> (Vec<f64>, &[u8]) {
    let (chunks, rest) = data.as_chunks::<WIDTH>();
    (chunks.iter().map(|&bytes| number(bytes)).collect(), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        let mut header = header.to_owned();
        while !(bytes.len() + 2 + header.len() + 1).is_multiple_of(64) {
            header.push(' ');
        }
        header.push('\n');
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    fn parsed(bytes: &[u8]) -> Result<Vec<Point<f64, 3>>, String> {
        parse(bytes, Path::new("p.npy")).map_err(|error| error.to_string())
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect()
    }

    #[test]
    fn both_orders_and_widths_are_read() {
        let expected = [Point::from([1.0, 2.0, 3.0]), Point::from([4.0, 5.0, 6.0])];
        let c = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
        let rows = doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(parsed(&file(c, &rows)).expect("C order"), expected);
        let fortran = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }";
        let columns = doubles(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        assert_eq!(
            parsed(&file(fortran, &columns)).expect("Fortran order"),
            expected
        );
        let single = "{'descr': '>f4', 'fortran_order': False, 'shape': (2, 3), }";
        let singles: Vec<u8> = (1..=6_u8)
            .flat_map(|value| f32::from(value).to_be_bytes())
            .collect();
        assert_eq!(
            parsed(&file(single, &singles)).expect("big-endian f4"),
            expected
        );
    }

    #[test]
    fn later_versions_have_longer_headers_and_keys_come_in_any_order() {
        let header = "{\"shape\": (1, 3), 'fortran_order': False, 'descr': '>f8'}\n";
        for version in [2, 3] {
            let mut bytes = b"\x93NUMPY".to_vec();
            bytes.extend([version, 0]);
            bytes.extend((header.len() as u32).to_le_bytes());
            bytes.extend(header.as_bytes());
            bytes.extend([1.0_f64, 2.0, 3.0].iter().flat_map(|x| x.to_be_bytes()));
            assert_eq!(
                parsed(&bytes).expect("one site"),
                [Point::from([1.0, 2.0, 3.0])]
            );
        }
    }

    #[test]
    fn wrong_files_are_refused_for_their_faults() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
        let short = parsed(&file(header, &doubles(&[1.0, 2.0, 3.0, 4.0]))).unwrap_err();
        assert_eq!(short, "p.npy: ends after 4 of 6 numbers");
        let nan = parsed(&file(
            header,
            &doubles(&[1.0, 2.0, 3.0, f64::NAN, 5.0, 6.0]),
        ))
        .unwrap_err();
        assert!(nan.contains("row 1"), "{nan}");
        for rows in [u64::MAX / 3, 1 << 40] {
            let huge =
                format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, 3), }}");
            assert!(parsed(&file(&huge, &[0; 48])).is_err());
        }
        let flat = "{'descr': '<f8', 'fortran_order': False, 'shape': (6,), }";
        assert!(
            parsed(&file(flat, &[]))
                .unwrap_err()
                .contains("[n, 3] is expected")
        );
        let whole = "{'descr': '<i8', 'fortran_order': False, 'shape': (2, 3), }";
        assert!(
            parsed(&file(whole, &[0; 48]))
                .unwrap_err()
                .contains("f8 or f4")
        );
        let structured =
            "{'descr': [('x', '<f8'), ('y', '<f8')], 'fortran_order': False, 'shape': (2,)}";
        let message = parsed(&file(structured, &[])).unwrap_err();
        assert!(
            message.contains("[('x', '<f8'), ('y', '<f8')]"),
            "{message}"
        );
        let long = parsed(&file(header, &[0; 49])).unwrap_err();
        assert_eq!(long, "p.npy: holds more than its 6 numbers");
        for damaged in [
            "",
            "{}",
            "{'descr': '<f8', 'shape': (2, 3)}",
            "{'descr': '<f8', 'fortran_order': 1, 'shape': (2, 3)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (2, -3)}",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3)",
        ] {
            let message = parsed(&file(damaged, &[0; 48])).unwrap_err();
            assert!(message.contains("damaged"), "{message}");
        }
        assert!(parsed(b"x,y,z\n").unwrap_err().contains("not a .npy file"));
        assert!(parsed(b"").is_err());
    }
}
