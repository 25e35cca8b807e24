//! Collapse of short edges, shortest first, as long as cells stay sound and quality does not fall.
//!
//! A vertex goes to the other end of its edge if more patches meet there, else to the middle of all that
//! has gone there so far; on walls always to a place that was a vertex. A collapse is refused where a
//! cell would not stay a closed ball of faces that are all different, a face would turn or bend too far,
//! and where a face would lean, or the pyramid over it shrink, beyond both a limit and what it was. A cell
//! that is no good already may stay so.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use nalgebra::{Point3, Vector3};

use crate::complex::edit_mesh::{Behind, EditMesh, adjacent, loop_edges};

/// A face must keep this share of the sum of its triangles' areas.
const FLAT: f64 = 0.9;

/// Cosine of how far a face may turn: 35 degrees.
const TURN: f64 = 0.819_152_044_288_991_8;

/// Cosine of how far a face may lean against the line of its cells' centers: 45 degrees.
const LEAN: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Heights of pyramids over faces below this share of the mean cell's side may not shrink.
const HEIGHT: f64 = 0.05;

/// Faces that are new since a vertex moved.
type NewFaces = BTreeMap<u32, Vec<u32>>;

/// Collapses all edges shorter than `reach` (L) that may be, in a mesh whose mean cell has side `side`
/// (L). Returns how many were collapsed and how many were refused.
pub(crate) fn collapse(mesh: &mut EditMesh, reach: f64, side: f64) -> (usize, usize) {
    let mut collapse = Collapse {
        weights: vec![1.0; mesh.points.len()],
        mesh,
        reach,
        side,
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
    side: f64,
    /// Edges by the bits of their lengths, which sort like the lengths.
    queue: BinaryHeap<Reverse<(u64, u32, u32)>>,
}

impl Collapse<'_> {
    fn length(&self, a: u32, b: u32) -> f64 {
        (self.mesh.points[a as usize] - self.mesh.points[b as usize]).norm()
    }

    fn push(&mut self, a: u32, b: u32) {
        let length = self.length(a, b);
        if length < self.reach {
            self.queue
                .push(Reverse((length.to_bits(), a.min(b), a.max(b))));
        }
    }

    /// Whether the edge is still there, as long as it was.
    fn is_current(&self, length: u64, a: u32, b: u32) -> bool {
        let faces = &self.mesh.at_point[a as usize];
        self.length(a, b).to_bits() == length
            && faces
                .iter()
                .any(|&face| adjacent(&self.mesh.faces[face as usize], a, b))
    }

    /// Collapses an edge if it may be.
    fn try_edge(&mut self, a: u32, b: u32) -> bool {
        let Some((kept, gone, place)) = self.target(a, b) else {
            return false;
        };
        let [at_kept, at_gone] = [kept, gone].map(|point| &self.mesh.at_point[point as usize]);
        let common = at_kept.intersection(at_gone);
        let is_pinched = |face: &u32| !adjacent(&self.mesh.faces[*face as usize], a, b);
        if common.into_iter().any(is_pinched) {
            return false;
        }
        let faces: BTreeSet<u32> = at_kept | at_gone;
        let new: NewFaces = faces
            .iter()
            .map(|&face| (face, renamed(&self.mesh.faces[face as usize], gone, kept)))
            .collect();
        if !self.is_allowed(&new, (kept, gone), place) {
            return false;
        }
        self.mesh.points[kept as usize] = place;
        self.weights[kept as usize] += self.weights[gone as usize];
        for (face, corners) in new {
            self.mesh.replace_face(face, corners);
        }
        let around: BTreeSet<u32> = self.neighbors(kept);
        for other in around {
            self.push(kept, other);
        }
        true
    }

    fn neighbors(&self, point: u32) -> BTreeSet<u32> {
        let faces = self.mesh.at_point[point as usize].iter();
        let edges = faces.flat_map(|&face| loop_edges(&self.mesh.faces[face as usize]));
        edges
            .filter(|&(from, _)| from == point)
            .map(|(_, to)| to)
            .collect()
    }

    /// Which end stays, which goes, and where they meet; none where walls forbid it.
    fn target(&self, a: u32, b: u32) -> Option<(u32, u32, Point3<f64>)> {
        let [at_a, at_b] = [a, b].map(|point| self.mesh.patches_at(point));
        let (kept, gone, most, least) = match at_b.len() > at_a.len() {
            true => (b, a, at_b, at_a),
            false => (a, b, at_a, at_b),
        };
        if !least.is_subset(&most) || least.len() >= 3 {
            return None;
        }
        // On walls an edge must lie in as many patches as its less bound end.
        let here = self.mesh.at_point[a as usize].iter();
        let along = here.filter(|&&face| adjacent(&self.mesh.faces[face as usize], a, b));
        let along: BTreeSet<u32> = along.filter_map(|&face| self.mesh.patch(face)).collect();
        if !least.is_subset(&along) {
            return None;
        }
        let [from, to] = [kept, gone].map(|point| self.mesh.points[point as usize]);
        let [weight, other] = [kept, gone].map(|point| self.weights[point as usize]);
        let place = match most.is_empty() {
            true => from + (to - from) * (other / (weight + other)),
            false => from,
        };
        Some((kept, gone, place))
    }

    /// Whether cells stay sound and quality does not fall.
    fn is_allowed(&mut self, new: &NewFaces, (kept, gone): (u32, u32), place: Point3<f64>) -> bool {
        let cells: BTreeSet<u32> = new
            .keys()
            .flat_map(|&face| self.mesh.cells_at(face))
            .collect();
        if !cells.iter().all(|&cell| self.is_ball(cell, new)) {
            return false;
        }
        let before = Measures::of(self.mesh, &cells, &NewFaces::new());
        let old = self.mesh.points[kept as usize];
        self.mesh.points[kept as usize] = place;
        let after = Measures::of(self.mesh, &cells, new);
        self.mesh.points[kept as usize] = old;
        let moved: BTreeSet<u32> = [kept, gone]
            .map(|point| &self.mesh.at_point[point as usize])
            .into_iter()
            .flatten()
            .copied()
            .collect();
        after.is_no_worse_than(&before, &moved, self.reach, self.side)
    }

    /// Whether a cell is a closed ball of different faces.
    fn is_ball(&self, cell: u32, new: &NewFaces) -> bool {
        let (mut edges, mut points) = (BTreeSet::new(), BTreeSet::new());
        let (mut sets, mut count) = (BTreeSet::new(), 0);
        for &face in &self.mesh.of_cell[cell as usize] {
            let corners = new.get(&face).unwrap_or(&self.mesh.faces[face as usize]);
            if corners.len() < 3 {
                continue;
            }
            count += 1;
            points.extend(corners.iter().copied());
            sets.insert(corners.iter().copied().collect::<BTreeSet<u32>>());
            for (from, to) in loop_edges(corners) {
                let edge = match self.mesh.owner[face as usize] == cell {
                    true => (from, to),
                    false => (to, from),
                };
                if !edges.insert(edge) {
                    return false;
                }
            }
        }
        let is_closed = edges.iter().all(|&(from, to)| edges.contains(&(to, from)));
        is_closed
            && count >= 4
            && sets.len() == count
            && points.len() + count == edges.len() / 2 + 2
    }
}

