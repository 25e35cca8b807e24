//! Gmsh `.msh` in text, versions 2.2 and 4.1: first-order tetrahedra, triangles, quadrangles.
//!
//! Scalar `$NodeData` become vertex data. Sections of one name and time step (one per partition) are
//! one field, a later step of a field replaces the earlier; a field that leaves out a node of a
//! tetrahedron, or gives it two values, is refused where it is used. Points and lines are passed over; other volume elements are
//! refused, because leaving them out would leave holes. Format: Gmsh reference manual, section
//! "MSH file format" (4.1) and its legacy section (2.2).

use std::collections::HashMap;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshParts, no_tetrahedron};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;

/// Reads tetrahedra, or the surface of a file without any.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Mesh, ParseError> {
    let mut file = GmshFile {
        words: Words::new(bytes, None),
        version: Version::Four,
        tags: HashMap::new(),
        mesh: MeshParts::default(),
        steps: Vec::new(),
    };
    while let Some(section) = file.words.word() {
        let section = section.to_ascii_lowercase();
        match section.as_slice() {
            b"$meshformat" => file.read_format()?,
            b"$nodes" | b"$parametricnodes" => file.read_nodes()?,
            b"$elements" => file.read_elements()?,
            b"$nodedata" => file.read_node_data()?,
            _ if section.starts_with(b"$") => {}
            _ => return Err(file.words.unexpected("a section such as $Nodes", &section)),
        }
        file.skip_to_end(&section)?;
    }
    let mut names: Vec<usize> = vec![0; file.mesh.vertices.len()];
    for (&tag, &vertex) in &file.tags {
        if let Some(name) = names.get_mut(vertex as usize) {
            *name = tag;
        }
    }
    let node = |vertex: usize| format!("node {}", names[vertex]);
    file.mesh.into_mesh(node)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

struct GmshFile<'a> {
    words: Words<'a>,
    version: Version,
    /// Node tag → vertex.
    tags: HashMap<usize, u32>,
    mesh: MeshParts,
    /// The time step of every field of the mesh's point data.
    steps: Vec<usize>,
}

