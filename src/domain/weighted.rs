//! A domain with a density that is a polynomial in x, y and z.

use nalgebra::{Point3, Vector3};

use crate::domain::error::DomainError;
use crate::domain::space::{Domain, PieceScratch};
use crate::geometry::bounds::Bounds;
use crate::geometry::faceted::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;

/// A domain whose pieces all have the same polynomial as density. Its cells are the domain's.
#[derive(Debug)]
pub struct WeightedDomain {
    domain: Box<dyn Domain>,
    /// In the domain's coordinates.
    density: Polynomial,
    mean: f64,
}

/// The density's sign is looked at in so many places along each axis.
const PLACES: u32 = 24;

impl WeightedDomain {
    /// `domain` with `density`, a polynomial in its coordinates.
    ///
    /// # Errors
    /// When the density is not positive in one of a grid of places.
    pub fn new(domain: Box<dyn Domain>, density: Polynomial) -> Result<Self, DomainError> {
        let bounds = domain.bounds();
        let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(PLACES);
        let (mut sum, mut count) = (0.0, 0.0);
        for k in 0..PLACES.pow(3) {
            let share = [k % PLACES, k / PLACES % PLACES, k / PLACES / PLACES].map(middle);
            let place = bounds.min + bounds.extent().component_mul(&Vector3::from(share));
            if !domain.contains(&place) {
                continue;
            }
            let value = density.at(&place);
            if !(value.is_finite() && value > 0.0) {
                let position = place.into();
                return Err(DomainError::Density { value, position });
            }
            sum += value;
            count += 1.0;
        }
        let mean = if count > 0.0 { sum / count } else { 1.0 };
        Ok(Self {
            domain,
            density,
            mean,
        })
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

    fn radius_squared(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
    ) -> f64 {
        self.domain.radius_squared(site, cell, scratch)
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

    fn weighted_pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let density = self.density.seen_from(site);
        let mut weigh = |sign: f64, piece: Piece<'_>| visit(sign, piece, Some(&density));
        self.domain.pieces(site, cell, scratch, &mut weigh);
    }

    fn has_density(&self) -> bool {
        true
    }

    /// From the same grid of places as the check of the sign: good to a percent or so.
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
