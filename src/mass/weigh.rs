//! From a solid and a density to its mass properties.

use crate::geometry::bounds::Bounds;
use crate::integrals::moments::Moments;
use crate::integrals::{polynomial_density, surface, tetrahedra};
use crate::mass::body::Body;
use crate::mass::density::Density;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};
use crate::mesh::validate::Solid;

/// Why a solid cannot be weighed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WeighError {
    /// A density that sums to nothing, to less, or to no number.
    #[error("the mass is {mass}: it must be positive for a center of mass; give another density")]
    Massless {
        /// The mass.
        mass: f64,
    },
    /// Vertex data wanted of a surface.
    #[error("`vertex` density needs a tetrahedral mesh with vertex data; this is a surface")]
    VertexOfSurface,
    /// Vertex data wanted by a name that is not there.
    #[error("the mesh has no vertex data `{name}`; it has {there}")]
    NoSuchField {
        /// The name.
        name: String,
        /// The names there are.
        there: String,
    },
    /// No vertex data, or several and no name.
    #[error("`vertex` density needs one field of vertex data to choose; the mesh has {there}")]
    WhichField {
        /// The names there are.
        there: String,
    },
}

/// The mass properties of `solid` made of `density`; `extent` is the whole body's bounding box,
/// over which ramps run.
///
/// # Errors
///
/// If the mass is not positive, or if the density asks for vertex data that are not there.
pub fn weigh(solid: &Solid, density: &Density, extent: &Bounds<3>) -> Result<Body, WeighError> {
    match solid {
        Solid::Surface(closed, _) => weigh_surface(closed.mesh(), density, extent),
        Solid::Tets(sound, _) => weigh_tets(sound.mesh(), density, extent),
    }
}

/// The least box that holds a solid.
#[must_use]
pub fn bounds(solid: &Solid) -> Bounds<3> {
    match solid {
        Solid::Surface(closed, _) => closed.mesh().bounds(),
        Solid::Tets(sound, _) => sound.mesh().bounds(),
    }
}

/// [`weigh`] for a surface that is closed and oriented outward.
///
/// # Errors
///
/// As [`weigh`].
pub fn weigh_surface(
    mesh: &SurfaceMesh,
    density: &Density,
    extent: &Bounds<3>,
) -> Result<Body, WeighError> {
    let near = Bounds::of(&mesh.vertices).center();
    let (vertices, triangles) = (&mesh.vertices[..], &mesh.triangles[..]);
    let moments = match density {
        Density::Constant(value) => surface::constant(vertices, triangles, &near) * *value,
        Density::Ramp(ramp) => {
            surface::linear(vertices, triangles, &ramp.over(extent, &near), &near)
        }
        Density::Profile(profile) => profile.surface_moments(vertices, triangles, &near),
        Density::Polynomial(polynomial) => {
            polynomial_density::solid(vertices, triangles, polynomial, &near)
        }
        Density::Vertex(_) => return Err(WeighError::VertexOfSurface),
    };
    let volume = surface::volume(vertices, triangles, &near);
    let area = surface::area(vertices, triangles);
    check(&moments)?;
    Ok(Body::from_moments(volume, area, &moments, &near))
}

/// [`weigh`] for tetrahedra of positive volume.
///
/// # Errors
///
/// As [`weigh`].
pub fn weigh_tets(
    mesh: &TetMesh,
    density: &Density,
    extent: &Bounds<3>,
) -> Result<Body, WeighError> {
    let near = Bounds::of(&mesh.vertices).center();
    let (vertices, tets) = (&mesh.vertices[..], &mesh.tets[..]);
    let moments = match density {
        Density::Constant(value) => tetrahedra::constant(vertices, tets, &near) * *value,
        Density::Ramp(ramp) => {
            let linear = ramp.over(extent, &near);
            let at = |vertex| linear.value + linear.gradient.dot(&(vertex - near));
            let densities: Vec<f64> = vertices.iter().map(at).collect();
            tetrahedra::moments(vertices, tets, &densities, &near)
        }
        Density::Profile(profile) => profile.tet_moments(vertices, tets, &near),
        Density::Polynomial(polynomial) => {
            polynomial_density::tetrahedra(vertices, tets, polynomial, &near)
        }
        Density::Vertex(name) => {
            let densities = field(mesh, name.as_deref())?;
            tetrahedra::moments(vertices, tets, densities, &near)
        }
    };
    let volume = tetrahedra::constant(vertices, tets, &near).mass;
    let area = {
        let boundary = mesh.boundary();
        surface::area(&boundary.vertices, &boundary.triangles)
    };
    check(&moments)?;
    Ok(Body::from_moments(volume, area, &moments, &near))
}

/// The vertex data of this name, or the only ones.
fn field<'a>(mesh: &'a TetMesh, name: Option<&str>) -> Result<&'a [f64], WeighError> {
    let names: Vec<_> = mesh
        .vertex_data
        .iter()
        .map(|field| format!("`{}`", field.name))
        .collect();
    let there = if names.is_empty() {
        "none".into()
    } else {
        names.join(", ")
    };
    match (name, &mesh.vertex_data[..]) {
        (Some(name), _) => mesh.data(name).ok_or(WeighError::NoSuchField {
            name: name.into(),
            there,
        }),
        (None, [VertexData { values, .. }]) => Ok(values),
        (None, _) => Err(WeighError::WhichField { there }),
    }
}

fn check(moments: &Moments) -> Result<(), WeighError> {
    let mass = moments.mass;
    let sound = mass > 0.0 && moments.ten().iter().all(|value| value.is_finite());
    if sound {
        Ok(())
    } else {
        Err(WeighError::Massless { mass })
    }
}
