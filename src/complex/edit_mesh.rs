//! A mesh that can be changed face by face and changed back.
//!
//! All changes go through a journal, so that a change is made first, judged, and undone where it does not
//! pass. In a periodic mesh a vertex on a period has copies, one at each image; whoever changes one changes
//! all ([`EditMesh::move_point`], [`EditMesh::collapse_edge`]).

use std::collections::BTreeSet;
use std::mem;

use nalgebra::{Point3, Vector3};

use crate::complex::loop_shape::{CellShape, FaceShape};
use crate::complex::point_copies::{Joined, PointCopies};
use crate::complex::vertex_key::Shift;
use crate::mesh::poly_mesh::PolyMesh;

/// What lies behind a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Behind {
    /// A cell.
    Cell(u32),
    /// The outside, through a wall of a patch.
    Wall(u32),
    /// The face one period away, and the patch in which this one is.
    Image {
        /// The other face.
        face: u32,
        /// This face's patch.
        patch: u32,
    },
}

/// A change that can be undone.
#[derive(Clone, Debug)]
enum Undo {
    Point,
    Move(u32, Point3<f64>),
    Loop(u32, Vec<u32>),
    Sides(u32, u32, Behind),
    Face,
    Cell,
    Join(Joined),
}

/// A patch: its name, and the number of and the way (L) to the one a period away.
type EditPatch = (String, Option<(usize, Vector3<f64>)>);

/// A mesh under change.
#[derive(Clone, Debug)]
pub(crate) struct EditMesh {
    /// All points, those without faces too.
    pub(crate) points: Vec<Point3<f64>>,
    /// The loops of all faces, outward of the owner; those that are gone are empty.
    pub(crate) faces: Vec<Vec<u32>>,
    /// The owner of every face.
    pub(crate) owner: Vec<u32>,
    /// What lies on its other side.
    pub(crate) behind: Vec<Behind>,
    /// The faces at every point.
    pub(crate) at_point: Vec<Vec<u32>>,
    /// The faces of every cell; those that are gone have none.
    pub(crate) of_cell: Vec<Vec<u32>>,
    /// Points that may not move: corners of the walls.
    pub(crate) pinned: BTreeSet<u32>,
    /// The sites of the cells.
    pub(crate) sites: Vec<u32>,
    /// The patches: names, and the way to their partners (L).
    pub(crate) patches: Vec<EditPatch>,
    /// The images of points.
    pub(crate) copies: PointCopies,
    journal: Vec<Undo>,
    pub(crate) face_shapes: Vec<Option<FaceShape>>,
    pub(crate) cell_shapes: Vec<Option<CellShape>>,
}

