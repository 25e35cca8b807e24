//! Reader of sites from a NumPy array (`.npy`, format versions 1 to 3).
//!
//! Layout (NEP 1, `numpy.lib.format`): `\x93NUMPY`, the version's two bytes, the header's length in
//! little-endian (two bytes in version 1, four later), the header, the numbers. The header is a
//! Python literal such as `{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }`.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use nalgebra::Point;

use crate::mesh::formats::binary::Scalar;
use crate::scene::error::Error;

/// The first bytes of an array's file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// The greatest whole number below which f64 holds all.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// Parses a `.npy` file; `path` is for messages only.
///
/// # Errors
/// [`Error::File`] when it is no array of `D` columns of numbers, its length is not the announced
/// one, or it holds a number that is not finite (its row is named).
pub fn parse<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    rows(bytes).map_err(|message| Error::File {
        path: path.to_owned(),
        message,
    })
}

fn rows<const D: usize>(bytes: &[u8]) -> Result<Vec<Point<f64, D>>, String> {
    if bytes.starts_with(b"PK") {
        return Err("a .npz archive of arrays; save the one of the sites by numpy.save".to_owned());
    }
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
        finite_row(row, coordinates)
    };
    (0..count).map(point).collect()
}

/// Some rows of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct NpyPart {
    /// The number of the first of them.
    pub(crate) first: u64,
    /// They themselves.
    pub(crate) rows: Vec<Point<f64, 3>>,
}

/// The longest beginning of a file in which the header is looked for.
const LONGEST_HEADER: u64 = 1 << 16;

/// Reads one part of several, `[part, parts]`, of the rows of a file; nothing where it cannot be read in parts: where
/// it is packed, in Fortran's order or damaged.
///
/// # Errors
/// [`Error::File`] for rows that are no sites, [`Error::Read`].
pub(crate) fn read_part(path: &Path, [part, parts]: [u64; 2]) -> Result<Option<NpyPart>, Error> {
    let failed = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    let mut start = Vec::new();
    let head = Read::by_ref(&mut file).take(LONGEST_HEADER);
    { head }.read_to_end(&mut start).map_err(failed)?;
    let header = split(&start)
        .and_then(|(header, data)| Some((NpyHeader::parse(header)?, start.len() - data.len())));
    let Some((header, rows_at, width)) = header.and_then(|(header, at)| {
        let width = 3 * header.kind().ok()?.0.width() as u64;
        Some((header, at as u64, width))
    }) else {
        return Ok(None);
    };
    let Ok(count) = header.row_count::<3>().map(|count| count as u64) else {
        return Ok(None);
    };
    if header.is_fortran || count.checked_mul(width) != Some(length - rows_at) {
        return Ok(None);
    }
    let [first, end] = [part, part + 1]
        .map(|part| (u128::from(count) * u128::from(part) / u128::from(parts)) as u64);
    file.seek(SeekFrom::Start(rows_at + first * width))
        .map_err(failed)?;
    let mut bytes = vec![0; ((end - first) * width) as usize];
    file.read_exact(&mut bytes).map_err(failed)?;
    let rows = header
        .numbers(&bytes)
        .and_then(|(values, _)| finite_rows(&values, first));
    let rows = rows.map_err(|message| Error::File {
        path: path.to_owned(),
        message,
    })?;
    Ok(Some(NpyPart { first, rows }))
}

/// Rows of three numbers, the first of which has the number `first`.
fn finite_rows(values: &[f64], first: u64) -> Result<Vec<Point<f64, 3>>, String> {
    let rows = (first..).zip(values.as_chunks::<3>().0);
    let rows = rows.map(|(row, numbers)| finite_row(row as usize, *numbers));
    rows.collect()
}

fn finite_row<const D: usize>(row: usize, coordinates: [f64; D]) -> Result<Point<f64, D>, String> {
    match coordinates.iter().all(|value| value.is_finite()) {
        true => Ok(Point::from(coordinates)),
        false => Err(format!(
            "row {row} (counted from 0) is {coordinates:?}; sites need finite coordinates"
        )),
    }
}

