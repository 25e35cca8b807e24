//! PLY, the Stanford polygon format, text and binary of either byte order.
//!
//! Of the element `vertex` the properties x, y, z are read, of `face` the list `vertex_indices`
//! (or `vertex_index`), with any other properties before, between or after them; other elements are
//! passed over. Triangle strips are not read. Binary data begin after the line end of `end_header`,
//! which is of the same kind (LF, CR LF or CR) as the first line's.

use nalgebra::Point3;

use crate::mesh::formats::binary::{Bytes, Scalar};
use crate::mesh::formats::error::{ELEMENT_LIMIT, ErrorKind, ParseError};
use crate::mesh::formats::mesh::not_empty;
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;

/// Reads a surface; polygons are triangulated.
///
/// # Errors
///
/// The line or byte and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    let mut words = Words::new(bytes, None);
    let header = read_header(&mut words)?;
    let start = data_start(bytes, words.position());
    words.next_line();
    let mut source = match header.encoding {
        PlyEncoding::Text => Source::Text(words),
        PlyEncoding::Little => Source::Binary(Bytes::new(bytes, start, false)),
        PlyEncoding::Big => Source::Binary(Bytes::new(bytes, start, true)),
    };
    let mesh = read_body(&header, &mut source)?;
    source.check_end()?;
    let mend = "export the mesh with its faces, not as a point cloud or strips";
    not_empty(mesh, "faces", mend)
}

/// Where binary data begin, for a header whose last word ends at `end`. After a header whose lines
/// end with CR alone, the data's first byte may be that of LF.
fn data_start(bytes: &[u8], end: usize) -> usize {
    let first = bytes.iter().position(|byte| b"\n\r".contains(byte));
    let ends_with_cr = first.is_some_and(|at| bytes[at..].starts_with(b"\r"));
    let is_cr_lf = first.is_some_and(|at| bytes[at..].starts_with(b"\r\n"));
    let rest = &bytes[end..];
    let blanks = rest.iter().position(|byte| !b" \t".contains(byte));
    let start = end + blanks.unwrap_or(rest.len());
    let is_long = !ends_with_cr || is_cr_lf;
    match bytes[start..] {
        [b'\r', b'\n', ..] if is_long => start + 2,
        [b'\r' | b'\n', ..] => start + 1,
        _ => start,
    }
}

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PlyEncoding {
    Text,
    Little,
    Big,
}

/// The header: everything before the data.
#[derive(Clone, Debug)]
struct PlyHeader {
    encoding: PlyEncoding,
    elements: Vec<Element>,
}

/// A kind of element, such as `vertex`.
#[derive(Clone, Debug)]
struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// A property of an element: a number, or a list preceded by its length of type `list`.
#[derive(Clone, Debug)]
struct Property {
    name: String,
    list: Option<Scalar>,
    kind: Scalar,
}

/// Reads up to and including the line `end_header`.
fn read_header(words: &mut Words<'_>) -> Result<PlyHeader, ParseError> {
    check_magic(words)?;
    let mut encoding = None;
    let mut elements = Vec::new();
    loop {
        words.next_line();
        let word = words.some_word("end_header")?;
        match word.to_ascii_lowercase().as_slice() {
            b"end_header" => break,
            b"comment" | b"obj_info" => {}
            b"format" => encoding = Some(read_encoding(words)?),
            b"element" => elements.push(read_element(words, &elements)?),
            b"property" => read_property(words, &mut elements)?,
            _ => return Err(words.unexpected("a header line", word)),
        }
    }
    let missing = || words.unexpected("a line `format`", b"end_header");
    let encoding = encoding.ok_or_else(missing)?;
    Ok(PlyHeader { encoding, elements })
}

fn check_magic(words: &mut Words<'_>) -> Result<(), ParseError> {
    let magic = words.some_word("the header ply")?;
    match magic.eq_ignore_ascii_case(b"ply") {
        true => Ok(()),
        false => Err(words.unexpected("the header ply", magic)),
    }
}

fn read_encoding(words: &mut Words<'_>) -> Result<PlyEncoding, ParseError> {
    let word = words.some_word_on_line("a format")?;
    match word.to_ascii_lowercase().as_slice() {
        b"ascii" => Ok(PlyEncoding::Text),
        b"binary_little_endian" => Ok(PlyEncoding::Little),
        b"binary_big_endian" => Ok(PlyEncoding::Big),
        _ => Err(words.unexpected("ascii, binary_little_endian or binary_big_endian", word)),
    }
}

