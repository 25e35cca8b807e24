//! Errors of invalid domains of the plane.

use nalgebra::Vector2;
use thiserror::Error;

/// Why a rectangle, corners or half-planes are not a domain, or a density is none.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlaneDomainError {
    /// A coordinate, normal or offset is NaN or infinite.
    #[error("{what} {index} of the domain is not finite")]
    NotFinite {
        /// What was given: a corner or a half-plane.
        what: &'static str,
        /// Which one, from zero.
        index: usize,
    },
    /// Fewer than three corners or half-planes.
    #[error("a domain in the plane needs at least 3 {what}, {count} were given")]
    TooFew {
        /// What was given: corners or half-planes.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// The domain lies so far from the origin that its coordinates have too few digits left.
    #[error(
        "the domain reaches from {min} to {max} along {}: so far from the origin too few digits are left for \
         sites; shift it towards the origin",
        ["x", "y"][*axis]
    )]
    FarAway {
        /// 0, 1 for x, y.
        axis: usize,
        /// Where it begins.
        min: f64,
        /// Where it ends.
        max: f64,
    },
    /// The domain has no area.
    #[error("the domain has no area (its extent is {width} by {height})")]
    NoArea {
        /// Extent along x (L).
        width: f64,
        /// Extent along y (L).
        height: f64,
    },
    /// Two sides of a polygon cross or cover each other.
    #[error(
        "sides {first} and {second} of the polygon cross or overlap near ({x}, {y}); side k begins at corner k, \
         counted from zero through all loops"
    )]
    Crossing {
        /// The lesser side.
        first: usize,
        /// The greater side.
        second: usize,
        /// Where, along x (L).
        x: f64,
        /// Where, along y (L).
        y: f64,
    },
    /// The density is negative or no number somewhere.
    #[error("the density is {value} at ({x}, {y}): it must be positive in the domain")]
    Density {
        /// Its value.
        value: f64,
        /// Where, along x (L).
        x: f64,
        /// Where, along y (L).
        y: f64,
    },
    /// The density depends on z.
    #[error("the density depends on z; in the plane it is a polynomial in x and y")]
    DensityOfZ,
    /// The density changes along a periodic axis.
    #[error("the density changes along {}, along which the domain repeats itself", ["x", "y"][*axis])]
    DensityAlongPeriod {
        /// 0, 1 for x, y.
        axis: usize,
    },
    /// A half-plane whose normal is zero.
    #[error("half-plane {index} of the domain has the normal (0, 0)")]
    ZeroNormal {
        /// Which one, from zero.
        index: usize,
    },
    /// The half-planes leave a direction open.
    #[error("the half-planes do not bound the domain: add one that closes the side left open")]
    Unbounded,
}

impl PlaneDomainError {
    /// A domain of this extent without area.
    pub(crate) fn no_area(extent: &Vector2<f64>) -> Self {
        Self::NoArea {
            width: extent.x,
            height: extent.y,
        }
    }
}
