//! Densities as functions of position, and their parsing from the text of `chebloyd mass --density`.

use crate::geometry::bounds::Bounds;
use crate::integrals::mesh_moments::LinearDensity;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::polynomial_text::PolynomialError;
use crate::mass::profile::{Profile, ProfileError};
use nalgebra::{Point3, Vector3};
use std::str::FromStr;

/// A density (mass / L³) as a function of position.
///
/// Reads from text by [`str::parse`]: `2.7`, `linear:axis=z,from=0,to=1`,
/// `profile:axis=x,0.2=1,0.8=5`, `vertex`, `vertex:name`, or a polynomial such as
/// `1 + 2*x - 0.5*y*z`.
#[derive(Clone, Debug, PartialEq)]
pub enum SolidDensity {
    /// The same everywhere.
    Constant(f64),
    /// Linear along an axis over the whole body's extent.
    Ramp(Ramp),
    /// Piecewise linear along a direction.
    Profile(Profile),
    /// A polynomial in the coordinates.
    Polynomial(Polynomial),
    /// Values at the vertices of a tetrahedral mesh, linear in between: the field of this name,
    /// or the only one there is.
    Vertex(Option<String>),
}

/// A density that grows linearly along a coordinate axis, from one face of the body's bounding
/// box to the opposite one (\[BL\] Table 3: 0 at the bottom, 1 at the top).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// The axis: 0, 1 or 2.
    pub axis: usize,
    /// The density where the body begins.
    pub from: f64,
    /// The density where the body ends.
    pub to: f64,
}

impl Ramp {
    /// The ramp over `extent`, as a linear function measured from `origin`.
    #[must_use]
    pub fn over(&self, extent: &Bounds<3>, origin: &Point3<f64>) -> LinearDensity {
        let length = extent.extent()[self.axis];
        let mut gradient = Vector3::zeros();
        gradient[self.axis] = (self.to - self.from) / length;
        let share = (origin[self.axis] - extent.min[self.axis]) / length;
        LinearDensity {
            value: self.from + (self.to - self.from) * share,
            gradient,
        }
    }
}

/// Why a text is not a density.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DensityError {
    /// Not a number, not a known kind, and not a polynomial either.
    #[error(
        "`{text}` is not a density: {error} (a density is a number, a polynomial in x, y, z, \
         `linear:axis=z,from=0,to=1`, `profile:axis=z,0.2=1,0.8=5` or `vertex[:NAME]`)"
    )]
    Polynomial {
        /// The text.
        text: String,
        /// Why it is no polynomial.
        error: PolynomialError,
    },
    /// A kind that does not exist.
    #[error("density kind `{kind}` does not exist; known are `linear`, `profile` and `vertex`")]
    Kind {
        /// The text before the colon.
        kind: String,
    },
    /// A setting that is not `key=value` or has no such key.
    #[error("`{setting}` is no setting of a `{kind}` density; it takes {known}")]
    Setting {
        /// The kind.
        kind: &'static str,
        /// The text between commas.
        setting: String,
        /// What it takes.
        known: &'static str,
    },
    /// A value that is no finite number.
    #[error("`{value}` in `{setting}` is not a finite number")]
    Number {
        /// The text between commas.
        setting: String,
        /// The value.
        value: String,
    },
    /// An axis other than x, y or z.
    #[error("axis `{axis}` does not exist; it is `x`, `y` or `z`")]
    Axis {
        /// The text after `axis=`.
        axis: String,
    },
    /// A missing setting.
    #[error("a `{kind}` density needs `{key}`, as in `{example}`")]
    Missing {
        /// The kind.
        kind: &'static str,
        /// The key.
        key: &'static str,
        /// A complete one.
        example: &'static str,
    },
    /// Breaks that make no profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
}

const LINEAR: &str = "linear:axis=z,from=0,to=1";
const PROFILE: &str = "profile:axis=z,0.2=1,0.8=5";

impl FromStr for SolidDensity {
    type Err = DensityError;

    fn from_str(text: &str) -> Result<Self, DensityError> {
        let text = text.trim();
        match text.split_once(':') {
            Some(("linear", settings)) => ramp(settings).map(Self::Ramp),
            Some(("profile", settings)) => profile(settings).map(Self::Profile),
            Some(("vertex", name)) => Ok(Self::Vertex(Some(name.trim().into()))),
            Some((kind, _)) => Err(DensityError::Kind { kind: kind.into() }),
            None if text == "vertex" => Ok(Self::Vertex(None)),
            None => number_or_polynomial(text),
        }
    }
}

fn number_or_polynomial(text: &str) -> Result<SolidDensity, DensityError> {
    let polynomial: Polynomial = text.parse().map_err(|error| DensityError::Polynomial {
        text: text.into(),
        error,
    })?;
    if polynomial.degree() == 0 {
        return Ok(SolidDensity::Constant(polynomial.at(&Point3::origin())));
    }
    Ok(SolidDensity::Polynomial(polynomial))
}

fn ramp(settings: &str) -> Result<Ramp, DensityError> {
    let (mut axis, mut from, mut to) = (None, None, None);
    for setting in settings.split(',') {
        match key_and_value(setting) {
            Some(("axis", value)) => axis = Some(axis_named(value)?),
            Some(("from", value)) => from = Some(number(setting, value)?),
            Some(("to", value)) => to = Some(number(setting, value)?),
            _ => return Err(unknown("linear", setting, "`axis`, `from` and `to`")),
        }
    }
    let missing = |key| DensityError::Missing {
        kind: "linear",
        key,
        example: LINEAR,
    };
    Ok(Ramp {
        axis: axis.ok_or(missing("axis"))?,
        from: from.ok_or(missing("from"))?,
        to: to.ok_or(missing("to"))?,
    })
}

fn profile(settings: &str) -> Result<Profile, DensityError> {
    let mut axis = None;
    let mut breaks = Vec::new();
    for setting in settings.split(',') {
        match key_and_value(setting) {
            Some(("axis", value)) => axis = Some(axis_named(value)?),
            Some((position, density)) => {
                breaks.push([number(setting, position)?, number(setting, density)?]);
            }
            None => return Err(unknown("profile", setting, "`axis` and `position=density`")),
        }
    }
    let axis = axis.ok_or(DensityError::Missing {
        kind: "profile",
        key: "axis",
        example: PROFILE,
    })?;
    let direction = Vector3::from_fn(|row, _| if row == axis { 1.0 } else { 0.0 });
    Ok(Profile::new(&direction, breaks)?)
}

fn key_and_value(setting: &str) -> Option<(&str, &str)> {
    let (key, value) = setting.split_once('=')?;
    Some((key.trim(), value.trim()))
}

fn unknown(kind: &'static str, setting: &str, known: &'static str) -> DensityError {
    DensityError::Setting {
        kind,
        setting: setting.trim().into(),
        known,
    }
}

fn axis_named(name: &str) -> Result<usize, DensityError> {
    let axis = ["x", "y", "z"]
        .iter()
        .position(|axis| axis.eq_ignore_ascii_case(name));
    axis.ok_or(DensityError::Axis { axis: name.into() })
}

fn number(setting: &str, value: &str) -> Result<f64, DensityError> {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(DensityError::Number {
            setting: setting.trim().into(),
            value: value.into(),
        }),
    }
}
