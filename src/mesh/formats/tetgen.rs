//! TetGen's pair of files: `.node` with the vertices, `.ele` with the tetrahedra.
//!
//! Numbering starts at 0 or 1 as the first vertex says. Vertex attributes become vertex data
//! named `attribute1`, `attribute2`, …; boundary markers and region numbers are passed over. Tetrahedra
//! of ten nodes (`tetgen -o2`) are read by their corners where all edges are straight.

use nalgebra::Point3;

use crate::mesh::formats::error::ParseError;
use crate::mesh::formats::mesh::{Mesh, MeshFile, MeshParts, no_tetrahedron};
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::words::Words;
use crate::mesh::tets::{TetMesh, VertexData};

/// The vertices of a `.node` file.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// The number of the first vertex, 0 or 1.
    pub first: i64,
    /// Positions (L).
    pub vertices: Vec<Point3<f64>>,
    /// The attributes.
    pub vertex_data: Vec<VertexData>,
}

impl Nodes {
    /// The vertices with their attributes, to which elements are added.
    fn into_parts(self) -> MeshParts {
        let vertices = self.vertices.len();
        let data = self.vertex_data.into_iter();
        let data = data.map(|field| PointData::of(field.name, field.values, vertices));
        MeshParts {
            point_data: data.collect(),
            vertices: self.vertices,
            ..MeshParts::default()
        }
    }
}

/// Reads a `.node` file.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse_nodes(bytes: &[u8]) -> Result<Nodes, ParseError> {
    let mut words = Words::new(bytes, Some(b'#'));
    let count = words.size("the number of vertices", "vertices")?;
    let mut nodes = Nodes {
        first: 0,
        vertices: Vec::with_capacity(words.capacity_for(count, 8)),
        vertex_data: read_layout(&mut words)?,
    };
    for number in 0..count as i64 {
        words.next_line();
        read_node(&mut words, number, &mut nodes)?;
    }
    words.next_line();
    check_end(&mut words, "vertices", count)?;
    Ok(nodes)
}

/// Reads the line of the vertex with zero-based index `number`.
fn read_node(words: &mut Words<'_>, number: i64, nodes: &mut Nodes) -> Result<(), ParseError> {
    let written = words.integer("a vertex number")?;
    if number == 0 && written == 1 {
        nodes.first = 1;
    }
    if written != number + nodes.first {
        let expected = "vertices numbered without gaps from 0 or 1";
        return Err(words.unexpected(expected, written.to_string().as_bytes()));
    }
    let mut value = || words.number_on_line("a coordinate");
    let point = Point3::new(value()?, value()?, value()?);
    nodes.vertices.push(point);
    for field in &mut nodes.vertex_data {
        field.values.push(words.value_on_line()?);
    }
    Ok(())
}

/// Reads the `.ele` file that belongs to `nodes`.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse_elements(bytes: &[u8], nodes: Nodes) -> Result<TetMesh, ParseError> {
    match read_elements(bytes, nodes)?.mesh {
        Mesh::Tets(tets) => Ok(tets),
        Mesh::Surface(_) => Err(no_tetrahedra()),
    }
}

/// As [`parse_elements`], with what there is to say about the file.
pub(crate) fn read_elements(bytes: &[u8], nodes: Nodes) -> Result<MeshFile, ParseError> {
    let mut words = Words::new(bytes, Some(b'#'));
    let count = words.size("the number of tetrahedra", "tetrahedra")?;
    let corners = words.count_on_line("4 corners per tetrahedron, or 10 nodes")?;
    if corners != 4 && corners != 10 {
        return Err(words.error(no_tetrahedron(format!("{corners}-node tetrahedron"))));
    }
    let (first, vertices) = (nodes.first, nodes.vertices.len());
    let mut mesh = nodes.into_parts();
    mesh.tets.reserve(words.capacity_for(count, 10));
    let mut tet = Vec::with_capacity(corners);
    for _ in 0..count {
        words.next_line();
        words.integer("a tetrahedron's number")?;
        tet.clear();
        for _ in 0..corners {
            tet.push(words.vertex_on_line(vertices, first)?);
        }
        mesh.add_tet(&tet).map_err(|kind| words.error(kind))?;
    }
    words.next_line();
    check_end(&mut words, "tetrahedra", count)?;
    if mesh.tets.is_empty() {
        return Err(no_tetrahedra());
    }
    mesh.into_mesh(|vertex| format!("vertex {}", vertex as i64 + first))
}

fn no_tetrahedra() -> ParseError {
    ParseError::missing("tetrahedra", "run TetGen again")
}

/// The rest of the first line: dimension, number of attributes, which become empty fields.
fn read_layout(words: &mut Words<'_>) -> Result<Vec<VertexData>, ParseError> {
    let dimension = words.count_on_line("a dimension")?;
    if dimension != 3 {
        let what = format!("a mesh of dimension {dimension}");
        return Err(words.unsupported(what, "export it with three coordinates a vertex"));
    }
    let attributes = match words.word_on_line() {
        None => 0,
        Some(word) => words.parse_count(word, "the number of attributes")?,
    };
    let attributes = words.capacity_for(attributes, 2);
    let field = |number| VertexData::new(&format!("attribute{number}"), Vec::new());
    Ok((1..=attributes).map(field).collect())
}

/// Refuses lines after the announced ones.
fn check_end(
    words: &mut Words<'_>,
    what: &'static str,
    announced: usize,
) -> Result<(), ParseError> {
    let found = announced + usize::from(words.word().is_some());
    words.check_count(what, announced, found)
}
