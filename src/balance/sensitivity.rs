//! Derivatives of the moments of clamp(form, low, high) by its parameters, from the half-spaces that integrate it.
//!
//! With A where the form exceeds low, B where it exceeds high and D_k = ∫ d · {1, y, y yᵀ}:
//!
//! ```text
//! ∂D_k/∂low = m_k(Ω) − m_k(A)      ∂D_k/∂value = m_k(A) − m_k(B)
//! ∂D_k/∂high = m_k(B)              ∂D_k/∂gradient = m_{k+1}(A) − m_{k+1}(B)
//! ```

use nalgebra::{Matrix3, Vector3};

use crate::arrays::MapEach;
use crate::balance::dual::DensityRange;
use crate::balance::solid::{AffineForm, SolidBalance};
use crate::geometry::moments::Moments;
use crate::integrals::half_space::ThreeMoments;

/// The derivatives of mass, first and second moments about the body's middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClampDerivatives {
    /// By the low end.
    pub(crate) low: Moments,
    /// By the high end.
    pub(crate) high: Moments,
    /// By the form's value at the middle.
    pub(crate) value: Moments,
    /// By the components of its gradient.
    pub(crate) gradient: [Moments; 3],
}

impl ClampDerivatives {
    /// Of a form over a body.
    pub(crate) fn of(body: &SolidBalance<'_>, form: &AffineForm, range: &DensityRange) -> Self {
        let above = body.above_to_third(&form.less(range.low));
        let over = if range.high < f64::INFINITY {
            body.above_to_third(&form.less(range.high))
        } else {
            ThreeMoments::default()
        };
        let less = |one: Moments, other: Moments| one + other * -1.0;
        Self {
            low: less(body.whole, above.low),
            high: over.low,
            value: less(above.low, over.low),
            gradient: [0, 1, 2].map_each(|axis| less(raised(&above, axis), raised(&over, axis))),
        }
    }

    /// How the center of mass of a body of these moments moves: ∂C = (∂D₁ − C ∂D₀)/D₀, for the low end, the
    /// high end, the value, and the gradient's components (columns).
    pub(crate) fn center(&self, moments: &Moments) -> [Vector3<f64>; 3] {
        [&self.low, &self.high, &self.value].map_each(|change| shift(moments, change))
    }

    /// The same for the gradient's components, one column each.
    pub(crate) fn center_by_gradient(&self, moments: &Moments) -> Matrix3<f64> {
        Matrix3::from_columns(
            &self
                .gradient
                .each_ref()
                .map_each(|change| shift(moments, change)),
        )
    }
}

fn shift(moments: &Moments, change: &Moments) -> Vector3<f64> {
    (change.first - moments.center() * change.mass) / moments.mass
}

/// The first moments of a body as a body of its own: its density times the coordinate of an axis.
fn raised(body: &ThreeMoments, axis: usize) -> Moments {
    let unit = Vector3::ith(axis, 1.0);
    Moments {
        mass: body.low.first[axis],
        first: body.low.second * unit,
        second: body.third.along(&unit),
    }
}
