//! Domains: a shape with an optional density.

use std::fmt::Debug;
use std::ops::Deref;

use nalgebra::Point3;

use crate::domain::density::Density;
use crate::domain::density_region::{DensityRegion, regions};
use crate::domain::density_sign::check_positive;
use crate::domain::error::DomainError;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::domain::tet_mesh::{IndexedTets, TetSolid};
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;

/// A shape and a density over it. Every shape is a domain of density 1; `dyn Domain` has all
/// methods of its [`DomainShape`].
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Domain, DomainShape};
///
/// let domain: Box<dyn Domain> = Box::new(Cuboid::unit());
/// assert!(domain.contains(&[0.5; 3].into()) && domain.density().is_none());
/// ```
pub trait Domain: Debug + Send + Sync {
    /// The shape.
    fn shape(&self) -> &(dyn DomainShape + 'static);

    /// The density; none is 1 everywhere.
    fn density(&self) -> Option<&Density> {
        None
    }

    /// Whether there is a density.
    fn has_density(&self) -> bool {
        self.density().is_some()
    }

    /// The mean of the density over Ω; 1 without one.
    fn mean_density(&self) -> f64 {
        self.density().map_or(1.0, Density::mean)
    }

    /// As [`DomainShape::pieces`], each piece with its density as a polynomial in the same
    /// coordinates; none is density 1.
    fn weighted_pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let shape = self.shape();
        match self.density() {
            Some(density) => density.pieces(shape, site, cell, scratch, visit),
            None => shape.pieces(site, cell, scratch, &mut |sign, piece| {
                visit(sign, piece, None)
            }),
        }
    }
}

impl<Shape: DomainShape> Domain for Shape {
    fn shape(&self) -> &(dyn DomainShape + 'static) {
        self
    }
}

impl<'a> Deref for dyn Domain + 'a {
    type Target = dyn DomainShape;

    fn deref(&self) -> &Self::Target {
        self.shape()
    }
}

/// A domain with a density that is a polynomial everywhere, in each of many boxes, or in every
/// tetrahedron. Its cells are the shape's.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Polynomial, Relaxation, WeightedDomain, random_sites};
///
/// let density = Polynomial::from_terms([([0, 0, 0], 1.0), ([1, 0, 0], 8.0)]);
/// let graded = WeightedDomain::new(Box::new(Cuboid::unit()), density)?;
/// let mut sites = random_sites(&graded, 20, 1)?;
/// Relaxation::new(graded).run(&mut sites)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct WeightedDomain {
    domain: Box<dyn Domain>,
    density: Density,
}

impl WeightedDomain {
    /// `domain` with `density`, a polynomial in its coordinates. Far from the origin a
    /// polynomial that was read from text keeps its digits, one of terms cancels them.
    ///
    /// # Errors
    /// When the density is negative somewhere, zero in a part of the domain, or changes along a
    /// periodic axis.
    pub fn new(domain: Box<dyn Domain>, density: Polynomial) -> Result<Self, DomainError> {
        refuse_periodic(domain.shape(), &density)?;
        check_positive(domain.shape(), &density)?;
        let density =
            Density::by_regions(domain.shape(), vec![DensityRegion::everywhere(density)])?;
        Ok(Self { domain, density })
    }

    /// `domain` with the density h^−(3+p) of cells of the edge h = `size` for energies of
    /// order p = `order`, within half a percent: the domain is cut into boxes, in each of which the
    /// density is a parabola in h.
    ///
    /// # Errors
    /// When the size is not positive somewhere, changes along a periodic axis or too fast.
    pub fn sized(
        domain: Box<dyn Domain>,
        size: &Polynomial,
        order: u32,
    ) -> Result<Self, DomainError> {
        refuse_periodic(domain.shape(), size)?;
        let regions = regions(domain.shape(), size, order)?;
        let density = Density::by_regions(domain.shape(), regions)?;
        Ok(Self { domain, density })
    }

    /// `domain` with a density given in regions that fill space.
    pub(crate) fn by_regions(
        domain: Box<dyn Domain>,
        regions: Vec<DensityRegion>,
    ) -> Result<Self, DomainError> {
        let density = Density::by_regions(domain.shape(), regions)?;
        Ok(Self { domain, density })
    }
}

impl TetSolid {
    /// The same solid with a density given at the vertices and linear on every tetrahedron.
    ///
    /// # Errors
    /// When a value is not positive.
    ///
    /// # Panics
    /// If there are fewer values than vertices.
    pub fn with_density(self, values: &[f64]) -> Result<WeightedDomain, DomainError> {
        let (mesh, boundary) = self.into_parts();
        let density = Density::on_tets(IndexedTets::new(mesh, &boundary), values)?;
        let domain = Box::new(boundary);
        Ok(WeightedDomain { domain, density })
    }
}

impl Domain for TetSolid {
    fn shape(&self) -> &(dyn DomainShape + 'static) {
        self.boundary()
    }
}

impl Domain for WeightedDomain {
    fn shape(&self) -> &(dyn DomainShape + 'static) {
        self.domain.shape()
    }

    fn density(&self) -> Option<&Density> {
        Some(&self.density)
    }
}

/// Refuses a polynomial that changes along a periodic axis.
fn refuse_periodic(shape: &dyn DomainShape, polynomial: &Polynomial) -> Result<(), DomainError> {
    let periods = shape.periods();
    let polynomial = polynomial.relative_to(&shape.bounds().center());
    let changes = |axis: &usize| {
        let mut terms = polynomial.terms();
        terms.any(|(powers, value)| powers[*axis] > 0 && value.abs() > 0.0)
    };
    match (0..3).filter(|&axis| periods[axis].is_some()).find(changes) {
        Some(axis) => Err(DomainError::DensityAlongPeriod { axis }),
        None => Ok(()),
    }
}
