//! Gmsh `.msh`, text or binary of either byte order, versions 1, 2, 4.0 and 4.1: tetrahedra, triangles
//! and quadrangles of first order, or of second order with straight edges (`second_order`).
//!
//! Physical groups and scalar `$ElementData` are kept. Scalar `$NodeData` become vertex data. Sections of one name and time step (one per partition) are
//! one field, a later step of a field replaces the earlier; a field that leaves out a node of a
//! tetrahedron, or gives it two values, is refused where it is used. Points and lines are passed over; other volume elements are
//! refused, because leaving them out would leave holes. Format: Gmsh reference manual, section
//! "MSH file format" (4.1) and its legacy sections (1, 2, 4.0).

use std::collections::HashMap;

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::gmsh_groups::GmshGroups;
use crate::mesh::formats::gmsh_input::{GmshBinary, GmshInput};
use crate::mesh::formats::mesh::{Mesh, MeshFile, MeshParts, no_tetrahedron};
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;

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
    let mut file = GmshFile::new(bytes);
    while let Some(section) = file.input.words.word() {
        let section = section.to_ascii_lowercase();
        file.read_section(&section)?;
        file.skip_to_end(&section)?;
    }
    file.into_mesh()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    One,
    Two,
    FourZero,
    Four,
}

/// A file as far as it is read.
pub(crate) struct GmshFile<'a> {
    pub(crate) input: GmshInput<'a>,
    version: Version,
    /// Node tag → vertex.
    pub(crate) tags: HashMap<usize, u32>,
    pub(crate) mesh: MeshParts,
    /// The time step of every field of the mesh's point data.
    pub(crate) steps: Vec<usize>,
    /// Whether triangles or quadrangles of order above two were passed over.
    has_high_order: bool,
    groups: GmshGroups,
    /// The numbers of the tetrahedra.
    pub(crate) tet_tags: Vec<usize>,
}

