//! Polygons with holes as JSON: `{"vertices": [[x, y, z], …], "faces": [[outer, hole, …], …]}`.
//!
//! A face is a list of loops, each a list of vertices counted from zero: the outer one,
//! counter-clockwise seen from outside, then its holes, which may run either way. A face without holes
//! may be its one loop. Vertices with two coordinates lie in the plane z = 0.

use nalgebra::Point3;
use serde::Deserialize;

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, not_empty};
use crate::mesh::holes::{HoleOutside, triangulate_with_holes};
use crate::mesh::surface::SurfaceMesh;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PolygonFile {
    vertices: Vec<Vec<f64>>,
    faces: Vec<FaceLoops>,
}

/// A face as its loops, or as the only one.
#[derive(Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a face is a list of loops, [[0, 1, 2, 3], [4, 5, 6]]: the outer one, then its holes"
)]
enum FaceLoops {
    Loops(Vec<Vec<u32>>),
    Outer(Vec<u32>),
}

/// Reads a surface; polygons are triangulated, and which triangles are of which is kept.
pub(crate) fn parse(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let file: PolygonFile = serde_json::from_slice(bytes).map_err(|error| {
        let expected = "polygons, {\"vertices\": [[x, y, z], …], \"faces\": [[[0, 1, 2]], …]}";
        ParseError::on_line(
            error.line(),
            ErrorKind::expected(expected, error.to_string()),
        )
    })?;
    let mut mesh = SurfaceMesh::default();
    for (number, place) in file.vertices.iter().enumerate() {
        mesh.vertices.push(point(number, place)?);
    }
    let mut elements = Elements::default();
    for (number, face) in file.faces.into_iter().enumerate() {
        let loops = match face {
            FaceLoops::Loops(loops) => loops,
            FaceLoops::Outer(outer) => vec![outer],
        };
        check_loops(number, &loops, mesh.vertices.len())?;
        triangulate_with_holes(&mesh.vertices, &loops, &mut mesh.triangles)
            .map_err(|HoleOutside(hole)| outside(number, hole))?;
        elements
            .polygons
            .resize(mesh.triangles.len(), number as u32);
    }
    let mesh = Mesh::Surface(not_empty(mesh, "faces", "give it some")?);
    Ok(MeshFile::labeled(mesh, elements))
}

fn point(number: usize, place: &[f64]) -> Result<Point3<f64>, ParseError> {
    match *place {
        [x, y, z] => Ok(Point3::new(x, y, z)),
        [x, y] => Ok(Point3::new(x, y, 0.0)),
        _ => {
            let found = format!("{} at vertex {number}", place.len());
            let kind = ErrorKind::expected("two or three coordinates a vertex", found);
            Err(ParseError::whole(kind))
        }
    }
}

/// Refuses loops of fewer than three vertices, and vertices that are not there.
fn check_loops(face: usize, loops: &[Vec<u32>], vertices: usize) -> Result<(), ParseError> {
    let short = loops.iter().find(|corners| corners.len() < 3);
    if loops.is_empty() || short.is_some() {
        let found = format!("{} at face {face}", short.map_or(0, Vec::len));
        let kind = ErrorKind::expected("loops of at least 3 vertices", found);
        return Err(ParseError::whole(kind));
    }
    for &vertex in loops.iter().flatten() {
        ErrorKind::check_vertex(i64::from(vertex), vertices, 0).map_err(ParseError::whole)?;
    }
    Ok(())
}

fn outside(face: usize, hole: usize) -> ParseError {
    ParseError::whole(ErrorKind::unsupported(
        format!(
            "hole {hole} of face {face} (counted from 0), which is not inside its outer loop or crosses another loop,"
        ),
        "list the outer loop first, then holes that lie in it",
    ))
}
