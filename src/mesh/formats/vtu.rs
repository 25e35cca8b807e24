//! VTK's XML unstructured grids and polygonal data, `.vtu` and `.vtp`: tetrahedra (or surface cells) and
//! scalars of points and cells.
//!
//! Several pieces make one mesh; their common vertices are merged when the mesh is checked. Of polygonal
//! data, polygons and strips of triangles are read, vertices and lines passed over. Format: "VTK File
//! Formats", Kitware.

use nalgebra::Point3;

use crate::mesh::elements::CellData;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, MeshParts};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::vtk::{POLYGON, STRIP, add_cell, cell_ranges, point};
use crate::mesh::formats::vtk_xml::{VtkEncoding, decode};
use crate::mesh::formats::words::{integer, line_of, shown};
use crate::mesh::formats::xml::{Tag, next_tag};

/// VTK's type of polyhedra.
const POLYHEDRON: u8 = 42;

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    Ok(read(bytes)?.mesh)
}

/// As [`parse`], with what there is to say about the file.
pub(crate) fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut file = VtuFile::of(bytes);
    let (encoding, mut position) = file.read_header()?;
    let mut piece = VtuPiece::default();
    let mut section: &[u8] = b"";
    loop {
        let tag = file.next_tag(position, "</UnstructuredGrid> or </PolyData>")?;
        position = tag.end;
        match tag.name {
            b"Piece" => piece = VtuPiece::of(&tag),
            b"/Piece" => file.add_piece(&mut std::mem::take(&mut piece), tag.end)?,
            b"Points" | b"Cells" | b"PointData" | b"CellData" | b"Polys" | b"Strips" | b"Lines"
            | b"Verts" => section = tag.name,
            b"DataArray" => file.read_array(section, &tag, &encoding, &mut piece)?,
            b"/UnstructuredGrid" | b"/PolyData" => return file.mesh.into_mesh(point),
            _ if tag.name.strip_prefix(b"/") == Some(section) => section = b"",
            _ => {}
        }
    }
}

/// The cells of an unstructured grid as the file has them.
#[derive(Clone, Debug, Default)]
pub(crate) struct VtuCells {
    /// All points.
    pub(crate) points: Vec<Point3<f64>>,
    /// The type of every cell and its points.
    pub(crate) cells: Vec<(u8, Vec<u32>)>,
    /// Per cell the loops of its faces; none unless it is a polyhedron.
    pub(crate) faces: Vec<Vec<Vec<u32>>>,
}

/// Reads the cells of a file of one piece.
///
/// # Errors
/// The line and what is wrong there.
pub(crate) fn read_cells(bytes: &[u8]) -> Result<VtuCells, ParseError> {
    let file = VtuFile::of(bytes);
    let (encoding, mut position) = file.read_header()?;
    let mut piece: Option<VtuPiece> = None;
    let mut section: &[u8] = b"";
    loop {
        let tag = file.next_tag(position, "</UnstructuredGrid>")?;
        position = tag.end;
        let at_tag = |kind| file.error(tag.end, kind);
        match tag.name {
            b"Piece" if piece.is_some() => {
                let mend = "export a file of one piece";
                return Err(at_tag(ErrorKind::unsupported("a second piece", mend)));
            }
            b"Piece" => piece = Some(VtuPiece::of(&tag)),
            b"Points" | b"Cells" => section = tag.name,
            b"DataArray" if !section.is_empty() => {
                if let Some(piece) = &mut piece {
                    file.read_array(section, &tag, &encoding, piece)?;
                }
            }
            b"/UnstructuredGrid" => {
                let piece = piece.unwrap_or_default();
                piece.check_counts().map_err(at_tag)?;
                return piece.cells().map_err(at_tag);
            }
            _ if tag.name.strip_prefix(b"/") == Some(section) => section = b"",
            _ => {}
        }
    }
}

/// Whole numbers of an array from a place on, as many as asked for, each below a limit.
fn numbers_below(
    numbers: &[f64],
    start: usize,
    count: usize,
    limit: usize,
) -> Result<Vec<u32>, ErrorKind> {
    let expected = "a number of a point or of an entry that is there";
    let missing = || ErrorKind::Truncated { expected };
    let end = start.checked_add(count).ok_or_else(missing)?;
    let found = numbers.get(start..end).ok_or_else(missing)?;
    let number = |&number: &f64| match number >= 0.0 && number < limit as f64 {
        true => Ok(number as u32),
        false => Err(ErrorKind::expected(expected, number.to_string())),
    };
    found.iter().map(number).collect()
}

/// The arrays of a piece.
#[derive(Default)]
struct VtuPiece {
    points: Vec<f64>,
    connectivity: Vec<f64>,
    offsets: Vec<f64>,
    types: Vec<f64>,
    /// The faces of polyhedra: their count, and of each the count of its points and these.
    faces: Vec<f64>,
    /// Offsets and connectivity of the polygons and of the strips of polygonal data.
    polygons: [Vec<f64>; 2],
    strips: [Vec<f64>; 2],
    /// Fields of the points, or why they cannot be read.
    data: Vec<(String, Result<Vec<f64>, String>)>,
    /// Fields of the cells that can be read.
    cell_data: Vec<CellData>,
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

