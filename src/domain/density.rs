//! Densities over a domain: formulas in boxes, or linear functions on tetrahedra.

use std::sync::OnceLock;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::density_power::{PowerIntegral, over_regions, over_tetrahedron};
use crate::domain::density_region::DensityRegion;
use crate::domain::error::DomainError;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::domain::shape_integrator::{ShapeIntegrator, clip_to_box, clip_to_planes};
use crate::domain::tet_mesh::IndexedTets;
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::Monomials;
use crate::mesh::tets::{TetMesh, tet_volume};

/// The power of the density whose integral gives the least energy of order 1 in space: D/(D+p).
const OPTIMUM: f64 = 3.0 / 4.0;

/// A positive density over a domain.
#[derive(Debug)]
pub struct Density {
    parts: Parts,
    mean: f64,
    greatest: f64,
    /// On first use: of ρ^[`OPTIMUM`].
    power: OnceLock<PowerIntegral>,
}

#[derive(Debug)]
enum Parts {
    /// Boxes that fill space, with densities in the domain's coordinates.
    Regions(Vec<DensityRegion>),
    /// Per tetrahedron the value at its first corner and the gradient.
    Tets(IndexedTets, Vec<(f64, Vector3<f64>)>),
}

impl Density {
    /// The density in each of `regions`, which fill space.
    pub(crate) fn by_regions(
        shape: &dyn DomainShape,
        regions: Vec<DensityRegion>,
    ) -> Result<Self, DomainError> {
        let whole = ShapeIntegrator::new(shape);
        let middle = *whole.middle();
        let masses = regions.iter().map(|region| {
            let density = region.about(&middle);
            let monomials = Monomials::up_to(density.degree());
            let within = (&region.bounds, &region.planes[..]);
            whole.mass_of_terms(within, &middle, &density, &monomials)
        });
        let mean = masses.sum::<f64>() / shape.volume();
        if !(mean.is_normal() && mean > 0.0) {
            return Err(DomainError::Density {
                value: mean,
                position: middle.into(),
            });
        }
        let bounds = shape.bounds();
        let highs = regions.iter().map(|region| region.upper_bound(&bounds));
        Ok(Self {
            mean,
            greatest: highs.fold(0.0, f64::max),
            power: OnceLock::new(),
            parts: Parts::Regions(regions),
        })
    }

    /// The density that is linear on every tetrahedron and has these values at the vertices.
    pub(crate) fn on_tets(tets: IndexedTets, values: &[f64]) -> Result<Self, DomainError> {
        let mesh = &tets.mesh;
        for (&value, vertex) in values.iter().zip(&mesh.vertices) {
            if !(value.is_finite() && value > 0.0) {
                let position = (*vertex).into();
                return Err(DomainError::Density { value, position });
            }
        }
        let mut mass = 0.0;
        let mut linear = Vec::with_capacity(mesh.tets.len());
        for (vertices, corners) in mesh.tets.iter().zip(mesh.all_corners()) {
            let values = vertices.map_each(|vertex| values[vertex as usize]);
            mass += tet_volume(&corners) * values.iter().sum::<f64>() / 4.0;
            linear.push((values[0], gradient(&corners, &values)));
        }
        Ok(Self {
            mean: mass / mesh.volume(),
            greatest: values.iter().copied().fold(0.0, f64::max),
            power: OnceLock::new(),
            parts: Parts::Tets(tets, linear),
        })
    }

    /// The mean over the domain.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// No less than the density anywhere in the domain.
    #[must_use]
    pub fn upper_bound(&self) -> f64 {
        self.greatest
    }

    /// ∫ (ρ/mean)^¾ over the domain (L³) and an estimate of the error: the volume whose parts, taken as
    /// equal cubes of density `mean`, have asymptotically the least energy of order 1.
    #[must_use]
    pub(crate) fn optimal_volume(&self, shape: &dyn DomainShape) -> PowerIntegral {
        let power = self.power.get_or_init(|| match &self.parts {
            Parts::Regions(regions) => over_regions(shape, regions, OPTIMUM),
            Parts::Tets(tets, linear) => over_tets(&tets.mesh, linear),
        });
        let unit = self.mean.powf(-OPTIMUM);
        PowerIntegral {
            value: power.value * unit,
            error: power.error * unit,
        }
    }

    /// Visits the signed pieces of `cell` ∩ `shape`, each with its density as a polynomial in the
    /// same coordinates, those relative to `site`.
    pub(crate) fn pieces(
        &self,
        shape: &dyn DomainShape,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let regions = match &self.parts {
            Parts::Regions(regions) => regions,
            Parts::Tets(tets, linear) => {
                return tets.visit_parts(site, cell, scratch, |tet, part| {
                    let (value, gradient) = linear[tet as usize];
                    let corner = tets.mesh.vertices[tets.mesh.tets[tet as usize][0] as usize];
                    let at_site = value - gradient.dot(&(corner - site));
                    let density = Polynomial::linear(at_site, &gradient);
                    visit(1.0, Piece::Convex(part), Some(&density));
                });
            }
        };
        let around = cell.bounds().translated(&site.coords);
        let near = |region: &&DensityRegion| region.bounds.overlaps(&around);
        for region in regions.iter().filter(near) {
            let (bounds, density) = (&region.bounds, region.about(site));
            let mut weigh = |sign: f64, piece: Piece<'_>| visit(sign, piece, Some(&density));
            let is_whole = region.planes.is_empty();
            if is_whole && bounds.contains(&around.min) && bounds.contains(&around.max) {
                return shape.pieces(site, cell, scratch, &mut weigh);
            }
            let mut part = std::mem::take(&mut scratch.part);
            part.assign_translated(cell, &Vector3::zeros());
            let clip = &mut scratch.clip;
            if clip_to_box(&mut part, site, bounds, clip)
                && clip_to_planes(&mut part, site, &region.planes, clip)
            {
                shape.signed_pieces(site, &part, false, scratch, &mut weigh);
            }
            scratch.part = part;
        }
    }
}

/// ∫ ρ^[`OPTIMUM`] over tetrahedra, per tetrahedron ρ at its first corner and its gradient.
fn over_tets(mesh: &TetMesh, linear: &[(f64, Vector3<f64>)]) -> PowerIntegral {
    let mut sum = PowerIntegral::default();
    for ((first, gradient), corners) in linear.iter().zip(mesh.all_corners()) {
        let values = corners.map_each(|corner| first + gradient.dot(&(corner - corners[0])));
        let part = over_tetrahedron(tet_volume(&corners), values, OPTIMUM);
        sum.value += part.value;
        sum.error += part.error;
    }
    sum
}

/// The gradient of the linear function with these values at a tetrahedron's corners; zero for a flat one.
fn gradient(corners: &[Point3<f64>; 4], values: &[f64; 4]) -> Vector3<f64> {
    let edges = [1, 2, 3].map_each(|k| corners[k] - corners[0]);
    let rises = Vector3::from([1, 2, 3].map_each(|k| values[k] - values[0]));
    let rows = Matrix3::from_columns(&edges).transpose();
    rows.lu().solve(&rises).unwrap_or_default()
}
