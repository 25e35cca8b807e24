//! The boxes around the sites of two siblings in the index, side by side.

use nalgebra::Point3;
use wide::f64x2;

use crate::geometry::bounds::Bounds;

/// The boxes of two siblings, by component.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pair {
    pub(crate) min: [f64x2; 3],
    pub(crate) max: [f64x2; 3],
}

impl Pair {
    /// The boxes of a node's children.
    pub(crate) fn new([one, other]: [Bounds<3>; 2]) -> Self {
        let lanes = |axis: usize, end: fn(&Bounds<3>) -> &Point3<f64>| {
            f64x2::new([end(&one)[axis], end(&other)[axis]])
        };
        Self {
            min: [0, 1, 2].map(|axis| lanes(axis, |bounds| &bounds.min)),
            max: [0, 1, 2].map(|axis| lanes(axis, |bounds| &bounds.max)),
        }
    }

    /// The box around both.
    pub(crate) fn both(&self) -> Bounds<3> {
        let ends = |end: f64x2| end.to_array();
        Bounds {
            min: Point3::from(self.min.map(|end| ends(end)[0].min(ends(end)[1]))),
            max: Point3::from(self.max.map(|end| ends(end)[0].max(ends(end)[1]))),
        }
    }
}
