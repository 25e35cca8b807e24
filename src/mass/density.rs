//! What a body is made of.

use crate::geometry::bounds::Bounds;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::surface::LinearDensity;
use crate::mass::profile::Profile;
use nalgebra::{Point3, Vector3};

/// A density (mass / L³) as a function of place.
///
/// Reads from text by [`str::parse`]: `2.7`, `linear:axis=z,from=0,to=1`,
/// `profile:axis=x,0.2=1,0.8=5`, `vertex`, `vertex:name`, or a polynomial such as
/// `1 + 2*x - 0.5*y*z`.
#[derive(Clone, Debug, PartialEq)]
pub enum Density {
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
