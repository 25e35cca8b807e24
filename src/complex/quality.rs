//! Quality of a mesh by the definitions of OpenFOAM's `checkMesh`.
//!
//! Source: OpenFOAM v1912, `primitiveMeshCheck.C`, `primitiveMeshTools.C`, `polyMeshTools.C`, with the
//! patches of a period as coupled ones.

use nalgebra::{Point3, Vector3};

use crate::complex::element::{CellElement, scaled_jacobian};
use crate::complex::face_geometry::{MeshGeometry, NO_AREA};
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};
use crate::parallel::map;

/// The sum of a cell's areas may be this share of their sizes (`closedThreshold_`).
const CLOSED: f64 = 1e-6;

/// Pyramids of faces over cell centers below this volume (L³) are bad (`-SMALL`).
const BAD_PYRAMID: f64 = -1e-15;

/// The center of a cell's face lies in the plane of another within this cosine (`planarCosAngle_`).
const PLANAR: f64 = 1e-6;

/// A mesh, and what all its figures are made of.
#[derive(Debug)]
pub(crate) struct MeasuredMesh<'a> {
    /// The mesh, whose structure is sound.
    pub(crate) mesh: &'a PolyMesh,
    /// The faces of every cell.
    pub(crate) cells: CellFaces,
    /// Centers, areas and volumes.
    pub(crate) geometry: MeshGeometry,
    /// The shape of every cell.
    pub(crate) elements: Vec<CellElement>,
    faces: Vec<FaceQuality>,
}

impl<'a> MeasuredMesh<'a> {
    /// Measures a mesh, whose structure is sound.
    #[must_use]
    pub(crate) fn new(mesh: &'a PolyMesh) -> Self {
        let cells = mesh.cell_faces();
        let geometry = MeshGeometry::of(mesh, &cells);
        let element = |cell: usize| CellElement::of(mesh, &cells, cell);
        let elements = map(mesh.cell_count, &element);
        let beyond = Beyond::new(mesh, &geometry);
        let quality = |face: usize| face_quality(mesh, &geometry, &beyond, face);
        let faces = map(mesh.face_count(), &quality);
        Self {
            mesh,
            cells,
            geometry,
            elements,
            faces,
        }
    }

    /// The angles of non-orthogonality (degrees) of all faces that are not on walls.
    #[must_use]
    pub(crate) fn non_orthogonality(&self) -> Vec<f64> {
        let cosines = self.faces.iter().filter_map(|face| face.cosine);
        let angles = cosines.map(|(cosine, _)| degrees(cosine));
        angles.collect()
    }

    /// The skewness of all faces.
    #[must_use]
    pub(crate) fn skewness(&self) -> Vec<f64> {
        self.faces.iter().map(|face| face.skewness).collect()
    }

    /// The scaled Jacobians of hexahedra, ascending.
    #[must_use]
    pub(crate) fn scaled_jacobians(&self) -> Vec<f64> {
        let hexahedra = self.elements.iter().filter_map(|element| match element {
            CellElement::Hexahedron(corners) => Some(scaled_jacobian(self.mesh, corners)),
            _ => None,
        });
        let mut jacobians: Vec<f64> = hexahedra.collect();
        jacobians.sort_by(f64::total_cmp);
        jacobians
    }
}

/// The angle of a cosine.
fn degrees(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

/// How good a mesh is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MeshQuality {
    /// The sum of all cells' volumes (L³).
    pub(crate) volume: f64,
    /// The greatest angle between a face's normal and the line of its cells' centers (degrees).
    pub(crate) non_orthogonality_max: f64,
    /// The angle whose cosine is the mean (degrees).
    pub(crate) non_orthogonality_mean: f64,
    /// The greatest distance of a face's center from where that line meets the face, relative to the
    /// face's size.
    pub(crate) skewness_max: f64,
    /// The same over faces on walls.
    pub(crate) skewness_wall_max: f64,
    /// How many pyramids of a face over the center of its cell have no positive volume.
    pub(crate) bad_pyramids: usize,
    /// The greatest aspect ratio of a cell.
    pub(crate) aspect_max: f64,
    /// The least ratio of a face's area to the sum of its triangles' areas.
    pub(crate) flatness_min: f64,
    /// How many cells have a face whose plane has the center of another on its outer side.
    pub(crate) concave_cells: usize,
    /// The length of the shortest edge (L).
    pub(crate) edge_min: f64,
    /// The area of the smallest face (L²).
    pub(crate) face_min: f64,
    /// How many cells' areas do not sum to zero.
    pub(crate) open_cells: usize,
}

