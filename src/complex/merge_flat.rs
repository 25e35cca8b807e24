//! Cells without a place inside that sees all their faces joined to neighbors.
//!
//! A dual element of four sites in a square, between a quadrilateral and two triangles, is flat wherever its
//! points are. It goes to the neighbor with which it shares the greatest area. So do cells of which parts stay
//! inverted wherever their points go, each to the neighbor with which that helps most.

use std::collections::{BTreeMap, BTreeSet};

use crate::complex::divide::unseen;
use crate::complex::dual::DualMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::sorted_faces::SortedFaces;
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};

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

/// Joins each of `bad` cells to the neighbor with which all is best: no cell opens, fewest cells cannot
/// see their faces, the largest face goes. It is the collapse of an edge of the mesh whose dual this is.
/// Whether any was joined.
pub(crate) fn join_bad(dual: &mut DualMesh, bad: &BTreeSet<u32>) -> bool {
    let others = |dual: &DualMesh| dual.mesh.check_closed().ok().map(|others| others.len());
    let Some(first) = others(dual) else {
        return false;
    };
    let is_sound = |dual: &DualMesh| others(dual).is_some_and(|count| count <= first);
    let (mut all, mut taken) = (BTreeMap::new(), BTreeSet::new());
    for &cell in bad {
        let best = best_neighbor(dual, cell, &taken, &is_sound);
        if let Some(other) = best {
            all.insert(cell, other);
            taken.extend([cell, other]);
        }
    }
    let mut next = joined(dual, &all);
    while !is_sound(&next) && all.pop_last().is_some() {
        next = joined(dual, &all);
    }
    *dual = next;
    !all.is_empty()
}

/// The neighbor with which a cell is best joined, if neither is `taken`.
fn best_neighbor(
    dual: &DualMesh,
    cell: u32,
    taken: &BTreeSet<u32>,
    is_sound: &impl Fn(&DualMesh) -> bool,
) -> Option<u32> {
    let is_free = |other: &u32| !taken.contains(&cell) && !taken.contains(other);
    let mut best: Option<(usize, u32)> = None;
    for other in neighbors(&dual.mesh, cell).into_iter().filter(is_free) {
        let joined = joined(dual, &BTreeMap::from([(cell, other)]));
        if !is_sound(&joined) {
            continue;
        }
        let count = unseen(&joined.mesh).len();
        if best.is_none_or(|(least, _)| count < least) {
            best = Some((count, other));
        }
    }
    best.map(|(_, other)| other)
}

/// The cells beside a cell, those with the largest common area first.
fn neighbors(mesh: &PolyMesh, cell: u32) -> Vec<u32> {
    let cells = mesh.cell_faces();
    let geometry = MeshGeometry::of(mesh, &cells);
    let mut shared: Vec<(u32, f64)> = shared(mesh, &cells, &geometry, cell).into_iter().collect();
    shared.sort_by(|one, other| other.1.total_cmp(&one.1));
    shared.into_iter().map(|(other, _)| other).collect()
}

/// The cells beside a cell with the common areas (L²).
fn shared(
    mesh: &PolyMesh,
    cells: &CellFaces,
    geometry: &MeshGeometry,
    cell: u32,
) -> BTreeMap<u32, f64> {
    let mut shared: BTreeMap<u32, f64> = BTreeMap::new();
    for (face, is_owner) in cells.of(cell as usize) {
        let other = match is_owner {
            true => mesh.neighbor.get(face).copied(),
            false => Some(mesh.owner[face]),
        };
        if let Some(other) = other {
            *shared.entry(other).or_default() += geometry.face_areas[face].norm();
        }
    }
    shared
}

/// The dual with `flat` cells joined to neighbors that are not joined themselves.
fn merged(dual: &DualMesh, flat: &[usize]) -> DualMesh {
    joined(dual, &targets(&dual.mesh, flat))
}

/// The dual with cells joined to others.
fn joined(dual: &DualMesh, targets: &BTreeMap<u32, u32>) -> DualMesh {
    let mesh = &dual.mesh;
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
        let free = shared(mesh, &cells, &geometry, cell as u32)
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
