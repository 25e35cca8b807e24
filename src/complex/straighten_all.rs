//! A mesh without the vertices that only divide an edge.
//!
//! The dual has no use for them: their elements would be flat. So they go however far the edge turns there,
//! unless a feature turns into a corner.

use nalgebra::Vector3;

use crate::complex::edit_mesh::{EditMesh, adjacent};
use crate::mesh::poly_mesh::PolyMesh;

/// The same cells and faces without vertices of two edges. Faces keep three corners, and vertices of three
/// patches stay, as do those of two where their edges turn by more than `angle` (degrees).
#[must_use]
pub(crate) fn without_chains(mesh: &PolyMesh, angle: f64) -> PolyMesh {
    let mut edited = EditMesh::of(mesh);
    let turn = angle.to_radians().cos();
    let mut has_changed = true;
    while has_changed {
        has_changed = false;
        for point in 0..edited.points.len() as u32 {
            has_changed |= remove_link(&mut edited, point, turn);
        }
    }
    edited.finish()
}

/// Removes a vertex of two edges, if it may go; whether it did.
fn remove_link(mesh: &mut EditMesh, point: u32, turn: f64) -> bool {
    let &[one, other] = mesh.neighbors(point).as_slice() else {
        return false;
    };
    let faces = mesh.at_point[point as usize].clone();
    let patches = mesh.patches_at(point).len();
    let way = |end: u32| -> Vector3<f64> {
        let way = mesh.points[end as usize] - mesh.points[point as usize];
        way.try_normalize(0.0).unwrap_or_default()
    };
    let is_corner = patches > 2 || (patches == 2 && way(one).dot(&way(other)) > -turn);
    let has_room = faces.iter().all(|&face| {
        let corners = &mesh.faces[face as usize];
        corners.len() > 3 && !adjacent(corners, one, other)
    });
    if is_corner || !has_room {
        return false;
    }
    for face in faces {
        let corners = mesh.faces[face as usize].iter().copied();
        let corners = corners.filter(|&corner| corner != point).collect();
        mesh.set_loop(face, corners);
    }
    true
}
