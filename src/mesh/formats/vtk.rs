//! Legacy VTK, text or binary: unstructured grids of tetrahedra (or surface cells), polygonal data.
//!
//! Tetrahedra, triangles and quadrangles of second order are read where their edges are straight.
//! Scalars of the points (SCALARS and one-component arrays of FIELD) become vertex data; other
//! attributes and all cell data are passed over. Keywords are read in any case. Both layouts of CELLS are read: counts before
//! each cell (versions up to 4.2) and OFFSETS with CONNECTIVITY (5.1). Format: "VTK File
//! Formats", Kitware.

use nalgebra::Point3;

use crate::mesh::elements::CellData;
use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, MeshParts, no_tetrahedron};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::vtk_input::{VtkInput, is_text};
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;

/// VTK's numbers for polygons and strips of triangles.
pub(crate) const POLYGON: u32 = 7;
pub(crate) const STRIP: u32 = 6;

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line or byte and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    Ok(read(bytes)?.mesh)
}

/// As [`parse`], with what there is to say about the file.
pub(crate) fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut words = Words::new(bytes, None);
    words.next_line();
    words.next_line();
    let is_binary = read_is_binary(&mut words)?;
    let mut file = VtkFile {
        input: VtkInput { words, is_binary },
        mesh: MeshParts::default(),
        cells: Vec::new(),
        kinds: Vec::new(),
        tuples: None,
    };
    while let Some(keyword) = file.input.words.word() {
        let keyword = keyword.to_ascii_uppercase();
        file.read_section(&keyword)?;
    }
    file.into_mesh()
}

/// Reads whether the data are binary.
fn read_is_binary(words: &mut Words<'_>) -> Result<bool, ParseError> {
    let encoding = words.some_word("ASCII or BINARY")?;
    let is_binary = is(encoding, "binary");
    if !is_binary && !is(encoding, "ascii") {
        let what = format!("a {} .vtk file", shown(encoding));
        return Err(words.unsupported(what, "export it as ASCII, BINARY or as .vtu"));
    }
    Ok(is_binary)
}

/// The owner of the data that follow, points or cells, and the number of tuples.
#[derive(Clone, Copy, Debug)]
struct Tuples {
    of_points: bool,
    count: usize,
}

struct VtkFile<'a> {
    input: VtkInput<'a>,
    mesh: MeshParts,
    cells: Vec<Vec<u32>>,
    kinds: Vec<u32>,
    tuples: Option<Tuples>,
}