/// A loop with a point renamed, and not named twice in a row.
fn renamed(corners: &[u32], gone: u32, kept: u32) -> Vec<u32> {
    let name = |&point: &u32| if point == gone { kept } else { point };
    let mut renamed: Vec<u32> = corners.iter().map(name).collect();
    renamed.dedup();
    if renamed.len() > 1 && renamed.first() == renamed.last() {
        renamed.pop();
    }
    renamed
}

/// Quality around some cells.
struct Measures {
    faces: BTreeMap<u32, FaceMeasure>,
    /// The least ratio of pyramids and flatness in every cell, for what is good and what is not.
    are_good: BTreeMap<u32, bool>,
}

#[derive(Clone, Copy)]
struct FaceMeasure {
    area: Vector3<f64>,
    flatness: f64,
    /// The cosine of its lean, 1 on walls.
    lean: f64,
    /// The least height (L) of the pyramids over it.
    height: f64,
}

impl Measures {
    /// The measures of the faces of `cells` with some of them new.
    fn of(mesh: &EditMesh, cells: &BTreeSet<u32>, new: &NewFaces) -> Self {
        let corners = |face: u32| {
            new.get(&face)
                .unwrap_or(&mesh.faces[face as usize])
                .as_slice()
        };
        let faces: BTreeSet<u32> = cells
            .iter()
            .flat_map(|&cell| mesh.of_cell[cell as usize].iter().copied())
            .filter(|&face| corners(face).len() >= 3)
            .collect();
        let behind = faces.iter().flat_map(|&face| mesh.cells_at(face));
        let all: BTreeSet<u32> = behind.collect();
        let center = |cell: u32| {
            let faces = mesh.of_cell[cell as usize].iter();
            let faces = faces.filter(|&&face| corners(face).len() >= 3);
            let signed = faces.map(|&face| {
                let (center, area) = mesh.measure(corners(face));
                let is_owner = mesh.owner[face as usize] == cell;
                (center.coords, if is_owner { area } else { -area })
            });
            center_of(&signed.collect::<Vec<_>>())
        };
        let centers: BTreeMap<u32, Point3<f64>> =
            all.iter().map(|&cell| (cell, center(cell))).collect();
        let measure = |&face: &u32| (face, FaceMeasure::of(mesh, face, corners(face), &centers));
        let faces: BTreeMap<u32, FaceMeasure> = faces.iter().map(measure).collect();
        let is_good = |&cell: &u32| {
            let own = mesh.of_cell[cell as usize].iter();
            let own = own.filter_map(|face| faces.get(face));
            (
                cell,
                own.into_iter()
                    .all(|face| face.height > 0.0 && face.flatness >= FLAT),
            )
        };
        let are_good = cells.iter().map(is_good).collect();
        Self { faces, are_good }
    }

