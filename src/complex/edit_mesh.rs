//! A mesh that can be changed face by face, and back to OpenFOAM's order.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};

use crate::complex::face_geometry::polygon_geometry;
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};

/// What lies behind a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Behind {
    /// A cell.
    Cell(u32),
    /// The outside, through a patch.
    Patch(u32),
}

/// A mesh without periods under change.
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
    pub(crate) at_point: Vec<BTreeSet<u32>>,
    /// The faces of every cell.
    pub(crate) of_cell: Vec<BTreeSet<u32>>,
    patches: Vec<String>,
    sites: Vec<u32>,
}

impl EditMesh {
    /// A copy of `mesh`, which has no periods.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh) -> Self {
        let patch_of = |face: usize| {
            let ends = mesh.patches.iter().map(|patch| patch.start + patch.count);
            ends.take_while(|&end| end <= face).count() as u32
        };
        let behind = (0..mesh.face_count()).map(|face| match mesh.neighbor.get(face) {
            Some(&cell) => Behind::Cell(cell),
            None => Behind::Patch(patch_of(face)),
        });
        let mut edited = Self {
            points: mesh.points.clone(),
            faces: mesh.faces().map(<[u32]>::to_vec).collect(),
            owner: mesh.owner.clone(),
            behind: behind.collect(),
            at_point: vec![BTreeSet::new(); mesh.points.len()],
            of_cell: vec![BTreeSet::new(); mesh.cell_count],
            patches: mesh
                .patches
                .iter()
                .map(|patch| patch.name.clone())
                .collect(),
            sites: mesh.sites.clone(),
        };
        for face in 0..edited.faces.len() {
            for &point in &edited.faces[face] {
                edited.at_point[point as usize].insert(face as u32);
            }
            for cell in edited.cells_at(face as u32) {
                edited.of_cell[cell as usize].insert(face as u32);
            }
        }
        edited
    }

    /// The cells on both sides of a face.
    pub(crate) fn cells_at(&self, face: u32) -> impl Iterator<Item = u32> + use<> {
        let other = match self.behind[face as usize] {
            Behind::Cell(cell) => Some(cell),
            Behind::Patch(_) => None,
        };
        std::iter::once(self.owner[face as usize]).chain(other)
    }

    /// The patch of a face on a wall.
    #[must_use]
    pub(crate) fn patch(&self, face: u32) -> Option<u32> {
        match self.behind[face as usize] {
            Behind::Cell(_) => None,
            Behind::Patch(patch) => Some(patch),
        }
    }

    /// The patches that meet in a point.
    #[must_use]
    pub(crate) fn patches_at(&self, point: u32) -> BTreeSet<u32> {
        let faces = self.at_point[point as usize].iter();
        faces.filter_map(|&face| self.patch(face)).collect()
    }

    /// The edges of all faces, each once.
    #[must_use]
    pub(crate) fn edges(&self) -> BTreeSet<(u32, u32)> {
        let loops = self.faces.iter().flat_map(|corners| loop_edges(corners));
        loops.map(|(a, b)| (a.min(b), a.max(b))).collect()
    }

    /// Gives a face another loop; without three corners it is gone.
    pub(crate) fn replace_face(&mut self, face: u32, corners: Vec<u32>) {
        for &point in &self.faces[face as usize] {
            self.at_point[point as usize].remove(&face);
        }
        if corners.len() < 3 {
            for cell in self.cells_at(face) {
                self.of_cell[cell as usize].remove(&face);
            }
            self.faces[face as usize].clear();
            return;
        }
        for &point in &corners {
            self.at_point[point as usize].insert(face);
        }
        self.faces[face as usize] = corners;
    }

    /// Center and area times normal (L²) of a loop.
    #[must_use]
    pub(crate) fn measure(&self, corners: &[u32]) -> (Point3<f64>, Vector3<f64>) {
        let places: Vec<Vector3<f64>> = corners
            .iter()
            .map(|&corner| self.points[corner as usize].coords)
            .collect();
        polygon_geometry(&places)
    }

    /// The mesh in OpenFOAM's order. Faces that are gone leave nothing behind.
    #[must_use]
    pub(crate) fn finish(&self) -> PolyMesh {
        let mut mesh = PolyMesh::default();
        mesh.cell_count = self.of_cell.len();
        mesh.sites.clone_from(&self.sites);
        let mut inner = Vec::new();
        let mut walls: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for face in (0..self.faces.len()).filter(|&face| !self.faces[face].is_empty()) {
            match self.behind[face] {
                Behind::Cell(cell) => inner.push((self.owner[face], cell, face)),
                Behind::Patch(patch) => walls.entry(patch).or_default().push(face),
            }
        }
        inner.sort_unstable();
        mesh.neighbor.extend(inner.iter().map(|&(_, cell, _)| cell));
        let mut order: Vec<usize> = inner.into_iter().map(|(.., face)| face).collect();
        for (patch, mut faces) in walls {
            faces.sort_by_key(|&face| self.owner[face]);
            mesh.patches.push(MeshPatch {
                name: self.patches[patch as usize].clone(),
                start: order.len(),
                count: faces.len(),
                partner: None,
            });
            order.extend(faces);
        }
        self.push_faces(&mut mesh, &order);
        mesh
    }

    fn push_faces(&self, mesh: &mut PolyMesh, order: &[usize]) {
        const UNUSED: u32 = u32::MAX;
        let mut numbers = vec![UNUSED; self.points.len()];
        for &face in order {
            mesh.owner.push(self.owner[face]);
            let points = self.faces[face].iter().map(|&point| {
                let number = &mut numbers[point as usize];
                if *number == UNUSED {
                    *number = mesh.points.len() as u32;
                    mesh.points.push(self.points[point as usize]);
                }
                *number
            });
            let points: Vec<u32> = points.collect();
            mesh.push_corners(points);
        }
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
