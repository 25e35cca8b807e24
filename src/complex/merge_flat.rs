//! Cells without a place inside that sees all their faces joined to neighbors.
//!
//! A dual element of four sites in a square, between a quadrilateral and two triangles, is flat wherever its
//! points are. It goes to the neighbor with which it shares the greatest area.

use std::collections::{BTreeMap, BTreeSet};

use crate::complex::divide::unseen;
use crate::complex::dual::DualMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::sorted_faces::SortedFaces;
use crate::mesh::poly_mesh::PolyMesh;

/// Joins cells to neighbors as long as fewer are left, and all are closed balls.
pub(crate) fn merge_flat(dual: &mut DualMesh) {
    // Closed cells that are no balls; none where a cell is open.
    let others = |mesh: &PolyMesh| mesh.check_closed().ok().map(|others| others.len());
    let (mut flat, first) = (unseen(&dual.mesh), others(&dual.mesh));
    let is_sound = |dual: &DualMesh| others(&dual.mesh).is_some_and(|count| Some(count) <= first);
    while !flat.is_empty() {
        let mut next = merged(dual, &flat);
        if !is_sound(&next) {
            flat.retain(|&cell| is_sound(&merged(dual, &[cell])));
            next = merged(dual, &flat);
        }
        let left = unseen(&next.mesh);
        if left.len() >= unseen(&dual.mesh).len() || !is_sound(&next) {
            return;
        }
        (*dual, flat) = (next, left);
    }
}

/// The dual with `flat` cells joined to neighbors that are not joined themselves.
fn merged(dual: &DualMesh, flat: &[usize]) -> DualMesh {
    let mesh = &dual.mesh;
    let targets = targets(mesh, flat);
    let cell = |cell: u32| targets.get(&cell).copied().unwrap_or(cell);
    let mut faces = SortedFaces::default();
    for (face, corners) in mesh.faces().enumerate().take(mesh.neighbor.len()) {
        let sides = [mesh.owner[face], mesh.neighbor[face]].map(cell);
        if sides[0] != sides[1] {
            faces.push_inner(sides, corners.to_vec());
        }
    }
    for (number, patch) in (0..).zip(&mesh.patches) {
        for face in patch.start..patch.start + patch.count {
            faces.push_wall(cell(mesh.owner[face]), mesh.face(face).to_vec(), number);
        }
    }
    let names: Vec<String> = mesh
        .patches
        .iter()
        .map(|patch| patch.name.clone())
        .collect();
    let (merged, used, _) = faces.finish(&mesh.points, &names);
    let anchors = used.iter().map(|&point| dual.anchors[point as usize]);
    DualMesh {
        mesh: merged,
        anchors: anchors.collect(),
    }
}

/// Per cell to be joined the one that takes it.
fn targets(mesh: &PolyMesh, flat: &[usize]) -> BTreeMap<u32, u32> {
    let cells = mesh.cell_faces();
    let geometry = MeshGeometry::of(mesh, &cells);
    let (mut targets, mut taken) = (BTreeMap::new(), BTreeSet::new());
    for &cell in flat {
        if taken.contains(&(cell as u32)) {
            continue;
        }
        let mut shared: BTreeMap<u32, f64> = BTreeMap::new();
        for (face, is_owner) in cells.of(cell) {
            let other = match is_owner {
                true => mesh.neighbor.get(face).copied(),
                false => Some(mesh.owner[face]),
            };
            if let Some(other) = other {
                *shared.entry(other).or_default() += geometry.face_areas[face].norm();
            }
        }
        let free = shared
            .into_iter()
            .filter(|(other, _)| !targets.contains_key(other));
        let largest = free.max_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((other, _)) = largest {
            targets.insert(cell as u32, other);
            taken.extend([cell as u32, other]);
        }
    }
    targets
}
