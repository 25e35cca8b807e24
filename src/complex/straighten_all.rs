//! A mesh without the vertices that only divide an edge.

use crate::complex::collapse::straighten_edges;
use crate::complex::edit_mesh::EditMesh;
use crate::mesh::poly_mesh::PolyMesh;

/// The same cells and faces without vertices of two edges, however far the edge turns there. Faces keep
/// three corners, and vertices of three patches stay.
#[must_use]
pub(crate) fn without_chains(mesh: &PolyMesh) -> PolyMesh {
    let mut edited = EditMesh::of(mesh);
    while straighten_edges(&mut edited, f64::INFINITY) > 0 {}
    edited.finish()
}
