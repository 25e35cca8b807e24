//! The solid filled with tetrahedra as a domain, and the parts of a cell in each of them.
//!
//! The solid is the one within the tetrahedra's boundary. Where they carry a density, a cell is cut
//! tetrahedron by tetrahedron: it is clipped by the four planes of every near one. Two tetrahedra at
//! a facet are cut by the same plane from either side, so that nothing is lost or counted twice.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::candidates::visit_candidates;
use crate::domain::error::DomainError;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::clip::{Clip, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::tets::{FACETS, TetMesh};
use crate::mesh::validate::{ValidTetMesh, validate_surface, validate_tets};

/// A solid given by tetrahedra that fill it.
#[derive(Clone, Debug)]
pub struct TetSolid {
    mesh: TetMesh,
    boundary: SurfaceSolid,
}

/// Tetrahedra with their bounding boxes and the labels of their facets.
#[derive(Debug)]
pub(crate) struct IndexedTets {
    pub(crate) mesh: TetMesh,
    /// Per tetrahedron the labels of the facets opposite its corners.
    labels: Vec<[Label; 4]>,
    bvh: Bvh,
}

impl TetSolid {
    /// The solid that `tets` fill. Walls are numbered as those of its boundary
    /// ([`SurfaceSolid::new`]).
    ///
    /// # Errors
    /// When the boundary bounds no solid, as where tetrahedra overlap.
    pub fn new(tets: &ValidTetMesh) -> Result<Self, DomainError> {
        let mesh = tets.mesh().clone();
        let refused = |reason: String| DomainError::Boundary { reason };
        let validated = validate_surface(&mesh.boundary());
        let (surface, report) = validated.map_err(|refusal| refused(refusal.to_string()))?;
        if let Some(overlap) = report.repeated.or(report.negative) {
            let remedy = "tetrahedra overlap there, remove the overlapping ones";
            return Err(refused(format!(
                "encloses {overlap} more than once: {remedy}"
            )));
        }
        let boundary = SurfaceSolid::new(&surface)?;
        Ok(Self { mesh, boundary })
    }

    /// The solid of tetrahedra.
    ///
    /// # Errors
    /// [`DomainError::Mesh`] when they fill no solid, and as [`TetSolid::new`].
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Domain, TetSolid};
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let solid = TetSolid::from_arrays(&corners, &[[0, 1, 2, 3]])?;
    /// assert!((solid.shape().volume() - 1.0 / 6.0).abs() < 1e-15);
    /// # Ok::<(), chebloyd::DomainError>(())
    /// ```
    pub fn from_arrays<P: Copy + Into<Point3<f64>>>(
        vertices: &[P],
        tets: &[[u32; 4]],
    ) -> Result<Self, DomainError> {
        let mesh = TetMesh {
            vertices: vertices.iter().map(|&vertex| vertex.into()).collect(),
            tets: tets.to_vec(),
            vertex_data: Vec::new(),
        };
        Self::new(&validate_tets(&mesh)?.0)
    }

    /// The tetrahedra.
    #[must_use]
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// The solid by its boundary.
    #[must_use]
    pub fn boundary(&self) -> &SurfaceSolid {
        &self.boundary
    }

    /// The solid by its boundary alone.
    #[must_use]
    pub(crate) fn into_boundary(self) -> SurfaceSolid {
        self.boundary
    }

    /// The mesh and its boundary.
    pub(crate) fn into_parts(self) -> (TetMesh, SurfaceSolid) {
        (self.mesh, self.boundary)
    }
}

impl IndexedTets {
    /// The tetrahedra of `mesh`, which has this boundary.
    pub(crate) fn new(mesh: TetMesh, boundary: &SurfaceSolid) -> Self {
        Self {
            labels: labels(&mesh, boundary),
            bvh: Bvh::new(mesh.all_corners().map(|corners| Bounds::of(&corners))),
            mesh,
        }
    }

    /// Visits the parts of all tetrahedra in `cell`, each with its tetrahedron's number.
    pub(crate) fn visit_parts(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        mut visit: impl FnMut(u32, &Polyhedron),
    ) {
        let mut near = std::mem::take(&mut scratch.candidates);
        near.clear();
        visit_candidates(&self.bvh, site, cell, |tet| near.push(tet));
        for &tet in &near {
            scratch.piece.assign_translated(cell, &Vector3::zeros());
            if self.clip_to(tet, site, scratch) {
                visit(tet, &scratch.piece);
            }
        }
        scratch.candidates = near;
    }

    /// Clips the piece to a tetrahedron and returns whether anything is left.
    fn clip_to(&self, tet: u32, site: &Point3<f64>, scratch: &mut PieceScratch) -> bool {
        let vertices = self.mesh.tets[tet as usize];
        for (opposite, corners) in FACETS.iter().enumerate() {
            let mut facet = corners.map_each(|corner| vertices[corner]);
            // By ascending vertex, so that both tetrahedra at the facet use the same plane.
            let is_odd = (facet[0] > facet[1]) ^ (facet[1] > facet[2]) ^ (facet[0] > facet[2]);
            facet.sort_unstable();
            let [a, b, c] = facet.map_each(|vertex| self.mesh.vertices[vertex as usize] - site);
            let normal = (b - a).cross(&(c - a));
            let outward = if is_odd { -1.0 } else { 1.0 };
            let plane = HalfSpace {
                normal: normal * outward,
                offset: normal.dot(&a) * outward,
            };
            let label = self.labels[tet as usize][opposite];
            if clip(&mut scratch.piece, &plane, label, &mut scratch.clip) == Clip::Emptied {
                return false;
            }
        }
        true
    }
}

/// Labels facets on the boundary by their walls, the others as inner ones. Boundary triangles are
/// identified by their corners' coordinates.
fn labels(mesh: &TetMesh, boundary: &SurfaceSolid) -> Vec<[Label; 4]> {
    let key = |corners: [Point3<f64>; 3]| {
        let mut key = corners.map_each(|corner| <[f64; 3]>::from(corner).map_each(f64::to_bits));
        key.sort_unstable();
        key
    };
    let triangles = boundary.surface().all_corners().map(key).zip(0..);
    let walls: HashMap<_, u32> = triangles.collect();
    let label = |tet: usize, corners: [usize; 3]| {
        let all = mesh.corners(tet);
        let wall = walls.get(&key(corners.map_each(|corner| all[corner])));
        wall.map_or(FacetKind::Inner.label(), |&triangle| {
            boundary.indexed().label(triangle)
        })
    };
    (0..mesh.tets.len())
        .map(|tet| FACETS.map(|corners| label(tet, corners)))
        .collect()
}
