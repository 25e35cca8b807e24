//! STL, the stereolithography format, text and binary: triangle soup.
//!
//! A file is binary if its length is the one its count announces (84 + 50 n bytes), even if it
//! starts with `solid` as some programs have it; text if it starts with `solid` and no zero byte
//! follows soon; binary with a wrong count otherwise. Equal corners (by bits, −0 as 0) become one
//! vertex. Normals are passed over: the corners' order orients a triangle.

use nalgebra::Point3;

use crate::mesh::formats::binary::{Bytes, Scalar};
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::not_empty;
use crate::mesh::formats::words::Words;
use crate::mesh::repair::Welder;
use crate::mesh::surface::SurfaceMesh;

/// Bytes before the first triangle of a binary file: 80 of remarks, 4 of count.
const HEADER: usize = 84;

/// Bytes per triangle of a binary file: normal, corners, attribute.
const RECORD: usize = 50;

/// Reads a surface from either variant.
///
/// # Errors
///
/// The line or byte and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    let mesh = if is_text(bytes) && !is_binary(bytes) {
        parse_text(bytes)?
    } else {
        parse_binary(bytes)?
    };
    not_empty(mesh, "triangles", "export the mesh again")
}

/// Whether the length is that of a binary file with the count in its header.
#[must_use]
pub fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|count| bytes.len() == HEADER + RECORD * count)
}

fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(HEADER + RECORD)];
    bytes.trim_ascii_start().starts_with(b"solid") && !start.contains(&0)
}

fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(Scalar::UInt32.decode(count, false) as usize)
}

/// The number of triangles in the header, unless it contradicts the file's length.
fn checked_count(bytes: &[u8]) -> Result<usize, ParseError> {
    let Some(announced) = announced(bytes) else {
        let expected = "a header of 84 bytes";
        return Err(ParseError::at_byte(
            bytes.len(),
            ErrorKind::Truncated { expected },
        ));
    };
    if bytes.len() != HEADER + RECORD * announced {
        let kind = ErrorKind::WrongCount {
            what: "triangles",
            announced,
            found: (bytes.len() - HEADER) / RECORD,
        };
        return Err(ParseError::at_byte(HEADER - 4, kind));
    }
    ErrorKind::check_limit("triangles", announced)
        .map_err(|kind| ParseError::at_byte(HEADER - 4, kind))
}

fn parse_binary(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    let count = checked_count(bytes)?;
    let mut soup = Soup::with_capacity(count);
    let mut cursor = Bytes::new(bytes, HEADER, false);
    for _ in 0..count {
        cursor.skip(12, "a normal")?;
        for _ in 0..3 {
            let mut coordinate = || cursor.finite(Scalar::Float32, "a coordinate");
            soup.corner(&Point3::new(coordinate()?, coordinate()?, coordinate()?));
        }
        cursor.skip(2, "an attribute")?;
    }
    Ok(soup.into_mesh())
}

fn parse_text(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    let mut words = Words::new(bytes, None);
    let mut soup = Soup::with_capacity(words.capacity_for(usize::MAX, 200));
    while let Some(word) = words.word() {
        match word {
            b"solid" => read_solid(&mut words, &mut soup)?,
            _ => return Err(words.unexpected("solid", word)),
        }
    }
    Ok(soup.into_mesh())
}

/// Reads up to and including the line `endsolid`.
fn read_solid(words: &mut Words<'_>, soup: &mut Soup) -> Result<(), ParseError> {
    words.next_line();
    loop {
        let word = words.some_word("facet or endsolid")?;
        match word {
            b"facet" => read_facet(words, soup)?,
            b"endsolid" => {
                words.next_line();
                return Ok(());
            }
            _ => return Err(words.unexpected("facet or endsolid", word)),
        }
    }
}

/// Reads a facet after its first word; exporters write NaN into the normals of slivers, so
/// these are passed over.
fn read_facet(words: &mut Words<'_>, soup: &mut Soup) -> Result<(), ParseError> {
    words.next_line();
    keyword(words, "outer")?;
    keyword(words, "loop")?;
    for _ in 0..3 {
        keyword(words, "vertex")?;
        soup.corner(&words.point()?);
    }
    keyword(words, "endloop")?;
    keyword(words, "endfacet")?;
    words.check_limit("triangles", soup.corners.len() / 3)?;
    Ok(())
}

fn keyword(words: &mut Words<'_>, expected: &'static str) -> Result<(), ParseError> {
    let word = words.some_word(expected)?;
    if word.eq_ignore_ascii_case(expected.as_bytes()) {
        return Ok(());
    }
    Err(words.unexpected(expected, word))
}

/// Corners without connection, welded as they come.
struct Soup {
    welder: Welder,
    corners: Vec<u32>,
}

impl Soup {
    fn with_capacity(triangles: usize) -> Self {
        Self {
            welder: Welder::with_capacity(triangles / 2 + 2),
            corners: Vec::with_capacity(3 * triangles),
        }
    }

    fn corner(&mut self, point: &Point3<f64>) {
        self.corners.push(self.welder.index(point));
    }

    fn into_mesh(self) -> SurfaceMesh {
        let (triangles, _) = self.corners.as_chunks::<3>();
        SurfaceMesh {
            vertices: self.welder.into_points(),
            triangles: triangles.to_vec(),
        }
    }
}
