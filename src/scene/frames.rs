//! The scene's `frames`: along which axes distances are measured.

use nalgebra::{Rotation3, Unit, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::frames::Frames;
use crate::scene::error::Error;
use crate::scene::validate::all_finite;

/// One frame for all cells: the axes of space, turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// The axis about which they are turned, of any length but zero.
    pub axis: [f64; 3],
    /// By how much, counter-clockwise as seen against the axis.
    pub degrees: f64,
}

impl Turn {
    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        if dimension != 3 {
            let message = "frames are for sites in space only".to_owned();
            return Err(Error::value("frames", message));
        }
        all_finite("frames.axis", &self.axis)?;
        all_finite("frames.degrees", &[self.degrees])?;
        if Vector3::from(self.axis).norm() > 0.0 {
            return Ok(());
        }
        let message = "an axis of length zero points nowhere".to_owned();
        Err(Error::value("frames.axis", message))
    }
}

/// The frames of a scene that says so.
#[must_use]
pub fn frames(turn: Option<&Turn>) -> Frames {
    turn.map_or(Frames::Axes, |turn| {
        let axis = Unit::new_normalize(Vector3::from(turn.axis));
        Frames::One(Rotation3::from_axis_angle(&axis, turn.degrees.to_radians()))
    })
}