impl VtkFile<'_> {
    fn read_section(&mut self, keyword: &[u8]) -> Result<(), ParseError> {
        match keyword {
            b"DATASET" => self.read_dataset()?,
            b"POINTS" => self.read_points()?,
            b"CELLS" => self.cells = self.read_cells()?,
            b"POLYGONS" => self.add_cells(POLYGON)?,
            b"TRIANGLE_STRIPS" => self.add_cells(STRIP)?,
            b"VERTICES" | b"LINES" => drop(self.read_cells()?),
            b"CELL_TYPES" => self.read_kinds()?,
            b"POINT_DATA" => self.start_attributes(true)?,
            b"CELL_DATA" => self.start_attributes(false)?,
            b"METADATA" => self.skip_metadata(),
            b"FIELD" => self.read_field()?,
            _ => self.read_attribute(keyword)?,
        }
        Ok(())
    }

    fn read_dataset(&mut self) -> Result<(), ParseError> {
        let kind = self.input.words.some_word("the kind of data set")?;
        if is(kind, "UNSTRUCTURED_GRID") || is(kind, "POLYDATA") {
            return Ok(());
        }
        let what = format!("a VTK data set of kind {}", shown(kind));
        let mend = "export an UNSTRUCTURED_GRID of tetrahedra or POLYDATA";
        Err(self.input.words.unsupported(what, mend))
    }

    /// A number type, whose data then follow on the next line.
    fn read_kind(&mut self) -> Result<Scalar, ParseError> {
        let name = self.input.words.some_word_on_line("a number type")?;
        let kind = self.input.kind(name)?;
        self.input.start_data();
        Ok(kind)
    }

    fn read_points(&mut self) -> Result<(), ParseError> {
        let words = &mut self.input.words;
        let count = words.size("the number of points", "points")?;
        let most = words.capacity_for(count, 6);
        self.mesh.vertices.reserve(most);
        let kind = self.read_kind()?;
        for _ in 0..count {
            let mut coordinate = || self.input.finite(kind, "a coordinate");
            let point = Point3::new(coordinate()?, coordinate()?, coordinate()?);
            self.mesh.vertices.push(point);
        }
        Ok(())
    }

    fn add_cells(&mut self, kind: u32) -> Result<(), ParseError> {
        let mut cells = self.read_cells()?;
        self.cells.append(&mut cells);
        self.kinds.resize(self.cells.len(), kind);
        Ok(())
    }

    fn read_cells(&mut self) -> Result<Vec<Vec<u32>>, ParseError> {
        let words = &mut self.input.words;
        let first = words.count("the number of cells")?;
        let second = words.count("the size of the cell list")?;
        if self.is_next("OFFSETS") {
            return self.read_offset_cells(first, second);
        }
        let mut cells = Vec::with_capacity(self.input.words.capacity_for(first, 4));
        self.input.start_data();
        let mut found = 0_usize;
        for _ in 0..first {
            let corners = self
                .input
                .count(Scalar::Int32, "a cell's number of vertices")?;
            cells.push(self.read_cell(Scalar::Int32, corners)?);
            found = found.saturating_add(corners + 1);
        }
        let what = "numbers in the cell list";
        ErrorKind::check_count(what, second, found).map_err(|kind| self.input.error(kind))?;
        Ok(cells)
    }

    fn read_cell(&mut self, kind: Scalar, corners: usize) -> Result<Vec<u32>, ParseError> {
        let vertices = self.mesh.vertices.len();
        (0..corners)
            .map(|_| self.input.vertex(kind, vertices))
            .collect()
    }

    fn read_offset_cells(
        &mut self,
        offsets: usize,
        size: usize,
    ) -> Result<Vec<Vec<u32>>, ParseError> {
        self.input.words.word();
        let kind = self.read_kind()?;
        let offsets: Vec<usize> = (0..offsets)
            .map(|_| self.input.count(kind, "an offset"))
            .collect::<Result<_, _>>()?;
        let keyword = self.input.words.some_word("CONNECTIVITY")?;
        if !is(keyword, "CONNECTIVITY") {
            return Err(self.input.words.unexpected("CONNECTIVITY", keyword));
        }
        let kind = self.read_kind()?;
        let connectivity = self.read_cell(kind, size)?;
        let disorder = || ErrorKind::expected("ascending offsets", "others");
        let ranges = cell_ranges(&offsets, size);
        let ranges = ranges.ok_or_else(|| self.input.error(disorder()))?;
        let cell = |[start, end]: [usize; 2]| connectivity[start..end].to_vec();
        Ok(ranges.into_iter().map(cell).collect())
    }

    fn read_kinds(&mut self) -> Result<(), ParseError> {
        let count = self.input.words.count("the number of cell types")?;
        self.input.start_data();
        for _ in 0..count {
            let kind = self.input.count(Scalar::Int32, "a cell type")?;
            self.kinds.push(u32::try_from(kind).unwrap_or(u32::MAX));
        }
        Ok(())
    }

    fn start_attributes(&mut self, of_points: bool) -> Result<(), ParseError> {
        let count = self.input.words.count("the number of data")?;
        self.tuples = Some(Tuples { of_points, count });
        Ok(())
    }

    /// Reads an attribute of POINT_DATA or CELL_DATA.
    fn read_attribute(&mut self, keyword: &[u8]) -> Result<(), ParseError> {
        let Some(Tuples { count, .. }) = self.tuples else {
            return Err(self
                .input
                .words
                .unexpected("a section such as POINTS", keyword));
        };
        match keyword {
            b"SCALARS" => self.read_scalars(count),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => self.skip_array(count, 1),
            b"VECTORS" | b"NORMALS" => self.skip_array(count, 3),
            b"TENSORS" => self.skip_array(count, 9),
            b"TENSORS6" => self.skip_array(count, 6),
            b"LOOKUP_TABLE" => {
                self.input.words.some_word_on_line("a table's name")?;
                let size = self.input.words.count_on_line("a table's size")?;
                self.skip_values(b"unsigned_char", size, 4)
            }
            b"TEXTURE_COORDINATES" => {
                self.input.words.some_word_on_line("a name")?;
                let components = self.input.words.count_on_line("the number of components")?;
                let kind = self.input.words.some_word_on_line("a number type")?;
                self.skip_values(kind, count, components)
            }
            b"COLOR_SCALARS" => {
                self.input.words.some_word_on_line("a name")?;
                let components = self.input.words.count_on_line("the number of components")?;
                self.skip_values(b"unsigned_char", count, components)
            }
            _ => Err(self.input.words.unexpected("a kind of data", keyword)),
        }
    }

    fn read_scalars(&mut self, count: usize) -> Result<(), ParseError> {
        let name = shown(self.input.words.some_word_on_line("a name")?);
        let kind = self.input.words.some_word_on_line("a number type")?;
        let components = match self.input.words.word_on_line() {
            None => 1,
            Some(word) => self
                .input
                .words
                .parse_count(word, "the number of components")?,
        };
        if self.is_next("LOOKUP_TABLE") {
            self.input.words.word();
            self.input.words.some_word_on_line("a table's name")?;
        }
        self.read_array(name, kind, components, count)
    }

    /// Reads the arrays of a FIELD, in or outside POINT_DATA and CELL_DATA.
    fn read_field(&mut self) -> Result<(), ParseError> {
        self.input.words.some_word("a field's name")?;
        let arrays = self.input.words.count("the number of arrays")?;
        for _ in 0..arrays {
            if self.is_next("METADATA") {
                self.skip_metadata();
            }
            let name = shown(self.input.words.some_word("an array's name")?);
            let components = self.input.words.count("the number of components")?;
            let count = self.input.words.count("the number of tuples")?;
            let kind = self.input.words.some_word("a number type")?;
            self.read_array(name, kind, components, count)?;
        }
        Ok(())
    }

    /// Keeps one-component arrays of numbers of the points and the cells.
    fn read_array(
        &mut self,
        name: String,
        kind: &[u8],
        components: usize,
        count: usize,
    ) -> Result<(), ParseError> {
        let is_bits = is(kind, "bit");
        if self.tuples.is_none()
            || components != 1
            || is_text(kind)
            || is_bits && self.input.is_binary
        {
            return self.skip_values(kind, count, components);
        }
        let mut values = Vec::with_capacity(self.input.words.capacity_for(count, 2));
        let kind = self.input.kind(kind)?;
        self.input.start_data();
        for _ in 0..count {
            values.push(self.input.value(kind)?);
        }
        if self.tuples.is_some_and(|tuples| tuples.of_points) {
            let vertices = self.mesh.vertices.len();
            let field = PointData::of(name, values, vertices);
            self.mesh.point_data.push(field);
        } else {
            self.mesh.cell_data.push(CellData { name, values });
        }
        Ok(())
    }

    /// Passes over an attribute with a name, a type and its values.
    fn skip_array(&mut self, count: usize, components: usize) -> Result<(), ParseError> {
        self.input.words.some_word_on_line("a name")?;
        let kind = self.input.words.some_word_on_line("a type")?;
        self.skip_values(kind, count, components)
    }

    /// Passes over the values of an array of this type.
    fn skip_values(
        &mut self,
        kind: &[u8],
        count: usize,
        components: usize,
    ) -> Result<(), ParseError> {
        self.input
            .skip_values(kind, count.saturating_mul(components))
    }

    /// Whether the next word is this keyword.
    fn is_next(&self, keyword: &str) -> bool {
        self.input
            .words
            .peek()
            .is_some_and(|word| is(word, keyword))
    }

    /// Moves past the empty line that ends a METADATA block.
    fn skip_metadata(&mut self) {
        self.input.words.word();
        self.input.words.next_line();
        while !self.input.words.rest_of_line().is_empty() {}
    }

    fn into_mesh(mut self) -> Result<MeshFile, ParseError> {
        ErrorKind::check_count("cell types", self.cells.len(), self.kinds.len())
            .map_err(ParseError::whole)?;
        for (number, (cell, &kind)) in self.cells.iter().zip(&self.kinds).enumerate() {
            add_cell(&mut self.mesh, kind, cell).map_err(ParseError::whole)?;
            self.mesh.number_cell(number);
        }
        self.mesh.into_mesh(point)
    }
}

