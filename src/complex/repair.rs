//! Improvement of the cells that miss the limits: the change that gains most is made, until there is none.
//!
//! Changes are: a vertex moves (on walls along them), an edge collapses, a cell is cut along the plane of a
//! wall or of a re-entrant edge, or joined to a neighbor. All are made on trial and judged by
//! [`crate::complex::edit_shapes`]; cells stay closed balls.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};

use crate::complex::cell_union::unite;
use crate::complex::collapse::{EdgeCollapse, target, try_collapse};
use crate::complex::edit_mesh::{Behind, EditMesh, loop_edges};
use crate::complex::edit_shapes::{FAILING, Miss, Soundness};
use crate::complex::wall_cut::{CuttingPlane, cut};
use crate::complex::wall_projection::WallProjection;

/// How often all failing cells are tried.
const ROUNDS: usize = 12;

/// Changes of one cell per round.
const CHANGES: usize = 6;

/// Edges up to this share of the mean cell's side may collapse.
const LONGEST: f64 = 0.6;

/// Cells up to this share of the mean cell's volume may be joined to a neighbor.
const SMALL: f64 = 0.4;

/// Pieces of cells up to this share of the mean cell's volume are slivers.
const SLIVER: f64 = 0.05;

/// How near to a cutting plane vertices count as on it, in sides of the mean cell.
const SNAPS: [f64; 3] = [0.02, 0.08, 0.2];

/// Steps of moved vertices in sides of the mean cell.
const STEPS: [f64; 3] = [0.2, 0.07, 0.02];

/// What a cut must gain: it adds a cell.
const CUT_COST: f64 = 0.2;

/// A mesh under repair.
pub(crate) struct Repair<'a> {
    /// The mesh.
    pub(crate) mesh: &'a mut EditMesh,
    /// Its walls.
    pub(crate) walls: &'a WallProjection,
    /// The side of the mean cell (L).
    pub(crate) side: f64,
    /// Cells from this number on are further pieces of sites' cells.
    pub(crate) first_piece: u32,
    /// Whether what is around a sliver is mended so that it can join a neighbor.
    pub(crate) mends_unions: bool,
    /// Cells for which no change helps as they and their neighbors are.
    pub(crate) stuck: BTreeSet<u32>,
}

/// A change that may be made.
enum Change {
    Collapse(EdgeCollapse),
    Move(u32, Point3<f64>),
    Cut(u32, CuttingPlane),
    Unite(u32, u32),
}

