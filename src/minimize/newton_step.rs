//! One step of Newton's method in a box, and Chebyshev's where third derivatives are known.
//!
//! One step minimizes the quadratic model over the box *exactly* (`box_quadratic`), instead of
//! taking the free Newton step and projecting it: Bertsekas (*Projected Newton methods*, SIAM J.
//! Control Optim. 20, 1982) shows that projection can point uphill unless nearly active
//! variables are held, while in three variables the exact step costs one small factorization
//! more, and only when a bound is in the way. At a minimum both hold the same variables: those at
//! a bound whose gradient pushes outward.
//!
//! # Third derivatives
//!
//! Where the objective knows them, a step s that no bound limits becomes Chebyshev's,
//! s − ½ H⁻¹ T s s with T the third derivative (Traub, *Iterative Methods for the Solution of
//! Equations*, 1964, section 5.2, in several variables): it converges cubically and saves a
//! Voronoi cell about one evaluation. Where the second term is not small, it is left away.

use nalgebra::{SMatrix, SVector};

use crate::minimize::box_quadratic::{minimize_quadratic, positive_definite};
use crate::minimize::inverse::Inverse;
use crate::minimize::problem::Evaluation;

/// Up to this share of Newton's step the correction by the third derivative is trusted.
const LARGEST_CORRECTION: f64 = 0.5;

/// The step from where the function is `evaluation`, with `third` derivatives where they are known,
/// within `lower` and `upper` (relative to the point). `length` is the size of long steps.
pub(crate) fn newton_step<const D: usize>(
    evaluation: &Evaluation<D>,
    third: Option<&[SMatrix<f64, D, D>; D]>,
    length: f64,
    lower: &SVector<f64, D>,
    upper: &SVector<f64, D>,
) -> Option<SVector<f64, D>> {
    let Evaluation {
        gradient, hessian, ..
    } = evaluation;
    let (shifted, inverse) = positive_definite(hessian, gradient, length)?;
    let step = minimize_quadratic(&shifted, &inverse, gradient, lower, upper);
    let is_inside = |step: &SVector<f64, D>| {
        (0..D).all(|axis| lower[axis] < step[axis] && step[axis] < upper[axis])
    };
    let corrected = third
        .filter(|_| is_inside(&step))
        .and_then(|third| corrected(&step, gradient, third, &inverse))
        .filter(is_inside);
    Some(corrected.unwrap_or(step))
}

/// Chebyshev's step, if it is known and stays near Newton's `step` and as good as downhill.
fn corrected<const D: usize>(
    step: &SVector<f64, D>,
    gradient: &SVector<f64, D>,
    third: &[SMatrix<f64, D, D>; D],
    inverse: &Inverse<D>,
) -> Option<SVector<f64, D>> {
    let mut bend = SVector::zeros();
    for (along, share) in third.iter().zip(step.iter()) {
        bend += along * step * *share;
    }
    let corrected = step - inverse.solve(&bend) * 0.5;
    let is_small = (corrected - step).amax() <= LARGEST_CORRECTION * step.amax();
    let is_downhill = gradient.dot(&corrected) <= LARGEST_CORRECTION * gradient.dot(step);
    (is_small && is_downhill).then_some(corrected)
}
