//! Faces with the cells that they part, put into OpenFOAM's order.

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};

/// Faces in any order.
#[derive(Clone, Debug, Default)]
pub(crate) struct SortedFaces {
    /// The cells on both sides, the loop as seen from outside the first.
    inner: Vec<([u32; 2], Vec<u32>)>,
    /// By patch: the cell and the loop.
    walls: BTreeMap<u32, Vec<(u32, Vec<u32>)>>,
}

impl SortedFaces {
    /// Adds a face between two cells, its loop as seen from outside the first; without three corners it
    /// is none.
    pub(crate) fn push_inner(&mut self, mut cells: [u32; 2], mut corners: Vec<u32>) {
        if corners.len() < 3 {
            return;
        }
        if cells[0] > cells[1] {
            cells.reverse();
            corners[1..].reverse();
        }
        self.inner.push((cells, corners));
    }

    /// Adds a face on a patch, its loop as seen from outside; without three corners it is none.
    pub(crate) fn push_wall(&mut self, cell: u32, corners: Vec<u32>, patch: u32) {
        if corners.len() >= 3 {
            self.walls.entry(patch).or_default().push((cell, corners));
        }
    }

    /// The mesh of cells that these faces bound, with patches of these names. Cells of two faces, which
    /// have no volume, are removed and their faces joined. Also returns the given number of each point.
    #[must_use]
    pub(crate) fn finish(
        mut self,
        points: &[Point3<f64>],
        names: &[String],
    ) -> (PolyMesh, Vec<u32>, Vec<u32>) {
        while self.join_flat() {}
        let cells = self.number_cells();
        let mut mesh = PolyMesh::default();
        mesh.cell_count = cells.len();
        self.inner.sort();
        let mut numbers = PointNumbers::new(points);
        for ([owner, neighbor], corners) in &self.inner {
            mesh.owner.push(*owner);
            mesh.neighbor.push(*neighbor);
            mesh.push_corners(corners.iter().map(|&point| numbers.of(point)));
        }
        for (patch, mut faces) in std::mem::take(&mut self.walls) {
            faces.sort();
            mesh.patches.push(MeshPatch {
                name: names[patch as usize].clone(),
                start: mesh.face_count(),
                count: faces.len(),
                partner: None,
            });
            for (owner, corners) in faces {
                mesh.owner.push(owner);
                mesh.push_corners(corners.into_iter().map(|point| numbers.of(point)));
            }
        }
        mesh.points = numbers
            .used
            .iter()
            .map(|&point| points[point as usize])
            .collect();
        (mesh, numbers.used, cells)
    }

    /// Joins the faces of one cell that has two; whether there was one.
    fn join_flat(&mut self) -> bool {
        let mut faces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (face, (cells, _)) in self.inner.iter().enumerate() {
            for &cell in cells {
                faces.entry(cell).or_default().push(face);
            }
        }
        for (cell, _) in self.walls.values().flatten() {
            faces.entry(*cell).or_default().push(usize::MAX);
        }
        let flat = faces
            .into_iter()
            .find(|(_, faces)| faces.len() == 2 && faces.iter().all(|&face| face != usize::MAX));
        let Some((cell, pair)) = flat else {
            return false;
        };
        let (second, _) = self.inner.swap_remove(pair[1].max(pair[0]));
        let (first, corners) = self.inner.swap_remove(pair[0].min(pair[1]));
        let beyond = second[usize::from(second[0] == cell)];
        let other = first[usize::from(first[0] == cell)];
        match first[0] == cell {
            true => self.push_inner([beyond, other], corners),
            false => self.push_inner([other, beyond], corners),
        }
        true
    }

    /// Numbers the cells that have faces without gaps; returns their given numbers.
    fn number_cells(&mut self) -> Vec<u32> {
        let inner = self.inner.iter().flat_map(|(cells, _)| *cells);
        let walls = self.walls.values().flatten().map(|(cell, _)| *cell);
        let mut cells: Vec<u32> = inner.chain(walls).collect();
        cells.sort_unstable();
        cells.dedup();
        let number = |cell: &mut u32| {
            *cell = cells.binary_search(cell).unwrap_or_default() as u32;
        };
        self.inner
            .iter_mut()
            .flat_map(|(cells, _)| cells)
            .for_each(number);
        let walls = self.walls.values_mut().flatten();
        walls.map(|(cell, _)| cell).for_each(number);
        cells
    }
}

/// New numbers of points by first use.
struct PointNumbers {
    numbers: Vec<u32>,
    used: Vec<u32>,
}

impl PointNumbers {
    const UNUSED: u32 = u32::MAX;

    fn new(points: &[Point3<f64>]) -> Self {
        Self {
            numbers: vec![Self::UNUSED; points.len()],
            used: Vec::new(),
        }
    }

    fn of(&mut self, point: u32) -> u32 {
        let number = &mut self.numbers[point as usize];
        if *number == Self::UNUSED {
            *number = self.used.len() as u32;
            self.used.push(point);
        }
        *number
    }
}