/// A vertex as VTK's users know it.
pub(crate) fn point(vertex: usize) -> String {
    format!("point {vertex} (counted from 0)")
}

fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

/// Adds a cell of VTK's type number `kind` over the vertices `cell`: tetrahedra (10; 24 and 71 of
/// second order), triangles (5, 22, 69), strips of them (6), polygons (7), quads (9, 23, 28, 70),
/// pixels (8). Vertices and lines (1 to 4, 21, 35, 68) are passed over, all else is refused.
pub(crate) fn add_cell(mesh: &mut MeshParts, kind: u32, cell: &[u32]) -> Result<(), ErrorKind> {
    match (kind, cell.len()) {
        (10 | 71, 4) | (24 | 71, 10) => mesh.add_tet(cell)?,
        (22 | 69, 6) | (23 | 70, 8) | (28 | 70, 9) => mesh.add_second_order_face(cell)?,
        (8, 4) => {
            let quad = [cell[0], cell[1], cell[3], cell[2]];
            triangulate(&mesh.vertices, &quad, &mut mesh.triangles);
        }
        (6, _) => add_strip(mesh, cell),
        (5 | 7 | 9, 3..) | (69, 3) | (70, 4) => {
            triangulate(&mesh.vertices, cell, &mut mesh.triangles);
        }
        (1..=4 | 21 | 35 | 68, _) => {}
        (_, count) => return Err(refused_cell(kind, count)),
    }
    Ok(())
}

