//! A mesh of either kind, and the parts of a file that may hold both.

use nalgebra::Point3;

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::point_data::{PointData, vertex_data};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;

/// A mesh of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Mesh {
    /// Triangles.
    Surface(SurfaceMesh),
    /// Tetrahedra.
    Tets(TetMesh),
}

/// A mesh, and what its file says about the elements.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) mesh: Mesh,
    pub(crate) elements: Elements,
}

impl From<Mesh> for MeshFile {
    fn from(mesh: Mesh) -> Self {
        let elements = Elements::default();
        Self { mesh, elements }
    }
}

/// The parts of a file of a format for both kinds.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshParts {
    pub(crate) vertices: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) point_data: Vec<PointData>,
}

impl MeshParts {
    /// The tetrahedra if there are any (triangles beside them are their boundary or inner
    /// walls), else the triangles. `node` names a vertex as the file does, in what is said about
    /// data.
    pub(crate) fn into_mesh(self, node: impl Fn(usize) -> String) -> Result<Mesh, ParseError> {
        let vertices = self.vertices;
        if !self.tets.is_empty() {
            let (tets, data) = (self.tets, self.point_data);
            let vertex_data = vertex_data(data, &tets, vertices.len(), node);
            return Ok(Mesh::Tets(TetMesh {
                vertices,
                tets,
                vertex_data,
            }));
        }
        if self.triangles.is_empty() {
            let what = "triangles, polygons or tetrahedra";
            return Err(ParseError::missing(
                what,
                "export the mesh with its elements",
            ));
        }
        Ok(Mesh::Surface(SurfaceMesh {
            vertices,
            triangles: self.triangles,
        }))
    }
}

/// The surface, unless it has no triangles: then the error that `what` is missing.
pub(crate) fn not_empty(
    mesh: SurfaceMesh,
    what: &'static str,
    mend: &'static str,
) -> Result<SurfaceMesh, ParseError> {
    if mesh.triangles.is_empty() {
        return Err(ParseError::missing(what, mend));
    }
    Ok(mesh)
}

/// The error of volume elements that are not plain tetrahedra: leaving them out would leave
/// holes in the solid.
pub(crate) fn no_tetrahedron(kind: impl std::fmt::Display) -> ErrorKind {
    let mend = "export first-order tetrahedra only, or the solid's surface";
    ErrorKind::unsupported(format!("volume elements of type {kind}"), mend)
}
