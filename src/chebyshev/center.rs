//! The center of a cell: the minimizer of its Chebyshev energy within bounds.
//!
//! E is convex in the center (for pieces that sum to a set), so Newton's method with the exact
//! Hessian finds it in two to five evaluations. L-BFGS-B is the choice of \[BL\] section 3.5.

use nalgebra::{Point3, Vector3};

use crate::chebyshev::energy::{SignedPiece, energy};
use crate::chebyshev::walk::WalkScratch;
use crate::geometry::bounds::Bounds;
use crate::minimize::newton::{NewtonOptions, newton};
use crate::minimize::problem::Minimum;

/// What is minimized: the energy of order p of signed pieces.
#[derive(Clone, Copy, Debug)]
pub struct Objective<'a> {
    /// The pieces.
    pub pieces: &'a [SignedPiece],
    /// p ≥ 1.
    pub order: u32,
    /// Their volume (L³), by which gradients and steps are measured.
    pub volume: f64,
}

impl Objective<'_> {
    /// The center within `bounds` by projected Newton, from `start`; the gradient at an inner
    /// center is at most 1e-12 of that of a step of the cell's size.
    #[must_use]
    pub fn center(
        &self,
        start: &Point3<f64>,
        bounds: &Bounds<3>,
        scratch: &mut WalkScratch,
    ) -> Minimum<3> {
        newton(
            |center| energy(self.pieces, center, self.order, scratch),
            &start.coords,
            &bounds.min.coords,
            &bounds.max.coords,
            &self.options(),
        )
    }

    /// The energy of a cube of the same volume, (3/8) V^{4/3} for p = 1, sets the scale.
    fn options(&self) -> NewtonOptions {
        let length = self.volume.cbrt();
        let scale = self.volume * length.powi(self.order as i32 - 1);
        NewtonOptions::new(scale, length)
    }

    /// The gradient's scale: that of the energy by the cell's size (L^(2+p)).
    #[must_use]
    pub fn gradient_scale(&self) -> f64 {
        self.options().scale
    }

    /// Energy, gradient and Hessian about `center`.
    #[must_use]
    pub fn at(
        &self,
        center: &Vector3<f64>,
        scratch: &mut WalkScratch,
    ) -> crate::minimize::problem::Evaluation<3> {
        energy(self.pieces, center, self.order, scratch)
    }
}
