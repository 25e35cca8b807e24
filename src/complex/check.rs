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
        let unsound = cells.map_init(CellBoundary::default, |boundary, cell| {
            self.topology(&faces, cell, boundary).err()
        });
        let unsound: Vec<MeshCheckError> = unsound.flatten_iter().collect();
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
        let is_distinct = |place: usize| {
            let corner = corners[place];
            (corner as usize) < self.points.len() && !corners[..place].contains(&corner)
        };
        let distinct = (0..corners.len()).filter(|&place| is_distinct(place));
        let distinct = distinct.count();
        let (owner, neighbor) = (self.owner[face], self.neighbor.get(face).copied());
        let highest = owner.max(neighbor.unwrap_or(0)) as usize;
        if distinct == corners.len() && corners.len() >= 3 && highest < self.cell_count {
            return Ok(());
        }
        Err(MeshCheckError::Face {
            face,
            corners: corners.len(),
            distinct,
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
    fn topology(
        &self,
        faces: &CellFaces,
        cell: usize,
        boundary: &mut CellBoundary,
    ) -> Result<(), MeshCheckError> {
        boundary.clear();
        for (face, is_owner) in faces.of(cell) {
            let corners = self.face(face);
            boundary.vertices.extend_from_slice(corners);
            let next = corners.iter().cycle().skip(1);
            for (&from, &to) in corners.iter().zip(next) {
                let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
                boundary.edges[usize::from((from < to) == is_owner)].push(edge);
            }
        }
        boundary.vertices.sort_unstable();
        boundary.vertices.dedup();
        for edges in &mut boundary.edges {
            edges.sort_unstable();
        }
        let [one_way, other_way] = &boundary.edges;
        if one_way != other_way || one_way.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(boundary.open_edge(cell));
        }
        let (vertices, edges) = (boundary.vertices.len(), one_way.len());
        let faces = faces.of(cell).len();
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

/// The edges and vertices of a cell, in memory that serves one cell after another.
#[derive(Debug, Default)]
struct CellBoundary {
    /// Edges run down and up, seen from outside, by their lower and their higher end.
    edges: [Vec<u64>; 2],
    vertices: Vec<u32>,
}

impl CellBoundary {
    fn clear(&mut self) {
        self.edges.iter_mut().for_each(Vec::clear);
        self.vertices.clear();
    }

    /// The first edge of a cell that is not run once either way.
    fn open_edge(&self, cell: usize) -> MeshCheckError {
        let [down, up] = &self.edges;
        // Both are sorted.
        let below = |edges: &[u64], edge: u64| edges.partition_point(|&other| other < edge);
        let times = |edges: &[u64], edge: u64| below(edges, edge + 1) - below(edges, edge);
        let mut all: Vec<u64> = down.iter().chain(up).copied().collect();
        all.sort_unstable();
        let counts = |edge: u64| [up, down].map(|edges| times(edges, edge) as u32);
        let open = all.into_iter().find(|&edge| counts(edge) != [1, 1]);
        let edge = open.unwrap_or_default();
        let [forward, back] = counts(edge);
        MeshCheckError::Open {
            cell,
            from: (edge >> 32) as u32,
            to: edge as u32,
            forward,
            back,
        }
    }
}
