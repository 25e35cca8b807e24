//! The scene's `frames`: the axes along which a cell's Chebyshev distance is measured.

use std::path::{Path, PathBuf};

use nalgebra::{Point3, Rotation3, Unit, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::domain::Domain;
use crate::relax::frames::Frames;
use crate::relax::frames::boundary_frames;
use crate::scene::error::Error;
use crate::scene::site_file;

/// The frames of cells: one for all, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the frames are \"boundary\", {\"file\": …} or {\"axis\": […], \"degrees\": …}"
)]
pub enum FrameChoice {
    /// A rule by its name.
    Rule(Rule),
    /// One frame for all cells.
    Turn(Turn),
    /// A frame for every site.
    File(FrameFile),
}

/// How cells get frames of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Rule {
    /// Aligned with the nearest walls and smooth in between, as the sites stand at the start.
    Boundary,
}

/// One frame for all cells: the axes of space, turned.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// The axis about which they are turned, of any length but zero.
    pub axis: [f64; 3],
    /// The angle, counter-clockwise when viewed against the axis.
    pub degrees: f64,
}

/// A frame for every site, from a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameFile {
    /// A file in one of the formats of sites, relative to the scene's folder: for every site, in
    /// their order, the axis about which the axes of space are turned, as long as the angle in
    /// radians (SciPy's `Rotation.as_rotvec`).
    pub file: PathBuf,
}

impl Turn {
    fn rotation(&self) -> Rotation3<f64> {
        let axis = Unit::new_normalize(Vector3::from(self.axis));
        Rotation3::from_axis_angle(&axis, self.degrees.to_radians())
    }
}

impl FrameChoice {
    /// The one frame of all cells.
    pub(crate) fn of_all(&self) -> Option<Rotation3<f64>> {
        match self {
            Self::Turn(turn) => Some(turn.rotation()),
            Self::Rule(_) | Self::File(_) => None,
        }
    }

    pub(crate) fn anchor(&mut self, folder: &Path) {
        if let Self::File(FrameFile { file }) = self {
            *file = folder.join(&file);
        }
    }

    /// The file that holds the frames.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::File(FrameFile { file }) => Some(file),
            Self::Rule(_) | Self::Turn(_) => None,
        }
    }

    /// Whether there is a frame for every site.
    #[must_use]
    pub fn is_per_site(&self) -> bool {
        !matches!(self, Self::Turn(_))
    }

    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        if dimension != 3 {
            let message = "frames are for sites in space only";
            return Err(Error::value("frames", message));
        }
        let Self::Turn(turn) = self else {
            return Ok(());
        };
        let length = Vector3::from(turn.axis).norm();
        if length > 0.0 && length.is_finite() && turn.degrees.is_finite() {
            return Ok(());
        }
        let message = "an axis of length zero points nowhere, and all numbers must be finite";
        Err(Error::value("frames.axis", message))
    }

    /// The frames of `sites` in `domain`.
    ///
    /// # Errors
    /// When a file cannot be read or does not have as many rotations as there are sites, or the
    /// sites have no diagram.
    pub fn frames(&self, domain: &dyn Domain, sites: &[Point3<f64>]) -> Result<Frames, Error> {
        match self {
            Self::Rule(Rule::Boundary) => boundary_frames(domain, sites)
                .map(Frames::PerSite)
                .map_err(|error| Error::value("frames", error.to_string())),
            Self::Turn(turn) => Ok(Frames::One(turn.rotation())),
            Self::File(FrameFile { file }) => read(file, sites.len()).map(Frames::PerSite),
        }
    }
}

fn read(path: &Path, count: usize) -> Result<Vec<Rotation3<f64>>, Error> {
    let rows = site_file::read::<3>(path)?;
    if rows.len() != count {
        return Err(Error::File {
            path: path.to_owned(),
            message: format!("holds {} rotations for {count} sites", rows.len()),
        });
    }
    let rotation = |row: &Point3<f64>| Rotation3::from_scaled_axis(row.coords);
    Ok(rows.iter().map(rotation).collect())
}
