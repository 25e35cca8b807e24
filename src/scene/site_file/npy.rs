//! Sites as a NumPy array of n rows, f64 or f32, in C or Fortran order and any byte order.

use std::io;
use std::path::Path;

use nalgebra::Point;
use npyz::{NpyFile, Order, TypeChar};

use crate::scene::error::Error;

/// Parses a `.npy` file; `path` is for messages only.
///
/// # Errors
/// [`Error::File`] when it is no array of `D` columns of floats, ends early, or holds a number
/// that is not finite (its row is named).
pub fn parse<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    rows(bytes).map_err(|message| Error::File {
        path: path.to_owned(),
        message,
    })
}

fn rows<const D: usize>(bytes: &[u8]) -> Result<Vec<Point<f64, D>>, String> {
    let file = NpyFile::new(bytes).map_err(|error| format!("not a .npy file: {error}"))?;
    let count = row_count::<D>(file.shape())?;
    let order = file.order();
    let values = numbers(file)?;
    let expected = count.saturating_mul(D);
    if values.len() != expected {
        return Err(format!("ends after {} of {expected} numbers", values.len()));
    }
    (0..count)
        .map(|row| point(&values, row, count, order))
        .collect()
}

fn row_count<const D: usize>(shape: &[u64]) -> Result<usize, String> {
    match shape {
        [count, width] if *width == D as u64 => {
            usize::try_from(*count).map_err(|_| format!("{count} rows are too many"))
        }
        _ => Err(format!(
            "the array's shape is {shape:?} where [n, {D}] is expected"
        )),
    }
}

/// The file's numbers in storage order, as many as there are.
fn numbers(file: NpyFile<&[u8]>) -> Result<Vec<f64>, String> {
    let dtype = file.dtype();
    let kind = match &dtype {
        npyz::DType::Plain(kind) => (kind.type_char(), kind.size_field()),
        _ => {
            return Err(format!(
                "the array's type is {} where f8 or f4 is expected",
                dtype.descr()
            ));
        }
    };
    match kind {
        (TypeChar::Float, 8) => all(file.data::<f64>().map_err(|error| error.to_string())?),
        (TypeChar::Float, 4) => {
            let data = file.data::<f32>().map_err(|error| error.to_string())?;
            all(data.map(|value| value.map(f64::from)))
        }
        _ => Err(format!(
            "the array's type is {} where f8 or f4 is expected",
            dtype.descr()
        )),
    }
}

fn all(data: impl Iterator<Item = io::Result<f64>>) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    for value in data {
        match value {
            Ok(value) => values.push(value),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => break,
            Err(error) => return Err(error.to_string()),
        }
    }
    Ok(values)
}

fn point<const D: usize>(
    values: &[f64],
    row: usize,
    count: usize,
    order: Order,
) -> Result<Point<f64, D>, String> {
    let mut point = Point::<f64, D>::origin();
    for axis in 0..D {
        point[axis] = match order {
            Order::C => values[row * D + axis],
            Order::Fortran => values[axis * count + row],
        };
    }
    if point.iter().all(|value| value.is_finite()) {
        return Ok(point);
    }
    Err(format!(
        "row {row} (counted from 0) is {:?}; sites need finite coordinates",
        point.coords.as_slice()
    ))
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
    fn wrong_files_are_told_apart() {
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
        assert!(parsed(b"x,y,z\n").unwrap_err().contains("not a .npy file"));
        assert!(parsed(b"").is_err());
    }
}