/// What one face contributes.
#[derive(Clone, Copy, Debug)]
struct FaceQuality {
    /// The cosine of non-orthogonality, and whether it counts for the mean; none on walls.
    cosine: Option<(f64, bool)>,
    skewness: f64,
    bad_pyramids: usize,
    flatness: f64,
    edge: f64,
    area: f64,
}

/// What one cell contributes.
#[derive(Clone, Copy, Debug)]
struct CellQuality {
    aspect: f64,
    is_open: bool,
    is_concave: bool,
}

impl MeshQuality {
    /// How good a measured mesh is.
    #[must_use]
    pub(crate) fn of(measured: &MeasuredMesh<'_>) -> Self {
        let MeasuredMesh {
            mesh,
            cells,
            geometry,
            faces,
            ..
        } = measured;
        let all = map(mesh.cell_count, &|cell| cell_quality(geometry, cells, cell));
        let mut quality = Self {
            volume: geometry.cell_volumes.iter().sum(),
            flatness_min: 1.0,
            edge_min: f64::INFINITY,
            face_min: f64::INFINITY,
            ..Self::default()
        };
        quality.add_faces(faces);
        quality.add_cells(&all);
        quality
    }

    fn add_faces(&mut self, faces: &[FaceQuality]) {
        let (mut least, mut sum, mut count) = (1.0_f64, 0.0, 0.0);
        for face in faces {
            self.skewness_max = self.skewness_max.max(face.skewness);
            self.bad_pyramids += face.bad_pyramids;
            self.flatness_min = self.flatness_min.min(face.flatness);
            self.edge_min = self.edge_min.min(face.edge);
            self.face_min = self.face_min.min(face.area);
            match face.cosine {
                None => self.skewness_wall_max = self.skewness_wall_max.max(face.skewness),
                Some((cosine, counts)) => {
                    least = least.min(cosine);
                    sum += if counts { cosine } else { 0.0 };
                    count += f64::from(counts);
                }
            }
        }
        if count > 0.0 {
            self.non_orthogonality_max = degrees(least);
            self.non_orthogonality_mean = degrees(sum / count);
        }
    }

    fn add_cells(&mut self, cells: &[CellQuality]) {
        for cell in cells {
            self.aspect_max = self.aspect_max.max(cell.aspect);
            self.open_cells += usize::from(cell.is_open);
            self.concave_cells += usize::from(cell.is_concave);
        }
    }
}

/// The center of the cell behind a face that is not a wall, and whether the face counts for means: of
/// two that are one period apart the first does.
struct Beyond<'a> {
    mesh: &'a PolyMesh,
    geometry: &'a MeshGeometry,
}

impl<'a> Beyond<'a> {
    fn new(mesh: &'a PolyMesh, geometry: &'a MeshGeometry) -> Self {
        Self { mesh, geometry }
    }

    fn of(&self, face: usize) -> Option<(Point3<f64>, bool)> {
        if let Some(cell) = self.mesh.neighbor_of(face) {
            return Some((self.geometry.cell_centers[cell], true));
        }
        let holds = |start: usize, count: usize| (start..start + count).contains(&face);
        let patches = self.mesh.patches.iter();
        let (here, patch) = patches
            .enumerate()
            .find(|(_, patch)| holds(patch.start, patch.count))?;
        let (partner, way) = patch.partner?;
        let other = self.mesh.patches.get(partner)?.start + (face - patch.start);
        let cell = *self.mesh.owner.get(other)? as usize;
        Some((self.geometry.cell_centers[cell] - way, here < partner))
    }
}

