//! Collapse of short edges, shortest first, as long as cells stay sound and quality does not fall.
//!
//! A vertex goes to the other end of its edge if more patches meet there, else to the middle of all that
//! has gone there so far; on curved walls to the nearest place of the wall. A collapse is refused where a
//! cell would not stay a closed ball of faces that are all different, a face would turn too far, or
//! anything around would miss a stated limit by more than before ([`crate::complex::edit_shapes`]).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point3, Vector3};

use crate::complex::edit_mesh::{EditMesh, adjacent};
use crate::complex::edit_shapes::Miss;
use crate::complex::wall_projection::WallProjection;

/// Cosine of how far a face may turn: 35 degrees.
const TURN: f64 = 0.819_152_044_288_991_8;

/// Faces of this area, relative to the square of the reach, are none: only one that is none may become another.
const NO_AREA: f64 = 1e-14;

/// What may happen to an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeCollapse {
    /// The end that stays.
    pub(crate) kept: u32,
    /// The end that goes.
    pub(crate) gone: u32,
    /// Where it goes.
    pub(crate) place: Point3<f64>,
}

/// Collapses all edges shorter than `reach` (L) that may be. Returns how many were collapsed and how many
/// were refused.
pub(crate) fn collapse(
    mesh: &mut EditMesh,
    reach: f64,
    walls: Option<&WallProjection>,
) -> (usize, usize) {
    let mut collapse = Collapse {
        weights: vec![1.0; mesh.points.len()],
        mesh,
        reach,
        walls,
        queue: BinaryHeap::new(),
    };
    for (a, b) in collapse.mesh.edges() {
        collapse.push(a, b);
    }
    let mut counts = (0, 0);
    while let Some(Reverse((length, a, b))) = collapse.queue.pop() {
        if !collapse.is_current(length, a, b) {
            continue;
        }
        let is_collapsed = usize::from(collapse.try_edge(a, b));
        counts = (counts.0 + is_collapsed, counts.1 + 1 - is_collapsed);
    }
    counts
}

struct Collapse<'a> {
    mesh: &'a mut EditMesh,
    /// Per point: how many vertices it stands for.
    weights: Vec<f64>,
    reach: f64,
    walls: Option<&'a WallProjection>,
    /// Edges by the bits of their lengths, which sort like the lengths.
    queue: BinaryHeap<Reverse<(u64, u32, u32)>>,
}

impl Collapse<'_> {
    fn push(&mut self, a: u32, b: u32) {
        let length = self.mesh.edge_length(a, b);
        if length < self.reach {
            self.queue
                .push(Reverse((length.to_bits(), a.min(b), a.max(b))));
        }
    }

    /// Whether the edge is still there, as long as it was.
    fn is_current(&self, length: u64, a: u32, b: u32) -> bool {
        self.mesh.edge_length(a, b).to_bits() == length && self.mesh.has_edge(a, b)
    }

    /// Collapses an edge if it may be.
    fn try_edge(&mut self, a: u32, b: u32) -> bool {
        let weights = [a, b].map(|point| self.weights[point as usize]);
        let Some(edge) = target(self.mesh, (a, b), weights, self.walls) else {
            return false;
        };
        if !apply_if_no_worse(self.mesh, &edge, self.reach) {
            return false;
        }
        self.weights[edge.kept as usize] = weights[0] + weights[1];
        for other in self.mesh.neighbors(edge.kept) {
            self.push(edge.kept, other);
        }
        true
    }
}

impl EditMesh {
    /// The distance of two points (L).
    #[must_use]
    pub(crate) fn edge_length(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm()
    }

    /// Whether two points are the ends of an edge.
    #[must_use]
    pub(crate) fn has_edge(&self, a: u32, b: u32) -> bool {
        let mut faces = self.at_point[a as usize].iter();
        faces.any(|&face| adjacent(&self.faces[face as usize], a, b))
    }

    /// The faces along an edge.
    #[must_use]
    pub(crate) fn faces_along(&self, a: u32, b: u32) -> Vec<u32> {
        let faces = self.at_point[a as usize].iter().copied();
        faces
            .filter(|&face| adjacent(&self.faces[face as usize], a, b))
            .collect()
    }
}

