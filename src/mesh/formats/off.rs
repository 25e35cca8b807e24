//! OFF, the Object File Format of Geomview: polygons.
//!
//! Headers OFF, COFF, NOFF, CNOFF, STOFF and their mixtures are read (or none at all), counts
//! on the header's line or on the next, comments anywhere. Whatever follows the coordinates or
//! a face's indices on its line (colors, normals) is passed over.

use std::fmt::Write;

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile};
use crate::mesh::formats::words::{Words, integer, shown};
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;

/// Reads a surface; polygons are triangulated.
///
/// # Errors
///
/// The line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<SurfaceMesh, ParseError> {
    read_mesh(bytes, &mut Elements::default())
}

/// As [`parse`], with the polygon of every triangle.
pub(crate) fn parse_file(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let mut elements = Elements::default();
    let mesh = Mesh::Surface(read_mesh(bytes, &mut elements)?);
    Ok(MeshFile::labeled(mesh, elements))
}

fn read_mesh(bytes: &[u8], elements: &mut Elements) -> Result<SurfaceMesh, ParseError> {
    let mut words = Words::new(bytes, Some(b'#'));
    header(&mut words)?;
    let vertices = words.size("the number of vertices", "vertices")?;
    let faces = words.count("the number of faces")?;
    words.next_line();
    let mut mesh = SurfaceMesh::default();
    read_vertices(&mut words, vertices, &mut mesh)?;
    read_faces(&mut words, faces, &mut mesh, elements)?;
    at_end(&mut words, faces)?;
    Ok(mesh)
}

/// Writes a surface, every coordinate as the shortest decimal that reads back equal.
#[must_use]
pub fn write(mesh: &SurfaceMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for point in &mesh.vertices {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{} {} {}", point.x, point.y, point.z);
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

/// Whether `word` is one of the headers OFF, COFF, STCN4OFF, …
#[must_use]
pub fn is_header(word: &[u8]) -> bool {
    let Some((prefix, off)) = word.split_last_chunk::<3>() else {
        return false;
    };
    let is_known = |letter: &u8| b"STCN4".contains(&letter.to_ascii_uppercase());
    off.eq_ignore_ascii_case(b"OFF") && prefix.iter().all(is_known)
}

fn header(words: &mut Words<'_>) -> Result<(), ParseError> {
    let Some(word) = words.peek() else {
        return Err(ParseError::whole(ErrorKind::Empty));
    };
    if integer(word).is_some() {
        return Ok(());
    }
    words.word();
    if !is_header(word) {
        return Err(words.unexpected("the header OFF", word));
    }
    let next = words.clone().word_on_line();
    let is_binary = next.is_some_and(|next| next.eq_ignore_ascii_case(b"binary"));
    // A small n before a capital OFF stands for another dimension.
    let is_upper = word.ends_with(b"OFF");
    if is_binary || word.contains(&b'4') || is_upper && word.contains(&b'n') {
        let (word, next) = (shown(word), shown(next.unwrap_or_default()));
        let mend = "export plain OFF: text, three coordinates a vertex";
        return Err(words.unsupported(format!("the dialect {word} {next}"), mend));
    }
    Ok(())
}

fn read_vertices(
    words: &mut Words<'_>,
    count: usize,
    mesh: &mut SurfaceMesh,
) -> Result<(), ParseError> {
    mesh.vertices.reserve(words.capacity_for(count, 6));
    for number in 0..count {
        if number == 0 && is_pair(words) {
            let mend =
                "a solid has three; for a run in the plane write a scene with \"dimension\": 2";
            return Err(words.unsupported("a vertex of two coordinates", mend));
        }
        mesh.vertices.push(words.point_on_line()?);
        words.next_line();
    }
    Ok(())
}

/// Whether just two numbers stand on the line.
fn is_pair(words: &Words<'_>) -> bool {
    let mut words = words.clone();
    let is_number = |word: &[u8]| std::str::from_utf8(word).is_ok_and(|w| w.parse::<f64>().is_ok());
    let mut pair = [words.word(), words.word_on_line()].into_iter();
    let are_numbers = pair.all(|word| word.is_some_and(is_number));
    are_numbers && words.word_on_line().is_none() && !words.is_at_end()
}

fn read_faces(
    words: &mut Words<'_>,
    count: usize,
    mesh: &mut SurfaceMesh,
    elements: &mut Elements,
) -> Result<(), ParseError> {
    mesh.triangles.reserve(words.capacity_for(count, 8));
    let mut polygon = Vec::new();
    for face in 0..count as u32 {
        read_polygon(words, mesh.vertices.len(), &mut polygon)?;
        triangulate(&mesh.vertices, &polygon, &mut mesh.triangles);
        words.check_limit("triangles", mesh.triangles.len())?;
        elements.polygons.resize(mesh.triangles.len(), face);
        words.next_line();
    }
    Ok(())
}

fn read_polygon(
    words: &mut Words<'_>,
    vertices: usize,
    polygon: &mut Vec<u32>,
) -> Result<(), ParseError> {
    let corners = words.count("a face's number of vertices")?;
    polygon.clear();
    for _ in 0..corners {
        polygon.push(words.vertex_on_line(vertices, 0)?);
    }
    if corners < 3 {
        let found = corners.to_string();
        return Err(words.unexpected("a face of at least 3 vertices", found.as_bytes()));
    }
    Ok(())
}

/// Refuses lines after the last face: the counts were too low.
fn at_end(words: &mut Words<'_>, announced: usize) -> Result<(), ParseError> {
    if words.word().is_none() {
        return Ok(());
    }
    let line = words.line();
    let mut found = announced + 1;
    while words.next_line() && words.word().is_some() {
        found += 1;
    }
    ErrorKind::check_count("faces", announced, found)
        .map_err(|kind| ParseError::on_line(line, kind))
}
