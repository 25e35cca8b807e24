//! VTK's XML unstructured grids, `.vtu`: tetrahedra (or surface cells) and point scalars.
//!
//! Data may be text, base64 in place, or appended (raw or base64), of either byte
//! order, uncompressed or compressed with zlib. Several pieces make one mesh; their common
//! vertices are not merged. Format: "VTK File Formats", Kitware.
//!
//! Binary data are preceded by a header of unsigned integers: uncompressed, one, the number of
//! bytes; compressed, the number of blocks, the size of a block, the size of the last block if
//! it is partial, and every block's compressed size. In base64 a compressed array's header is
//! encoded apart from the blocks.

use std::io::Read;

use flate2::read::ZlibDecoder;
use nalgebra::Point3;

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshParts};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::vtk::{add_cell, cell_ranges, point};
use crate::mesh::formats::words::{Words, integer, line_of, shown};
use crate::mesh::formats::xml::{Tag, next_tag};

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    let mut file = VtuFile {
        bytes,
        mesh: MeshParts::default(),
    };
    let (encoding, mut position) = file.read_header()?;
    let mut piece = VtuPiece::default();
    let mut section: &[u8] = b"";
    loop {
        let tag = file.next_tag(position, "</UnstructuredGrid>")?;
        position = tag.end;
        match tag.name {
            b"Piece" => piece = VtuPiece::of(&tag),
            b"/Piece" => file.add_piece(&mut std::mem::take(&mut piece), tag.end)?,
            b"Points" | b"Cells" | b"PointData" | b"CellData" => section = tag.name,
            b"/Points" | b"/Cells" | b"/PointData" | b"/CellData" => section = b"",
            b"DataArray" => file.read_array(section, &tag, &encoding, &mut piece)?,
            b"/UnstructuredGrid" => return file.into_mesh(),
            _ => {}
        }
    }
}

/// The arrays of a piece.
#[derive(Default)]
struct VtuPiece {
    points: Vec<f64>,
    connectivity: Vec<f64>,
    offsets: Vec<f64>,
    types: Vec<f64>,
    /// Fields of the points, or why they cannot be read.
    data: Vec<(String, Result<Vec<f64>, String>)>,
    announced_points: Option<usize>,
    announced_cells: Option<usize>,
}

impl VtuPiece {
    /// An empty piece that announces the counts in its tag.
    fn of(tag: &Tag<'_>) -> Self {
        let announced = |name| {
            let count = integer(tag.attribute(name)?.trim_ascii())?;
            usize::try_from(count).ok()
        };
        Self {
            announced_points: announced("NumberOfPoints"),
            announced_cells: announced("NumberOfCells"),
            ..Self::default()
        }
    }

    fn check_counts(&self) -> Result<(), ErrorKind> {
        let points = self.points.len() / 3;
        ErrorKind::check_count("points", self.announced_points.unwrap_or(points), points)?;
        let cells = self.types.len();
        ErrorKind::check_count("cells", self.announced_cells.unwrap_or(cells), cells)
    }
}

struct VtuFile<'a> {
    bytes: &'a [u8],
    mesh: MeshParts,
}

impl<'a> VtuFile<'a> {
    /// The encoding that the tag `VTKFile` gives, and the byte offset of its end.
    fn read_header(&self) -> Result<(VtuEncoding<'a>, usize), ParseError> {
        let mut position = 0;
        loop {
            let tag = self.next_tag(position, "the element VTKFile")?;
            if tag.name == b"VTKFile" {
                let kind = tag.attribute("type").unwrap_or_default();
                if kind != b"UnstructuredGrid" {
                    let what = format!("a VTK file of type {}", shown(kind));
                    let mend = "export an UnstructuredGrid of tetrahedra";
                    return Err(self.error(tag.end, ErrorKind::unsupported(what, mend)));
                }
                return Ok((VtuEncoding::of(&tag, self.bytes), tag.end));
            }
            position = tag.end;
        }
    }

