//! Readers of files of sites, chosen by extension: `.csv`, `.npy`, `.xyz`, `.txt` and `.json`.
//!
//! A CSV file may begin with a header; if it does, the columns named x, y and z (in any case)
//! are read, in any order of columns. Without one every line has exactly one number per axis. In
//! CSV and in text by white space (`.xyz`, `.txt`) blank lines and what follows `#` are skipped. Text
//! whose first line is one whole number is chemistry's XYZ (`xyz`). Lines end with LF, CR LF or CR.
//! A JSON file is an array of arrays of numbers. Errors name the line, or the site counted from zero.

use std::path::Path;

use nalgebra::Point;

use crate::mesh::formats::words::{line_of, lines};
use crate::scene::error::{Error, bare_message};
use crate::scene::number_text::{AXES, number};
use crate::scene::{memory, npy, xyz};

/// Reads the sites in `path`: `.csv`, `.npy`, `.xyz`, `.txt` or `.json`.
///
/// # Errors
/// [`Error::UnknownFormat`], [`Error::Read`], or what is wrong with the file and where.
pub fn read<const D: usize>(path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.to_str() {
        Some("csv") => parse_csv::<D>,
        Some("xyz" | "txt") => parse_words::<D>,
        Some("json") => parse_json::<D>,
        Some("npy") => npy::parse::<D>,
        _ => {
            return Err(Error::UnknownFormat {
                path: path.to_owned(),
            });
        }
    };
    memory::check_file(path)?;
    let bytes = std::fs::read(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    let sites = parse(&bytes, path)?;
    if sites.is_empty() {
        return Err(Error::File {
            path: path.to_owned(),
            message: "holds no sites".to_owned(),
        });
    }
    Ok(sites)
}

/// Parses a `.csv` file; `path` is for messages only.
///
/// # Errors
/// [`Error::Line`] with the first line that is not a point.
fn parse_csv<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    let fields = |line: &str| {
        line.split(',')
            .map(|field| field.trim().trim_matches('"').to_owned())
            .collect()
    };
    parse_lines(bytes, path, fields, true)
}

/// Parses a `.xyz` or `.txt` file; `path` is for messages only.
///
/// # Errors
/// [`Error::Line`] with the first line that is not a point.
fn parse_words<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    if let Some(parsed) = xyz::parse(bytes) {
        return parsed.map_err(|(line, message)| Error::Line {
            path: path.to_owned(),
            line,
            message,
        });
    }
    let fields = |line: &str| line.split_whitespace().map(str::to_owned).collect();
    parse_lines(bytes, path, fields, false)
}

fn parse_lines<const D: usize>(
    bytes: &[u8],
    path: &Path,
    fields: impl Fn(&str) -> Vec<String>,
    mut header_allowed: bool,
) -> Result<Vec<Point<f64, D>>, Error> {
    let text = std::str::from_utf8(bytes).map_err(|error| not_text(bytes, error, path))?;
    let mut columns = Columns::plain();
    let mut sites = Vec::new();
    for (index, line) in lines(text.trim_start_matches('\u{feff}')).enumerate() {
        let content = line.split('#').next().unwrap_or("").trim();
        if content.is_empty() {
            continue;
        }
        let at = |message| Error::Line {
            path: path.to_owned(),
            line: index + 1,
            message,
        };
        let fields = fields(content);
        if header_allowed && fields.iter().any(|field| is_word(field)) {
            columns = Columns::named(&fields).map_err(at)?;
        } else {
            sites.push(columns.point(&fields).map_err(at)?);
        }
        header_allowed = false;
    }
    Ok(sites)
}

/// The columns of the coordinates in a line.
struct Columns<const D: usize> {
    at: [usize; D],
    width: usize,
}

impl<const D: usize> Columns<D> {
    fn plain() -> Self {
        Self {
            at: std::array::from_fn(|axis| axis),
            width: D,
        }
    }

    fn named(header: &[String]) -> Result<Self, String> {
        let mut at = [0; D];
        for (column, axis) in at.iter_mut().zip(AXES) {
            let found = header
                .iter()
                .position(|name| name.eq_ignore_ascii_case(axis));
            *column = found.ok_or_else(|| {
                format!(
                    "the header names no column {axis}; expected {}",
                    AXES[..D].join(",")
                )
            })?;
        }
        Ok(Self {
            at,
            width: header.len(),
        })
    }