    fn is_no_worse_than(
        &self,
        before: &Self,
        moved: &BTreeSet<u32>,
        reach: f64,
        side: f64,
    ) -> bool {
        let stays_good = |(cell, &is_good): (&u32, &bool)| is_good || !before.are_good[cell];
        let kept_good = self.are_good.iter().all(stays_good);
        let is_fine = |(face, now): (&u32, &FaceMeasure)| {
            let Some(then) = before.faces.get(face) else {
                return false;
            };
            let is_small = then.area.norm() <= 4.0 * reach * reach;
            let cosine = then.area.dot(&now.area) / (then.area.norm() * now.area.norm());
            let turns = moved.contains(face) && !is_small && cosine < TURN;
            let leans = now.lean < LEAN.min(then.lean - 1e-9);
            let sinks = now.height < (HEIGHT * side).min(then.height - 1e-9 * side);
            !turns && !leans && !sinks && now.area.norm() > 1e-14 * side * side
        };
        kept_good && self.faces.iter().all(is_fine)
    }
}

/// The center of mass of a cell, by pyramids over the mean of its faces' centers.
fn center_of(faces: &[(Vector3<f64>, Vector3<f64>)]) -> Point3<f64> {
    let mean = faces.iter().map(|(center, _)| center).sum::<Vector3<f64>>() / faces.len() as f64;
    let (mut weighted, mut sum) = (Vector3::zeros(), 0.0);
    for (center, area) in faces {
        let pyramid = area.dot(&(center - mean));
        weighted += pyramid * (0.75 * center + 0.25 * mean);
        sum += pyramid;
    }
    Point3::from(if sum > 0.0 { weighted / sum } else { mean })
}

impl FaceMeasure {
    fn of(
        mesh: &EditMesh,
        face: u32,
        corners: &[u32],
        centers: &BTreeMap<u32, Point3<f64>>,
    ) -> Self {
        let (center, area) = mesh.measure(corners);
        let size = area.norm().max(1e-300);
        let owner = centers[&mesh.owner[face as usize]];
        let below = area.dot(&(center - owner)) / size;
        let (lean, height) = match mesh.behind[face as usize] {
            Behind::Patch(_) => (1.0, below),
            Behind::Cell(cell) => {
                let line = centers[&cell] - owner;
                let above = area.dot(&(centers[&cell] - center)) / size;
                (
                    area.dot(&line) / (size * line.norm().max(1e-300)),
                    below.min(above),
                )
            }
        };
        let place = |point: u32| mesh.points[point as usize];
        let triangles = loop_edges(corners).map(|(from, to)| {
            0.5 * (place(to) - place(from))
                .cross(&(center - place(from)))
                .norm()
        });
        Self {
            area,
            flatness: area.norm() / triangles.sum::<f64>().max(1e-300),
            lean,
            height,
        }
    }
}

/// Removes vertices with two edges in the whole mesh that lie within `reach` (L) of the line between
/// their neighbors; those in which three patches meet stay, and faces keep three corners.
pub(crate) fn straighten_edges(mesh: &mut EditMesh, reach: f64) -> usize {
    let mut removed = 0;
    for point in 0..mesh.points.len() as u32 {
        let faces: Vec<u32> = mesh.at_point[point as usize].iter().copied().collect();
        let edges = faces
            .iter()
            .flat_map(|&face| loop_edges(&mesh.faces[face as usize]));
        let ends: BTreeSet<u32> = edges
            .filter_map(|(from, to)| match point {
                _ if from == point => Some(to),
                _ if to == point => Some(from),
                _ => None,
            })
            .collect();
        let ends: Vec<u32> = ends.into_iter().collect();
        let &[one, other] = ends.as_slice() else {
            continue;
        };
        let place = |point: u32| mesh.points[point as usize];
        let (chord, arm) = (place(other) - place(one), place(point) - place(one));
        let is_near = chord.cross(&arm).norm() <= reach * chord.norm();
        let has_room = faces.iter().all(|&face| {
            let corners = &mesh.faces[face as usize];
            corners.len() > 3 && !adjacent(corners, one, other)
        });
        if is_near && has_room && mesh.patches_at(point).len() < 3 {
            for face in faces {
                let corners = mesh.faces[face as usize].iter().copied();
                let corners = corners.filter(|&corner| corner != point).collect();
                mesh.replace_face(face, corners);
            }
            removed += 1;
        }
    }
    removed
}
