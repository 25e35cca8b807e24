//! The center of a cell: the minimizer of its Chebyshev energy within bounds.
//!
//! E is convex in the center (for pieces that sum to a set), so Newton's method with the exact
//! Hessian finds it in two to five evaluations. L-BFGS-B is the choice of \[BL\] section 3.5.

use nalgebra::Vector3;

use crate::chebyshev::energy::{SignedPiece, energy};
use crate::chebyshev::walk::WalkScratch;
use crate::geometry::bounds::Bounds;
use crate::minimize::newton::{NewtonOptions, newton};

/// What is minimized: the energy of order p of signed pieces, in coordinates about their site.
#[derive(Clone, Copy, Debug)]
pub struct Objective<'a> {
    /// The pieces.
    pub pieces: &'a [SignedPiece],
    /// p ≥ 1.
    pub order: u32,
    /// Their volume (L³), by which gradients and steps are measured.
    pub volume: f64,
}

/// A center and what finding it told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Center {
    /// The center's displacement from the site.
    pub point: Vector3<f64>,
    /// The energy about the center (L^(3+p)).
    pub energy: f64,
    /// The energy about the site, where the search began (L^(3+p)).
    pub energy_at_site: f64,
    /// The gradient about the site (L^(2+p)).
    pub gradient_at_site: Vector3<f64>,
    /// How many evaluations it took.
    pub evaluations: u32,
}

impl Objective<'_> {
    /// The center within `bounds`, which hold the site, searched from the site by projected
    /// Newton; the projected gradient there is at most 1e-12 of that of a step of the cell's size.
    #[must_use]
    pub fn center(&self, bounds: &Bounds<3>, scratch: &mut WalkScratch) -> Center {
        let mut first = None;
        let length = self.volume.cbrt();
        let scale = self.volume * length.powi(self.order as i32 - 1);
        let found = newton(
            |center| {
                let evaluation = energy(self.pieces, center, self.order, scratch);
                first.get_or_insert((evaluation.value, evaluation.gradient));
                evaluation
            },
            &Vector3::zeros(),
            &bounds.min.coords,
            &bounds.max.coords,
            &NewtonOptions::new(scale, length),
        );
        let (energy_at_site, gradient_at_site) = first.unwrap_or((found.value, found.gradient));
        Center {
            point: found.point,
            energy: found.value,
            energy_at_site,
            gradient_at_site,
            evaluations: found.evaluations,
        }
    }
}
