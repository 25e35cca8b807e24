//! STL, the stereolithography format, text and binary: triangle soup.
//!
//! A file is binary if its length is the one its count announces (84 + 50 n bytes), even if it
//! starts with `solid` as some programs have it; text if it starts with `solid` and no zero byte
//! follows soon; binary otherwise. What follows the last triangle of a binary file is passed over,
//! unless it is further triangles: then the count is wrong. In text, tags are read in any case, and
//! whatever follows one on its line is passed over. Equal corners (by bits, −0 as 0) become one
//! vertex. Normals are passed over: the corners' order orients a triangle.

use nalgebra::Point3;

use crate::mesh::elements::{Elements, Groups};
use crate::mesh::formats::binary::{Bytes, Scalar};
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, not_empty};
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
    read_mesh(bytes, &mut Groups::default())
}

/// As [`parse`], with the solid of a text file that every triangle belongs to.
pub(crate) fn parse_file(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut groups = Groups::default();
    let mesh = Mesh::Surface(read_mesh(bytes, &mut groups)?);
    let elements = Elements {
        groups,
        ..Elements::default()
    };
    Ok(MeshFile::labeled(mesh, elements))
}

fn read_mesh(bytes: &[u8], groups: &mut Groups) -> Result<SurfaceMesh, ParseError> {
    let mesh = if is_text(bytes) && !is_binary(bytes) {
        parse_text(bytes, groups)?
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

/// Whether a file could be binary STL with something after its last triangle: it is long enough and
/// no text.
pub(crate) fn may_be_binary(bytes: &[u8]) -> bool {
    let is_long = announced(bytes).is_some_and(|count| bytes.len() >= HEADER + RECORD * count);
    is_long && bytes[..HEADER + RECORD.min(bytes.len() - HEADER)].contains(&0)
}

/// Whether a file starts as text STL does.
pub(crate) fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(HEADER + RECORD)];
    let first = bytes.trim_ascii_start().get(..5).unwrap_or_default();
    first.eq_ignore_ascii_case(b"solid") && !start.contains(&0)
}

fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(Scalar::UInt32.decode(count, false) as usize)
}

/// Whether what follows the last triangle is nothing but whole triangles.
fn is_triangles(rest: &[u8]) -> bool {
    let (records, remainder) = rest.as_chunks::<RECORD>();
    let is_finite = |number: &[u8]| Scalar::Float32.decode(number, false).is_finite();
    let is_triangle = |record: &[u8; RECORD]| {
        let corners = &record[12..48];
        corners.iter().any(|&byte| byte != 0) && corners.chunks_exact(4).all(is_finite)
    };
    !records.is_empty() && remainder.is_empty() && records.iter().all(is_triangle)
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
    let rest = bytes.get(HEADER + RECORD * announced..);
    if rest.is_none_or(is_triangles) {
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

fn parse_text(bytes: &[u8], groups: &mut Groups) -> Result<SurfaceMesh, ParseError> {
    let mut words = Words::new(bytes, None);
    let mut soup = Soup::with_capacity(words.capacity_for(usize::MAX, 200));
    while let Some(word) = words.word() {
        if !word.eq_ignore_ascii_case(b"solid") {
            return Err(words.unexpected("solid", word));
        }
        let name = String::from_utf8_lossy(words.rest_of_line()).into_owned();
        let number = groups.names().len() + 1;
        let group = match name.is_empty() {
            true => groups.named(&format!("solid {number}")),
            false => groups.named(&name),
        };
        read_solid(&mut words, &mut soup)?;
        groups.fill(soup.corners.len() / 3, group);
    }
    Ok(soup.into_mesh())
}

/// Reads up to and including the line `endsolid`, also written `end solid`.
fn read_solid(words: &mut Words<'_>, soup: &mut Soup) -> Result<(), ParseError> {
    loop {
        let expected = "facet or endsolid";
        let word = words.some_word(expected)?;
        if word.eq_ignore_ascii_case(b"facet") {
            read_facet(words, soup)?;
        } else if ends(words, word, b"solid") {
            words.next_line();
            return Ok(());
        } else {
            return Err(words.unexpected(expected, word));
        }
    }
}

/// Reads a facet after its first word; exporters write NaN into the normals of slivers, so
/// these are passed over.
fn read_facet(words: &mut Words<'_>, soup: &mut Soup) -> Result<(), ParseError> {
    tag(words, "outer")?;
    tag(words, "loop")?;
    for _ in 0..3 {
        tag(words, "vertex")?;
        soup.corner(&words.point()?);
    }
    end_tag(words, "endloop")?;
    end_tag(words, "endfacet")?;
    // Text after the last tag, unless the next one stands on the same line.
    let mut ahead = words.clone();
    if !ahead.word_on_line().is_some_and(is_facet_or_end) {
        words.next_line();
    }
    words.check_limit("triangles", soup.corners.len() / 3)?;
    Ok(())
}

fn is_facet_or_end(word: &[u8]) -> bool {
    [&b"facet"[..], b"endsolid", b"end"]
        .iter()
        .any(|tag| word.eq_ignore_ascii_case(tag))
}

/// Reads `expected` in any case: after other text on this line, or first on a later one.
fn tag(words: &mut Words<'_>, expected: &'static str) -> Result<(), ParseError> {
    seek(words, expected, |_, word| {
        word.eq_ignore_ascii_case(expected.as_bytes())
    })
}

/// Reads `endloop` or `endfacet`, also written as two words.
fn end_tag(words: &mut Words<'_>, expected: &'static str) -> Result<(), ParseError> {
    let what = expected.trim_start_matches("end").as_bytes();
    seek(words, expected, |words, word| ends(words, word, what))
}

fn seek(
    words: &mut Words<'_>,
    expected: &'static str,
    is_found: impl Fn(&mut Words<'_>, &[u8]) -> bool,
) -> Result<(), ParseError> {
    while let Some(word) = words.word_on_line() {
        if is_found(words, word) {
            return Ok(());
        }
    }
    let word = words.some_word(expected)?;
    if is_found(words, word) {
        return Ok(());
    }
    Err(words.unexpected(expected, word))
}

/// Whether `word` is the tag `end…` of `what`; takes the second word if it is written as two.
fn ends(words: &mut Words<'_>, word: &[u8], what: &[u8]) -> bool {
    let is_what = |word: &[u8]| word.eq_ignore_ascii_case(what);
    let Some((end, rest)) = word.split_at_checked(3) else {
        return false;
    };
    if !end.eq_ignore_ascii_case(b"end") {
        return false;
    }
    if rest.is_empty() && words.clone().word_on_line().is_some_and(is_what) {
        words.word_on_line();
        return true;
    }
    is_what(rest)
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
