//! Principal moments and axes of inertia, the body frame (\[M\] section 2.2).

use crate::arrays::MapEach;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Products of inertia below this share of the trace are rounding: they are taken for zero, so
/// that a body symmetric about coordinate planes has exactly those axes.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Principal moments of inertia and the axes they belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// The moments (mass · L²), ascending.
    pub moments: Vector3<f64>,
    /// Unit axes in the order of the moments, right-handed: the first two point where their
    /// largest component is positive. Equal moments leave their axes a choice, made the same way
    /// every time.
    pub axes: [Vector3<f64>; 3],
}

impl Principal {
    /// Of a symmetric inertia tensor.
    #[must_use]
    pub fn of(inertia: &Matrix3<f64>) -> Self {
        let noise = ROUNDING * inertia.trace().abs();
        let mut clean = *inertia;
        for (row, column) in [(0, 1), (0, 2), (1, 2)] {
            if inertia[(row, column)].abs() <= noise {
                clean[(row, column)] = 0.0;
                clean[(column, row)] = 0.0;
            }
        }
        let eigen = SymmetricEigen::new(clean);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let axis =
            |place: usize| with_positive_largest(eigen.eigenvectors.column(order[place]).into());
        let (first, second) = (axis(0), axis(1));
        Self {
            moments: order.map_each(|place| eigen.eigenvalues[place]).into(),
            axes: [first, second, first.cross(&second)],
        }
    }
}

/// The one of ±`axis` whose largest component is positive.
fn with_positive_largest(axis: Vector3<f64>) -> Vector3<f64> {
    if axis[axis.iamax()] < 0.0 {
        -axis
    } else {
        axis
    }
}
