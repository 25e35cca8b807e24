//! A mesh of either kind, and the parts of a file that may hold both.

use nalgebra::Point3;

use crate::mesh::elements::{CellData, Elements, Groups};
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
    /// The groups of the triangles and of the tetrahedra.
    pub(crate) triangle_groups: Groups,
    pub(crate) tet_groups: Groups,
    /// The cell of the file that every tetrahedron is.
    pub(crate) tet_cells: Vec<u32>,
    /// Scalar fields of the file's cells.
    pub(crate) cell_data: Vec<CellData>,
}

impl MeshParts {
    /// Puts the elements that have no group yet into this one.
    pub(crate) fn label(&mut self, group: &str) {
        let count = self.triangles.len();
        if self.triangle_groups.of_elements().len() < count {
            let group = self.triangle_groups.named(group);
            self.triangle_groups.fill(count, group);
        }
        let count = self.tets.len();
        if self.tet_groups.of_elements().len() < count {
            let group = self.tet_groups.named(group);
            self.tet_groups.fill(count, group);
        }
    }

    /// Notes that the tetrahedra without a cell yet are this cell of the file.
    pub(crate) fn number_cell(&mut self, cell: usize) {
        self.tet_cells.resize(self.tets.len(), cell as u32);
    }

    /// Scalar fields with one value for each tetrahedron.
    fn tet_data(&self) -> Vec<CellData> {
        let of_tets = |field: &CellData| CellData {
            name: field.name.clone(),
            values: (self.tet_cells.iter())
                .map(|&cell| field.values.get(cell as usize).copied().unwrap_or(f64::NAN))
                .collect(),
        };
        self.cell_data.iter().map(of_tets).collect()
    }

    /// What the file says about the tetrahedra, or the triangles where it has none.
    fn elements(&mut self) -> Elements {
        let cell_data = self.tet_data();
        let groups = match self.tets.is_empty() {
            true => &mut self.triangle_groups,
            false => &mut self.tet_groups,
        };
        Elements {
            groups: std::mem::take(groups),
            polygons: Vec::new(),
            cell_data,
        }
    }

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
    pub(crate) fn into_mesh(
        mut self,
        node: impl Fn(usize) -> String,
    ) -> Result<MeshFile, ParseError> {
        let notes = self.notes();
        let elements = self.elements();
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
            return Ok(MeshFile {
                mesh,
                notes,
                elements,
            });
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
        Ok(MeshFile {
            mesh,
            notes,
            elements,
        })
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