fn read_element(words: &mut Words<'_>, earlier: &[Element]) -> Result<Element, ParseError> {
    let name = shown(words.some_word_on_line("an element's name")?).to_ascii_lowercase();
    let count = words.count_on_line("an element's count")?;
    let count = words.check_limit("elements", count)?;
    if earlier.iter().any(|element| element.name == name) {
        return Err(words.unexpected("an element not named before", name.as_bytes()));
    }
    if name == "tristrips" {
        let mend = "export it with the element `face`";
        return Err(words.unsupported("a PLY file of triangle strips", mend));
    }
    let properties = Vec::new();
    Ok(Element {
        name,
        count,
        properties,
    })
}

fn read_property(words: &mut Words<'_>, elements: &mut [Element]) -> Result<(), ParseError> {
    let next = words.clone().word_on_line();
    let is_list = next.is_some_and(|word| word.eq_ignore_ascii_case(b"list"));
    let (list, expected) = if is_list {
        words.word_on_line();
        (Some(read_kind(words, "a number type")?), "a list's type")
    } else {
        (None, "a property's type")
    };
    let kind = read_kind(words, expected)?;
    let name = shown(words.some_word_on_line("a property's name")?).to_ascii_lowercase();
    let Some(element) = elements.last_mut() else {
        return Err(words.unexpected("a line `element` before", b"property"));
    };
    let is_read = ["x", "y", "z", "vertex_index", "vertex_indices"].contains(&name.as_str());
    if is_read && element.properties.iter().any(|other| other.name == name) {
        return Err(words.unexpected("a property not named before", name.as_bytes()));
    }
    element.properties.push(Property { name, list, kind });
    Ok(())
}

fn read_kind(words: &mut Words<'_>, expected: &'static str) -> Result<Scalar, ParseError> {
    let word = words.some_word_on_line(expected)?;
    Scalar::named(&word.to_ascii_lowercase()).ok_or_else(|| words.unexpected("a number type", word))
}

fn read_body(header: &PlyHeader, source: &mut Source<'_>) -> Result<SurfaceMesh, ParseError> {
    let mut mesh = SurfaceMesh::default();
    let is_vertex = |element: &&Element| element.name == "vertex";
    let vertices = header.elements.iter().find(is_vertex);
    let mut polygons = Polygons {
        vertices: vertices.map_or(0, |element| element.count),
        ..Polygons::default()
    };
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, source, &mut mesh.vertices)?,
            "face" => read_faces(element, source, &mut polygons)?,
            _ => skip_element(element, source)?,
        }
    }
    // Faces may precede the vertices: they are triangulated once both are read.
    for polygon in polygons.iter() {
        triangulate(&mesh.vertices, polygon, &mut mesh.triangles);
    }
    Ok(mesh)
}

/// Faces as read, in one list.
#[derive(Default)]
struct Polygons {
    /// How many vertices the header announces.
    vertices: usize,
    indices: Vec<u32>,
    ends: Vec<usize>,
}

impl Polygons {
    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts
            .zip(&self.ends)
            .map(|(&start, &end)| &self.indices[start..end])
    }
}

/// The axis of every property of the vertices: 0, 1, 2 for x, y, z, which must all be there.
fn axes(vertices: &Element) -> Result<Vec<Option<usize>>, ParseError> {
    let axis = |property: &Property| {
        ["x", "y", "z"]
            .iter()
            .position(|axis| *axis == property.name && property.list.is_none())
    };
    let axes: Vec<Option<usize>> = vertices.properties.iter().map(axis).collect();
    if (0..3).any(|axis| !axes.contains(&Some(axis))) {
        let what = "vertex properties x, y, z";
        return Err(ParseError::missing(what, "export vertex positions"));
    }
    Ok(axes)
}

fn read_vertices(
    element: &Element,
    source: &mut Source<'_>,
    vertices: &mut Vec<Point3<f64>>,
) -> Result<(), ParseError> {
    let axes = axes(element)?;
    vertices.reserve(source.capacity_for(element.count));
    for _ in 0..element.count {
        let mut point = Point3::origin();
        for (property, axis) in element.properties.iter().zip(&axes) {
            match *axis {
                Some(axis) => point[axis] = source.coordinate(property.kind)?,
                None => skip_property(property, source)?,
            }
        }
        vertices.push(point);
    }
    Ok(())
}

