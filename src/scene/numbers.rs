//! Checks of a scene's numbers that several of its keys share.

use nalgebra::Point;

use crate::scene::error::Error;

/// `row` has `D` numbers: the scene has been validated.
pub(crate) fn point<const D: usize>(row: &[f64]) -> Point<f64, D> {
    Point::from(std::array::from_fn::<f64, D, _>(|axis| row[axis]))
}

pub(crate) fn dimensions_match(key: &str, length: usize, dimension: usize) -> Result<(), Error> {
    if length == dimension {
        return Ok(());
    }
    let other = match length {
        2 | 3 => format!(" (or \"dimension\": {length} in the scene)"),
        _ => String::new(),
    };
    Err(Error::value(
        key,
        format!("{length} values where {dimension} are needed{other}"),
    ))
}

/// Checks the length of every row of a list.
pub(crate) fn rows_match(key: &str, rows: &[Vec<f64>], dimension: usize) -> Result<(), Error> {
    for (index, row) in rows.iter().enumerate() {
        dimensions_match(&format!("{key}[{index}]"), row.len(), dimension)?;
    }
    Ok(())
}

pub(crate) fn not_negative(key: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value >= 0.0 {
        return Ok(());
    }
    let message = format!("{value:?} is not 0 or a positive number");
    Err(Error::value(key, message))
}

pub(crate) fn at_least_one(key: &str, value: u64) -> Result<(), Error> {
    if value > 0 {
        return Ok(());
    }
    Err(Error::value(key, "0 is too few; give at least 1"))
}
