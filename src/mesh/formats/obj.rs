//! OBJ, the Wavefront format: polygons.
//!
//! Lines `v` and `f` are read, in all forms of `f` (v, v/vt, v//vn, v/vt/vn, negative indices
//! that count from the last vertex so far); all groups (`g`, else objects `o`) make one surface, but
//! which face is in which is kept. A face's vertices precede it. Lines that end in a backslash continue. Other lines are passed
//! over. Vertices are not split by normals or texture coordinates, which would open the
//! surface.

use nalgebra::Point3;

use crate::mesh::elements::{Elements, Groups};
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, not_empty};
use crate::mesh::formats::words::{Words, integer};
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;

/// Reads a surface; polygons are triangulated.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    read_mesh(bytes, &mut Labels::default())
}

/// As [`parse`], with the group and the polygon of every triangle.
pub(crate) fn parse_file(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut labels = Labels::default();
    let mesh = Mesh::Surface(read_mesh(bytes, &mut labels)?);
    let mut elements = labels.elements;
    elements.groups = if labels.has_groups {
        labels.groups.0
    } else {
        labels.objects.0
    };
    Ok(MeshFile::labeled(mesh, elements))
}

/// The labels of the triangles so far, and those that the next ones will have.
struct Labels {
    elements: Elements,
    has_groups: bool,
    /// By `g` and by `o`, each with the number of the current one.
    groups: (Groups, u32),
    objects: (Groups, u32),
    faces: u32,
}

impl Default for Labels {
    fn default() -> Self {
        let mut groups = Groups::default();
        let first = groups.named(UNNAMED);
        Self {
            elements: Elements::default(),
            has_groups: false,
            groups: (groups.clone(), first),
            objects: (groups, first),
            faces: 0,
        }
    }
}

/// The name of the group of faces before any line `g` or `o`.
const UNNAMED: &str = "default";

impl Labels {
    fn start_group(&mut self, name: &str) {
        self.groups.1 = self.groups.0.named(name);
        self.has_groups = true;
    }
    /// Labels the triangles up to `count`, of the next face.
    fn fill(&mut self, count: usize) {
        self.elements.polygons.resize(count, self.faces);
        self.faces += 1;
        for (groups, current) in [&mut self.groups, &mut self.objects] {
            groups.fill(count, *current);
        }
    }
}

fn read_mesh(bytes: &[u8], labels: &mut Labels) -> Result<SurfaceMesh, ParseError> {
    let mut words = Words::new(bytes, Some(b'#'));
    let mut mesh = SurfaceMesh::default();
    let mut polygon = Vec::new();
    while let Some(word) = words.word() {
        match word {
            b"v" | b"V" => mesh.vertices.push(vertex(&mut words)?),
            b"f" | b"F" => {
                face(&mut words, mesh.vertices.len(), &mut polygon)?;
                triangulate(&mesh.vertices, &polygon, &mut mesh.triangles);
                words.check_limit("triangles", mesh.triangles.len())?;
                labels.fill(mesh.triangles.len());
            }
            b"g" | b"G" => labels.start_group(&name(&mut words)),
            b"o" | b"O" => labels.objects.1 = labels.objects.0.named(&name(&mut words)),
            _ => {}
        }
        while same_line(&mut words).is_some() {}
        words.next_line();
    }
    not_empty(mesh, "faces", "export the mesh with its faces")
}

/// The rest of a line, its words joined by single spaces.
fn name(words: &mut Words<'_>) -> String {
    let mut name = String::new();
    while let Some(word) = same_line(words) {
        let space = if name.is_empty() { "" } else { " " };
        name = name + space + &String::from_utf8_lossy(word);
    }
    if name.is_empty() {
        return UNNAMED.to_owned();
    }
    name
}

fn vertex(words: &mut Words<'_>) -> Result<Point3<f64>, ParseError> {
    let mut coordinate = || {
        let expected = "a coordinate";
        let word = same_line(words).ok_or_else(|| words.line_ended(expected))?;
        words.parse_number(word, expected)
    };
    Ok(Point3::new(coordinate()?, coordinate()?, coordinate()?))
}

/// Reads a face's vertex indices into `polygon`.
fn face(words: &mut Words<'_>, vertices: usize, polygon: &mut Vec<u32>) -> Result<(), ParseError> {
    polygon.clear();
    while let Some(word) = same_line(words) {
        let number = word.split(|&byte| byte == b'/').next();
        let index = number.and_then(integer);
        let index = index.ok_or_else(|| words.unexpected("a vertex index", word))?;
        let offset = if index < 0 { vertices as i64 + 1 } else { 0 };
        let out_of_range = ErrorKind::OutOfRange {
            index,
            vertices,
            first: 1,
        };
        let vertex = ErrorKind::check_vertex(index + offset, vertices, 1);
        polygon.push(vertex.map_err(|_| words.error(out_of_range))?);
    }
    if polygon.len() < 3 {
        return Err(words.line_ended("a face of at least 3 vertices"));
    }
    Ok(())
}

/// The next word on this line or on those that continue it.
fn same_line<'a>(words: &mut Words<'a>) -> Option<&'a [u8]> {
    loop {
        let word = words.word_on_line()?;
        if word != b"\\" {
            return Some(word);
        }
        words.next_line();
    }
}