impl<'a> GmshFile<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let words = Words::new(bytes, None);
        Self {
            input: GmshInput {
                words,
                binary: None,
            },
            version: Version::Four,
            tags: HashMap::new(),
            mesh: MeshParts::default(),
            steps: Vec::new(),
            has_high_order: false,
            groups: GmshGroups::default(),
            tet_tags: Vec::new(),
        }
    }

    fn into_mesh(mut self) -> Result<MeshFile, ParseError> {
        if self.has_high_order && self.mesh.tets.is_empty() {
            let what = "a surface of elements of order above two";
            let mend = "export first-order elements (Mesh.ElementOrder = 1)";
            return Err(ParseError::whole(ErrorKind::unsupported(what, mend)));
        }
        self.mesh.tet_cells = (0..self.mesh.tets.len() as u32).collect();
        let mut names: Vec<usize> = vec![0; self.mesh.vertices.len()];
        for (&tag, &vertex) in &self.tags {
            if let Some(name) = names.get_mut(vertex as usize) {
                *name = tag;
            }
        }
        self.mesh
            .into_mesh(|vertex| format!("node {}", names[vertex]))
    }

    fn read_format(&mut self) -> Result<(), ParseError> {
        let words = &mut self.input.words;
        let version = words.some_word("a version")?;
        self.version = match version {
            b"1" | b"1.0" => Version::One,
            b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
            b"4" | b"4.0" => Version::FourZero,
            b"4.1" => Version::Four,
            _ => {
                let what = format!("Gmsh's format {}", shown(version));
                let mend = "export version 4.1 or 2.2 (gmsh -save -format msh41)";
                return Err(words.unsupported(what, mend));
            }
        };
        if words.count("0 for text or 1 for binary")? == 0 {
            return Ok(());
        }
        let size = match words.count("the width of sizes in bytes")? {
            4 => Scalar::UInt32,
            8 => Scalar::UInt64,
            other => {
                let expected = "a width of 4 or 8 bytes";
                return Err(words.unexpected(expected, other.to_string().as_bytes()));
            }
        };
        words.next_line();
        self.read_byte_order(size)
    }

    /// Reads the 1 that tells a binary file's byte order.
    fn read_byte_order(&mut self, size: Scalar) -> Result<(), ParseError> {
        let big_endian = match self.input.words.take(4) {
            Some([1, 0, 0, 0]) => false,
            Some([0, 0, 0, 1]) => true,
            Some(bytes) => {
                let kind = ErrorKind::expected("the number 1 in four bytes", shown(bytes));
                return Err(ParseError::at_byte(self.input.words.position() - 4, kind));
            }
            None => return Err(self.input.words.truncated("the byte order")),
        };
        self.input.binary = Some(GmshBinary { big_endian, size });
        Ok(())
    }

    /// Reads a section of version 1, which has no `$MeshFormat`.
    fn read_old(
        &mut self,
        read: impl Fn(&mut Self) -> Result<(), ParseError>,
    ) -> Result<(), ParseError> {
        self.version = Version::One;
        read(self)
    }

    /// Nodes of version 2, each with the entity it lies on and its parameters there; in text these
    /// stand behind the coordinates.
    fn read_parametric_nodes(&mut self) -> Result<(), ParseError> {
        if self.input.binary.is_none() {
            return self.read_nodes();
        }
        let count = self.input.words.count("the number of nodes")?;
        self.input.start_data();
        for _ in 0..count {
            let tag = self.input.count("a node's number")?;
            self.add_tag(tag)?;
            self.mesh.vertices.push(self.input.point(0)?);
            let dimension = self.input.count("an entity's dimension")?;
            self.input.integer("an entity's number")?;
            // Vertices and volumes have no parameters.
            for _ in 0..dimension % 3 {
                self.input.value()?;
            }
        }
        Ok(())
    }

    fn read_nodes(&mut self) -> Result<(), ParseError> {
        if matches!(self.version, Version::One | Version::Two) {
            let count = self.input.words.count("the number of nodes")?;
            self.input.start_data();
            for _ in 0..count {
                let tag = self.input.count("a node's number")?;
                self.add_tag(tag)?;
                self.mesh.vertices.push(self.input.point(0)?);
            }
            return Ok(());
        }
        let (blocks, announced) = self.read_section_head("the number of node blocks")?;
        for _ in 0..blocks {
            match self.version {
                Version::Four => self.read_node_block()?,
                _ => self.read_old_node_block()?,
            }
        }
        let found = self.mesh.vertices.len();
        ErrorKind::check_count("nodes", announced, found).map_err(|kind| self.input.error(kind))
    }

    /// The numbers of blocks and of all that is in them.
    fn read_section_head(&mut self, what: &'static str) -> Result<(usize, usize), ParseError> {
        self.input.start_data();
        let blocks = self.input.size(what)?;
        let announced = self.input.size("the number of all")?;
        if self.version == Version::Four && self.input.binary.is_some() {
            self.input.size("the smallest number")?;
            self.input.size("the greatest number")?;
        }
        self.input.end_line();
        Ok((blocks, announced))
    }

    fn read_node_block(&mut self) -> Result<(), ParseError> {
        let dimension = self.input.count("an entity's dimension")?;
        self.input.integer("an entity's number")?;
        let parametric = self.input.count("0 or 1 for parametric")?;
        let count = self.input.size("the number of nodes in the block")?;
        for _ in 0..count {
            let tag = self.input.size("a node's number")?;
            self.add_tag(tag)?;
        }
        let parameters = if parametric == 0 { 0 } else { dimension };
        for _ in 0..count {
            self.mesh.vertices.push(self.input.point(parameters)?);
        }
        Ok(())
    }

    /// A block of version 4.0, where every node has its number before its coordinates.
    fn read_old_node_block(&mut self) -> Result<(), ParseError> {
        self.input.integer("an entity's number")?;
        let dimension = self.input.count("an entity's dimension")?;
        let parametric = self.input.count("0 or 1 for parametric")?;
        let count = self.input.size("the number of nodes in the block")?;
        let parameters = if parametric == 0 { 0 } else { dimension };
        for _ in 0..count {
            let tag = self.input.count("a node's number")?;
            self.add_tag(tag)?;
            self.mesh.vertices.push(self.input.point(parameters)?);
        }
        Ok(())
    }

    /// Numbers the next vertex `tag`.
    fn add_tag(&mut self, tag: usize) -> Result<(), ParseError> {
        let vertex = ErrorKind::check_limit("nodes", self.tags.len());
        let vertex = vertex.map_err(|kind| self.input.error(kind))?;
        if self.tags.insert(tag, vertex as u32).is_none() {
            return Ok(());
        }
        let expected = "a node number not used before";
        Err(self
            .input
            .error(ErrorKind::expected(expected, tag.to_string())))
    }

    fn read_elements(&mut self) -> Result<(), ParseError> {
        match (self.version, self.input.binary) {
            (Version::One | Version::Two, None) => self.read_element_lines(),
            (Version::One | Version::Two, Some(_)) => self.read_element_runs(),
            _ => {
                let (blocks, announced) = self.read_section_head("the number of element blocks")?;
                let mut found = 0_usize;
                for _ in 0..blocks {
                    found = found.saturating_add(self.read_element_block()?);
                }
                ErrorKind::check_count("elements", announced, found)
                    .map_err(|kind| self.input.error(kind))
            }
        }
    }

    /// Elements of versions 1 and 2 in text, each on its line.
    fn read_element_lines(&mut self) -> Result<(), ParseError> {
        let count = self.input.words.count("the number of elements")?;
        for _ in 0..count {
            let number = self.input.count("an element's number")?;
            let kind = self.input.count("an element's type")?;
            // Version 1 has two regions and the number of nodes, version 2 counts its tags.
            let tags = match self.version {
                Version::One => 3,
                _ => self.input.count("the number of tags")?,
            };
            let mut physical = None;
            for _ in 0..tags {
                let tag = self.input.integer("a tag")?;
                physical.get_or_insert(tag);
            }
            self.read_element(kind, false)?;
            self.label(number, |groups| groups.name(dimension_of(kind), physical));
        }
        Ok(())
    }

    /// Elements of version 2 in binary: runs of one type with one number of tags.
    fn read_element_runs(&mut self) -> Result<(), ParseError> {
        let count = self.input.words.count("the number of elements")?;
        self.input.start_data();
        let mut found = 0_usize;
        while found < count {
            let kind = self.input.count("an element's type")?;
            let run = self.input.count("the number of elements of this type")?;
            let tags = self.input.count("the number of tags")?;
            for _ in 0..run {
                let number = self.input.count("an element's number")?;
                let physical = self.first_tag(tags)?;
                self.read_element(kind, false)?;
                self.label(number, |groups| groups.name(dimension_of(kind), physical));
            }
            // A run of none must not go on forever.
            found = found.saturating_add(run.max(1));
        }
        Ok(())
    }

    /// The first of an element's tags, all of which are read.
    fn first_tag(&mut self, tags: usize) -> Result<Option<i64>, ParseError> {
        let mut first = None;
        for _ in 0..tags {
            let tag = self.input.integer("a tag")?;
            first.get_or_insert(tag);
        }
        Ok(first)
    }

    /// Reads a block of elements of one type; returns their number.
    fn read_element_block(&mut self) -> Result<usize, ParseError> {
        let first = self.input.integer("an entity's dimension or number")?;
        let second = self.input.integer("an entity's number or dimension")?;
        let kind = self.input.count("an element's type")?;
        let count = self.input.size("the number of elements in the block")?;
        let is_wide = self.version == Version::Four;
        let entity = if is_wide { second } else { first };
        for _ in 0..count {
            let number = match is_wide {
                true => self.input.size("an element's number")?,
                false => self.input.count("an element's number")?,
            };
            self.read_element(kind, is_wide)?;
            self.label(number, |groups| {
                groups.name_of_entity(dimension_of(kind), entity)
            });
        }
        Ok(count)
    }

    /// Labels what the element of this number added, if anything.
    fn label(&mut self, number: usize, group: impl Fn(&GmshGroups) -> String) {
        let labeled = self.mesh.triangle_groups.of_elements().len()
            + self.mesh.tet_groups.of_elements().len();
        if labeled < self.mesh.triangles.len() + self.mesh.tets.len() {
            self.mesh.label(&group(&self.groups));
            self.tet_tags.resize(self.mesh.tets.len(), number);
        }
    }

    /// Reads which physical group entities belong to; what cannot be read is passed over.
    fn read_entities(&mut self) {
        let before = self.input.clone();
        let is_old = self.version == Version::FourZero;
        if self.groups.read_entities(&mut self.input, is_old).is_err() {
            self.input = before;
        }
    }

    /// Reads an element's nodes; `is_wide` where their numbers are sizes.
    fn read_element(&mut self, kind: usize, is_wide: bool) -> Result<(), ParseError> {
        let Some(count) = node_count(kind) else {
            return Err(self.input.error(no_tetrahedron(kind)));
        };
        if is_passed_over(kind) {
            self.has_high_order |= (20..=25).contains(&kind);
            for _ in 0..count * usize::from(self.input.binary.is_some()) {
                self.input.corner(is_wide)?;
            }
            self.input.end_line();
            return Ok(());
        }
        let mut nodes = [0; 10];
        let nodes = &mut nodes[..count];
        for node in nodes.iter_mut() {
            let tag = self.input.corner(is_wide)?;
            *node = self.vertex(tag)?;
        }
        let added = match (kind, &*nodes) {
            (2, &[a, b, c]) => {
                self.mesh.triangles.push([a, b, c]);
                Ok(())
            }
            (3, quad) => {
                triangulate(&self.mesh.vertices, quad, &mut self.mesh.triangles);
                Ok(())
            }
            (4 | 11, tet) => self.mesh.add_tet(tet),
            (_, face) => self.mesh.add_second_order_face(face),
        };
        added.map_err(|kind| self.input.error(kind))?;
        self.input.end_line();
        Ok(())
    }

    /// The vertex of a node's number.
    pub(crate) fn vertex(&self, tag: usize) -> Result<u32, ParseError> {
        let vertices = self.mesh.vertices.len();
        let vertex = self.tags.get(&tag).copied();
        let out_of_range = ErrorKind::OutOfRange {
            index: tag as i64,
            vertices,
            first: 1,
        };
        vertex
            .filter(|&vertex| (vertex as usize) < vertices)
            .ok_or_else(|| self.input.error(out_of_range))
    }

    /// Moves past the line `$End…` of a section, whose name is given in small letters.
    fn skip_to_end(&mut self, section: &[u8]) -> Result<(), ParseError> {
        if self.input.binary.is_some() {
            return self.skip_to_binary_end(section);
        }
        let counted = ["$nodes", "$parametricnodes", "$elements", "$nod", "$elm"];
        let is_counted = counted.iter().any(|name| name.as_bytes() == section);
        loop {
            let word = self.input.words.some_word("the end of a section")?;
            let end = word.to_ascii_lowercase();
            if end.strip_prefix(b"$end") == section.strip_prefix(b"$") {
                return Ok(());
            }
            if is_counted {
                let expected = "the end of a section, its count was too low";
                return Err(self.input.words.unexpected(expected, word));
            }
            self.input.words.next_line();
        }
    }

    fn skip_to_binary_end(&mut self, section: &[u8]) -> Result<(), ParseError> {
        let end = [b"$end", &section[1..]].concat();
        let expected = "the end of a section";
        match self.input.words.skip_past(&end) {
            true => Ok(()),
            false => Err(self.input.error(ErrorKind::Truncated { expected })),
        }
    }

    /// Reads the content of a section, whose name is given in small letters, as far as it is of use.
    fn read_section(&mut self, section: &[u8]) -> Result<(), ParseError> {
        match section {
            b"$meshformat" => self.read_format()?,
            b"$nod" => self.read_old(GmshFile::read_nodes)?,
            b"$elm" => self.read_old(GmshFile::read_elements)?,
            b"$nodes" => self.read_nodes()?,
            b"$parametricnodes" => self.read_parametric_nodes()?,
            b"$elements" => self.read_elements()?,
            b"$nodedata" => self.read_node_data()?,
            b"$elementdata" => self.read_element_data()?,
            b"$physicalnames" => self.groups.read_names(&mut self.input)?,
            b"$entities" => self.read_entities(),
            _ if section.starts_with(b"$") => {}
            _ => {
                let expected = ErrorKind::expected("a section such as $Nodes", shown(section));
                return Err(self.input.error(expected));
            }
        }
        Ok(())
    }
}

/// The number of nodes of an element's type, `None` for volumes other than tetrahedra of first and
/// second order.
fn node_count(kind: usize) -> Option<usize> {
    Some(match kind {
        15 => 1,
        1 => 2,
        2 | 8 => 3,
        3 | 4 | 26 => 4,
        27 => 5,
        9 | 28 => 6,
        16 => 8,
        10 | 20 => 9,
        11 | 21 => 10,
        22 => 12,
        23 | 24 => 15,
        25 => 21,
        _ => return None,
    })
}

/// Points, lines of any order, and triangles of order above two: these bound curved volumes, which
/// are refused.
fn is_passed_over(kind: usize) -> bool {
    matches!(kind, 1 | 8 | 15 | 20..=28)
}

/// The dimension of an element by its type, of those that are read.
fn dimension_of(kind: usize) -> usize {
    if matches!(kind, 4 | 11) { 3 } else { 2 }
}