impl EditMesh {
    /// A copy of `mesh`.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh) -> Self {
        let mut edited = Self {
            points: mesh.points.clone(),
            faces: mesh.faces().map(<[u32]>::to_vec).collect(),
            owner: mesh.owner.clone(),
            behind: (0..mesh.face_count())
                .map(|face| behind(mesh, face))
                .collect(),
            at_point: vec![Vec::new(); mesh.points.len()],
            of_cell: vec![Vec::new(); mesh.cell_count],
            pinned: BTreeSet::new(),
            sites: mesh.sites.clone(),
            patches: mesh
                .patches
                .iter()
                .map(|patch| (patch.name.clone(), patch.partner))
                .collect(),
            copies: PointCopies::of(mesh),
            journal: Vec::new(),
            face_shapes: vec![None; mesh.face_count()],
            cell_shapes: vec![None; mesh.cell_count],
        };
        for face in 0..edited.faces.len() as u32 {
            edited.attach(face);
        }
        edited
    }

    /// The cells on both sides of a face.
    pub(crate) fn cells_at(&self, face: u32) -> impl Iterator<Item = u32> + use<> {
        let other = match self.behind[face as usize] {
            Behind::Cell(cell) => Some(cell),
            _ => None,
        };
        std::iter::once(self.owner[face as usize]).chain(other)
    }

    /// The patch of a face on a wall.
    #[must_use]
    pub(crate) fn patch(&self, face: u32) -> Option<u32> {
        match self.behind[face as usize] {
            Behind::Wall(patch) => Some(patch),
            _ => None,
        }
    }

    /// The patches of walls that meet in a point.
    #[must_use]
    pub(crate) fn patches_at(&self, point: u32) -> Vec<u32> {
        let faces = self.at_point[point as usize].iter();
        let mut patches: Vec<u32> = faces.filter_map(|&face| self.patch(face)).collect();
        patches.sort_unstable();
        patches.dedup();
        patches
    }

    /// The cells at some points, ascending.
    #[must_use]
    pub(crate) fn cells_at_points(&self, points: &[u32]) -> Vec<u32> {
        let faces = points
            .iter()
            .flat_map(|&point| self.at_point[point as usize].iter());
        let mut cells: Vec<u32> = faces.flat_map(|&face| self.cells_at(face)).collect();
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The faces of some cells, ascending.
    #[must_use]
    pub(crate) fn faces_of(&self, cells: &[u32]) -> Vec<u32> {
        let faces = cells
            .iter()
            .flat_map(|&cell| self.of_cell[cell as usize].iter().copied());
        let mut faces: Vec<u32> = faces.collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// The loop of a face as it is seen from outside one of its cells.
    #[must_use]
    pub(crate) fn outward(&self, face: u32, cell: u32) -> Vec<u32> {
        let corners = &self.faces[face as usize];
        match self.owner[face as usize] == cell {
            true => corners.clone(),
            false => corners.iter().rev().copied().collect(),
        }
    }

    /// The edges of all faces, each once, ascending.
    #[must_use]
    pub(crate) fn edges(&self) -> Vec<(u32, u32)> {
        let loops = self.faces.iter().flat_map(|corners| loop_edges(corners));
        let mut edges: Vec<(u32, u32)> = loops.map(|(a, b)| (a.min(b), a.max(b))).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// The other ends of a point's edges, ascending.
    #[must_use]
    pub(crate) fn neighbors(&self, point: u32) -> Vec<u32> {
        let mut ends = Vec::new();
        for &face in &self.at_point[point as usize] {
            for (from, to) in loop_edges(&self.faces[face as usize]) {
                if from == point {
                    ends.push(to);
                } else if to == point {
                    ends.push(from);
                }
            }
        }
        ends.sort_unstable();
        ends.dedup();
        ends
    }

    /// The other ends of the edges of a point and its images, as the point sees them.
    #[must_use]
    pub(crate) fn all_neighbors(&self, point: u32) -> Vec<(u32, Shift)> {
        let copies = self.copies_of(point);
        let seen = copies.iter().flat_map(|&copy| {
            let ends = self.neighbors(copy).into_iter();
            ends.map(move |end| self.copies.relative(copy, end))
        });
        let mut seen: Vec<(u32, Shift)> = seen.collect();
        seen.sort_unstable();
        seen.dedup();
        seen
    }

    /// A point and its images.
    #[must_use]
    pub(crate) fn copies_of(&self, point: u32) -> Vec<u32> {
        self.copies.of_point(point)
    }

    /// The center of the cell behind a face that is not a wall, as it lies at this face.
    #[must_use]
    pub(crate) fn cell_behind(&self, face: u32) -> Option<(u32, Vector3<f64>)> {
        match self.behind[face as usize] {
            Behind::Cell(cell) => Some((cell, Vector3::zeros())),
            Behind::Wall(_) => None,
            Behind::Image { face, patch } => {
                let (_, way) = self.patches[patch as usize].1?;
                Some((self.owner[face as usize], -way))
            }
        }
    }

    /// Remembers the state to which [`EditMesh::undo_to`] returns.
    #[must_use]
    pub(crate) fn mark(&self) -> usize {
        self.journal.len()
    }

    /// Makes all changes final.
    pub(crate) fn keep(&mut self) {
        self.journal.clear();
    }

    /// Undoes all changes since a mark.
    pub(crate) fn undo_to(&mut self, mark: usize) {
        while self.journal.len() > mark {
            match self.journal.pop() {
                Some(Undo::Point) => {
                    self.points.pop();
                    self.at_point.pop();
                }
                Some(Undo::Move(point, place)) => {
                    self.points[point as usize] = place;
                    self.forget_point(point);
                }
                Some(Undo::Loop(face, corners)) => self.exchange_loop(face, corners),
                Some(Undo::Sides(face, owner, behind)) => self.exchange_sides(face, owner, behind),
                Some(Undo::Face) => {
                    self.exchange_loop(self.faces.len() as u32 - 1, Vec::new());
                    self.faces.pop();
                    self.owner.pop();
                    self.behind.pop();
                    self.face_shapes.pop();
                }
                Some(Undo::Cell) => {
                    self.of_cell.pop();
                    self.cell_shapes.pop();
                    self.sites.pop();
                }
                Some(Undo::Join(joined)) => self.copies.part(joined),
                None => return,
            }
        }
    }

    /// Adds a point.
    pub(crate) fn add_point(&mut self, place: Point3<f64>) -> u32 {
        self.points.push(place);
        self.at_point.push(Vec::new());
        self.journal.push(Undo::Point);
        self.points.len() as u32 - 1
    }

    /// Adds a cell without faces.
    pub(crate) fn add_cell(&mut self, site: u32) -> u32 {
        self.of_cell.push(Vec::new());
        self.cell_shapes.push(None);
        self.sites.push(site);
        self.journal.push(Undo::Cell);
        self.of_cell.len() as u32 - 1
    }

    /// Adds a face.
    pub(crate) fn add_face(&mut self, corners: Vec<u32>, owner: u32, behind: Behind) -> u32 {
        let face = self.faces.len() as u32;
        self.faces.push(Vec::new());
        self.owner.push(owner);
        self.behind.push(behind);
        self.face_shapes.push(None);
        self.journal.push(Undo::Face);
        self.exchange_loop(face, corners);
        face
    }

    /// Moves a point and its images.
    pub(crate) fn move_point(&mut self, point: u32, place: Point3<f64>) {
        let way = place - self.points[point as usize];
        for copy in self.copies.of_point(point) {
            let here = self.points[copy as usize];
            self.journal.push(Undo::Move(copy, here));
            self.points[copy as usize] = if copy == point { place } else { here + way };
            self.forget_point(copy);
        }
    }

    /// Gives a face another loop; without three corners it is gone.
    pub(crate) fn set_loop(&mut self, face: u32, mut corners: Vec<u32>) {
        if corners.len() < 3 {
            corners.clear();
        }
        let before = self.faces[face as usize].clone();
        self.journal.push(Undo::Loop(face, before));
        self.exchange_loop(face, corners);
    }

    /// Gives a face other cells.
    pub(crate) fn set_sides(&mut self, face: u32, owner: u32, behind: Behind) {
        let before = (self.owner[face as usize], self.behind[face as usize]);
        self.journal.push(Undo::Sides(face, before.0, before.1));
        self.exchange_sides(face, owner, behind);
    }

    /// Makes one point of the ends of an edge, and of its images: `gone` becomes `kept`, which moves to
    /// `place`.
    pub(crate) fn collapse_edge(&mut self, kept: u32, gone: u32, place: Point3<f64>) {
        let mut pairs = vec![(gone, Some(kept))];
        if !self.copies.is_trivial() {
            let (all, joined) = self.copies.join(kept, gone);
            self.journal.push(Undo::Join(joined));
            pairs = all;
        }
        for (old, new) in pairs {
            let Some(new) = new else { continue };
            for face in self.at_point[old as usize].clone() {
                let corners = renamed(&self.faces[face as usize], old, new);
                self.set_loop(face, corners);
            }
        }
        // Images of `gone` where none of `kept` was are images of `kept` now.
        for copy in self.copies.of_point(kept) {
            let there = place + self.copies.way(kept, copy);
            let before = mem::replace(&mut self.points[copy as usize], there);
            self.journal.push(Undo::Move(copy, before));
            self.forget_point(copy);
        }
    }

    /// Replaces the loop and whatever lists it.
    fn exchange_loop(&mut self, face: u32, corners: Vec<u32>) {
        self.detach(face);
        self.faces[face as usize] = corners;
        self.attach(face);
    }

    fn exchange_sides(&mut self, face: u32, owner: u32, behind: Behind) {
        self.detach(face);
        self.owner[face as usize] = owner;
        self.behind[face as usize] = behind;
        self.attach(face);
    }

    /// Lists a face at its points and cells.
    fn attach(&mut self, face: u32) {
        self.forget(face);
        if self.faces[face as usize].is_empty() {
            return;
        }
        for &point in &self.faces[face as usize] {
            let list = &mut self.at_point[point as usize];
            if !list.contains(&face) {
                list.push(face);
            }
        }
        for cell in self.cells_at(face) {
            self.of_cell[cell as usize].push(face);
        }
    }

    fn detach(&mut self, face: u32) {
        self.forget(face);
        if self.faces[face as usize].is_empty() {
            return;
        }
        for &point in &self.faces[face as usize] {
            self.at_point[point as usize].retain(|&other| other != face);
        }
        for cell in self.cells_at(face) {
            self.of_cell[cell as usize].retain(|&other| other != face);
        }
    }

    /// Forgets the shapes of a face and its cells.
    fn forget(&mut self, face: u32) {
        self.face_shapes[face as usize] = None;
        for cell in self.cells_at(face) {
            self.cell_shapes[cell as usize] = None;
        }
    }

    fn forget_point(&mut self, point: u32) {
        for place in 0..self.at_point[point as usize].len() {
            self.forget(self.at_point[point as usize][place]);
        }
    }
}

fn behind(mesh: &PolyMesh, face: usize) -> Behind {
    if let Some(&cell) = mesh.neighbor.get(face) {
        return Behind::Cell(cell);
    }
    let ends = mesh.patches.iter().map(|patch| patch.start + patch.count);
    let number = ends.take_while(|&end| end <= face).count();
    let patch = &mesh.patches[number];
    match patch.partner {
        None => Behind::Wall(number as u32),
        Some((other, _)) => Behind::Image {
            face: (mesh.patches[other].start + face - patch.start) as u32,
            patch: number as u32,
        },
    }
}

/// The directed edges of a loop.
pub(crate) fn loop_edges(corners: &[u32]) -> impl Iterator<Item = (u32, u32)> + Clone {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&from, &to)| (from, to))
}

/// Whether two points follow each other in a loop.
#[must_use]
pub(crate) fn adjacent(corners: &[u32], a: u32, b: u32) -> bool {
    loop_edges(corners).any(|(from, to)| (from, to) == (a, b) || (from, to) == (b, a))
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
