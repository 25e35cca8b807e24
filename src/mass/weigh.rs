//! The mass properties of a solid of given density.

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::{area, at_vertices, constant, linear, polynomial, volume};
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;
use nalgebra::Point3;

/// Why a solid cannot be weighed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WeighError {
    /// The mass is not a positive number.
    #[error("the mass is {mass}: it must be positive for a center of mass; give another density")]
    Massless {
        /// The mass.
        mass: f64,
    },
    /// Vertex data needed for a surface.
    #[error("`vertex` density needs a tetrahedral mesh with vertex data; this is a surface")]
    VertexOfSurface,
    /// There are no vertex data of that name.
    #[error("the mesh has no vertex data `{name}`; it has {there}")]
    NoSuchField {
        /// The name.
        name: String,
        /// The names there are.
        there: String,
    },
    /// Vertex data that do not give every vertex one finite value.
    #[error("{0}, or choose another density")]
    FaultyField(String),
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
/// If the mass is not positive, or if the density needs vertex data that are not there.
pub fn weigh(
    solid: &Solid,
    density: &SolidDensity,
    extent: &Bounds<3>,
) -> Result<Body, WeighError> {
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
    density: &SolidDensity,
    extent: &Bounds<3>,
) -> Result<Body, WeighError> {
    let (vertices, triangles) = (&mesh.vertices[..], &mesh.triangles[..]);
    let area = area(vertices, triangles);
    weigh_simplices(vertices, triangles, area, density, extent, |_, _| {
        Err(WeighError::VertexOfSurface)
    })
}

/// [`weigh`] for tetrahedra of positive volume.
///
/// # Errors
///
/// As [`weigh`].
pub fn weigh_tets(
    mesh: &TetMesh,
    density: &SolidDensity,
    extent: &Bounds<3>,
) -> Result<Body, WeighError> {
    let (vertices, tets) = (&mesh.vertices[..], &mesh.tets[..]);
    let boundary = mesh.boundary();
    let area = area(&boundary.vertices, &boundary.triangles);
    weigh_simplices(vertices, tets, area, density, extent, |name, near| {
        Ok(at_vertices(vertices, tets, field(mesh, name)?, near))
    })
}

/// [`weigh`] for triangles or tetrahedra; `by_data` gives the moments by vertex data of some name.
fn weigh_simplices<const K: usize>(
    vertices: &[Point3<f64>],
    simplices: &[[u32; K]],
    area: f64,
    density: &SolidDensity,
    extent: &Bounds<3>,
    by_data: impl Fn(Option<&str>, &Point3<f64>) -> Result<Moments, WeighError>,
) -> Result<Body, WeighError> {
    let near = Bounds::of(vertices).center();
    let moments = match density {
        SolidDensity::Constant(value) => constant(vertices, simplices, &near) * *value,
        SolidDensity::Ramp(ramp) => linear(vertices, simplices, &ramp.over(extent, &near), &near),
        SolidDensity::Profile(profile) => profile.moments(vertices, simplices, &near),
        SolidDensity::Polynomial(density) => polynomial(vertices, simplices, density, &near),
        SolidDensity::Vertex(name) => by_data(name.as_deref(), &near)?,
    };
    let volume = volume(vertices, simplices, &near);
    let mass = moments.mass;
    let is_sound = mass > 0.0 && moments.ten().iter().all(|value| value.is_finite());
    let body = is_sound.then(|| Body::from_moments(volume, area, &moments, &near));
    body.ok_or(WeighError::Massless { mass })
}

/// The vertex data of this name, or the only ones.
pub(crate) fn field<'a>(mesh: &'a TetMesh, name: Option<&str>) -> Result<&'a [f64], WeighError> {
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
    let field = match (name, &mesh.vertex_data[..]) {
        (Some(name), _) => mesh.field(name).ok_or(WeighError::NoSuchField {
            name: name.into(),
            there,
        })?,
        (None, [only]) => only,
        (None, _) => return Err(WeighError::WhichField { there }),
    };
    field.checked().map_err(WeighError::FaultyField)
}
