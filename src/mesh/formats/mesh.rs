//! A mesh of either kind, and how files that may hold both become one.

use nalgebra::Point3;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};

/// A mesh of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Mesh {
    /// Triangles.
    Surface(SurfaceMesh),
    /// Tetrahedra.
    Tets(TetMesh),
}

/// What a file holds that may hold both kinds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Collected {
    pub(crate) vertices: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) vertex_data: Vec<VertexData>,
}

impl Collected {
    /// The tetrahedra if there are any (triangles beside them are their boundary or inner
    /// walls), else the triangles.
    pub(crate) fn into_mesh(self) -> Result<Mesh, ParseError> {
        let Self {
            vertices,
            triangles,
            tets,
            vertex_data,
        } = self;
        if !tets.is_empty() {
            return Ok(Mesh::Tets(TetMesh {
                vertices,
                tets,
                vertex_data,
            }));
        }
        if !triangles.is_empty() {
            return Ok(Mesh::Surface(SurfaceMesh {
                vertices,
                triangles,
            }));
        }
        Err(ParseError::whole(ErrorKind::Missing {
            what: "triangles, polygons or tetrahedra",
            mend: "export the mesh with its elements",
        }))
    }
}

/// The error of volume elements that are not plain tetrahedra: leaving them out would leave
/// holes in the solid.
pub(crate) fn no_tetrahedron(kind: impl std::fmt::Display) -> ErrorKind {
    ErrorKind::Unsupported {
        what: format!("volume elements of type {kind}"),
        mend: "export first-order tetrahedra only, or the solid's surface",
    }
}
