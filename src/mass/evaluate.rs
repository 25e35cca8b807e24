//! The density at points of a solid, for pictures and files.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::mass::density::SolidDensity;
use crate::mass::tet_values::TetValues;
use crate::mass::weigh::{WeighError, field};
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;

/// A density as a function of position; NaN where it has no value.
pub(crate) type DensityFunction<'a> = Box<dyn Fn(&Point3<f64>) -> f64 + Send + Sync + 'a>;

/// `density` over `solid`; `extent` is the whole body's box, over which ramps run.
///
/// # Errors
/// When the density needs vertex data that are not there.
pub(crate) fn density_function<'a>(
    solid: &'a Solid,
    density: &'a SolidDensity,
    extent: &Bounds<3>,
) -> Result<DensityFunction<'a>, WeighError> {
    Ok(match density {
        SolidDensity::Constant(value) => Box::new(|_| *value),
        SolidDensity::Ramp(ramp) => {
            let origin = extent.center();
            let linear = ramp.over(extent, &origin);
            Box::new(move |point| linear.value + linear.gradient.dot(&(point - origin)))
        }
        SolidDensity::Profile(profile) => Box::new(|point| profile.at_point(point)),
        SolidDensity::Polynomial(polynomial) => Box::new(|point| polynomial.at(point)),
        SolidDensity::Vertex(name) => {
            let Solid::Tets(sound, _) = solid else {
                return Err(WeighError::VertexOfSurface);
            };
            let values = field(sound.mesh(), name.as_deref())?;
            vertex_function(sound.mesh(), values)
        }
    })
}

/// Values at a mesh's vertices, linear in between.
pub(crate) fn vertex_function<'a>(mesh: &'a TetMesh, values: &'a [f64]) -> DensityFunction<'a> {
    let values = TetValues::new(mesh, values);
    Box::new(move |point| values.at(point))
}