fn read_faces(
    element: &Element,
    source: &mut Source<'_>,
    polygons: &mut Polygons,
) -> Result<(), ParseError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    polygons.ends.reserve(source.capacity_for(element.count));
    for _ in 0..element.count {
        for property in &element.properties {
            let is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
            match property.list {
                Some(length) if is_corners => {
                    read_corners(length, property.kind, source, polygons)?;
                }
                _ => skip_property(property, source)?,
            }
        }
    }
    Ok(())
}

fn read_corners(
    length: Scalar,
    kind: Scalar,
    source: &mut Source<'_>,
    polygons: &mut Polygons,
) -> Result<(), ParseError> {
    let corners = source.length(length)?;
    if corners < 3 {
        let found = corners.to_string();
        return Err(source.error(ErrorKind::expected("a face of at least 3 vertices", found)));
    }
    for _ in 0..corners {
        let vertex = source.index(kind, polygons.vertices)?;
        polygons.indices.push(vertex);
    }
    polygons.ends.push(polygons.indices.len());
    if polygons.indices.len() > ELEMENT_LIMIT * 3 {
        let (what, limit) = ("triangles", ELEMENT_LIMIT);
        return Err(source.error(ErrorKind::TooMany { what, limit }));
    }
    Ok(())
}

fn skip_element(element: &Element, source: &mut Source<'_>) -> Result<(), ParseError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            skip_property(property, source)?;
        }
    }
    Ok(())
}

fn skip_property(property: &Property, source: &mut Source<'_>) -> Result<(), ParseError> {
    let count = property
        .list
        .map_or(Ok(1), |length| source.length(length))?;
    for _ in 0..count {
        source.skip(property.kind)?;
    }
    Ok(())
}

/// The source of the numbers.
enum Source<'a> {
    Text(Words<'a>),
    Binary(Bytes<'a>),
}

impl Source<'_> {
    fn coordinate(&mut self, kind: Scalar) -> Result<f64, ParseError> {
        match self {
            Self::Text(words) => words.number("a coordinate"),
            Self::Binary(bytes) => bytes.finite(kind, "a coordinate"),
        }
    }

    fn length(&mut self, kind: Scalar) -> Result<usize, ParseError> {
        Ok(self.whole(kind, "a list's length")? as usize)
    }

    fn index(&mut self, kind: Scalar, vertices: usize) -> Result<u32, ParseError> {
        let vertex = self.whole(kind, "a vertex index")?;
        ErrorKind::check_vertex(i64::from(vertex), vertices, 0).map_err(|kind| self.error(kind))
    }

    /// A non-negative integer of at most 32 bits.
    fn whole(&mut self, kind: Scalar, expected: &'static str) -> Result<u32, ParseError> {
        let number = match self {
            Self::Text(words) => words.integer(expected)? as f64,
            Self::Binary(bytes) => bytes.scalar(kind, expected)?,
        };
        if number >= 0.0 && number <= f64::from(u32::MAX) && number.fract() == 0.0 {
            return Ok(number as u32);
        }
        Err(self.error(ErrorKind::expected(expected, number.to_string())))
    }

    fn skip(&mut self, kind: Scalar) -> Result<(), ParseError> {
        match self {
            Self::Text(words) => words.some_word("a property").map(|_| ()),
            Self::Binary(bytes) => bytes.skip(kind.width(), "a property"),
        }
    }

    /// A bound on the elements that the rest can hold.
    fn capacity_for(&self, announced: usize) -> usize {
        match self {
            Self::Text(words) => words.capacity_for(announced, 4),
            Self::Binary(bytes) => announced.min(bytes.left()),
        }
    }

    /// Refuses text after the last element: the counts were too low. Binary files may be
    /// padded.
    fn check_end(&mut self) -> Result<(), ParseError> {
        let Self::Text(words) = self else {
            return Ok(());
        };
        match words.word() {
            None => Ok(()),
            Some(word) => Err(words.unexpected("the end of the file", word)),
        }
    }

    fn error(&self, kind: ErrorKind) -> ParseError {
        match self {
            Self::Text(words) => words.error(kind),
            Self::Binary(bytes) => bytes.error(kind),
        }
    }
}
