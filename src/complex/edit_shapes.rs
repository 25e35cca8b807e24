//! The quality of a mesh under change, and by how much faces and cells miss stated limits.
//!
//! The measures are those of [`crate::complex::quality`]. What a face misses is zero within the limits and
//! grows beyond them; a change is allowed where neither the sum over all cells that it touches
//! nor the worst of them grows. So nothing good is spoilt, and what is bad may always be improved.

use nalgebra::{Point3, Vector3};

use crate::complex::edit_mesh::{EditMesh, loop_edges};
use crate::complex::loop_shape::{CellShape, FaceShape};
use crate::complex::quality::skewness;

/// The least cosine between a face's normal and the line of its cells' centers: that of 40 degrees.
const LEAN: f64 = 0.766_044_443_118_978;

/// The cosine at which a face misses by one: that of 68 degrees. OpenFOAM warns above 70.
const LEAN_FAILS: f64 = 0.374_606_593_415_912;

/// The least height of a pyramid over a face in sides of its cell.
const HEIGHT: f64 = 0.05;

/// The greatest skewness. OpenFOAM fails above 4.
const SKEW: f64 = 2.8;

/// The skewness at which a face misses by one.
const SKEW_FAILS: f64 = 3.9;

/// The least flatness of a face.
const FLAT: f64 = 0.9;

/// How much a cell of no volume misses.
const NO_VOLUME: f64 = 100.0;

/// By how much cells miss the limits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Miss {
    /// The sum over their faces.
    pub(crate) sum: f64,
    /// The worst.
    pub(crate) worst: f64,
}

/// Rounding of a sum of misses.
const ROUNDING: f64 = 1e-9;

impl Miss {
    fn add(&mut self, miss: f64) {
        self.sum += miss;
        self.worst = self.worst.max(miss);
    }

    /// Whether a change from `before` to this is no loss.
    #[must_use]
    pub(crate) fn is_no_worse_than(&self, before: &Self) -> bool {
        self.sum <= before.sum + ROUNDING && self.worst <= before.worst + ROUNDING
    }
}

/// A face misses by this or more: `checkMesh` fails, or nearly.
pub(crate) const FAILING: f64 = 1.0;

impl EditMesh {
    /// The shape of a face.
    pub(crate) fn face_shape(&mut self, face: u32) -> FaceShape {
        if let Some(shape) = self.face_shapes[face as usize] {
            return shape;
        }
        let shape = self.shape_of(&self.faces[face as usize]);
        self.face_shapes[face as usize] = Some(shape);
        shape
    }

    /// The shape of a loop (OpenFOAM v1912, `primitiveMeshFaceCentresAndAreas.C`).
    #[must_use]
    pub(crate) fn shape_of(&self, corners: &[u32]) -> FaceShape {
        let place = |&corner: &u32| self.points[corner as usize].coords;
        let mean = corners.iter().map(place).sum::<Vector3<f64>>() / corners.len() as f64;
        let (mut normal, mut size, mut weighted) = (Vector3::zeros(), 0.0, Vector3::zeros());
        for (from, to) in loop_edges(corners) {
            let (from, to) = (place(&from), place(&to));
            let area = (to - from).cross(&(mean - from));
            normal += area;
            size += area.norm();
            weighted += area.norm() * (from + to + mean);
        }
        let is_flat = corners.len() < 4 || size < 1e-150;
        FaceShape {
            center: Point3::from(if is_flat {
                mean
            } else {
                weighted / (3.0 * size)
            }),
            area: 0.5 * normal,
            flatness: if is_flat { 1.0 } else { normal.norm() / size },
        }
    }

    /// The shape of a cell (OpenFOAM v1912, `primitiveMeshCellCentresAndVols.C`).
    pub(crate) fn cell_shape(&mut self, cell: u32) -> CellShape {
        if let Some(shape) = self.cell_shapes[cell as usize] {
            return shape;
        }
        let count = self.of_cell[cell as usize].len();
        let mut mean = Vector3::zeros();
        for place in 0..count {
            let face = self.of_cell[cell as usize][place];
            mean += self.face_shape(face).center.coords;
        }
        mean /= count.max(1) as f64;
        let (mut weighted, mut thrice) = (Vector3::zeros(), 0.0);
        for place in 0..count {
            let face = self.of_cell[cell as usize][place];
            let FaceShape { center, area, .. } = self.face_shape(face);
            let height = area.dot(&(center.coords - mean));
            let pyramid = match self.owner[face as usize] == cell {
                true => height,
                false => -height,
            };
            weighted += pyramid * (0.75 * center.coords + 0.25 * mean);
            thrice += pyramid;
        }
        let is_solid = thrice.abs() > 1e-300;
        let shape = CellShape {
            center: Point3::from(if is_solid { weighted / thrice } else { mean }),
            volume: thrice / 3.0,
        };
        self.cell_shapes[cell as usize] = Some(shape);
        shape
    }

    /// The sum of all cells' volumes (L³).
    pub(crate) fn volume(&mut self) -> f64 {
        (0..self.of_cell.len() as u32)
            .filter(|&cell| !self.of_cell[cell as usize].is_empty())
            .collect::<Vec<_>>()
            .into_iter()
            .map(|cell| self.cell_shape(cell).volume)
            .sum()
    }

