//! Removal of vertices with two edges: chains of edges become chords.
//!
//! A chain runs between vertices with other numbers of edges or corners of the walls. It is replaced by
//! chords from which it is nowhere farther than a reach (Douglas & Peucker 1973), as long as faces keep
//! three corners, edges are different, and no cell gets worse.

use crate::complex::edit_mesh::EditMesh;

/// Replaces chains by chords within `reach` (L). Returns how many vertices are gone.
pub(crate) fn straighten_edges(mesh: &mut EditMesh, reach: f64) -> usize {
    let mut removed = 0;
    let mut is_done = vec![false; mesh.points.len()];
    for point in 0..mesh.points.len() as u32 {
        if is_done[point as usize] || !is_link(mesh, point) {
            continue;
        }
        let chain = chain_of(mesh, point, &mut is_done);
        removed += straighten_run(mesh, &chain, reach);
    }
    removed
}

/// Whether a point has two edges and may go.
fn is_link(mesh: &EditMesh, point: u32) -> bool {
    !mesh.at_point[point as usize].is_empty()
        && mesh.all_neighbors(point).len() == 2
        && mesh.neighbors(point).len() == 2
        && !mesh.pinned.contains(&point)
        && mesh.patches_at(point).len() < 3
}

/// The longest chain through a link; its ends are no links, or both one of them.
fn chain_of(mesh: &EditMesh, point: u32, is_done: &mut [bool]) -> Vec<u32> {
    let mut chain = vec![point];
    is_done[point as usize] = true;
    let has_copies = |point: u32| mesh.copies_of(point).len() > 1;
    for end in mesh.neighbors(point) {
        chain.reverse();
        let (mut before, mut here) = (point, end);
        chain.push(here);
        // Chains of points with images are straightened point by point.
        while !has_copies(point)
            && !has_copies(here)
            && !is_done[here as usize]
            && is_link(mesh, here)
        {
            is_done[here as usize] = true;
            let ends = mesh.neighbors(here);
            let next = if ends[0] == before { ends[1] } else { ends[0] };
            (before, here) = (here, next);
            chain.push(here);
        }
    }
    chain
}

/// Removes what lies between the ends of a chain, or divides it at its farthest point.
fn straighten_run(mesh: &mut EditMesh, chain: &[u32], reach: f64) -> usize {
    let &[first, .., last] = chain else { return 0 };
    if chain.len() < 3 {
        return 0;
    }
    let inner = &chain[1..chain.len() - 1];
    let (place, distance) = farthest(mesh, chain);
    if distance <= reach && first != last && remove(mesh, first, inner, last) {
        return inner.len();
    }
    if inner.len() < 2 && chain.len() < 4 {
        return 0;
    }
    straighten_run(mesh, &chain[..=place], reach) + straighten_run(mesh, &chain[place..], reach)
}

/// The place in a chain, and the distance (L), of the point farthest from the chord; near the middle
/// where all lie on it.
fn farthest(mesh: &EditMesh, chain: &[u32]) -> (usize, f64) {
    let at = |place: usize| mesh.points[chain[place] as usize];
    let last = chain.len() - 1;
    let chord = at(last) - at(0);
    let length = chord.norm();
    let distance = |place: usize| {
        let arm = at(place) - at(0);
        match length > 1e-300 {
            true => chord.cross(&arm).norm() / length,
            false => arm.norm(),
        }
    };
    let mut best = (chain.len() / 2, distance(chain.len() / 2));
    for place in 1..last {
        let off = distance(place);
        if off > best.1 * (1.0 + 1e-9) {
            best = (place, off);
        }
    }
    best
}

/// Removes the points between two others, unless something gets worse.
fn remove(mesh: &mut EditMesh, first: u32, inner: &[u32], last: u32) -> bool {
    let Some(&one) = inner.first() else {
        return false;
    };
    let faces = mesh.at_point[one as usize].iter();
    let mut left = faces.map(|&face| mesh.faces[face as usize].len());
    if left.any(|corners| corners < inner.len() + 3) || mesh.has_edge(first, last) {
        return false;
    }
    let all: Vec<u32> = inner
        .iter()
        .flat_map(|&point| mesh.copies_of(point))
        .collect();
    let cells = mesh.cells_at_points(&all);
    let soundness = mesh.soundnesses(&cells);
    let before = mesh.miss(&cells);
    let mark = mesh.mark();
    for &point in &all {
        for face in mesh.at_point[point as usize].clone() {
            let corners = mesh.faces[face as usize].iter().copied();
            let corners: Vec<u32> = corners.filter(|&corner| corner != point).collect();
            mesh.set_loop(face, corners);
        }
    }
    let is_sound = mesh.stay_sound(&cells, &soundness);
    let is_fine = is_sound && mesh.miss(&cells).is_no_worse_than(&before);
    match is_fine {
        true => mesh.keep(),
        false => mesh.undo_to(mark),
    }
    is_fine
}
