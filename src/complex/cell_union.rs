//! Two neighboring cells made one.

use crate::complex::edit_mesh::{Behind, EditMesh};
use crate::complex::wall_polygons::outline;

/// The cosine of how far two faces towards the same cell may be inclined that become one: 25 degrees.
const INCLINED: f64 = 0.906_307_787_036_65;

/// Joins `gone` to `kept`. Faces between them vanish, and faces of both towards one neighbor or
/// patch become one where they are hardly inclined.
pub(crate) fn unite(mesh: &mut EditMesh, kept: u32, gone: u32) {
    for face in mesh.of_cell[gone as usize].clone() {
        let (owner, behind) = (mesh.owner[face as usize], mesh.behind[face as usize]);
        match (owner, behind) {
            (_, Behind::Cell(other)) if owner == kept || other == kept => {
                mesh.set_loop(face, Vec::new());
            }
            (_, _) if owner == gone => mesh.set_sides(face, kept, behind),
            _ => mesh.set_sides(face, owner, Behind::Cell(kept)),
        }
    }
    while join_faces(mesh, kept) {}
}

/// What lies behind a face, seen from a cell.
fn other_side(mesh: &EditMesh, face: u32, cell: u32) -> Behind {
    match mesh.owner[face as usize] == cell {
        true => mesh.behind[face as usize],
        false => Behind::Cell(mesh.owner[face as usize]),
    }
}

/// Makes one of two faces of a cell, if there are any.
pub(crate) fn join_faces(mesh: &mut EditMesh, cell: u32) -> bool {
    let mut faces = mesh.of_cell[cell as usize].clone();
    faces.sort_unstable();
    for (place, &one) in faces.iter().enumerate() {
        for &other in &faces[place + 1..] {
            if other_side(mesh, one, cell) == other_side(mesh, other, cell)
                && join_pair(mesh, cell, one, other)
            {
                return true;
            }
        }
    }
    false
}

/// Makes one of two faces, if their union is a disc that no other face touches within.
fn join_pair(mesh: &mut EditMesh, cell: u32, one: u32, other: u32) -> bool {
    let loops = [one, other].map(|face| mesh.outward(face, cell));
    let shapes = loops.each_ref().map(|corners| mesh.shape_of(corners).area);
    if shapes[0].dot(&shapes[1]) < INCLINED * shapes[0].norm() * shapes[1].norm() {
        return false;
    }
    let Some(mut corners) = outline(&[&loops[0], &loops[1]]) else {
        return false;
    };
    if corners.len() >= loops[0].len() + loops[1].len() {
        return false;
    }
    let gone = loops.iter().flatten().filter(|at| !corners.contains(at));
    let mut faces = gone.flat_map(|&at| mesh.at_point[at as usize].iter());
    if faces.any(|&face| face != one && face != other) {
        return false;
    }
    if mesh.owner[one as usize] != cell {
        corners.reverse();
    }
    mesh.set_loop(other, Vec::new());
    mesh.set_loop(one, corners);
    true
}
