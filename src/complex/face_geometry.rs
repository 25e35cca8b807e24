//! Face centers and areas, cell centers and volumes as OpenFOAM computes them.
//!
//! Source: OpenFOAM v1912, `primitiveMeshFaceCentresAndAreas.C`, `primitiveMeshCellCentresAndVols.C`. A
//! face is cut into triangles about the mean of its corners, a cell into pyramids about the mean of its
//! faces' centers.

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::mesh::poly_mesh::{CellFaces, PolyMesh};

/// Areas below this (L²) count as none (`ROOTVSMALL`).
pub(crate) const NO_AREA: f64 = 1e-150;

/// Volumes below this (L³) count as none (`VSMALL`).
const NO_VOLUME: f64 = 1e-300;

/// The centers and areas of faces, the centers and volumes of cells.
#[derive(Clone, Debug)]
pub(crate) struct MeshGeometry {
    /// Per face its center.
    pub(crate) face_centers: Vec<Point3<f64>>,
    /// Per face its area times its normal (L²), outward of the owner.
    pub(crate) face_areas: Vec<Vector3<f64>>,
    /// Per cell its center of mass.
    pub(crate) cell_centers: Vec<Point3<f64>>,
    /// Per cell its volume (L³).
    pub(crate) cell_volumes: Vec<f64>,
}

impl MeshGeometry {
    /// The geometry of `mesh`, whose structure is sound.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh, faces: &CellFaces) -> Self {
        let (face_centers, face_areas) = (0..mesh.face_count())
            .into_par_iter()
            .map(|face| face_geometry(mesh, face))
            .unzip();
        let mut geometry = Self {
            face_centers,
            face_areas,
            cell_centers: Vec::new(),
            cell_volumes: Vec::new(),
        };
        let cells = (0..mesh.cell_count).into_par_iter();
        (geometry.cell_centers, geometry.cell_volumes) =
            cells.map(|cell| geometry.cell(faces.of(cell))).unzip();
        geometry
    }

    /// Center and volume of the cell with these faces.
    fn cell(
        &self,
        faces: impl ExactSizeIterator<Item = (usize, bool)> + Clone,
    ) -> (Point3<f64>, f64) {
        let center = |face: usize| self.face_centers[face].coords;
        let total: Vector3<f64> = faces.clone().map(|(face, _)| center(face)).sum();
        let estimate = total / faces.len() as f64;
        let (mut weighted, mut thrice) = (Vector3::zeros(), 0.0);
        for (face, is_owner) in faces {
            let height = center(face) - estimate;
            let toward = if is_owner { height } else { -height };
            let pyramid = self.face_areas[face].dot(&toward);
            weighted += pyramid * (0.75 * center(face) + 0.25 * estimate);
            thrice += pyramid;
        }
        match thrice.abs() > NO_VOLUME {
            true => (Point3::from(weighted / thrice), thrice / 3.0),
            false => (Point3::from(estimate), thrice / 3.0),
        }
    }
}

/// Center and area of a face.
fn face_geometry(mesh: &PolyMesh, face: usize) -> (Point3<f64>, Vector3<f64>) {
    let corners: Vec<Vector3<f64>> = mesh.face_places(face).map(|place| place.coords).collect();
    polygon_geometry(&corners)
}

/// Center and area times normal (L²) of a polygon.
#[must_use]
pub(crate) fn polygon_geometry(corners: &[Vector3<f64>]) -> (Point3<f64>, Vector3<f64>) {
    let mean = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
    if let [a, b, c] = corners {
        return (
            Point3::from((a + b + c) / 3.0),
            0.5 * (b - a).cross(&(c - a)),
        );
    }
    let (mut normal, mut size, mut weighted) = (Vector3::zeros(), 0.0, Vector3::zeros());
    for (place, &from) in corners.iter().enumerate() {
        let to = corners[(place + 1) % corners.len()];
        let area = (to - from).cross(&(mean - from));
        normal += area;
        size += area.norm();
        weighted += area.norm() * (from + to + mean);
    }
    match size < NO_AREA {
        true => (Point3::from(mean), Vector3::zeros()),
        false => (Point3::from(weighted / (3.0 * size)), 0.5 * normal),
    }
}
