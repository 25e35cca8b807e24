//! The ASCII polyhedra of Mirtich's program volInt.c: vertices, then polygons.
//!
//! The number of vertices, three coordinates for each, the number of faces, and for each face how many
//! vertices it has and which, counted from zero, counter-clockwise seen from outside. White space may
//! be put in as one likes, names have no extension of their own. Format: the README of volInt.c, 1996.

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::ParseError;
use crate::mesh::formats::mesh::{Mesh, MeshFile, not_empty};
use crate::mesh::formats::words::Words;
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;

/// Reads a surface; polygons are triangulated, and which triangles are of which is kept.
pub(crate) fn parse(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut words = Words::new(bytes, Some(b'#'));
    let mut mesh = SurfaceMesh::default();
    let count = words.size("the number of vertices", "vertices")?;
    mesh.vertices.reserve(words.capacity_for(count, 6));
    for _ in 0..count {
        mesh.vertices.push(words.point()?);
    }
    let faces = words.size("the number of faces", "faces")?;
    let mut elements = Elements::default();
    let mut polygon = Vec::new();
    for face in 0..faces as u32 {
        read_polygon(&mut words, count, &mut polygon)?;
        triangulate(&mesh.vertices, &polygon, &mut mesh.triangles);
        words.check_limit("triangles", mesh.triangles.len())?;
        elements.polygons.resize(mesh.triangles.len(), face);
    }
    at_end(&mut words)?;
    let mesh = Mesh::Surface(not_empty(mesh, "faces", "export the mesh with its faces")?);
    Ok(MeshFile::labeled(mesh, elements))
}

/// Refuses what follows the last face.
fn at_end(words: &mut Words<'_>) -> Result<(), ParseError> {
    let expected = "the end of the file, its count of faces was too low";
    words
        .word()
        .map_or(Ok(()), |word| Err(words.unexpected(expected, word)))
}

fn read_polygon(
    words: &mut Words<'_>,
    vertices: usize,
    polygon: &mut Vec<u32>,
) -> Result<(), ParseError> {
    let corners = words.count("a face's number of vertices")?;
    if corners < 3 {
        let found = corners.to_string();
        return Err(words.unexpected("a face of at least 3 vertices", found.as_bytes()));
    }
    polygon.clear();
    for _ in 0..corners {
        polygon.push(words.vertex(vertices, 0)?);
    }
    Ok(())
}

/// Whether a file begins as these do: a number alone on its line, then lines of three.
pub(crate) fn is_likely(bytes: &[u8]) -> bool {
    let lines = bytes.split(|byte| b"\n\r".contains(byte));
    let words = |line: &[u8]| {
        let words = line.split(u8::is_ascii_whitespace);
        words.filter(|word| !word.is_empty()).count()
    };
    let mut filled = lines.filter(|line| words(line) > 0);
    let is_number = |line: &[u8]| {
        let text = std::str::from_utf8(line).unwrap_or_default();
        text.split_whitespace()
            .all(|word| word.parse::<f64>().is_ok())
    };
    let (first, second) = (filled.next(), filled.next());
    let (Some(first), Some(second)) = (first, second) else {
        return false;
    };
    words(first) == 1 && words(second) == 3 && is_number(first) && is_number(second)
}