    /// The first tag at or after `position`; `expected` describes the missing one in the error.
    fn next_tag(&self, position: usize, expected: &'static str) -> Result<Tag<'a>, ParseError> {
        let missing = || self.error(self.bytes.len(), ErrorKind::Truncated { expected });
        next_tag(self.bytes, position).ok_or_else(missing)
    }

    fn read_array(
        &self,
        section: &[u8],
        tag: &Tag<'_>,
        encoding: &VtuEncoding<'_>,
        piece: &mut VtuPiece,
    ) -> Result<(), ParseError> {
        let name = tag.attribute("Name").unwrap_or_default();
        let components = tag.attribute("NumberOfComponents").unwrap_or(b"1");
        let decoded = || decode(self.bytes, tag, encoding);
        match (section, name) {
            (b"Points", _) => piece.points = decoded()?,
            (b"Cells", b"connectivity") => piece.connectivity = decoded()?,
            (b"Cells", b"offsets") => piece.offsets = decoded()?,
            (b"Cells", b"types") => piece.types = decoded()?,
            (b"PointData", _) if components == b"1" && tag.attribute("type") != Some(b"String") => {
                let values = decoded().map_err(|error| error.kind.to_string());
                piece.data.push((shown(name), values));
            }
            _ => {}
        }
        Ok(())
    }

    /// Adds a finished piece, which ends at `end`.
    fn add_piece(&mut self, piece: &mut VtuPiece, end: usize) -> Result<(), ParseError> {
        let at_piece = |kind| ParseError::on_line(line_of(self.bytes, end), kind);
        let (points, rest) = piece.points.as_chunks::<3>();
        if !rest.is_empty() {
            let found = piece.points.len().to_string();
            return Err(at_piece(ErrorKind::expected(
                "three coordinates a point",
                found,
            )));
        }
        piece.check_counts().map_err(at_piece)?;
        if let Some(number) = piece.points.iter().find(|number| !number.is_finite()) {
            let found = number.to_string();
            return Err(at_piece(ErrorKind::NotFinite { found }));
        }
        let base = self.mesh.vertices.len();
        self.mesh
            .vertices
            .extend(points.iter().map(|&point| Point3::from(point)));
        ErrorKind::check_limit("points", self.mesh.vertices.len()).map_err(at_piece)?;
        add_data(&mut self.mesh, piece, base);
        add_cells(&mut self.mesh, piece, base).map_err(at_piece)
    }

    fn into_mesh(self) -> Result<Mesh, ParseError> {
        self.mesh.into_mesh(point)
    }

    fn error(&self, position: usize, kind: ErrorKind) -> ParseError {
        ParseError::on_line(line_of(self.bytes, position), kind)
    }
}

/// Continues the fields of the pieces so far, of which the mesh had `base` points. A field that a
/// piece lacks is at fault.
fn add_data(mesh: &mut MeshParts, piece: &mut VtuPiece, base: usize) {
    let count = mesh.vertices.len() - base;
    if count == 0 {
        return;
    }
    let mut fresh: Vec<PointData> = Vec::new();
    for (name, values) in piece.data.drain(..) {
        fresh.push(match values {
            Ok(values) => PointData::of(name, values, count),
            Err(fault) => PointData::faulty(name, fault),
        });
    }
    if base == 0 {
        mesh.point_data.append(&mut fresh);
        return;
    }
    let lacking = |name: &str| {
        let fault = "a piece of the file lacks it".to_owned();
        PointData::faulty(name.to_owned(), fault)
    };
    for field in &mut mesh.point_data {
        let at = fresh.iter().position(|other| other.name() == field.name());
        field.append(at.map_or_else(|| lacking(field.name()), |at| fresh.remove(at)));
    }
    let late = fresh.iter().map(|field| lacking(field.name()));
    mesh.point_data.extend(late);
}

fn add_cells(mesh: &mut MeshParts, piece: &VtuPiece, base: usize) -> Result<(), ErrorKind> {
    let mut offsets = vec![0];
    for &offset in &piece.offsets {
        offsets.push(whole(offset).ok_or_else(|| {
            ErrorKind::expected("an offset into the list of vertices", offset.to_string())
        })?);
    }
    ErrorKind::check_count("cell types", piece.offsets.len(), piece.types.len())?;
    let size = piece.connectivity.len();
    let disorder = || {
        let expected = "ascending offsets up to the list's length";
        ErrorKind::expected(expected, format!("others than up to {size}"))
    };
    let ranges = cell_ranges(&offsets, size).ok_or_else(disorder)?;
    let vertices = mesh.vertices.len() - base;
    let mut cell = Vec::new();
    for ([start, end], &kind) in ranges.into_iter().zip(&piece.types) {
        cell.clear();
        for &vertex in &piece.connectivity[start..end] {
            cell.push(base as u32 + vertex_index(vertex, vertices)?);
        }
        // Fractions and negative numbers are no types.
        let kind = whole(kind).and_then(|kind| u32::try_from(kind).ok());
        add_cell(mesh, kind.unwrap_or(u32::MAX), &cell)?;
    }
    Ok(())
}

/// A non-negative integer.
fn whole(number: f64) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0).then_some(number as usize)
}