/// Which end stays, which goes, and where they meet; none where walls forbid it. `weights` say how many
/// vertices the ends stand for.
#[must_use]
pub(crate) fn target(
    mesh: &EditMesh,
    (a, b): (u32, u32),
    weights: [f64; 2],
    walls: Option<&WallProjection>,
) -> Option<EdgeCollapse> {
    let bound = |point: u32| (mesh.pinned.contains(&point), mesh.patches_at(point));
    let (at_a, at_b) = (bound(a), bound(b));
    let rank = |(is_pinned, patches): &(bool, Vec<u32>)| (*is_pinned, patches.len());
    let is_turned = rank(&at_b) > rank(&at_a);
    let ((kept, most, heavy), (gone, least, light)) = match is_turned {
        true => ((b, at_b, weights[1]), (a, at_a, weights[0])),
        false => ((a, at_a, weights[0]), (b, at_b, weights[1])),
    };
    let is_in = |all: &[u32]| least.1.iter().all(|patch| all.contains(patch));
    if least.0 || least.1.len() >= 3 || !is_in(&most.1) {
        return None;
    }
    // On walls an edge must lie in as many patches as its less bound end.
    let along = mesh.faces_along(a, b).into_iter();
    let along: Vec<u32> = along.filter_map(|face| mesh.patch(face)).collect();
    if !is_in(&along) || mesh.copies_of(a).contains(&b) {
        return None;
    }
    let [from, to] = [kept, gone].map(|point| mesh.points[point as usize]);
    let middle = from + (to - from) * (light / (heavy + light));
    let place = match (most.0 || most.1 != least.1, walls) {
        (true, _) => from,
        (false, Some(walls)) if !most.1.is_empty() => walls.nearest(&most.1, &middle)?,
        (false, _) => middle,
    };
    Some(EdgeCollapse { kept, gone, place })
}

/// Collapses an edge unless something gets worse. Faces that are larger than `reach` (L) must not turn far.
pub(crate) fn apply_if_no_worse(mesh: &mut EditMesh, edge: &EdgeCollapse, reach: f64) -> bool {
    let mark = mesh.mark();
    let Some((before, after)) = try_collapse(mesh, edge, reach) else {
        return false;
    };
    let is_fine = after.is_no_worse_than(&before);
    match is_fine {
        true => mesh.keep(),
        false => mesh.undo_to(mark),
    }
    is_fine
}

/// Collapses an edge and returns what cells around missed and miss; nothing, with the mesh as it was, where
/// cells do not stay sound.
pub(crate) fn try_collapse(
    mesh: &mut EditMesh,
    edge: &EdgeCollapse,
    reach: f64,
) -> Option<(Miss, Miss)> {
    let &EdgeCollapse { kept, gone, place } = edge;
    let points = [mesh.copies_of(kept), mesh.copies_of(gone)].concat();
    let cells = mesh.cells_at_points(&points);
    let soundness = mesh.soundnesses(&cells);
    let before = mesh.miss(&cells);
    let faces: Vec<u32> = points
        .iter()
        .flat_map(|&point| mesh.at_point[point as usize].clone())
        .collect();
    let areas: Vec<Vector3<f64>> = faces.iter().map(|&f| mesh.face_shape(f).area).collect();
    let mark = mesh.mark();
    mesh.collapse_edge(kept, gone, place);
    let stay = mesh.stay_sound(&cells, &soundness);
    let is_there = |cell: &u32| !mesh.of_cell[*cell as usize].is_empty();
    if !stay || !cells.iter().all(is_there) || turn(mesh, &faces, &areas, reach) {
        mesh.undo_to(mark);
        return None;
    }
    let after = mesh.miss(&cells);
    Some((before, after))
}

/// Whether a face that is not small turns too far, or one is lost.
fn turn(mesh: &mut EditMesh, faces: &[u32], before: &[Vector3<f64>], reach: f64) -> bool {
    faces.iter().zip(before).any(|(&face, then)| {
        if mesh.faces[face as usize].is_empty() {
            return false;
        }
        let now = mesh.face_shape(face).area;
        let (large, small) = (then.norm(), now.norm());
        let is_none = |area: f64| area <= NO_AREA * reach * reach;
        is_none(small) && !is_none(large)
            || large > 4.0 * reach * reach && then.dot(&now) < TURN * large * small
    })
}
