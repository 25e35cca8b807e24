//! A conforming mesh of polyhedra by its faces, in OpenFOAM's order.
//!
//! Faces between two cells come first, by owner, then by neighbor (upper-triangular order); the
//! owner has the lower number, and the face's corners run counter-clockwise as seen from outside it.
//! Then come the faces of every patch.

use nalgebra::{Point3, Vector3};

/// Faces that border on something other than a cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeshPatch {
    /// Its name.
    pub(crate) name: String,
    /// Its first face.
    pub(crate) start: usize,
    /// How many faces it has.
    pub(crate) count: usize,
    /// The patch one period away, face by face, and the way there (L).
    pub(crate) partner: Option<(usize, Vector3<f64>)>,
}

/// A mesh of polyhedra.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PolyMesh {
    /// All points.
    pub(crate) points: Vec<Point3<f64>>,
    corners: Vec<u32>,
    ends: Vec<usize>,
    /// The cell on the inner side of every face.
    pub(crate) owner: Vec<u32>,
    /// The cell on the other side of the faces between two cells, which come first.
    pub(crate) neighbor: Vec<u32>,
    /// The other faces.
    pub(crate) patches: Vec<MeshPatch>,
    /// The site of every cell; empty where the mesh is not of a diagram.
    pub(crate) sites: Vec<u32>,
    /// How many cells there are.
    pub(crate) cell_count: usize,
}

impl PolyMesh {
    /// Adds a face without its cells.
    pub(crate) fn push_corners(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len());
    }

    /// Maps all points to `to` + `factor` (y − `from`), the factor positive.
    pub(crate) fn transform(&mut self, factor: f64, from: &Point3<f64>, to: &Point3<f64>) {
        for point in &mut self.points {
            *point = to + factor * (*point - from);
        }
        let partners = self.patches.iter_mut();
        for (_, way) in partners.filter_map(|patch| patch.partner.as_mut()) {
            *way *= factor;
        }
    }

    /// How many faces there are.
    #[must_use]
    pub(crate) fn face_count(&self) -> usize {
        self.ends.len()
    }

    /// The points of a face.
    #[inline]
    #[must_use]
    pub(crate) fn face(&self, face: usize) -> &[u32] {
        let start = if face == 0 { 0 } else { self.ends[face - 1] };
        &self.corners[start..self.ends[face]]
    }

    /// All faces.
    pub(crate) fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.face_count()).map(|face| self.face(face))
    }

    /// The places of a face's corners.
    pub(crate) fn face_places(&self, face: usize) -> impl ExactSizeIterator<Item = Point3<f64>> {
        let corners = self.face(face).iter();
        corners.map(|&corner| self.points[corner as usize])
    }

    /// The cell on the other side of a face, if there is one.
    #[inline]
    #[must_use]
    pub(crate) fn neighbor_of(&self, face: usize) -> Option<usize> {
        self.neighbor.get(face).map(|&cell| cell as usize)
    }

    /// The faces of every cell, and whether the cell owns each.
    #[must_use]
    pub(crate) fn cell_faces(&self) -> CellFaces {
        let mut starts = vec![0; self.cell_count + 1];
        for &cell in self.owner.iter().chain(&self.neighbor) {
            starts[cell as usize + 1] += 1;
        }
        for cell in 0..self.cell_count {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        let mut faces = vec![0; self.owner.len() + self.neighbor.len()];
        let mut push = |cell: u32, entry: u32| {
            faces[next[cell as usize]] = entry;
            next[cell as usize] += 1;
        };
        for face in 0..self.face_count() {
            push(self.owner[face], (face as u32) << 1 | 1);
            if let Some(&cell) = self.neighbor.get(face) {
                push(cell, (face as u32) << 1);
            }
        }
        CellFaces { starts, faces }
    }
}

/// The faces of every cell.
#[derive(Clone, Debug)]
pub(crate) struct CellFaces {
    starts: Vec<usize>,
    /// Twice the face's number, plus one where the cell owns it.
    faces: Vec<u32>,
}

impl CellFaces {
    /// The faces of a cell, and whether it owns each.
    pub(crate) fn of(&self, cell: usize) -> impl ExactSizeIterator<Item = (usize, bool)> + Clone {
        let faces = &self.faces[self.starts[cell]..self.starts[cell + 1]];
        faces
            .iter()
            .map(|&entry| ((entry >> 1) as usize, entry & 1 == 1))
    }
}
