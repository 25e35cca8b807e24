//! Errors of invalid domain descriptions.

use thiserror::Error;

use crate::geometry::bounds::Bounds;
use crate::mesh::report::Refusal;

/// Coordinates farther from the origin than so many extents of the domain leave sites twelve of 52 bits.
pub(crate) const FARTHEST: f64 = (1_u64 << 40) as f64;

/// Why a description is no domain.
///
/// # Examples
/// ```
/// use chebloyd::{Bounds, Cuboid, DomainError};
///
/// let flat = Cuboid::new(Bounds::from_corners([0.0; 3], [1.0, 0.0, 1.0]), [false; 3]);
/// assert!(matches!(flat, Err(DomainError::EmptyExtent { axis: 1, .. })));
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DomainError {
    /// A coordinate is NaN or infinite.
    #[error("the domain has the coordinate {value}; all must be finite")]
    NotFinite {
        /// The coordinate.
        value: f64,
    },
    /// A box ends where it begins, or before.
    #[error(
        "the box has no extent along {}: min {min}, max {max}; max must be greater than min",
        ["x", "y", "z"][*axis]
    )]
    EmptyExtent {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Where it begins.
        min: f64,
        /// Where it ends.
        max: f64,
    },
    /// The domain's volume is zero, or too small or large for a number.
    #[error("the domain's volume is {volume}; it must be a positive number")]
    NoVolume {
        /// The volume (L³).
        volume: f64,
    },
    /// A half-space has no normal.
    #[error("half-space {number} has a normal of length zero; give [nx, ny, nz, d] with n ≠ 0")]
    NoNormal {
        /// Its place in the list, from zero.
        number: usize,
    },
    /// The domain lies so far from the origin that its coordinates have too few digits left.
    #[error(
        "the domain reaches from {min} to {max} along {}: so far from the origin neighboring numbers lie {step:e} \
         apart, too few for sites; shift it towards the origin",
        ["x", "y", "z"][*axis], step = max.abs().max(min.abs()) * f64::EPSILON
    )]
    FarAway {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// Where it begins.
        min: f64,
        /// Where it ends.
        max: f64,
    },
    /// Half-spaces that leave the set unbounded.
    #[error("the {count} half-spaces do not bound a solid: it is infinite towards {direction:?}")]
    Unbounded {
        /// How many half-spaces there are.
        count: usize,
        /// An axis direction in which the set has no end within reach.
        direction: [f64; 3],
    },
    /// Half-spaces without a common point of the interior.
    #[error(
        "the half-spaces have no interior in common: nothing is left after half-space {number}; \
         n·y ≤ d keeps the side away from the normal"
    )]
    NoInterior {
        /// The half-space that removed the rest, from zero.
        number: usize,
    },
    /// A mesh that bounds or fills no solid.
    #[error("the mesh {0}")]
    Mesh(#[from] Refusal),
    /// A surface that encloses something more than once, or negatively.
    #[error("the surface {reason}")]
    Overlap {
        /// What is wrong with it.
        reason: String,
    },
    /// Tetrahedra whose boundary bounds no solid.
    #[error("the boundary of the tetrahedra {reason}")]
    Boundary {
        /// What is wrong with it.
        reason: String,
    },
    /// A density that is not positive.
    #[error("the density is {value} at {position:?}; it must be a positive number everywhere")]
    Density {
        /// Its value.
        value: f64,
        /// Where.
        position: [f64; 3],
    },
    /// A density that does not repeat itself where the domain does.
    #[error(
        "the domain is periodic along {axis}, but its density changes with {axis}; leave {axis} out \
         of the density, or \"periodic\" out of the box",
        axis = ["x", "y", "z"][*axis]
    )]
    DensityAlongPeriod {
        /// 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A wanted size of cells that is not positive.
    #[error("the size is {value} at {position:?}; it must be a positive number everywhere")]
    Size {
        /// Its value.
        value: f64,
        /// Where.
        position: [f64; 3],
    },
    /// A wanted size of cells that comes too near to zero, or changes too fast.
    #[error(
        "the size is about {value:e} near {position:?} and changes by {change:e} beside it; let \
         it change less, or keep it farther from zero"
    )]
    SizeTooSteep {
        /// About its value.
        value: f64,
        /// By how much it changes in the smallest box.
        change: f64,
        /// Where.
        position: [f64; 3],
    },
    /// A wanted size of cells of too high a degree.
    #[error("the size has degree {degree}; {highest} is the highest")]
    SizeDegree {
        /// Its degree.
        degree: u32,
        /// The highest that is known.
        highest: u32,
    },
}

/// Refuses a domain farther from the origin than [`FARTHEST`] of its extents, along any axis.
pub(crate) fn check_digits(bounds: &Bounds<3>) -> Result<(), DomainError> {
    let is_far = |axis: &usize| {
        let (min, max) = (bounds.min[*axis], bounds.max[*axis]);
        min.abs().max(max.abs()) > FARTHEST * (max - min)
    };
    match (0..3).find(is_far) {
        Some(axis) => Err(DomainError::FarAway {
            axis,
            min: bounds.min[axis],
            max: bounds.max[axis],
        }),
        None => Ok(()),
    }
}
