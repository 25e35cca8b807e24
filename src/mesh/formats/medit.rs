//! MEDIT `.mesh` in text: tetrahedra, triangles, quadrilaterals, and second-order tetrahedra and
//! triangles (`TetrahedraP2`, `TrianglesP2`) with straight edges.
//!
//! An element's reference names its group. A file is a list of keywords, each with its count and entities; keywords not known here are
//! passed over up to the next word that starts with a letter. Hexahedra and prisms are refused,
//! because leaving them out would leave holes. The format is the one of Frey, "MEDIT: An
//! interactive mesh visualization software", INRIA RT-0253 (2001).

use std::fmt::Write;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, MeshParts, no_tetrahedron};
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::polygon::triangulate;
use crate::mesh::tets::TetMesh;

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
    let mut words = Words::new(bytes, Some(b'#'));
    let mut mesh = MeshParts::default();
    while let Some(word) = words.word() {
        match word.to_ascii_lowercase().as_slice() {
            b"meshversionformatted" => drop(words.count("a version")?),
            b"dimension" => read_dimension(&mut words)?,
            b"vertices" => read_vertices(&mut words, &mut mesh)?,
            b"tetrahedra" => read_elements(&mut words, &mut mesh, |mesh, tet: [u32; 4]| {
                mesh.add_tet(&tet)
            })?,
            b"tetrahedrap2" => read_elements(&mut words, &mut mesh, |mesh, tet: [u32; 10]| {
                mesh.add_tet(&tet)
            })?,
            b"triangles" => read_elements(&mut words, &mut mesh, |mesh, face| {
                mesh.triangles.push(face);
                Ok(())
            })?,
            b"trianglesp2" => read_elements(&mut words, &mut mesh, |mesh, face: [u32; 6]| {
                mesh.add_second_order_face(&face)
            })?,
            b"quadrilaterals" => read_elements(&mut words, &mut mesh, |mesh, quad: [u32; 4]| {
                triangulate(&mesh.vertices, &quad, &mut mesh.triangles);
                Ok(())
            })?,
            b"hexahedra" | b"hexaedra" | b"prisms" | b"pyramids" | b"tetrahedrap3" => {
                refuse(&mut words, word)?
            }
            b"end" => break,
            _ if word[0].is_ascii_alphabetic() => skip(&mut words),
            _ => return Err(words.unexpected("a keyword", word)),
        }
    }
    mesh.into_mesh(|vertex| format!("vertex {}", vertex + 1))
}

/// Writes a tetrahedral mesh without its vertex data, every coordinate as the shortest decimal
/// that reads back equal.
#[must_use]
pub fn write(mesh: &TetMesh) -> String {
    let mut text = String::from("MeshVersionFormatted 2\nDimension 3\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "Vertices\n{}", mesh.vertices.len());
    for point in &mesh.vertices {
        let _ = writeln!(text, "{} {} {} 0", point.x, point.y, point.z);
    }
    let _ = writeln!(text, "Tetrahedra\n{}", mesh.tets.len());
    for [a, b, c, d] in mesh.tets.iter().map(|tet| tet.map(|vertex| vertex + 1)) {
        let _ = writeln!(text, "{a} {b} {c} {d} 0");
    }
    text.push_str("End\n");
    text
}

fn read_dimension(words: &mut Words<'_>) -> Result<(), ParseError> {
    let dimension = words.count("a dimension")?;
    if dimension == 3 {
        return Ok(());
    }
    let what = format!("a mesh of dimension {dimension}");
    let mend =
        "a solid has three coordinates a vertex; a domain of the plane is a polygon in a scene";
    Err(words.unsupported(what, mend))
}

fn read_vertices(words: &mut Words<'_>, mesh: &mut MeshParts) -> Result<(), ParseError> {
    let count = words.size("the number of vertices", "vertices")?;
    mesh.vertices.reserve(words.capacity_for(count, 6));
    for _ in 0..count {
        mesh.vertices.push(words.point()?);
        words.number("a reference")?;
    }
    Ok(())
}

fn read_elements<const N: usize>(
    words: &mut Words<'_>,
    mesh: &mut MeshParts,
    add: impl Fn(&mut MeshParts, [u32; N]) -> Result<(), ErrorKind>,
) -> Result<(), ParseError> {
    let count = words.size("the number of elements", "elements")?;
    for _ in 0..count {
        let mut element = [0; N];
        for vertex in &mut element {
            *vertex = words.vertex(mesh.vertices.len(), 1)?;
        }
        let reference = words.number("a reference")?;
        add(mesh, element).map_err(|kind| words.error(kind))?;
        mesh.label(&reference.to_string());
    }
    Ok(())
}

/// Refuses elements other than tetrahedra, if there are any.
fn refuse(words: &mut Words<'_>, keyword: &[u8]) -> Result<(), ParseError> {
    if words.count("the number of elements")? == 0 {
        return Ok(());
    }
    Err(words.error(no_tetrahedron(shown(keyword))))
}

/// Moves to the next word that starts with a letter.
fn skip(words: &mut Words<'_>) {
    while words
        .peek()
        .is_some_and(|word| !word[0].is_ascii_alphabetic())
    {
        words.word();
    }
}