    /// Makes the polygons and strips of polygonal data cells with types.
    fn name_faces(&mut self) {
        let lists = [
            (std::mem::take(&mut self.polygons), POLYGON),
            (std::mem::take(&mut self.strips), STRIP),
        ];
        for ([offsets, mut connectivity], kind) in lists {
            let base = self.connectivity.len() as f64;
            let used = offsets.last().map_or(0.0, |&end| end);
            connectivity.truncate(used as usize);
            self.connectivity.append(&mut connectivity);
            let count = self.types.len() + offsets.len();
            self.types.resize(count, f64::from(kind));
            self.offsets.extend(offsets.iter().map(|end| base + end));
        }
    }

    /// The cells with their points and faces, all numbers checked.
    fn cells(&self) -> Result<VtuCells, ErrorKind> {
        let (points, _) = self.points.as_chunks::<3>();
        let mut all = VtuCells {
            points: points.iter().map(|&point| Point3::from(point)).collect(),
            ..VtuCells::default()
        };
        let count = all.points.len();
        let (mut start, mut first) = (0, 0);
        for (cell, kind) in self.types.iter().enumerate() {
            let limit = self.connectivity.len() + 1;
            let end = numbers_below(&self.offsets, cell, 1, limit)?[0] as usize;
            let size = end.saturating_sub(start);
            let corners = numbers_below(&self.connectivity, start, size, count)?;
            all.cells.push((*kind as u8, corners));
            let (faces, next) = match *kind as u8 {
                POLYHEDRON => self.faces_from(first, count)?,
                _ => (Vec::new(), first),
            };
            all.faces.push(faces);
            (start, first) = (end, next);
        }
        Ok(all)
    }

    /// The loops of a polyhedron's faces from a place on, and where those of the next one begin.
    fn faces_from(&self, start: usize, points: usize) -> Result<(Vec<Vec<u32>>, usize), ErrorKind> {
        let limit = self.faces.len() + 1;
        let mut place = start + 1;
        let mut loops = Vec::new();
        for _ in 0..numbers_below(&self.faces, start, 1, limit)?[0] {
            let size = numbers_below(&self.faces, place, 1, limit)?[0] as usize;
            loops.push(numbers_below(&self.faces, place + 1, size, points)?);
            place += 1 + size;
        }
        Ok((loops, place))
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
    /// How many cells the pieces so far have.
    cells: usize,
}

impl<'a> VtuFile<'a> {
    /// A file of which nothing is read yet.
    fn of(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            mesh: MeshParts::default(),
            cells: 0,
        }
    }
    /// The encoding that the tag `VTKFile` gives, and the byte offset of its end.
    fn read_header(&self) -> Result<(VtkEncoding<'a>, usize), ParseError> {
        let mut position = 0;
        loop {
            let tag = self.next_tag(position, "the element VTKFile")?;
            if tag.name == b"VTKFile" {
                let kind = tag.attribute("type").unwrap_or_default();
                if kind != b"UnstructuredGrid" && kind != b"PolyData" {
                    let what = format!("a VTK file of type {}", shown(kind));
                    let mend = "export an UnstructuredGrid of tetrahedra or PolyData";
                    return Err(self.error(tag.end, ErrorKind::unsupported(what, mend)));
                }
                return Ok((VtkEncoding::of(&tag, self.bytes), tag.end));
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
        encoding: &VtkEncoding<'_>,
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
            (b"Cells", b"faces") => piece.faces = decoded()?,
            (b"Polys", b"offsets") => piece.polygons[0] = decoded()?,
            (b"Polys", b"connectivity") => piece.polygons[1] = decoded()?,
            (b"Strips", b"offsets") => piece.strips[0] = decoded()?,
            (b"Strips", b"connectivity") => piece.strips[1] = decoded()?,
            (b"PointData", _) if components == b"1" && tag.attribute("type") != Some(b"String") => {
                let values = decoded().map_err(|error| error.kind.to_string());
                piece.data.push((shown(name), values));
            }
            (b"CellData", _) if components == b"1" && tag.attribute("type") != Some(b"String") => {
                let name = shown(name);
                let values = decoded().ok();
                let field = values.map(|values| CellData { name, values });
                piece.cell_data.extend(field);
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
        piece.name_faces();
        let first = self.cells;
        self.cells += piece.types.len();
        self.add_cell_data(piece, first);
        add_cells(&mut self.mesh, piece, [base, first]).map_err(at_piece)
    }

    /// Continues the fields of the cells so far, `first` of them; where a piece lacks one it is NaN.
    fn add_cell_data(&mut self, piece: &mut VtuPiece, first: usize) {
        for field in piece.cell_data.drain(..) {
            let fields = &mut self.mesh.cell_data;
            let known = fields.iter().position(|known| known.name == field.name);
            let at = known.unwrap_or_else(|| {
                let (name, values) = (field.name.clone(), Vec::new());
                fields.push(CellData { name, values });
                fields.len() - 1
            });
            fields[at].values.resize(first, f64::NAN);
            fields[at].values.extend(field.values);
        }
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

/// Adds the cells of a piece, before which the mesh has `base` points and `first` cells.
fn add_cells(
    mesh: &mut MeshParts,
    piece: &VtuPiece,
    [base, first]: [usize; 2],
) -> Result<(), ErrorKind> {
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
    for (number, ([start, end], &kind)) in ranges.into_iter().zip(&piece.types).enumerate() {
        cell.clear();
        for &vertex in &piece.connectivity[start..end] {
            cell.push(base as u32 + vertex_index(vertex, vertices)?);
        }
        // Fractions and negative numbers are no types.
        let kind = whole(kind).and_then(|kind| u32::try_from(kind).ok());
        add_cell(mesh, kind.unwrap_or(u32::MAX), &cell)?;
        mesh.number_cell(first + number);
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