impl Repair<'_> {
    /// Improves failing cells as long as any gets better; returns those that fail still.
    pub(crate) fn run(&mut self) -> Vec<u32> {
        for _ in 0..ROUNDS {
            let mut is_improved = false;
            for cell in self.failing() {
                for _ in 0..CHANGES {
                    if self.stuck.contains(&cell) || self.miss_at(cell) < FAILING {
                        break;
                    }
                    is_improved |= self.improve(cell);
                }
            }
            if !is_improved {
                break;
            }
        }
        self.failing()
    }

    /// Joins small further pieces of cells to neighbors.
    pub(crate) fn join_pieces(&mut self) {
        for cell in self.first_piece..self.mesh.of_cell.len() as u32 {
            if self.mesh.of_cell[cell as usize].is_empty() || !self.is_small(cell) {
                continue;
            }
            let unions = self.unions(cell);
            if let Some(best) = self.best(unions, f64::NEG_INFINITY) {
                self.make(&best);
                self.mesh.keep();
            }
        }
    }

    /// Joins slivers to neighbors where no face fails for it, unless they are all that a site has: solvers gain
    /// nothing from them, and lose their gradients there.
    pub(crate) fn join_slivers(&mut self) {
        let mut pieces: BTreeMap<u32, usize> = BTreeMap::new();
        let is_there = |cell: &usize| !self.mesh.of_cell[*cell].is_empty();
        for cell in (0..self.mesh.of_cell.len()).filter(is_there) {
            *pieces.entry(self.mesh.sites[cell]).or_default() += 1;
        }
        for cell in 0..self.mesh.of_cell.len() as u32 {
            let site = self.mesh.sites[cell as usize];
            let is_empty = self.mesh.of_cell[cell as usize].is_empty();
            if is_empty || pieces[&site] < 2 || !self.is_sliver(cell) {
                continue;
            }
            if self.join_sliver(cell) {
                pieces.entry(site).and_modify(|count| *count -= 1);
            }
        }
    }

    /// Joins a cell to the neighbor with which that gains most, of those where no face fails for it once what
    /// is around is mended; whether there is one.
    fn join_sliver(&mut self, cell: u32) -> bool {
        let mut unions = Vec::new();
        for other in self.beside(cell) {
            let (kept, gone) = (cell.min(other), cell.max(other));
            let mark = self.mesh.mark();
            if let Some((before, after)) = self.make(&Change::Unite(kept, gone)) {
                unions.push((before.sum - after.sum, kept, gone));
            }
            self.mesh.undo_to(mark);
        }
        unions.sort_by(|one, other| other.0.total_cmp(&one.0));
        if !self.mends_unions {
            unions.truncate(1);
        }
        for (_, kept, gone) in unions {
            let mark = self.mesh.mark();
            if self.is_mended_union(kept, gone) {
                self.mesh.keep();
                let other = if kept == cell { gone } else { kept };
                self.mesh.sites[kept as usize] = self.mesh.sites[other as usize];
                return true;
            }
            self.mesh.undo_to(mark);
        }
        false
    }

    /// Joins `gone` to `kept`, moves vertices and collapses edges around where faces fail for it; whether none
    /// does any more.
    fn is_mended_union(&mut self, kept: u32, gone: u32) -> bool {
        let Some((before, mut after)) = self.make(&Change::Unite(kept, gone)) else {
            return false;
        };
        let (cells, soundness, _) = self.around(&[kept]);
        let is_fine = |after: &Miss| after.worst < FAILING || after.worst <= before.worst;
        for _ in 0..CHANGES {
            if is_fine(&after) || !self.mends_unions {
                break;
            }
            let worst = cells
                .iter()
                .map(|&cell| (self.mesh.miss(&[cell]).worst, cell));
            let worst = worst.max_by(|one, other| one.0.total_cmp(&other.0));
            let Some((_, cell)) = worst else { break };
            let mut changes = self.collapses(cell);
            changes.extend(self.moves(cell));
            let Some(best) = self.best(changes, 1e-6) else {
                break;
            };
            self.make(&best);
            after = self.mesh.miss(&cells);
        }
        is_fine(&after) && self.mesh.stay_sound(&cells, &soundness)
    }

    fn is_sliver(&mut self, cell: u32) -> bool {
        self.mesh.cell_shape(cell).volume < SLIVER * self.side.powi(3)
    }

    /// The cells that miss the limits too far, ascending.
    pub(crate) fn failing(&mut self) -> Vec<u32> {
        let mut cells = Vec::new();
        for face in 0..self.mesh.faces.len() as u32 {
            if !self.mesh.faces[face as usize].is_empty() && self.mesh.miss_of(face) >= FAILING {
                cells.extend(self.mesh.cells_at(face));
            }
        }
        let not_balls =
            (0..self.mesh.of_cell.len() as u32).filter(|&cell| !self.mesh.is_ball(cell));
        cells.extend(not_balls);
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The worst miss of a cell; of one that is no ball, infinite.
    fn miss_at(&mut self, cell: u32) -> f64 {
        match self.mesh.is_ball(cell) {
            true => self.mesh.miss(&[cell]).worst,
            false => f64::INFINITY,
        }
    }

    /// Makes the change that gains most.
    fn improve(&mut self, cell: u32) -> bool {
        let mut changes = self.collapses(cell);
        changes.extend(self.moves(cell));
        changes.extend(self.cuts(cell));
        changes.extend(self.unions(cell));
        match self.best(changes, 1e-6) {
            Some(best) => {
                self.make(&best);
                self.mesh.keep();
                let (around, ..) = self.around(&[cell]);
                for other in around {
                    self.stuck.remove(&other);
                }
                true
            }
            None => {
                self.stuck.insert(cell);
                false
            }
        }
    }

    /// The change that gains most, if that is more than `least`.
    fn best(&mut self, changes: Vec<Change>, least: f64) -> Option<Change> {
        let mut best: Option<(f64, Change)> = None;
        for change in changes {
            let mark = self.mesh.mark();
            let gain = self.make(&change).map(|(before, after)| {
                let cost = if matches!(change, Change::Cut(..)) {
                    CUT_COST
                } else {
                    0.0
                };
                let is_allowed = after.worst <= before.worst + 1e-9 || least < 0.0;
                if is_allowed {
                    before.sum - after.sum - cost
                } else {
                    f64::NEG_INFINITY
                }
            });
            self.mesh.undo_to(mark);
            let Some(gain) = gain else { continue };
            if gain > least && best.as_ref().is_none_or(|(known, _)| gain > *known) {
                best = Some((gain, change));
            }
        }
        best.map(|(_, change)| change)
    }

    /// Makes a change and returns what cells around missed and miss; nothing where cells do not stay sound,
    /// perhaps with the mesh half changed.
    fn make(&mut self, change: &Change) -> Option<(Miss, Miss)> {
        match change {
            Change::Collapse(edge) => try_collapse(self.mesh, edge, 0.3 * self.side),
            Change::Move(point, place) => {
                let copies = self.mesh.copies_of(*point);
                let cells = self.mesh.cells_at_points(&copies);
                let before = self.mesh.miss(&cells);
                self.mesh.move_point(*point, *place);
                Some((before, self.mesh.miss(&cells)))
            }
            Change::Cut(cell, plane) => {
                let (cells, soundness, before) = self.around(&[*cell]);
                let upper = cut(self.mesh, *cell, plane, self.walls)?;
                self.judge(&[cells, vec![upper]].concat(), &soundness, before)
            }
            Change::Unite(kept, gone) => {
                let (cells, soundness, before) = self.around(&[*kept, *gone]);
                unite(self.mesh, *kept, *gone);
                self.judge(&cells, &soundness, before)
            }
        }
    }

    /// Cells and their neighbors, how sound they are, and what they miss.
    fn around(&mut self, cells: &[u32]) -> (Vec<u32>, Vec<Soundness>, Miss) {
        let faces = self.mesh.faces_of(cells);
        let all = faces
            .iter()
            .flat_map(|&face| self.mesh.faces[face as usize].clone());
        let mut points: Vec<u32> = all.collect();
        points.sort_unstable();
        points.dedup();
        let cells = self.mesh.cells_at_points(&points);
        let soundness = self.mesh.soundnesses(&cells);
        let miss = self.mesh.miss(&cells);
        (cells, soundness, miss)
    }

    /// What cells missed and miss; a cell that becomes a ball counts more than any shape. Nothing where cells
    /// do not stay sound.
    fn judge(
        &mut self,
        cells: &[u32],
        soundness: &[Soundness],
        mut before: Miss,
    ) -> Option<(Miss, Miss)> {
        let (old, new) = cells.split_at(soundness.len());
        if !self.mesh.stay_sound(old, soundness)
            || new
                .iter()
                .any(|&cell| self.mesh.soundness(cell) == Soundness::Open)
        {
            return None;
        }
        let are_balls =
            |all: &[Soundness]| all.iter().filter(|&&one| one == Soundness::Ball).count();
        let gained = are_balls(&self.mesh.soundnesses(old)) - are_balls(soundness);
        if gained > 0 {
            before.sum += 1000.0 * gained as f64;
            before.worst = f64::INFINITY;
        }
        Some((before, self.mesh.miss(cells)))
    }

    fn collapses(&mut self, cell: u32) -> Vec<Change> {
        let faces = self.mesh.of_cell[cell as usize].iter();
        let edges = faces.flat_map(|&face| loop_edges(&self.mesh.faces[face as usize]));
        let mut edges: Vec<(u32, u32)> = edges.map(|(a, b)| (a.min(b), a.max(b))).collect();
        edges.sort_unstable();
        edges.dedup();
        edges.retain(|&(a, b)| self.mesh.edge_length(a, b) < LONGEST * self.side);
        let ways = [[1.0, 1.0], [1.0, 1e-12], [1e-12, 1.0]];
        let targets = edges
            .into_iter()
            .flat_map(|edge| ways.map(|weights| (edge, weights)));
        let mut found: Vec<EdgeCollapse> = targets
            .filter_map(|(edge, weights)| target(self.mesh, edge, weights, Some(self.walls)))
            .collect();
        found.dedup_by(|one, other| {
            (one.kept, one.gone) == (other.kept, other.gone) && one.place == other.place
        });
        found.into_iter().map(Change::Collapse).collect()
    }

    fn moves(&mut self, cell: u32) -> Vec<Change> {
        let mut points = Vec::new();
        for face in self.mesh.of_cell[cell as usize].clone() {
            if self.mesh.miss_of(face) > 0.5 * FAILING {
                points.extend_from_slice(&self.mesh.faces[face as usize]);
            }
        }
        points.sort_unstable();
        points.dedup();
        points.retain(|point| !self.mesh.pinned.contains(point));
        let mut moves = Vec::new();
        for point in points {
            let patches = self.mesh.patches_at(point);
            let here = self.mesh.points[point as usize];
            let ends = self.mesh.neighbors(point);
            let sum: Vector3<f64> = ends
                .iter()
                .map(|&at| self.mesh.points[at as usize].coords)
                .sum();
            let toward = sum / ends.len().max(1) as f64 - here.coords;
            let mut places = vec![here + 0.5 * toward, here + toward];
            for step in STEPS {
                for axis in [Vector3::x(), Vector3::y(), Vector3::z()] {
                    places.extend([1.0, -1.0].map(|sign| here + axis * (sign * step * self.side)));
                }
            }
            let place = |place: Point3<f64>| match patches.is_empty() {
                true => Some(place),
                false => self.walls.nearest(&patches, &place),
            };
            let places = places.into_iter().filter_map(place);
            moves.extend(places.map(|place| Change::Move(point, place)));
        }
        moves
    }

    fn cuts(&mut self, cell: u32) -> Vec<Change> {
        let mut planes = Vec::new();
        let mut faces = self.mesh.of_cell[cell as usize].clone();
        faces.retain(|&face| self.mesh.patch(face).is_some());
        for &face in &faces {
            let shape = self.mesh.face_shape(face);
            let corners = self.mesh.faces[face as usize].clone();
            planes.push((shape.center, shape.area, corners));
        }
        for (place, &one) in faces.iter().enumerate() {
            for &other in &faces[place + 1..] {
                planes.extend(self.bisector(one, other));
            }
        }
        let planes = planes.into_iter().filter_map(|(point, normal, on)| {
            let normal = normal.try_normalize(1e-300)?;
            Some(SNAPS.map(|snap| CuttingPlane {
                point,
                normal,
                on: on.clone(),
                reach: snap * self.side,
            }))
        });
        let planes: Vec<CuttingPlane> = planes.flatten().collect();
        planes
            .into_iter()
            .map(|plane| Change::Cut(cell, plane))
            .collect()
    }

    /// The plane that halves the angle between two faces at their common edge.
    fn bisector(&mut self, one: u32, other: u32) -> Option<(Point3<f64>, Vector3<f64>, Vec<u32>)> {
        let corners = &self.mesh.faces[other as usize];
        let common = self.mesh.faces[one as usize].iter().copied();
        let on: Vec<u32> = common.filter(|corner| corners.contains(corner)).collect();
        if on.len() < 2 {
            return None;
        }
        let [a, b] = [one, other].map(|face| self.mesh.face_shape(face).area);
        let normal = a.try_normalize(1e-300)? - b.try_normalize(1e-300)?;
        Some((self.mesh.points[on[0] as usize], normal, on))
    }

    /// The cells that have a face with a cell, ascending.
    fn beside(&self, cell: u32) -> Vec<u32> {
        let mut others = Vec::new();
        for &face in &self.mesh.of_cell[cell as usize] {
            if let Behind::Cell(other) = self.mesh.behind[face as usize] {
                others.push(if other == cell {
                    self.mesh.owner[face as usize]
                } else {
                    other
                });
            }
        }
        others.sort_unstable();
        others.dedup();
        others
    }

    fn unions(&mut self, cell: u32) -> Vec<Change> {
        let mut unions = Vec::new();
        for other in self.beside(cell) {
            let (kept, gone) = match cell < other {
                true => (cell, other),
                false => (other, cell),
            };
            let is_piece = gone >= self.first_piece;
            if self.is_small(cell) && cell == gone
                || self.is_small(other) && other == gone
                || is_piece && (self.is_small(kept) || self.is_small(gone))
            {
                unions.push(Change::Unite(kept, gone));
            }
        }
        unions
    }

    fn is_small(&mut self, cell: u32) -> bool {
        self.mesh.cell_shape(cell).volume < SMALL * self.side.powi(3)
    }
}