    /// By how much a face misses the limits.
    pub(crate) fn miss_of(&mut self, face: u32) -> f64 {
        let FaceShape {
            center,
            area,
            flatness,
        } = self.face_shape(face);
        let own = self.cell_shape(self.owner[face as usize]);
        let size = area.norm().max(1e-300);
        let from_owner = center - own.center;
        let mut miss = low(from_owner.dot(&area) / size, own.volume);
        let other = self.cell_behind(face);
        let (line, share) = match other {
            None => {
                let normal = area / size;
                (normal * normal.dot(&from_owner), 0.4)
            }
            Some((cell, way)) => {
                let shape = self.cell_shape(cell);
                let there = shape.center + way;
                miss = miss.max(low((there - center).dot(&area) / size, shape.volume));
                let line = there - own.center;
                let cosine = line.dot(&area) / (line.norm() * size).max(1e-300);
                miss += beyond((LEAN - cosine) / (LEAN - LEAN_FAILS));
                (line, 0.2)
            }
        };
        miss += ((FLAT - flatness) / 0.4).max(0.0).powi(2);
        let corners = self.faces[face as usize].iter();
        let places: Vec<Point3<f64>> = corners.map(|&at| self.points[at as usize]).collect();
        let skew = skewness(&places, (center, area), &from_owner, &line, share);
        miss + beyond((skew - SKEW) / (SKEW_FAILS - SKEW))
    }

    /// By how much some cells and their faces miss the limits.
    pub(crate) fn miss(&mut self, cells: &[u32]) -> Miss {
        let mut miss = Miss::default();
        for face in self.faces_of(cells) {
            miss.add(self.miss_of(face));
        }
        for &cell in cells {
            let is_empty = self.of_cell[cell as usize].is_empty();
            if !is_empty && self.cell_shape(cell).volume <= 0.0 {
                miss.add(NO_VOLUME);
            }
        }
        miss
    }

    /// How sound a cell is.
    #[must_use]
    pub(crate) fn soundness(&self, cell: u32) -> Soundness {
        let faces = &self.of_cell[cell as usize];
        if faces.is_empty() {
            return Soundness::Ball;
        }
        let mut edges: Vec<(u32, u32)> = Vec::with_capacity(8 * faces.len());
        let mut sets: Vec<Vec<u32>> = Vec::with_capacity(faces.len());
        for &face in faces {
            let corners = &self.faces[face as usize];
            let is_owner = self.owner[face as usize] == cell;
            edges.extend(loop_edges(corners).map(|(from, to)| match is_owner {
                true => (from, to),
                false => (to, from),
            }));
            let mut set = corners.clone();
            set.sort_unstable();
            if set.windows(2).any(|pair| pair[0] == pair[1]) {
                return Soundness::Open;
            }
            sets.push(set);
        }
        edges.sort_unstable();
        let is_closed = |&(from, to): &(u32, u32)| edges.binary_search(&(to, from)).is_ok();
        if edges.windows(2).any(|pair| pair[0] == pair[1]) || !edges.iter().all(is_closed) {
            return Soundness::Open;
        }
        let mut points = sets.concat();
        sets.sort_unstable();
        points.sort_unstable();
        points.dedup();
        let are_different = sets.windows(2).all(|pair| pair[0] != pair[1]);
        let is_sphere = points.len() + faces.len() == edges.len() / 2 + 2;
        match are_different && faces.len() >= 4 && is_sphere {
            true => Soundness::Ball,
            false => Soundness::Closed,
        }
    }

    /// Whether a cell is a closed ball of different faces, or gone.
    #[must_use]
    pub(crate) fn is_ball(&self, cell: u32) -> bool {
        self.soundness(cell) == Soundness::Ball
    }

    /// How sound each of some cells is.
    #[must_use]
    pub(crate) fn soundnesses(&self, cells: &[u32]) -> Vec<Soundness> {
        cells.iter().map(|&cell| self.soundness(cell)).collect()
    }

    /// Whether no cell is less sound than before.
    #[must_use]
    pub(crate) fn stay_sound(&self, cells: &[u32], before: &[Soundness]) -> bool {
        let mut pairs = cells.iter().zip(before);
        pairs.all(|(&cell, &before)| before == Soundness::Open || self.soundness(cell) >= before)
    }
}

/// The topology of a cell's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Soundness {
    /// An edge is not run once in either direction.
    Open,
    /// Closed, but no ball of different faces.
    Closed,
    /// A ball, or gone.
    Ball,
}

/// What a pyramid of some height (L) over the center of a cell of some volume (L³) misses.
fn low(height: f64, volume: f64) -> f64 {
    let least = HEIGHT * volume.max(1e-300).cbrt();
    beyond((least - height) / least)
}

/// The square of what is positive, and above one the tangent.
fn beyond(miss: f64) -> f64 {
    match miss.max(0.0) {
        small if small < 1.0 => small * small,
        large => 2.0 * large - 1.0,
    }
}
