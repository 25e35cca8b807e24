//! Sites as a JSON array of arrays of numbers.

use std::path::Path;

use nalgebra::Point;

use crate::scene::error::Error;
use crate::scene::read::bare_message;

/// Parses a `.json` file; `path` is for messages only.
///
/// # Errors
/// [`Error::Json`] where the text is no array of arrays, [`Error::File`] for a row of the wrong
/// length.
pub fn parse<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    let rows: Vec<Vec<f64>> = serde_json::from_slice(bytes).map_err(|error| Error::Json {
        path: path.to_owned(),
        line: error.line().max(1),
        column: error.column().max(1),
        message: format!(
            "{}; expected an array of points such as [[0, 0, 0], …]",
            bare_message(&error)
        ),
    })?;
    rows.iter()
        .enumerate()
        .map(|(index, row)| point(row, index, path))
        .collect()
}

fn point<const D: usize>(row: &[f64], index: usize, path: &Path) -> Result<Point<f64, D>, Error> {
    match <[f64; D]>::try_from(row) {
        Ok(coordinates) => Ok(Point::from(coordinates)),
        Err(_) => Err(Error::File {
            path: path.to_owned(),
            message: format!(
                "site {index} has {} coordinates where {D} are expected",
                row.len()
            ),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn json(text: &str) -> Result<Vec<Point<f64, 3>>, Error> {
        parse(text.as_bytes(), Path::new("p.json"))
    }

    #[test]
    fn triples_are_points() {
        let sites = json("[[0.5, 1, 2e-3],\n [1, 2, 3]]").expect("two points");
        assert_eq!(
            sites,
            [Point::from([0.5, 1.0, 2e-3]), Point::from([1.0, 2.0, 3.0])]
        );
    }

    #[test]
    fn what_is_no_triple_is_named() {
        let pair = json("[[0, 0, 0], [1, 2]]").unwrap_err().to_string();
        assert_eq!(
            pair,
            "p.json: site 1 has 2 coordinates where 3 are expected"
        );
        let nan = json("[[0, 0, 0],\n[1, NaN, 2]]").unwrap_err().to_string();
        assert!(nan.starts_with("p.json, line 2, column"), "{nan}");
        assert!(json("[[0, 0, 0],").unwrap_err().to_string().contains("EOF"));
        assert!(json("").is_err());
    }
}
