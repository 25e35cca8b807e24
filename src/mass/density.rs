//! Densities as functions of position.

use crate::geometry::bounds::Bounds;
use crate::integrals::mesh_moments::LinearDensity;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::polynomial_text::PolynomialError;
use crate::mass::profile::{Profile, ProfileError};
use nalgebra::{Point3, Vector3};

/// A density (mass / L³) as a function of position.
///
/// Reads from text by [`str::parse`]: `2.7`, `linear:axis=z,from=0,to=1`,
/// `profile:axis=x,0.2=1,0.8=5`, `ramp:direction=1,0,2,from=0.2,to=0.8,low=1,high=5`,
/// `clamp(1, 5, 2 + 3*x - z)` (the high end may be `inf`), `vertex`, `vertex:name`,
/// `clamp(1, 5, vertex:name)`, `ramp:vertex=name,from=20,to=80,low=1,high=5`, or a polynomial such as
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
    /// Such values, mapped and clamped.
    VertexRamp(VertexRamp),
}

/// Values at the vertices of a tetrahedral mesh, linear in between, and a density that grows with them
/// between two of them and is constant beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexRamp {
    /// The field, or the only one there is.
    pub name: Option<String>,
    /// The value where the density begins to grow.
    pub from: f64,
    /// By how much values exceed `from` where it ends; may be infinite.
    pub width: f64,
    /// The density up to `from`.
    pub low: f64,
    /// The density's growth per value.
    pub slope: f64,
}

impl VertexRamp {
    /// The density where the field has a value.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        self.low + self.slope * (value - self.from).clamp(0.0, self.width)
    }

    /// The values at which the density bends.
    pub(crate) fn bends(&self) -> Vec<f64> {
        let ends = [self.from, self.from + self.width];
        ends.into_iter().filter(|value| value.is_finite()).collect()
    }
}

impl SolidDensity {
    /// clamp(`low`, `high`, `value` + `gradient`·y); `high` may be infinite.
    ///
    /// # Errors
    ///
    /// If the range holds nothing, or the gradient is not finite.
    pub fn clamp(
        low: f64,
        high: f64,
        value: f64,
        gradient: &Vector3<f64>,
    ) -> Result<Self, DensityError> {
        if !(low.is_finite() && low <= high) {
            return Err(DensityError::ClampRange { low, high });
        }
        if gradient.iter().all(|slope| *slope == 0.0) || low >= high {
            return Ok(Self::Constant(value.max(low).min(high)));
        }
        Ok(Self::Profile(Profile::clamp(low, high, value, gradient)?))
    }
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
         `linear:axis=z,from=0,to=1`, `profile:axis=z,0.2=1,0.8=5`, \
         `ramp:direction=0,0,1,from=0,to=1,low=1,high=5`, `clamp(1, 5, POLYNOMIAL)` or \
         `vertex[:NAME]`)"
    )]
    Polynomial {
        /// The text.
        text: String,
        /// Why it is no polynomial.
        error: PolynomialError,
    },
    /// A kind that does not exist.
    #[error(
        "density kind `{kind}` does not exist; known are `linear`, `profile`, `ramp` and `vertex`"
    )]
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
    /// A direction that is not three numbers.
    #[error("`{text}` is no direction: it takes three numbers, as in `direction=0,0,1`")]
    Direction {
        /// The text after `direction=`.
        text: String,
    },
    /// A ramp that begins where it ends.
    #[error("a ramp from {from} to {to} has no length; give two places that differ")]
    Level {
        /// Where it begins.
        from: f64,
        /// Where it ends.
        to: f64,
    },
    /// A clamp that is not written as one.
    #[error(
        "`{text}` is no clamp; it is written `clamp(LOW, HIGH, POLYNOMIAL)` or `clamp(LOW, HIGH, vertex:NAME)`"
    )]
    Clamp {
        /// The text.
        text: String,
    },
    /// The ends of a clamp.
    #[error(
        "a clamp to [{low}, {high}] holds nothing; its low end must be finite and less than its high end"
    )]
    ClampRange {
        /// The low end.
        low: f64,
        /// The high end.
        high: f64,
    },
    /// A clamp of what is not affine.
    #[error("`clamp` takes a polynomial of degree one at most; `{text}` has degree {degree}")]
    ClampDegree {
        /// The polynomial.
        text: String,
        /// Its degree.
        degree: u32,
    },
    /// Breaks that make no profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
}
