//! Legacy VTK in text: unstructured grids of tetrahedra (or surface cells), polygonal data.
//!
//! Scalars of the points (SCALARS and one-component arrays of FIELD) become vertex data; other
//! attributes and all cell data are passed over. Keywords are read in any case. Both layouts of CELLS are read: counts before
//! each cell (versions up to 4.2) and OFFSETS with CONNECTIVITY (5.1). Format: "VTK File
//! Formats", Kitware.

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshParts, no_tetrahedron};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;

/// VTK's number for polygons.
const POLYGON: u32 = 7;

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    let mut words = Words::new(bytes, None);
    words.next_line();
    words.next_line();
    let encoding = words.some_word("ASCII")?;
    if !encoding.eq_ignore_ascii_case(b"ascii") {
        let what = format!("a {} .vtk file", shown(encoding));
        return Err(words.unsupported(what, "export it as ASCII or as .vtu"));
    }
    let mut file = VtkFile {
        words,
        mesh: MeshParts::default(),
        cells: Vec::new(),
        kinds: Vec::new(),
        tuples: None,
    };
    while let Some(keyword) = file.words.word() {
        let keyword = keyword.to_ascii_uppercase();
        file.read_section(&keyword)?;
    }
    file.into_mesh()
}

/// The owner of the data that follow, points or cells, and the number of tuples.
#[derive(Clone, Copy, Debug)]
struct Tuples {
    of_points: bool,
    count: usize,
}