fn vertex_index(number: f64, vertices: usize) -> Result<u32, ErrorKind> {
    let Some(index) = whole(number) else {
        let found = number.to_string();
        return Err(ErrorKind::expected("a vertex index", found));
    };
    // Casts saturate: a number out of range stays out of range.
    ErrorKind::check_vertex(i64::try_from(index).unwrap_or(i64::MAX), vertices, 0)
}

/// The encoding common to all arrays: attributes of the tag `VTKFile`, and the appended data.
#[derive(Clone, Debug)]
struct VtuEncoding<'a> {
    big_endian: bool,
    header: Scalar,
    compressor: Option<&'a [u8]>,
    /// The appended data after their underscore.
    appended: Option<&'a [u8]>,
    appended_raw: bool,
}

impl<'a> VtuEncoding<'a> {
    /// Reads the attributes of the tag `VTKFile` and finds the appended data.
    fn of(file: &Tag<'a>, bytes: &'a [u8]) -> Self {
        let appended = find_appended(bytes, file.end);
        let is_wide = file.attribute("header_type") == Some(b"UInt64");
        Self {
            big_endian: file.attribute("byte_order") == Some(b"BigEndian"),
            header: if is_wide {
                Scalar::UInt64
            } else {
                Scalar::UInt32
            },
            compressor: file.attribute("compressor").filter(|name| !name.is_empty()),
            appended: appended.as_ref().map(|&(_, data)| data),
            appended_raw: appended.is_some_and(|(is_raw, _)| is_raw),
        }
    }
}

/// All numbers of the array whose opening tag is `tag`. Integers beyond 2⁵³ are rounded.
fn decode(bytes: &[u8], tag: &Tag<'_>, encoding: &VtuEncoding<'_>) -> Result<Vec<f64>, ParseError> {
    let line = line_of(bytes, tag.end);
    let at_tag = |kind| ParseError::on_line(line, kind);
    let name = tag.attribute("type").unwrap_or_default();
    let kind = Scalar::named(&name.to_ascii_lowercase());
    let kind = kind.ok_or_else(|| at_tag(unknown("array of type", name)))?;
    let format = tag.attribute("format").unwrap_or(b"ascii");
    let content = tag.content(bytes);
    let data = match format {
        b"ascii" => return read_text(content, line),
        b"binary" => from_base64(content, encoding),
        b"appended" => appended(tag, encoding),
        _ => Err(unknown("array format", format)),
    };
    let data = data.map_err(at_tag)?;
    let numbers = data.chunks_exact(kind.width());
    Ok(numbers
        .map(|number| kind.decode(number, encoding.big_endian))
        .collect())
}

fn unknown(what: &str, name: &[u8]) -> ErrorKind {
    ErrorKind::unsupported(
        format!("the {what} {}", shown(name)),
        "export the file as ASCII",
    )
}

fn read_text(content: &[u8], line: usize) -> Result<Vec<f64>, ParseError> {
    let mut words = Words::new(content, None).on_line(line);
    let mut numbers = Vec::with_capacity(content.len() / 4);
    while let Some(word) = words.word() {
        numbers.push(words.parse_value(word)?);
    }
    Ok(numbers)
}

fn appended(tag: &Tag<'_>, encoding: &VtuEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let expected = "appended data";
    let offset = tag
        .attribute("offset")
        .and_then(|offset| std::str::from_utf8(offset).ok()?.parse::<usize>().ok());
    let data = encoding.appended.ok_or(ErrorKind::Truncated { expected })?;
    let data = offset
        .and_then(|offset| data.get(offset..))
        .ok_or(ErrorKind::Truncated { expected })?;
    if encoding.appended_raw {
        return from_raw(data, encoding);
    }
    let end = data
        .iter()
        .position(|&byte| byte == b'<')
        .unwrap_or(data.len());
    from_base64(&data[..end], encoding)
}

