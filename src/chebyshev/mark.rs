//! Points of interfaces, and how they move.

use wide::f64x2;

/// A point of an interface, told by two numbers.
#[derive(Clone, Copy, Debug, Default)]
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

/// How fast the crossing of an interface with an edge slides along that edge.
///
/// A center that moves by δ, of which δ_l and δ_r are the parts along the interface's two sectors
/// and δ_t that along the third axis, takes the interface with it: the crossing's mark changes by
/// −(δ_l + (δ_l − δ_r) distance, δ_t + (δ_l − δ_r) third).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Drift {
    /// Of the first sector's distance.
    pub(crate) distance: f64,
    /// Of the coordinate along the third axis.
    pub(crate) third: f64,
}