struct VtkFile<'a> {
    words: Words<'a>,
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
            b"POLYGONS" => {
                self.cells = self.read_cells()?;
                self.kinds = vec![POLYGON; self.cells.len()];
            }
            b"VERTICES" | b"LINES" => drop(self.read_cells()?),
            b"CELL_TYPES" => self.read_kinds()?,
            b"POINT_DATA" => self.start_data(true)?,
            b"CELL_DATA" => self.start_data(false)?,
            b"METADATA" => self.skip_metadata(),
            b"FIELD" => self.read_field()?,
            _ => self.read_attribute(keyword)?,
        }
        Ok(())
    }

    fn read_dataset(&mut self) -> Result<(), ParseError> {
        let kind = self.words.some_word("the kind of data set")?;
        if is(kind, "UNSTRUCTURED_GRID") || is(kind, "POLYDATA") {
            return Ok(());
        }
        let what = format!("a VTK data set of kind {}", shown(kind));
        let mend = "export an UNSTRUCTURED_GRID of tetrahedra or POLYDATA";
        Err(self.words.unsupported(what, mend))
    }

    fn read_points(&mut self) -> Result<(), ParseError> {
        let count = self.words.size("the number of points", "points")?;
        self.words.some_word_on_line("a number type")?;
        self.mesh
            .vertices
            .reserve(self.words.capacity_for(count, 6));
        for _ in 0..count {
            self.mesh.vertices.push(self.words.point()?);
        }
        Ok(())
    }

    fn read_cells(&mut self) -> Result<Vec<Vec<u32>>, ParseError> {
        let first = self.words.count("the number of cells")?;
        let second = self.words.count("the size of the cell list")?;
        if self.is_next("OFFSETS") {
            return self.read_offset_cells(first, second);
        }
        let mut cells = Vec::with_capacity(self.words.capacity_for(first, 4));
        let mut found = 0;
        for _ in 0..first {
            let corners = self.words.count("a cell's number of vertices")?;
            cells.push(self.read_cell(corners)?);
            found += corners + 1;
        }
        let what = "numbers in the cell list";
        self.words.check_count(what, second, found)?;
        Ok(cells)
    }

    fn read_cell(&mut self, corners: usize) -> Result<Vec<u32>, ParseError> {
        let vertices = self.mesh.vertices.len();
        (0..corners)
            .map(|_| self.words.vertex(vertices, 0))
            .collect()
    }

    fn read_offset_cells(
        &mut self,
        offsets: usize,
        size: usize,
    ) -> Result<Vec<Vec<u32>>, ParseError> {
        self.words.word();
        self.words.some_word_on_line("a number type")?;
        let offsets: Vec<usize> = (0..offsets)
            .map(|_| self.words.count("an offset"))
            .collect::<Result<_, _>>()?;
        let keyword = self.words.some_word("CONNECTIVITY")?;
        if !is(keyword, "CONNECTIVITY") {
            return Err(self.words.unexpected("CONNECTIVITY", keyword));
        }
        self.words.some_word_on_line("a number type")?;
        let connectivity = self.read_cell(size)?;
        let ranges = cell_ranges(&offsets, size);
        let ranges = ranges.ok_or_else(|| self.words.unexpected("ascending offsets", b"others"))?;
        let cell = |[start, end]: [usize; 2]| connectivity[start..end].to_vec();
        Ok(ranges.into_iter().map(cell).collect())
    }

    fn read_kinds(&mut self) -> Result<(), ParseError> {
        let count = self.words.count("the number of cell types")?;
        for _ in 0..count {
            let kind = self.words.count("a cell type")?;
            self.kinds.push(u32::try_from(kind).unwrap_or(u32::MAX));
        }
        Ok(())
    }

    fn start_data(&mut self, of_points: bool) -> Result<(), ParseError> {
        let count = self.words.count("the number of data")?;
        self.tuples = Some(Tuples { of_points, count });
        Ok(())
    }

    /// Reads an attribute of POINT_DATA or CELL_DATA.
    fn read_attribute(&mut self, keyword: &[u8]) -> Result<(), ParseError> {
        let Some(Tuples { count, .. }) = self.tuples else {
            return Err(self.words.unexpected("a section such as POINTS", keyword));
        };
        match keyword {
            b"SCALARS" => self.read_scalars(count),
            b"GLOBAL_IDS" | b"PEDIGREE_IDS" | b"EDGE_FLAGS" => self.skip_array(count, 1),
            b"VECTORS" | b"NORMALS" => self.skip_array(count, 3),
            b"TENSORS" => self.skip_array(count, 9),
            b"TENSORS6" => self.skip_array(count, 6),
            b"LOOKUP_TABLE" => {
                self.words.some_word_on_line("a table's name")?;
                let size = self.words.count_on_line("a table's size")?;
                self.skip_values(b"", size, 4)
            }
            b"TEXTURE_COORDINATES" => {
                self.words.some_word_on_line("a name")?;
                let components = self.words.count_on_line("the number of components")?;
                self.words.some_word_on_line("a number type")?;
                self.skip_values(b"", count, components)
            }
            b"COLOR_SCALARS" => {
                self.words.some_word_on_line("a name")?;
                let components = self.words.count_on_line("the number of components")?;
                self.skip_values(b"", count, components)
            }
            _ => Err(self.words.unexpected("a kind of data", keyword)),
        }
    }

    fn read_scalars(&mut self, count: usize) -> Result<(), ParseError> {
        let name = shown(self.words.some_word_on_line("a name")?);
        let kind = self.words.some_word_on_line("a number type")?;
        let components = match self.words.word_on_line() {
            None => 1,
            Some(word) => self.words.parse_count(word, "the number of components")?,
        };
        if self.is_next("LOOKUP_TABLE") {
            self.words.word();
            self.words.some_word_on_line("a table's name")?;
        }
        self.read_array(name, kind, components, count)
    }

    /// Reads the arrays of a FIELD, in or outside POINT_DATA and CELL_DATA.
    fn read_field(&mut self) -> Result<(), ParseError> {
        self.words.some_word("a field's name")?;
        let arrays = self.words.count("the number of arrays")?;
        for _ in 0..arrays {
            if self.is_next("METADATA") {
                self.skip_metadata();
            }
            let name = shown(self.words.some_word("an array's name")?);
            let components = self.words.count("the number of components")?;
            let count = self.words.count("the number of tuples")?;
            let kind = self.words.some_word("a number type")?;
            self.read_array(name, kind, components, count)?;
        }
        Ok(())
    }

    /// Keeps one-component arrays of numbers of the points.
    fn read_array(
        &mut self,
        name: String,
        kind: &[u8],
        components: usize,
        count: usize,
    ) -> Result<(), ParseError> {
        let of_points = self.tuples.is_some_and(|tuples| tuples.of_points);
        if !of_points || components != 1 || is_text(kind) {
            return self.skip_values(kind, count, components);
        }
        let mut values = Vec::with_capacity(self.words.capacity_for(count, 2));
        for _ in 0..count {
            values.push(self.words.value()?);
        }
        let vertices = self.mesh.vertices.len();
        let field = PointData::of(name, values, vertices);
        self.mesh.point_data.push(field);
        Ok(())
    }

    /// Passes over an attribute with a name, a type and its values.
    fn skip_array(&mut self, count: usize, components: usize) -> Result<(), ParseError> {
        self.words.some_word_on_line("a name")?;
        let kind = self.words.some_word_on_line("a type")?;
        self.skip_values(kind, count, components)
    }

    /// Passes over values of a type: text stands one value a line, which may be empty.
    fn skip_values(
        &mut self,
        kind: &[u8],
        count: usize,
        components: usize,
    ) -> Result<(), ParseError> {
        let values = count.saturating_mul(components);
        if is_text(kind) {
            for _ in 0..=values {
                if !self.words.next_line() {
                    break;
                }
            }
            return Ok(());
        }
        for _ in 0..values {
            self.words.some_word("a value")?;
        }
        Ok(())
    }

    /// Whether the next word is this keyword.
    fn is_next(&self, keyword: &str) -> bool {
        self.words.peek().is_some_and(|word| is(word, keyword))
    }

    /// Moves past the empty line that ends a METADATA block.
    fn skip_metadata(&mut self) {
        self.words.word();
        self.words.next_line();
        while !self.words.rest_of_line().is_empty() {}
    }

    fn into_mesh(mut self) -> Result<Mesh, ParseError> {
        ErrorKind::check_count("cell types", self.cells.len(), self.kinds.len())
            .map_err(ParseError::whole)?;
        for (cell, &kind) in self.cells.iter().zip(&self.kinds) {
            add_cell(&mut self.mesh, kind, cell).map_err(ParseError::whole)?;
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

/// Whether values of this type are text, one a line.
fn is_text(kind: &[u8]) -> bool {
    ["string", "utf8_string", "unicode_string", "variant"]
        .iter()
        .any(|text| is(kind, text))
}

/// Adds a cell of VTK's type number `kind` over the vertices `cell`: tetrahedra (10), triangles
/// (5), polygons (7), quads (9), pixels (8). Vertices and lines (1 to 4) are passed over, all
/// else is refused.
pub(crate) fn add_cell(mesh: &mut MeshParts, kind: u32, cell: &[u32]) -> Result<(), ErrorKind> {
    match (kind, cell) {
        (10, &[a, b, c, d]) => mesh.tets.push([a, b, c, d]),
        (8, &[a, b, c, d]) => triangulate(&mesh.vertices, &[a, b, d, c], &mut mesh.triangles),
        (5 | 7 | 9, _) if cell.len() >= 3 => {
            triangulate(&mesh.vertices, cell, &mut mesh.triangles);
        }
        (1..=4, _) => {}
        (5 | 7..=10, _) => {
            return Err(ErrorKind::expected(
                "a cell with the vertices of its type",
                format!("type {kind} with {} vertices", cell.len()),
            ));
        }
        _ => return Err(no_tetrahedron(format!("VTK {kind}"))),
    }
    Ok(())
}

/// The cells of a list `offsets` (n + 1 ascending positions, from 0) into `connectivity`;
/// `None` if an offset is out of order or range.
pub(crate) fn cell_ranges(offsets: &[usize], connectivity: usize) -> Option<Vec<[usize; 2]>> {
    let ordered = |pair: &[usize]| {
        (pair[0] <= pair[1] && pair[1] <= connectivity).then_some([pair[0], pair[1]])
    };
    offsets.windows(2).map(ordered).collect()
}
