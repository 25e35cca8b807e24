//! The invariants of a mesh of polyhedra: closed cells, each a ball, OpenFOAM's order of faces.

use rayon::prelude::*;
use thiserror::Error;

use crate::mesh::poly_mesh::{CellFaces, PolyMesh};

/// Why a mesh is not sound. Numbers count from zero.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum MeshCheckError {
    /// Faces, owners, neighbors and patches do not count the same.
    #[error(
        "{faces} faces, but {owners} owners, {neighbors} neighbors and {patched} faces in patches"
    )]
    Counts {
        /// Faces.
        faces: usize,
        /// Owners.
        owners: usize,
        /// Neighbors.
        neighbors: usize,
        /// Faces in patches.
        patched: usize,
    },
    /// A face names a point or cell that is not there, or has fewer than three different corners.
    #[error(
        "face {face} has {corners} corners, {distinct} of them different and in the mesh; its cells are {owner} and {neighbor:?} of {cells}"
    )]
    Face {
        /// The face.
        face: usize,
        /// How many corners it has.
        corners: usize,
        /// How many of them are different points of the mesh.
        distinct: usize,
        /// Its owner.
        owner: u32,
        /// Its neighbor.
        neighbor: Option<u32>,
        /// How many cells there are.
        cells: usize,
    },
    /// The owner's number is not below the neighbor's, or the face comes before one of lower cells.
    #[error("face {face} between cells {owner} and {neighbor} breaks the upper-triangular order")]
    Order {
        /// The face.
        face: usize,
        /// Its owner.
        owner: u32,
        /// Its neighbor.
        neighbor: u32,
    },
    /// An edge of a cell is not run once in either direction.
    #[error(
        "cell {cell} is not closed: its faces run {forward} times from point {from} to point {to} and {back} times back"
    )]
    Open {
        /// The cell.
        cell: usize,
        /// One end.
        from: u32,
        /// The other end.
        to: u32,
        /// How often its faces run that way.
        forward: u32,
        /// How often they run back.
        back: u32,
    },
    /// A cell's boundary is no sphere: V − E + F ≠ 2.
    #[error(
        "cell {cell} has {vertices} vertices, {edges} edges and {faces} faces, against Euler's formula"
    )]
    Euler {
        /// The cell.
        cell: usize,
        /// V.
        vertices: usize,
        /// E.
        edges: usize,
        /// F.
        faces: usize,
    },
    /// A point belongs to no face.
    #[error("point {point} belongs to no face")]
    Unused {
        /// The point.
        point: usize,
    },
}

impl PolyMesh {
    /// Tests the invariants of a mesh, and lists the cells that are closed and yet no balls, since they wrap
    /// around a hole of the domain or hold a cavity.
    ///
    /// # Errors
    /// [`MeshCheckError`] for the first that does not hold.
    pub(crate) fn check_closed(&self) -> Result<Vec<MeshCheckError>, MeshCheckError> {
        self.check_structure()?;
        let faces = self.cell_faces();
        let cells = (0..self.cell_count).into_par_iter();
        let unsound: Vec<MeshCheckError> = cells
            .filter_map(|cell| self.topology(&faces, cell).err())
            .collect();
        let is_open = |error: &&MeshCheckError| matches!(error, MeshCheckError::Open { .. });
        match unsound.iter().find(is_open) {
            None => Ok(unsound),
            Some(open) => Err(open.clone()),
        }
    }

    /// Tests all that makes it safe to measure: counts, numbers in range, the order of faces.
    ///
    /// # Errors
    /// [`MeshCheckError`] for the first that does not hold.
    pub(crate) fn check_structure(&self) -> Result<(), MeshCheckError> {
        let (faces, inner) = (self.face_count(), self.neighbor.len());
        let patched: usize = self.patches.iter().map(|patch| patch.count).sum();
        let mut end = inner;
        let follows = self.patches.iter().all(|patch| {
            let is_next = patch.start == end;
            end += patch.count;
            is_next
        });
        if faces != self.owner.len() || inner > faces || !follows || inner + patched != faces {
            return Err(MeshCheckError::Counts {
                faces,
                owners: self.owner.len(),
                neighbors: inner,
                patched,
            });
        }
        let all = (0..faces).into_par_iter();
        if let Some(error) = all.find_map_first(|face| self.check_face(face).err()) {
            return Err(error);
        }
        self.check_order()?;
        self.check_points()
    }

    fn check_face(&self, face: usize) -> Result<(), MeshCheckError> {
        let corners = self.face(face);
        let is_there = |corner: &u32| (*corner as usize) < self.points.len();
        let mut distinct: Vec<u32> = corners.iter().copied().filter(is_there).collect();
        distinct.sort_unstable();
        distinct.dedup();
        let (owner, neighbor) = (self.owner[face], self.neighbor.get(face).copied());
        let highest = owner.max(neighbor.unwrap_or(0)) as usize;
        if distinct.len() == corners.len() && corners.len() >= 3 && highest < self.cell_count {
            return Ok(());
        }
        Err(MeshCheckError::Face {
            face,
            corners: corners.len(),
            distinct: distinct.len(),
            owner,
            neighbor,
            cells: self.cell_count,
        })
    }

    fn check_order(&self) -> Result<(), MeshCheckError> {
        let mut before = (0, 0);
        for (face, pair) in self.owner.iter().zip(&self.neighbor).enumerate() {
            let (&owner, &neighbor) = pair;
            if owner >= neighbor || (owner, neighbor) < before {
                return Err(MeshCheckError::Order {
                    face,
                    owner,
                    neighbor,
                });
            }
            before = (owner, neighbor);
        }
        Ok(())
    }

    fn check_points(&self) -> Result<(), MeshCheckError> {
        let mut is_used = vec![false; self.points.len()];
        for &corner in self.faces().flatten() {
            is_used[corner as usize] = true;
        }
        match is_used.iter().position(|used| !used) {
            Some(point) => Err(MeshCheckError::Unused { point }),
            None => Ok(()),
        }
    }

    /// Whether a cell is a closed ball.
    fn topology(&self, faces: &CellFaces, cell: usize) -> Result<(), MeshCheckError> {
        // Every edge by its ends in ascending order, and whether it is run downward.
        let (mut runs, mut vertices) = (Vec::new(), Vec::new());
        for (face, is_owner) in faces.of(cell) {
            let corners = self.face(face);
            vertices.extend_from_slice(corners);
            let next = corners.iter().cycle().skip(1);
            for (&from, &to) in corners.iter().zip(next) {
                runs.push((from.min(to), from.max(to), (from < to) != is_owner));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        runs.sort_unstable();
        let mut edges = 0;
        for run in runs.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
            edges += 1;
            let back = run.iter().filter(|(.., is_downward)| *is_downward).count();
            if run.len() != 2 || back != 1 {
                return Err(MeshCheckError::Open {
                    cell,
                    from: run[0].0,
                    to: run[0].1,
                    forward: (run.len() - back) as u32,
                    back: back as u32,
                });
            }
        }
        let (vertices, faces) = (vertices.len(), faces.of(cell).len());
        match vertices + faces == edges + 2 {
            true => Ok(()),
            false => Err(MeshCheckError::Euler {
                cell,
                vertices,
                edges,
                faces,
            }),
        }
    }
}
