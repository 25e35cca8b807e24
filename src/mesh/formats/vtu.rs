//! VTK's XML unstructured grids, `.vtu`: tetrahedra (or surface cells) and point scalars.
//!
//! Data may stand as text, as base64 in place, or appended (raw or base64), of either byte
//! order, uncompressed or compressed with zlib. Several pieces make one mesh; their common
//! vertices are not merged. Format: "VTK File Formats", Kitware.

use nalgebra::Point3;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Collected, Mesh};
use crate::mesh::formats::vtk_cells::{add_cell, cell_ranges};
use crate::mesh::formats::vtu_array::{Encoding, decode};
use crate::mesh::formats::words::{ELEMENT_LIMIT, shown};
use crate::mesh::formats::xml::{Tag, line_of, next_tag};
use crate::mesh::tets::VertexData;

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    let mut file = File {
        bytes,
        mesh: Collected::default(),
    };
    let (encoding, mut position) = file.read_header()?;
    let mut piece = Piece::default();
    let mut section: &[u8] = b"";
    loop {
        let missing = || {
            file.error(
                bytes.len(),
                ErrorKind::Truncated {
                    expected: "</UnstructuredGrid>",
                },
            )
        };
        let tag = next_tag(bytes, position).ok_or_else(missing)?;
        position = tag.end;
        match tag.name {
            b"Piece" => piece = Piece::default(),
            b"/Piece" => file.add_piece(&std::mem::take(&mut piece), tag.end)?,
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
struct Piece {
    points: Vec<f64>,
    connectivity: Vec<f64>,
    offsets: Vec<f64>,
    types: Vec<f64>,
    data: Vec<VertexData>,
}

struct File<'a> {
    bytes: &'a [u8],
    mesh: Collected,
}

impl<'a> File<'a> {
    /// The encoding told by the tag `VTKFile`, and where it ends.
    fn read_header(&self) -> Result<(Encoding<'a>, usize), ParseError> {
        let mut position = 0;
        while let Some(tag) = next_tag(self.bytes, position) {
            if tag.name == b"VTKFile" {
                let kind = tag.attribute("type").unwrap_or_default();
                if kind != b"UnstructuredGrid" {
                    let what = format!("a VTK file of type {}", shown(kind));
                    let mend = "export an UnstructuredGrid of tetrahedra";
                    return Err(self.error(tag.end, ErrorKind::Unsupported { what, mend }));
                }
                return Ok((Encoding::of(&tag, self.bytes), tag.end));
            }
            position = tag.end;
        }
        let expected = "the element VTKFile";
        Err(self.error(self.bytes.len(), ErrorKind::Truncated { expected }))
    }

    fn read_array(
        &self,
        section: &[u8],
        tag: &Tag<'_>,
        encoding: &Encoding<'_>,
        piece: &mut Piece,
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
                let values = decoded()?;
                piece.data.push(VertexData {
                    name: shown(name),
                    values,
                });
            }
            _ => {}
        }
        Ok(())
    }

    /// Adds a finished piece, which ends at `end`.
    fn add_piece(&mut self, piece: &Piece, end: usize) -> Result<(), ParseError> {
        let at_piece = |kind| ParseError::on_line(line_of(self.bytes, end), kind);
        let (points, rest) = piece.points.as_chunks::<3>();
        if !rest.is_empty() {
            let (expected, found) = ("three coordinates a point", piece.points.len().to_string());
            return Err(at_piece(ErrorKind::Expected { expected, found }));
        }
        let finite = |number: &&f64| !number.is_finite();
        let values = piece.data.iter().flat_map(|field| &field.values);
        if let Some(number) = piece.points.iter().chain(values).find(finite) {
            let found = number.to_string();
            return Err(at_piece(ErrorKind::NotFinite { found }));
        }
        let base = self.mesh.vertices.len();
        self.mesh
            .vertices
            .extend(points.iter().map(|&point| Point3::from(point)));
        if self.mesh.vertices.len() > ELEMENT_LIMIT {
            let (what, limit) = ("points", ELEMENT_LIMIT);
            return Err(at_piece(ErrorKind::TooMany { what, limit }));
        }
        add_data(&mut self.mesh, piece, base);
        add_cells(&mut self.mesh, piece, base).map_err(at_piece)
    }

    fn into_mesh(mut self) -> Result<Mesh, ParseError> {
        let count = self.mesh.vertices.len();
        self.mesh
            .vertex_data
            .retain(|field| field.values.len() == count);
        self.mesh.into_mesh()
    }

    fn error(&self, position: usize, kind: ErrorKind) -> ParseError {
        ParseError::on_line(line_of(self.bytes, position), kind)
    }
}

/// Continues the fields that all pieces so far had.
fn add_data(mesh: &mut Collected, piece: &Piece, base: usize) {
    for VertexData { name, values } in &piece.data {
        let known = mesh
            .vertex_data
            .iter_mut()
            .find(|field| field.name == *name);
        match known {
            Some(field) if field.values.len() == base => field.values.extend(values),
            None if base == 0 => {
                let (name, values) = (name.clone(), values.clone());
                mesh.vertex_data.push(VertexData { name, values });
            }
            _ => {}
        }
    }
}

fn add_cells(mesh: &mut Collected, piece: &Piece, base: usize) -> Result<(), ErrorKind> {
    let offsets: Vec<usize> = std::iter::once(0)
        .chain(piece.offsets.iter().map(|&offset| offset as usize))
        .collect();
    if piece.types.len() != piece.offsets.len() {
        let (what, announced, found) = ("cell types", piece.offsets.len(), piece.types.len());
        return Err(ErrorKind::WrongCount {
            what,
            announced,
            found,
        });
    }
    let (expected, size) = (
        "ascending offsets up to the list's length",
        piece.connectivity.len(),
    );
    let disorder = || ErrorKind::Expected {
        expected,
        found: format!("others than up to {size}"),
    };
    let ranges = cell_ranges(&offsets, size).ok_or_else(disorder)?;
    let vertices = mesh.vertices.len() - base;
    let mut cell = Vec::new();
    for ([start, end], &kind) in ranges.into_iter().zip(&piece.types) {
        cell.clear();
        for &vertex in &piece.connectivity[start..end] {
            if !(vertex >= 0.0 && vertex < vertices as f64) {
                let (index, first) = (vertex as i64, 0);
                return Err(ErrorKind::OutOfRange {
                    index,
                    vertices,
                    first,
                });
            }
            cell.push((base + vertex as usize) as u32);
        }
        add_cell(mesh, kind as u32, &cell)?;
    }
    Ok(())
}
