//! Readers of files of sites: CSV, text by white space, chemistry's XYZ, JSON, NumPy arrays.
//!
//! The format is the caller's, else that of the extension (`.csv`, `.tsv`, `.npy`, `.xyz`, `.txt`, `.json`),
//! else told by the content, as for standard input; gzip is unpacked. Text that is neither JSON nor
//! chemistry's XYZ (`xyz`) is a table (`site_table`). A JSON file is an array of arrays of numbers. Errors
//! name the line, or the site counted from zero.

use std::path::Path;

use nalgebra::Point;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::mesh::formats::unpack::{STANDARD_INPUT, extension_of, read_unpacked};
use crate::mesh::formats::words::line_of;
use crate::scene::error::{Error, bare_message};
use crate::scene::site_table::{self, Separator, SiteFile};
use crate::scene::{memory, npy, xyz};

/// A format of sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SiteFormat {
    /// A table with commas, semicolons or tabs between its columns.
    Csv,
    /// Text by white space, or chemistry's XYZ.
    Xyz,
    /// An array of arrays of numbers.
    Json,
    /// A NumPy array.
    Npy,
}

/// Reads the sites in `path`: `.csv`, `.npy`, `.xyz`, `.txt` or `.json`, or what its content says.
///
/// # Errors
/// [`Error::UnknownFormat`], [`Error::Read`], or what is wrong with the file and where.
pub fn read<const D: usize>(path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    Ok(read_as(path, None)?.sites)
}

/// As [`read`], of a format that is known, with notes; `-` is standard input.
pub(crate) fn read_as<const D: usize>(
    path: &Path,
    format: Option<SiteFormat>,
) -> Result<SiteFile<D>, Error> {
    memory::check_file(path)?;
    let bytes = read_unpacked(path).map_err(|error| Error::of_bytes(path, error))?;
    let name = shown(path);
    let format = format
        .or_else(|| SiteFormat::of_extension(&extension_of(path)))
        .or_else(|| SiteFormat::of_content(&bytes));
    let format = format.ok_or_else(|| Error::UnknownFormat {
        path: name.to_owned(),
    })?;
    let file = format.parse(&bytes, name)?;
    if file.sites.is_empty() {
        return Err(Error::File {
            path: name.to_owned(),
            message: "holds no sites".to_owned(),
        });
    }
    Ok(file)
}

/// A file's name in messages.
fn shown(path: &Path) -> &Path {
    if path == Path::new(STANDARD_INPUT) {
        Path::new("standard input")
    } else {
        path
    }
}

impl SiteFormat {
    fn of_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "csv" | "tsv" => Self::Csv,
            "xyz" | "txt" => Self::Xyz,
            "json" => Self::Json,
            "npy" => Self::Npy,
            _ => return None,
        })
    }

    /// The format of text that begins with a number or names its columns, or of an array.
    fn of_content(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(npy::MAGIC) || bytes.starts_with(b"PK") {
            return Some(Self::Npy);
        }
        let text = std::str::from_utf8(bytes).ok()?;
        let start = text.trim_start_matches('\u{feff}').trim_start();
        if start.is_empty() || start.starts_with('[') {
            return Some(Self::Json);
        }
        if xyz::parse::<3>(bytes).is_some() {
            return Some(Self::Xyz);
        }
        let line = site_table::first_line(text)?;
        let separator = Separator::of(line);
        let fields = separator.fields(line);
        let is_table = fields[0].parse::<f64>().is_ok() || site_table::names_columns(&fields);
        let format = match separator {
            Separator::Blank => Self::Xyz,
            Separator::Sign(_) => Self::Csv,
        };
        is_table.then_some(format)
    }

    fn parse<const D: usize>(self, bytes: &[u8], path: &Path) -> Result<SiteFile<D>, Error> {
        let sites = match self {
            Self::Csv => return parse_table(bytes, path, None),
            Self::Xyz => match xyz::parse(bytes) {
                None => return parse_table(bytes, path, Some(Separator::Blank)),
                Some(parsed) => parsed.map_err(|(line, message)| Error::Line {
                    path: path.to_owned(),
                    line,
                    message,
                })?,
            },
            Self::Json => parse_json(bytes, path)?,
            Self::Npy => npy::parse(bytes, path)?,
        };
        let notes = Vec::new();
        Ok(SiteFile { sites, notes })
    }
}

/// Parses a table with this separator, or the one that its first line says; `path` is for messages only.
///
/// # Errors
/// [`Error::Line`] with the first line that is not a point.
fn parse_table<const D: usize>(
    bytes: &[u8],
    path: &Path,
    separator: Option<Separator>,
) -> Result<SiteFile<D>, Error> {
    let text = std::str::from_utf8(bytes).map_err(|error| not_text(bytes, error, path))?;
    site_table::parse(text, separator).map_err(|(line, message)| Error::Line {
        path: path.to_owned(),
        line,
        message,
    })
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
        parse_table(text.as_bytes(), Path::new("p.csv"), None).map(|file| file.sites)
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
        let error = parse_table::<3>(b"0,0,0\n0,\xff,0\n", Path::new("p.csv"), None).unwrap_err();
        assert_eq!(error.to_string(), "p.csv, line 2: not text (UTF-8)");
    }

    #[test]
    fn words_come_by_any_white_space_with_comments() {
        let text = "# a cloud\n 0.5\t0.25 # first\n\n1 2\n";
        let blank = Some(Separator::Blank);
        let file =
            parse_table::<2>(text.as_bytes(), Path::new("p.xyz"), blank).expect("two points");
        assert_eq!(file.sites, [Point2::new(0.5, 0.25), Point2::new(1.0, 2.0)]);
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
