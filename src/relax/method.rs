//! Methods of relaxation with their options, chosen by calls.

use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm};

/// Moves of plain Lloyd unless told otherwise, as in the paper.
const LLOYD_MOVES: u64 = 50;

/// How sites move.
///
/// # Examples
/// ```
/// use chebloyd::Method;
///
/// let lloyd = Method::lloyd(150).accelerated();
/// let descent = Method::quasi_newton(100);
/// let cubes = Method::cubes(1000);
/// assert_ne!(lloyd, descent);
/// # let _ = cubes;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method(pub(crate) Plan);

impl Default for Method {
    /// Fifty of Lloyd's moves.
    fn default() -> Self {
        Self::lloyd(LLOYD_MOVES)
    }
}

impl Method {
    /// Lloyd's iteration: every site moves to its own cell's center (\[BL\] section 3.5).
    #[must_use]
    pub fn lloyd(iterations: u64) -> Self {
        let spec = EnergySpec {
            norm: Norm::Linf,
            order: 1,
            minimizer: Minimizer::Newton,
        };
        Self(Plan::lloyd(spec, iterations))
    }

    /// At most so many steps of a descent of the global objective by L-BFGS-B.
    #[must_use]
    pub fn quasi_newton(iterations: u64) -> Self {
        Self(Plan::quasi_newton(1, iterations))
    }

    /// Rounds of falling noise, each followed by a descent; the best sites are kept.
    #[must_use]
    pub fn anneal() -> Self {
        let noise = Perturbation::default_of(PerturbationKind::Anneal);
        Self(Plan::perturbed(1, noise))
    }

    /// From coarse to fine, with exchanges of sites from crowded cells to holes: makes cubes of the
    /// cells of `count` sites where that many cubes fill the domain.
    #[must_use]
    pub fn cubes(count: usize) -> Self {
        Self(Plan::cubes(1, count))
    }

    /// Lengthens Lloyd's moves where that ends lower.
    #[must_use]
    pub fn accelerated(mut self) -> Self {
        self.0.is_accelerated = true;
        self
    }

    /// At most so many moves in all.
    #[must_use]
    pub fn iterations(mut self, moves: u64) -> Self {
        self.0.iterations = moves;
        self
    }

    /// Ends a descent after a move whose `movement_percent` is below this.
    #[must_use]
    pub fn tolerance(mut self, movement_percent: f64) -> Self {
        self.0.tolerance = movement_percent;
        self
    }

    /// The order p ≥ 1 of the energy ∫ d∞^p.
    #[must_use]
    pub fn order(mut self, order: u32) -> Self {
        self.0.spec.order = order;
        if let Some(descent) = &mut self.0.descent {
            descent.order = order;
        }
        self
    }

    /// The distance that Lloyd's moves minimize; descents are always of the Chebyshev norm.
    #[must_use]
    pub fn norm(mut self, norm: Norm) -> Self {
        self.0.spec.norm = norm;
        self
    }

    /// The seed of the noise, in methods that have noise.
    #[must_use]
    pub fn seed(mut self, seed: u64) -> Self {
        if let Some(perturbation) = &mut self.0.perturbation {
            perturbation.seed = seed;
        }
        self
    }
}