/// The header's text and the bytes of the numbers.
fn split(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let (version, rest) = bytes.strip_prefix(MAGIC)?.split_at_checked(2)?;
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

    /// The type of the numbers, and the sign of their bytes' order.
    fn kind(&self) -> Result<(Scalar, char), String> {
        let descr = self.descr.trim_matches(['\'', '"']);
        let kind = descr.get(1..).and_then(scalar);
        let order = descr.chars().next().filter(|order| "<>=|".contains(*order));
        let (Some(kind), Some(order)) = (kind, order) else {
            return Err(format!(
                "the array's type is {}; save it as numbers: array.astype(float)",
                self.descr
            ));
        };
        Ok((kind, order))
    }

    /// The numbers in storage order, as many as there are, and the bytes after them.
    fn numbers<'b>(&self, data: &'b [u8]) -> Result<(Vec<f64>, &'b [u8]), String> {
        let (kind, order) = self.kind()?;
        let chunks = data.chunks_exact(kind.width());
        let rest = chunks.remainder();
        let decode = |bytes: &[u8]| kind.decode(bytes, order == '>');
        let values: Vec<f64> = chunks.map(decode).collect();
        let is_wide = matches!(kind, Scalar::Int64 | Scalar::UInt64);
        match values.iter().find(|value| is_wide && value.abs() >= EXACT) {
            None => Ok((values, rest)),
            Some(value) => Err(format!(
                "holds about {value:e}, beyond 2^53, which would be rounded"
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

/// The type of numbers that NumPy calls so.
fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "f8" => Scalar::Float64,
        "f4" => Scalar::Float32,
        "i1" => Scalar::Int8,
        "i2" => Scalar::Int16,
        "i4" => Scalar::Int32,
        "i8" => Scalar::Int64,
        "u1" => Scalar::UInt8,
        "u2" => Scalar::UInt16,
        "u4" => Scalar::UInt32,
        "u8" => Scalar::UInt64,
        _ => return None,
    })
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
    fn parts_of_a_file_are_its_rows_and_what_has_none_is_told() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("p.npy");
        let write = |bytes: &[u8]| std::fs::write(&path, bytes).expect("room");
        let header = |order: &str| {
            format!("{{'descr': '<f8', 'fortran_order': {order}, 'shape': (7, 3), }}")
        };
        let mut numbers: Vec<f64> = (0..21).map(f64::from).collect();
        let whole = file(&header("False"), &doubles(&numbers));
        write(&whole);
        for parts in [1, 2, 3, 8] {
            let mut rows = Vec::new();
            for part in 0..parts {
                let part = read_part(&path, [part, parts])
                    .expect("rows")
                    .expect("in parts");
                assert_eq!(part.first, rows.len() as u64);
                rows.extend(part.rows);
            }
            assert_eq!(rows, parsed(&whole).expect("an array"), "{parts} parts");
        }
        numbers[20] = f64::NAN;
        write(&file(&header("False"), &doubles(&numbers)));
        assert!(read_part(&path, [0, 2]).is_ok());
        let strange = read_part(&path, [1, 2]).expect_err("no number").to_string();
        assert!(strange.contains("row 6"), "{strange}");
        for other in [
            &file(&header("True"), &doubles(&numbers)),
            &whole[..whole.len() - 1],
            b"x,y,z",
        ] {
            write(other);
            assert_eq!(read_part(&path, [0, 2]).expect("a file"), None);
        }
    }

    #[test]
    fn whole_numbers_of_every_width_are_read() {
        let expected = [Point::from([1.0, 2.0, 3.0]), Point::from([4.0, 5.0, 6.0])];
        for (name, width) in [
            ("i1", 1),
            ("u1", 1),
            ("i2", 2),
            ("u2", 2),
            ("i4", 4),
            ("u4", 4),
            ("i8", 8),
            ("u8", 8),
        ] {
            for order in ["<", ">"] {
                let header = format!(
                    "{{'descr': '{order}{name}', 'fortran_order': False, 'shape': (2, 3), }}"
                );
                let data: Vec<u8> = (1..=6_u64)
                    .flat_map(|value| match order {
                        "<" => value.to_le_bytes()[..width].to_vec(),
                        _ => value.to_be_bytes()[8 - width..].to_vec(),
                    })
                    .collect();
                assert_eq!(
                    parsed(&file(&header, &data)).expect(name),
                    expected,
                    "{order}{name}"
                );
            }
        }
        let bytes = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3), }";
        assert_eq!(
            parsed(&file(bytes, &[1, 4, 2, 5, 3, 6])).expect("bytes"),
            expected
        );
        let wide = "{'descr': '<i8', 'fortran_order': False, 'shape': (1, 3), }";
        let data: Vec<u8> = [1, 2, (1_i64 << 53) + 1]
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        assert!(parsed(&file(wide, &data)).unwrap_err().contains("2^53"));
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
        let complex = "{'descr': '<c16', 'fortran_order': False, 'shape': (2, 3), }";
        assert!(
            parsed(&file(complex, &[0; 96]))
                .unwrap_err()
                .contains("astype(float)")
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