/// The refusal of a cell with `count` vertices.
fn refused_cell(kind: u32, count: usize) -> ErrorKind {
    match kind {
        5 | 7..=10 | 22..=24 | 28 => {
            let expected = "a cell with the vertices of its type";
            let found = format!("type {kind} with {count} vertices");
            ErrorKind::expected(expected, found)
        }
        69..=71 => {
            let what = format!("a cell of order above two (VTK {kind} with {count} nodes)");
            ErrorKind::unsupported(what, "export first-order cells")
        }
        _ => no_tetrahedron(format!("VTK {kind}")),
    }
}

/// Adds the triangles of a strip, every second one turned.
fn add_strip(mesh: &mut MeshParts, strip: &[u32]) {
    for (at, corners) in strip.windows(3).enumerate() {
        let turned = [corners[1], corners[0], corners[2]];
        let even = [corners[0], corners[1], corners[2]];
        mesh.triangles.push(if at % 2 == 0 { even } else { turned });
    }
}

/// The cells of a list `offsets` (n + 1 ascending positions, from 0) into `connectivity`;
/// `None` if an offset is out of order or range.
pub(crate) fn cell_ranges(offsets: &[usize], connectivity: usize) -> Option<Vec<[usize; 2]>> {
    let ordered = |pair: &[usize]| {
        (pair[0] <= pair[1] && pair[1] <= connectivity).then_some([pair[0], pair[1]])
    };
    offsets.windows(2).map(ordered).collect()
}