    fn point(&self, fields: &[String]) -> Result<Point<f64, D>, String> {
        if fields.len() != self.width {
            return Err(wrong_width::<D>(fields.len(), self.width));
        }
        let mut point = Point::origin();
        for (axis, &column) in self.at.iter().enumerate() {
            point[axis] = number(&fields[column], AXES[axis])?;
        }
        Ok(point)
    }
}

/// Whether a field is neither a number nor one that went wrong: a header's word.
fn is_word(field: &str) -> bool {
    field.parse::<f64>().is_err() && field.starts_with(|first: char| first.is_alphabetic())
}

fn wrong_width<const D: usize>(found: usize, expected: usize) -> String {
    let mend = match found {
        2 | 3 if expected == D => format!("; a scene with \"dimension\": {found} takes these"),
        _ => String::new(),
    };
    format!("{found} columns where {expected} are expected{mend}")
}

fn not_text(bytes: &[u8], error: std::str::Utf8Error, path: &Path) -> Error {
    let before = &bytes[..error.valid_up_to()];
    Error::Line {
        path: path.to_owned(),
        line: line_of(before, before.len()),
        message: "not text (UTF-8)".to_owned(),
    }
}

/// Parses a `.json` file; `path` is for messages only.
///
/// # Errors
/// [`Error::Json`] where the text is no array of arrays, [`Error::File`] for a row of the wrong
/// length.
fn parse_json<const D: usize>(bytes: &[u8], path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
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
        .map(|(index, row)| json_point(row, index, path))
        .collect()
}

fn json_point<const D: usize>(
    row: &[f64],
    index: usize,
    path: &Path,
) -> Result<Point<f64, D>, Error> {
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
    use nalgebra::{Point2, Point3};

    fn csv(text: &str) -> Result<Vec<Point3<f64>>, Error> {
        parse_csv(text.as_bytes(), Path::new("p.csv"))
    }

    fn refusal(text: &str) -> String {
        csv(text).unwrap_err().to_string()
    }

    #[test]
    fn a_header_is_optional() {
        let expected = vec![Point3::new(0.5, 1e-7, -2.0), Point3::new(1.0, 2.0, 3.0)];
        assert_eq!(
            csv("x,y,z\n0.5,1e-7,-2\n1,2,3\n").expect("header"),
            expected
        );
        assert_eq!(csv("0.5,1e-7,-2\r\n1,2,3").expect("none"), expected);
        let frame = "\u{feff},\"Z\",\"X\",\"Y\"\n\n0,-2,.5,1e-7\n1,3,1,2\n";
        assert_eq!(csv(frame).expect("named columns"), expected);
    }

    #[test]
    fn a_bad_line_is_named() {
        assert_eq!(
            refusal("x,y,z\n0,0,0\n0,NaN,1\n"),
            "p.csv, line 3: y is NaN; sites need finite coordinates"
        );
        assert!(refusal("0,0,0\n\n0,-inf,1\n").contains("line 3: y is -inf"));
        assert!(refusal("0,0,0\n0,1e999,1\n").contains("line 2: y is 1e999"));
        assert!(refusal("0,0,0\n0,,1\n").contains("line 2: y is ``"));
        assert!(refusal("0,0,0\n0,1\n").contains("line 2: 2 columns where 3 are expected"));
        assert!(refusal("0,0\n").contains("\"dimension\": 2"));
        assert!(refusal("nan,0,0\n").contains("line 1: x is nan"));
        assert!(refusal("a,b,c\n0,0,0\n").contains("no column x"));
        assert!(refusal("x,y,z\n0,0,0\nx,y,z\n").contains("line 3: x is `x`"));
    }

    #[test]
    fn bytes_that_are_no_text_are_named_by_line() {
        let error = parse_csv::<3>(b"0,0,0\n0,\xff,0\n", Path::new("p.csv")).unwrap_err();
        assert_eq!(error.to_string(), "p.csv, line 2: not text (UTF-8)");
    }

    #[test]
    fn words_come_by_any_white_space_with_comments() {
        let text = "# a cloud\n 0.5\t0.25 # first\n\n1 2\n";
        let sites: Vec<Point2<f64>> =
            parse_words(text.as_bytes(), Path::new("p.xyz")).expect("two points");
        assert_eq!(sites, [Point2::new(0.5, 0.25), Point2::new(1.0, 2.0)]);
    }

    fn json(text: &str) -> Result<Vec<Point<f64, 3>>, Error> {
        parse_json(text.as_bytes(), Path::new("p.json"))
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