impl GmshFile<'_> {
    fn read_format(&mut self) -> Result<(), ParseError> {
        let version = self.words.some_word("a version")?;
        self.version = match version {
            b"2" | b"2.0" | b"2.1" | b"2.2" => Version::Two,
            b"4.1" => Version::Four,
            _ => {
                let what = format!("Gmsh's format {}", shown(version));
                let mend = "export version 4.1 or 2.2 (gmsh -save -format msh41)";
                return Err(self.words.unsupported(what, mend));
            }
        };
        if self.words.count("0 for a text file")? == 0 {
            return Ok(());
        }
        let mend = "export it as text (Mesh.Binary = 0)";
        Err(self.words.unsupported("a binary .msh file", mend))
    }

    fn read_nodes(&mut self) -> Result<(), ParseError> {
        if self.version == Version::Two {
            let count = self.words.count("the number of nodes")?;
            for _ in 0..count {
                let tag = self.words.count("a node's number")?;
                self.add_tag(tag)?;
                self.add_vertex()?;
            }
            return Ok(());
        }
        let blocks = self.words.count("the number of node blocks")?;
        let announced = self.words.count("the number of nodes")?;
        self.words.next_line();
        for _ in 0..blocks {
            self.read_node_block()?;
        }
        let found = self.mesh.vertices.len();
        self.words.check_count("nodes", announced, found)
    }

    fn read_node_block(&mut self) -> Result<(), ParseError> {
        self.words.count("an entity's dimension")?;
        self.words.integer("an entity's number")?;
        self.words.count("0 or 1 for parametric")?;
        let count = self.words.count("the number of nodes in the block")?;
        for _ in 0..count {
            let tag = self.words.count("a node's number")?;
            self.add_tag(tag)?;
        }
        for _ in 0..count {
            self.add_vertex()?;
        }
        Ok(())
    }

    /// Numbers the next vertex `tag`.
    fn add_tag(&mut self, tag: usize) -> Result<(), ParseError> {
        let vertex = self.words.check_limit("nodes", self.tags.len())?;
        if self.tags.insert(tag, vertex as u32).is_none() {
            return Ok(());
        }
        let expected = "a node number not used before";
        Err(self.words.unexpected(expected, tag.to_string().as_bytes()))
    }

    /// Reads the coordinates of a vertex; parameters after them on the line are passed over.
    fn add_vertex(&mut self) -> Result<(), ParseError> {
        self.mesh.vertices.push(self.words.point_on_line()?);
        self.words.next_line();
        Ok(())
    }

    fn read_elements(&mut self) -> Result<(), ParseError> {
        if self.version == Version::Two {
            let count = self.words.count("the number of elements")?;
            for _ in 0..count {
                self.words.count("an element's number")?;
                let kind = self.words.count("an element's type")?;
                for _ in 0..self.words.count("the number of tags")? {
                    self.words.integer("a tag")?;
                }
                self.read_element(kind)?;
            }
            return Ok(());
        }
        let blocks = self.words.count("the number of element blocks")?;
        let announced = self.words.count("the number of elements")?;
        self.words.next_line();
        let mut found = 0;
        for _ in 0..blocks {
            found += self.read_element_block()?;
        }
        self.words.check_count("elements", announced, found)
    }

    /// Reads a block of elements of one type; returns their number.
    fn read_element_block(&mut self) -> Result<usize, ParseError> {
        self.words.count("an entity's dimension")?;
        self.words.integer("an entity's number")?;
        let kind = self.words.count("an element's type")?;
        let count = self.words.count("the number of elements in the block")?;
        for _ in 0..count {
            self.words.count("an element's number")?;
            self.read_element(kind)?;
        }
        Ok(count)
    }

    /// Reads an element's nodes: type 2 is a triangle, 3 a quadrangle, 4 a tetrahedron.
    fn read_element(&mut self, kind: usize) -> Result<(), ParseError> {
        match kind {
            2 => {
                let triangle = self.read_corners()?;
                self.mesh.triangles.push(triangle);
            }
            3 => {
                let quad: [u32; 4] = self.read_corners()?;
                triangulate(&self.mesh.vertices, &quad, &mut self.mesh.triangles);
            }
            4 => {
                let tet = self.read_corners()?;
                self.mesh.tets.push(tet);
            }
            // Points, lines of any order, and curved triangles and quadrangles: these bound curved
            // volumes, which are refused.
            1 | 8 | 9 | 10 | 15 | 16 | 20..=28 => {}
            _ => return Err(self.words.error(no_tetrahedron(kind))),
        }
        self.words.next_line();
        Ok(())
    }

    fn read_corners<const N: usize>(&mut self) -> Result<[u32; N], ParseError> {
        let mut corners = [0; N];
        for corner in &mut corners {
            let tag = self.words.count_on_line("a node's number")?;
            *corner = self.vertex(tag)?;
        }
        Ok(corners)
    }

    fn vertex(&self, tag: usize) -> Result<u32, ParseError> {
        let vertices = self.mesh.vertices.len();
        let vertex = self.tags.get(&tag).copied();
        let out_of_range = ErrorKind::OutOfRange {
            index: tag as i64,
            vertices,
            first: 1,
        };
        vertex
            .filter(|&vertex| (vertex as usize) < vertices)
            .ok_or_else(|| self.words.error(out_of_range))
    }

    /// Reads a scalar field; vectors and tensors are passed over.
    fn read_node_data(&mut self) -> Result<(), ParseError> {
        let name = self.read_name()?;
        for _ in 0..self.words.count("the number of real tags")? {
            self.words.value()?;
        }
        let integers = self.words.count("the number of integer tags")?;
        let mut layout = [0; 3];
        for at in 0..integers {
            let value = self.words.count("an integer tag")?;
            if let Some(slot) = layout.get_mut(at) {
                *slot = value;
            }
        }
        let [step, components, count] = layout;
        if components != 1 {
            return Ok(());
        }
        let field = self.field_of(name, step);
        self.read_values(field, count)
    }

    /// The place of a field in the mesh's point data, emptied if it was of another time step.
    fn field_of(&mut self, name: String, step: usize) -> usize {
        let fields = &mut self.mesh.point_data;
        let place = fields.iter().position(|field| field.name() == name);
        let field = place.unwrap_or(fields.len());
        if place.is_some() && self.steps[field] == step {
            return field;
        }
        let empty = PointData::empty(name, self.mesh.vertices.len());
        if place.is_some() {
            fields[field] = empty;
            self.steps[field] = step;
        } else {
            fields.push(empty);
            self.steps.push(step);
        }
        field
    }

    /// Reads the string tags, one a line; returns the first, the field's name, without quotes.
    fn read_name(&mut self) -> Result<String, ParseError> {
        let mut name = String::new();
        let tags = self.words.count("the number of string tags")?;
        self.words.next_line();
        for at in 0..tags {
            if self.words.peek().is_none() {
                return Err(self.words.truncated("a string tag"));
            }
            let text = self.words.rest_of_line();
            if at == 0 {
                let inside = text.strip_prefix(b"\"");
                let inside = inside.and_then(|text| text.strip_suffix(b"\""));
                name = shown(inside.unwrap_or(text));
            }
        }
        Ok(name)
    }

    fn read_values(&mut self, field: usize, count: usize) -> Result<(), ParseError> {
        for _ in 0..count {
            let tag = self.words.count("a node's number")?;
            let vertex = self.vertex(tag)?;
            let value = self.words.value_on_line()?;
            self.mesh.point_data[field].set(vertex, value);
        }
        Ok(())
    }

    /// Moves past the line `$End…` of a section, whose name is given in small letters.
    fn skip_to_end(&mut self, section: &[u8]) -> Result<(), ParseError> {
        let is_counted = [&b"$nodes"[..], b"$parametricnodes", b"$elements"].contains(&section);
        loop {
            let word = self.words.some_word("the end of a section")?;
            let end = word.to_ascii_lowercase();
            if end.strip_prefix(b"$end") == section.strip_prefix(b"$") {
                return Ok(());
            }
            if is_counted {
                let expected = "the end of a section, its count was too low";
                return Err(self.words.unexpected(expected, word));
            }
            self.words.next_line();
        }
    }
}
