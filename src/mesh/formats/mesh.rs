//! A mesh of either kind, and the parts of a file that may hold both.

use nalgebra::Point3;

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::point_data::{PointData, vertex_data};
use crate::mesh::formats::second_order::{QUAD_EDGES, TET_EDGES, TRIANGLE_EDGES, check_straight};
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, compact};

/// A mesh of either kind.
#[derive(Clone, Debug, PartialEq)]
pub enum Mesh {
    /// Triangles.
    Surface(SurfaceMesh),
    /// Tetrahedra.
    Tets(TetMesh),
}

/// A mesh with what its reader has to say about it, and what the file says about the elements.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshFile {
    pub(crate) mesh: Mesh,
    /// One sentence each.
    pub(crate) notes: Vec<String>,
    pub(crate) elements: Elements,
}

impl MeshFile {
    /// A mesh about which there is nothing to say.
    pub(crate) fn plain(mesh: Mesh) -> Self {
        Self::labeled(mesh, Elements::default())
    }

    /// A mesh whose file says so much about the elements.
    pub(crate) fn labeled(mesh: Mesh, elements: Elements) -> Self {
        let notes = Vec::new();
        Self {
            mesh,
            notes,
            elements,
        }
    }
}

/// The parts of a file of a format for both kinds.
#[derive(Clone, Debug, Default)]
pub(crate) struct MeshParts {
    pub(crate) vertices: Vec<Point3<f64>>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) point_data: Vec<PointData>,
    /// How many second-order elements are among them, by their corners.
    pub(crate) second_order: usize,
}

impl MeshParts {
    /// Adds a tetrahedron of four nodes or, of second order, ten: corners first.
    pub(crate) fn add_tet(&mut self, nodes: &[u32]) -> Result<(), ErrorKind> {
        let &[a, b, c, d, ref middles @ ..] = nodes else {
            return Err(ErrorKind::expected("four corners", nodes.len().to_string()));
        };
        if !middles.is_empty() {
            check_straight(&self.vertices, nodes, 4, TET_EDGES)?;
            self.second_order += 1;
        }
        self.tets.push([a, b, c, d]);
        Ok(())
    }

    /// Adds a triangle of six nodes, or a quadrangle of eight, or of nine with the last in its middle:
    /// corners first.
    pub(crate) fn add_second_order_face(&mut self, nodes: &[u32]) -> Result<(), ErrorKind> {
        let (corners, edges) = match nodes.len() {
            6 => (3, TRIANGLE_EDGES),
            _ => (4, QUAD_EDGES),
        };
        let nodes = if nodes.len() == 9 { &nodes[..8] } else { nodes };
        check_straight(&self.vertices, nodes, corners, edges)?;
        self.second_order += 1;
        triangulate(&self.vertices, &nodes[..corners], &mut self.triangles);
        Ok(())
    }

    /// The tetrahedra if there are any (triangles beside them are their boundary or inner
    /// walls), else the triangles. `node` names a vertex as the file does, in what is said about
    /// data.
    pub(crate) fn into_mesh(self, node: impl Fn(usize) -> String) -> Result<MeshFile, ParseError> {
        let notes = self.notes();
        let is_curved = self.second_order > 0;
        let mut vertices = self.vertices;
        if !self.tets.is_empty() {
            let (mut tets, data) = (self.tets, self.point_data);
            let mut vertex_data = vertex_data(data, &tets, vertices.len(), node);
            if is_curved {
                let kept = compact(&mut vertices, &mut tets);
                for field in &mut vertex_data {
                    field.values = kept.iter().map(|&at| field.values[at as usize]).collect();
                }
            }
            let mesh = Mesh::Tets(TetMesh {
                vertices,
                tets,
                vertex_data,
            });
            return Ok(MeshFile { mesh, notes, elements });
        }
        if self.triangles.is_empty() {
            let what = "triangles, polygons or tetrahedra";
            let mend = "export the mesh with its elements";
            return Err(ParseError::missing(what, mend));
        }
        let mut triangles = self.triangles;
        if is_curved {
            compact(&mut vertices, &mut triangles);
        }
        let mesh = Mesh::Surface(SurfaceMesh {
            vertices,
            triangles,
        });
        Ok(MeshFile { mesh, notes, elements })
    }

    fn notes(&self) -> Vec<String> {
        let count = self.second_order;
        let note = || {
            format!(
                "{count} second-order elements are read by their corners; their middle nodes lie on \
                 straight edges"
            )
        };
        (count > 0).then(note).into_iter().collect()
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
    let mend = "export tetrahedra of first or second order only, or the solid's surface";
    ErrorKind::unsupported(format!("volume elements of type {kind}"), mend)
}
