//! A mesh of hexahedra, prisms, pyramids and tetrahedra that share points, edges and faces.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::complex::element::CellElement;
use crate::complex::sorted_faces::SortedFaces;
use crate::mesh::poly_mesh::PolyMesh;

/// A mesh of elements; none is a polyhedron.
#[derive(Clone, Debug, Default)]
pub(crate) struct ElementMesh {
    /// All points.
    pub(crate) points: Vec<Point3<f64>>,
    /// All elements, their points in VTK's order.
    pub(crate) elements: Vec<CellElement>,
    /// Per element the cell of which it is all or a part, where that is known.
    pub(crate) cells: Vec<u32>,
    /// The faces on walls as seen from outside, with their patches.
    pub(crate) walls: Vec<(Vec<u32>, u32)>,
    /// The names of the patches.
    pub(crate) patches: Vec<String>,
}

/// The faces of elements by the places of their points, as seen from outside.
const TETRAHEDRON: [&[usize]; 4] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
const PYRAMID: [&[usize]; 5] = [
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];
const PRISM: [&[usize]; 5] = [
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
const HEXAHEDRON: [&[usize]; 6] = [
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[3, 0, 4, 7],
];

impl CellElement {
    /// Its points; none for polyhedra.
    #[must_use]
    pub(crate) fn corners(&self) -> &[u32] {
        match self {
            Self::Tetrahedron(corners) => corners,
            Self::Pyramid(corners) => corners,
            Self::Prism(corners) => corners,
            Self::Hexahedron(corners) => corners,
            Self::Polyhedron => &[],
        }
    }

    /// Its faces by places in its points, as seen from outside; none for polyhedra.
    #[must_use]
    pub(crate) fn faces(&self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron(_) => &TETRAHEDRON,
            Self::Pyramid(_) => &PYRAMID,
            Self::Prism(_) => &PRISM,
            Self::Hexahedron(_) => &HEXAHEDRON,
            Self::Polyhedron => &[],
        }
    }
}

/// The points of a face in ascending order, with a number that is no point's for triangles.
type FaceKey = [u32; 4];

fn key(corners: &[u32]) -> FaceKey {
    let mut key = [u32::MAX; 4];
    key[..corners.len()].copy_from_slice(corners);
    key.sort_unstable();
    key
}

impl ElementMesh {
    /// The same by faces, elements in the same order.
    #[must_use]
    pub(crate) fn by_faces(&self) -> PolyMesh {
        let patches: HashMap<FaceKey, u32> = self
            .walls
            .iter()
            .map(|(corners, patch)| (key(corners), *patch))
            .collect();
        let mut faces: Vec<(FaceKey, u32, Vec<u32>)> = Vec::new();
        for (number, element) in (0..).zip(&self.elements) {
            let corners = element.corners();
            faces.extend(element.faces().iter().map(|places| {
                let corners: Vec<u32> = places.iter().map(|&place| corners[place]).collect();
                (key(&corners), number, corners)
            }));
        }
        faces.sort_unstable();
        let mut sorted = SortedFaces::default();
        for same in faces.chunk_by(|one, other| one.0 == other.0) {
            let (key, owner, corners) = &same[0];
            match (same.get(1), patches.get(key)) {
                (Some((_, other, _)), _) => sorted.push_inner([*owner, *other], corners.clone()),
                (None, patch) => {
                    sorted.push_wall(*owner, corners.clone(), patch.copied().unwrap_or(0));
                }
            }
        }
        sorted.finish(&self.points, &self.patches).0
    }
}
