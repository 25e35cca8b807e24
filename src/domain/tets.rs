//! The solid filled with tetrahedra, as a domain.
//!
//! A cell that no boundary triangle touches is its own only piece, unless the tetrahedra carry a
//! density. Any other is cut tetrahedron by tetrahedron: the cell is clipped by the four planes of
//! every near one. Two tetrahedra at a facet are cut by the same plane from either side, so that
//! nothing is lost or counted twice. Inside and outside, and the way out, are the boundary's affair.

use std::collections::HashMap;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::domain::beyond::Beyond;
use crate::domain::error::DomainError;
use crate::domain::near::visit_near;
use crate::domain::space::{Domain, PieceScratch};
use crate::domain::surface::clipped::Meeting;
use crate::domain::surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::clip::{Clip, clip};
use crate::geometry::faceted::Piece;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;
use crate::mesh::tets::{FACETS, TetMesh, tet_volume};
use crate::mesh::validate::{ValidTetMesh, validate_surface};

/// A solid given by tetrahedra that fill it.
#[derive(Clone, Debug)]
pub struct TetSolid {
    mesh: TetMesh,
    /// Per tetrahedron the labels of the facets opposite its corners.
    labels: Vec<[Label; 4]>,
    tree: BoxTree,
    boundary: SurfaceSolid,
    volume: f64,
    density: Option<Density>,
}

/// A density that is linear on every tetrahedron.
#[derive(Clone, Debug)]
struct Density {
    /// Per tetrahedron the value at its first corner and the gradient.
    linear: Vec<(f64, Vector3<f64>)>,
    mean: f64,
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
        let crossings = report.crossings.map_or(0, |tally| tally.count);
        if crossings > 0 {
            let mend = "tetrahedra overlap there, remove the overlapping ones";
            return Err(refused(format!(
                "crosses itself in {crossings} pairs of triangles: {mend}"
            )));
        }
        let boundary = SurfaceSolid::new(&surface)?;
        Ok(Self {
            labels: labels(&mesh, &boundary),
            tree: BoxTree::new(mesh.all_corners().map(|corners| Bounds::of(&corners))),
            volume: mesh.volume(),
            boundary,
            mesh,
            density: None,
        })
    }

    /// The same solid with a density given at the vertices and linear on every tetrahedron.
    ///
    /// # Errors
    /// When a value is not positive.
    ///
    /// # Panics
    /// If there are fewer values than vertices.
    pub fn with_density(mut self, values: &[f64]) -> Result<Self, DomainError> {
        for (&value, vertex) in values.iter().zip(&self.mesh.vertices) {
            if !(value.is_finite() && value > 0.0) {
                let position = (*vertex).into();
                return Err(DomainError::Density { value, position });
            }
        }
        let mut mass = 0.0;
        let mut linear = Vec::with_capacity(self.mesh.tets.len());
        for (vertices, corners) in self.mesh.tets.iter().zip(self.mesh.all_corners()) {
            let values = vertices.map(|vertex| values[vertex as usize]);
            mass += tet_volume(&corners) * values.iter().sum::<f64>() / 4.0;
            let edges = [1, 2, 3].map(|k| corners[k] - corners[0]);
            let rises = Vector3::from([1, 2, 3].map(|k| values[k] - values[0]));
            let rows = Matrix3::from_columns(&edges).transpose();
            let gradient = rows.lu().solve(&rises).unwrap_or_default();
            linear.push((values[0], gradient));
        }
        let mean = mass / self.volume;
        self.density = Some(Density { linear, mean });
        Ok(self)
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

    /// Visits the parts of all tetrahedra in `cell`, each with its tetrahedron's number.
    pub fn visit_parts(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        mut visit: impl FnMut(u32, &Polyhedron),
    ) {
        let mut near = std::mem::take(&mut scratch.near);
        near.clear();
        visit_near(&self.tree, site, cell, |tet| near.push(tet));
        for &tet in &near {
            scratch.piece.assign_translated(cell, &Vector3::zeros());
            if self.clip_to(tet, site, scratch) {
                visit(tet, &scratch.piece);
            }
        }
        scratch.near = near;
    }

    /// Clips the piece to a tetrahedron and says whether anything is left.
    fn clip_to(&self, tet: u32, site: &Point3<f64>, scratch: &mut PieceScratch) -> bool {
        let vertices = self.mesh.tets[tet as usize];
        for (opposite, corners) in FACETS.iter().enumerate() {
            let mut facet = corners.map(|corner| vertices[corner]);
            // By ascending vertex, so that both tetrahedra at the facet use the same plane.
            let is_odd = (facet[0] > facet[1]) ^ (facet[1] > facet[2]) ^ (facet[0] > facet[2]);
            facet.sort_unstable();
            let [a, b, c] = facet.map(|vertex| self.mesh.vertices[vertex as usize] - site);
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
/// known by their places.
fn labels(mesh: &TetMesh, boundary: &SurfaceSolid) -> Vec<[Label; 4]> {
    let key = |corners: [Point3<f64>; 3]| {
        let mut key = corners.map(|corner| <[f64; 3]>::from(corner).map(f64::to_bits));
        key.sort_unstable();
        key
    };
    let triangles = boundary.surface().all_corners().map(key).zip(0..);
    let walls: HashMap<_, u32> = triangles.collect();
    let label = |tet: usize, corners: [usize; 3]| {
        let all = mesh.corners(tet);
        let wall = walls.get(&key(corners.map(|corner| all[corner])));
        wall.map_or(Beyond::Inner.label(), |&triangle| boundary.label(triangle))
    };
    (0..mesh.tets.len())
        .map(|tet| FACETS.map(|corners| label(tet, corners)))
        .collect()
}

impl Domain for TetSolid {
    fn bounds(&self) -> Bounds<3> {
        self.boundary.bounds()
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.boundary.contains(point)
    }

    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron) {
        self.boundary.start(site, index, cell);
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        if scratch.clipped.meet(&self.boundary, site, cell) == Meeting::Apart {
            visit(1.0, Piece::Convex(cell));
        } else {
            self.pieces_within(site, cell, scratch, visit);
        }
    }

    fn pieces_within(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        self.visit_parts(site, part, scratch, |_, part| {
            visit(1.0, Piece::Convex(part))
        });
    }

    fn weighted_pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let Some(density) = &self.density else {
            return self.pieces(site, cell, scratch, &mut |sign, part| {
                visit(sign, part, None)
            });
        };
        self.visit_parts(site, cell, scratch, |tet, part| {
            let (value, gradient) = density.linear[tet as usize];
            let corner = self.mesh.vertices[self.mesh.tets[tet as usize][0] as usize];
            let at_site = value - gradient.dot(&(corner - site));
            let density = Polynomial::linear(at_site, &gradient);
            visit(1.0, Piece::Convex(part), Some(&density));
        });
    }

    fn has_density(&self) -> bool {
        self.density.is_some()
    }

    fn mean_density(&self) -> f64 {
        self.density.as_ref().map_or(1.0, |density| density.mean)
    }

    fn shape(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(Piece<'_>),
    ) {
        self.boundary.shape(site, cell, scratch, visit);
    }

    fn first_exit(&self, site: &Point3<f64>, step: &Vector3<f64>) -> f64 {
        self.boundary.first_exit(site, step)
    }
}
