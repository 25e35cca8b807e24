//! Points of interfaces.

use wide::f64x2;

/// A point of an interface, told by two numbers.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Mark {
    /// Its Chebyshev distance from the center: that along either axis of the interface.
    pub(crate) distance: f64,
    /// Its coordinate along the third axis.
    pub(crate) third: f64,
}

impl Mark {
    /// The mark of its two numbers.
    #[inline]
    pub(crate) fn of(lanes: f64x2) -> Self {
        let [distance, third] = lanes.to_array();
        Self { distance, third }
    }
}