/// Decodes only as much base64 as the header announces: appended arrays follow one another.
fn from_base64(text: &[u8], encoding: &VtuEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let text = text.trim_ascii();
    let width = encoding.header.width();
    let first = base64(text, width)?;
    let count = header_value(&first, 0, encoding)?;
    if encoding.compressor.is_none() {
        return from_raw(&base64(text, width.saturating_add(count))?, encoding);
    }
    let header_size = count.saturating_add(3).saturating_mul(width);
    let header = base64(text, header_size)?;
    if header.len() < header_size {
        return Err(too_short());
    }
    let compressed: usize = (0..count).try_fold(0_usize, |sum, block| {
        Ok::<_, ErrorKind>(sum.saturating_add(header_value(&header, block + 3, encoding)?))
    })?;
    let blocks = text.get(header_size.div_ceil(3) * 4..).unwrap_or_default();
    let mut data = header;
    data.extend(base64(blocks, compressed)?);
    from_raw(&data, encoding)
}

/// The payload of header and data.
fn from_raw(data: &[u8], encoding: &VtuEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let width = encoding.header.width();
    let count = header_value(data, 0, encoding)?;
    match encoding.compressor {
        None => {
            let end = width.saturating_add(count);
            Ok(data.get(width..end).ok_or_else(too_short)?.to_vec())
        }
        Some(b"vtkZLibDataCompressor") => inflate(data, count, encoding),
        Some(name) => Err(unknown("compressor", name)),
    }
}

fn inflate(data: &[u8], blocks: usize, encoding: &VtuEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let mut start = blocks
        .saturating_add(3)
        .saturating_mul(encoding.header.width());
    // No block inflates beyond the size of a whole one: damaged data must not fill memory.
    let whole = header_value(data, 1, encoding)? as u64;
    let mut inflated = Vec::new();
    for block in 0..blocks {
        let size = header_value(data, block + 3, encoding)?;
        let end = start.saturating_add(size);
        let compressed = data.get(start..end).ok_or_else(too_short)?;
        let broken = |_| unknown("damaged zlib block", b"");
        ZlibDecoder::new(compressed)
            .take(whole)
            .read_to_end(&mut inflated)
            .map_err(broken)?;
        start = end;
    }
    Ok(inflated)
}

fn header_value(data: &[u8], at: usize, encoding: &VtuEncoding<'_>) -> Result<usize, ErrorKind> {
    let width = encoding.header.width();
    let start = at.saturating_mul(width);
    let bytes = data
        .get(start..start.saturating_add(width))
        .ok_or_else(too_short)?;
    Ok(encoding.header.decode(bytes, encoding.big_endian) as usize)
}

fn too_short() -> ErrorKind {
    let expected = "the rest of an array";
    ErrorKind::Truncated { expected }
}

/// The first `limit` bytes encoded in `text`, fewer if it is shorter. Padding may occur inside,
/// where encoded parts follow one another.
fn base64(text: &[u8], limit: usize) -> Result<Vec<u8>, ErrorKind> {
    let mut bytes = Vec::with_capacity(limit.min(text.len()));
    for group in text.chunks(4) {
        if bytes.len() >= limit {
            break;
        }
        let mut bits = 0_u32;
        let mut digits = 0;
        for &letter in group.iter().take_while(|&&letter| letter != b'=') {
            bits = bits << 6 | digit(letter)?;
            digits += 1;
        }
        bits <<= 6 * (4 - digits);
        let count = (digits as usize * 6) / 8;
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=count]);
    }
    bytes.truncate(limit);
    Ok(bytes)
}

fn digit(letter: u8) -> Result<u32, ErrorKind> {
    let value = match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => {
            return Err(ErrorKind::expected("base64", shown(&[letter])));
        }
    };
    Ok(u32::from(value))
}

/// Whether the appended data are raw, and the data after their underscore.
fn find_appended(bytes: &[u8], from: usize) -> Option<(bool, &[u8])> {
    const OPENING: &[u8] = b"<AppendedData";
    let rest = &bytes[from..];
    let start = rest
        .windows(OPENING.len())
        .position(|window| window == OPENING)?;
    let rest = &rest[start..];
    let end = rest.iter().position(|&byte| byte == b'>')?;
    let is_raw = rest[..end].windows(5).any(|window| window == b"\"raw\"");
    let underscore = rest[end..].iter().position(|&byte| byte == b'_')?;
    Some((is_raw, &rest[end + underscore + 1..]))
}
