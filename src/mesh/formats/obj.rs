//! OBJ, the Wavefront format: polygons.
//!
//! Lines `v` and `f` are read, in all forms of `f` (v, v/vt, v//vn, v/vt/vn, negative indices
//! that count from the last vertex so far); all groups and objects make one surface. A face's
//! vertices precede it. Lines that end in a backslash continue. Other lines are passed
//! over. Vertices are not split by normals or texture coordinates, which would open the
//! surface.

use nalgebra::Point3;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::not_empty;
use crate::mesh::formats::words::{Words, integer};
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;

/// Reads a surface; polygons are triangulated.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
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
            }
            _ => {}
        }
        while same_line(&mut words).is_some() {}
        words.next_line();
    }
    not_empty(mesh, "faces", "export the mesh with its faces")
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
