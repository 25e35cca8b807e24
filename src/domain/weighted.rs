//! A domain with a density that is a polynomial in x, y and z, or follows from one.

use nalgebra::{Point3, Vector3};

use crate::domain::error::DomainError;
use crate::domain::graded::{Region, regions};
use crate::domain::positive::check_positive;
use crate::domain::space::{Domain, PieceScratch};
use crate::domain::within::{clip_to_box, mass_within, start_of_all};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;

/// A domain with a density that is a polynomial everywhere, or in each of many boxes. Its cells are
/// the domain's.
#[derive(Debug)]
pub struct WeightedDomain {
    domain: Box<dyn Domain>,
    /// Boxes that fill space, with densities in the domain's coordinates.
    regions: Vec<Region>,
    mean: f64,
}

impl WeightedDomain {
    /// `domain` with `density`, a polynomial in its coordinates.
    ///
    /// # Errors
    /// When the density is not positive somewhere, or changes along a periodic axis.
    pub fn new(domain: Box<dyn Domain>, density: Polynomial) -> Result<Self, DomainError> {
        refuse_periodic(domain.as_ref(), &density)?;
        check_positive(domain.as_ref(), &density)?;
        Self::of(domain, vec![Region::everywhere(density)])
    }

    /// `domain` with the density h^−(3+p) that cells of the edge h = `size` want for energies of
    /// order p = `order`, within half a percent.
    ///
    /// # Errors
    /// When the size is not positive somewhere, changes along a periodic axis or too fast.
    pub fn sized(
        domain: Box<dyn Domain>,
        size: &Polynomial,
        order: u32,
    ) -> Result<Self, DomainError> {
        refuse_periodic(domain.as_ref(), size)?;
        let regions = regions(domain.as_ref(), size, order)?;
        Self::of(domain, regions)
    }

    fn of(domain: Box<dyn Domain>, regions: Vec<Region>) -> Result<Self, DomainError> {
        let start = start_of_all(domain.as_ref());
        let masses = regions.iter().map(|Region { bounds, density }| {
            mass_within(domain.as_ref(), &start, bounds, density)
        });
        let mean = masses.sum::<f64>() / domain.volume();
        if !(mean.is_normal() && mean > 0.0) {
            return Err(DomainError::Density {
                value: mean,
                position: domain.bounds().center().into(),
            });
        }
        Ok(Self {
            domain,
            regions,
            mean,
        })
    }
}

/// Refuses a polynomial that does not repeat itself where the domain does.
fn refuse_periodic(domain: &dyn Domain, polynomial: &Polynomial) -> Result<(), DomainError> {
    let periods = domain.periods();
    let changes = |axis: &usize| {
        let mut terms = polynomial.terms();
        terms.any(|(powers, value)| powers[*axis] > 0 && value.abs() > 0.0)
    };
    match (0..3).filter(|&axis| periods[axis].is_some()).find(changes) {
        Some(axis) => Err(DomainError::DensityAlongPeriod { axis }),
        None => Ok(()),
    }
}

impl Domain for WeightedDomain {
    fn bounds(&self) -> Bounds<3> {
        self.domain.bounds()
    }

    fn volume(&self) -> f64 {
        self.domain.volume()
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.domain.contains(point)
    }

    fn periods(&self) -> [Option<f64>; 3] {
        self.domain.periods()
    }

    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron) {
        self.domain.start(site, index, cell);
    }

    fn is_convex(&self) -> bool {
        self.domain.is_convex()
    }

    fn pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        self.domain.pieces(site, cell, scratch, visit);
    }

    fn pieces_within(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        self.domain.pieces_within(site, part, scratch, visit);
    }

    fn weighted_pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let mut around = cell.bounds();
        around.min += site.coords;
        around.max += site.coords;
        let near = |region: &&Region| region.bounds.overlaps(&around);
        for Region { bounds, density } in self.regions.iter().filter(near) {
            let density = density.seen_from(site);
            let mut weigh = |sign: f64, piece: Piece<'_>| visit(sign, piece, Some(&density));
            if bounds.contains(&around.min) && bounds.contains(&around.max) {
                return self.domain.pieces(site, cell, scratch, &mut weigh);
            }
            let mut part = std::mem::take(&mut scratch.part);
            part.assign_translated(cell, &Vector3::zeros());
            if clip_to_box(&mut part, site, bounds, &mut scratch.clip) {
                self.domain.pieces_within(site, &part, scratch, &mut weigh);
            }
            scratch.part = part;
        }
    }

    fn has_density(&self) -> bool {
        true
    }

    fn mean_density(&self) -> f64 {
        self.mean
    }

    fn shape(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(Piece<'_>),
    ) {
        self.domain.shape(site, cell, scratch, visit);
    }

    fn first_exit(&self, site: &Point3<f64>, step: &Vector3<f64>) -> f64 {
        self.domain.first_exit(site, step)
    }
}