fn face_quality(
    mesh: &PolyMesh,
    geometry: &MeshGeometry,
    beyond: &Beyond<'_>,
    face: usize,
) -> FaceQuality {
    let (center, area) = (geometry.face_centers[face], geometry.face_areas[face]);
    let owner = geometry.cell_centers[mesh.owner[face] as usize];
    let behind = beyond.of(face);
    let line = behind.map_or_else(
        || {
            let normal = area / (area.norm() + NO_AREA);
            normal * normal.dot(&(center - owner))
        },
        |(other, _)| other - owner,
    );
    let cosine = behind.map(|(_, counts)| {
        let cosine = line.dot(&area) / (line.norm() * area.norm() + NO_AREA);
        (cosine, counts)
    });
    // The share of the line that the face's size is at least.
    let share = if behind.is_some() { 0.2 } else { 0.4 };
    let inner = mesh
        .neighbor_of(face)
        .map(|cell| geometry.cell_centers[cell]);
    let pyramids = [
        Some((center - owner).dot(&area)),
        inner.map(|other| (other - center).dot(&area)),
    ];
    let is_bad = |pyramid: &&f64| **pyramid / 3.0 < BAD_PYRAMID;
    let corners: Vec<Point3<f64>> = mesh.face_places(face).collect();
    FaceQuality {
        cosine,
        skewness: skewness(&corners, (center, area), &(center - owner), &line, share),
        bad_pyramids: pyramids.iter().flatten().filter(is_bad).count(),
        flatness: flatness(&corners, &center, &area),
        edge: sides(&corners)
            .map(|(a, b)| (b - a).norm())
            .fold(f64::INFINITY, f64::min),
        area: area.norm(),
    }
}

fn sides(corners: &[Point3<f64>]) -> impl Iterator<Item = (Point3<f64>, Point3<f64>)> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&from, &to)| (from, to))
}

/// `primitiveMeshTools::faceSkewness` and `boundaryFaceSkewness`.
pub(crate) fn skewness(
    corners: &[Point3<f64>],
    (center, area): (Point3<f64>, Vector3<f64>),
    from_owner: &Vector3<f64>,
    line: &Vector3<f64>,
    share: f64,
) -> f64 {
    let meets = area.dot(from_owner) / (area.dot(line) + NO_AREA);
    let off = from_owner - meets * line;
    let direction = off / (off.norm() + NO_AREA);
    let reach = |corner: &Point3<f64>| direction.dot(&(corner - center)).abs();
    let size = corners
        .iter()
        .map(reach)
        .fold(share * line.norm() + NO_AREA, f64::max);
    off.norm() / size
}

/// `primitiveMeshTools::faceFlatness`.
fn flatness(corners: &[Point3<f64>], center: &Point3<f64>, area: &Vector3<f64>) -> f64 {
    if corners.len() <= 3 || area.norm() <= NO_AREA {
        return 1.0;
    }
    let triangle =
        |(from, to): (Point3<f64>, Point3<f64>)| 0.5 * (to - from).cross(&(center - from)).norm();
    area.norm() / (sides(corners).map(triangle).sum::<f64>() + NO_AREA)
}

/// `primitiveMeshTools::cellClosedness` and `checkConcaveCells`.
fn cell_quality(geometry: &MeshGeometry, cells: &CellFaces, cell: usize) -> CellQuality {
    let (mut sum, mut sizes) = (Vector3::zeros(), Vector3::zeros());
    for (face, is_owner) in cells.of(cell) {
        let area = geometry.face_areas[face];
        sum += if is_owner { area } else { -area };
        sizes += area.abs();
    }
    let openness = sum.abs().component_div(&sizes.add_scalar(NO_AREA)).max();
    let volume = geometry.cell_volumes[cell].max(NO_AREA);
    let aspect = sizes.max() / (sizes.min() + NO_AREA);
    CellQuality {
        aspect: aspect.max(sizes.sum() / (6.0 * volume.powf(2.0 / 3.0))),
        is_open: openness > CLOSED,
        is_concave: is_concave(geometry, cells, cell),
    }
}

fn is_concave(geometry: &MeshGeometry, cells: &CellFaces, cell: usize) -> bool {
    cells.of(cell).any(|(face, is_owner)| {
        let area = geometry.face_areas[face];
        let normal = if is_owner { area } else { -area } / area.norm().max(1e-300);
        let center = geometry.face_centers[face];
        let mut others = cells.of(cell).filter(|&(other, _)| other != face);
        others.any(|(other, _)| {
            let way = geometry.face_centers[other] - center;
            way.dot(&normal) / way.norm().max(1e-300) > -PLANAR
        })
    })
}
