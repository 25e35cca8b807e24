//! The mass properties of a solid of given density.

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::{area, at_vertices, constant, linear, polynomial, volume};
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
pub use crate::mass::linear_pieces::WeighError;
use crate::mass::linear_pieces::linear_pieces;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;
use nalgebra::Point3;

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
    let surface = (&mesh.vertices[..], &mesh.triangles[..]);
    weigh_simplices(surface, surface, density, extent, |_| {
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
    let solid = (&mesh.vertices[..], &mesh.tets[..]);
    let boundary = mesh.boundary();
    let surface = (&boundary.vertices[..], &boundary.triangles[..]);
    weigh_simplices(solid, surface, density, extent, |near| {
        let pieces = linear_pieces(mesh, density, extent)?;
        let (vertices, tets) = (&pieces.mesh.vertices, &pieces.mesh.tets);
        Ok(at_vertices(vertices, tets, &pieces.densities, near))
    })
}

/// Vertices and the simplices over them.
type Simplices<'a, const K: usize> = (&'a [Point3<f64>], &'a [[u32; K]]);

/// [`weigh`] for triangles or tetrahedra and their boundary; `by_data` gives the moments by vertex data.
fn weigh_simplices<const K: usize>(
    (vertices, simplices): Simplices<'_, K>,
    (corners, triangles): Simplices<'_, 3>,
    density: &SolidDensity,
    extent: &Bounds<3>,
    by_data: impl Fn(&Point3<f64>) -> Result<Moments, WeighError>,
) -> Result<Body, WeighError> {
    let near = Bounds::of(vertices).center();
    let moments = match density {
        SolidDensity::Constant(value) => constant(vertices, simplices, &near) * *value,
        SolidDensity::Ramp(ramp) => linear(vertices, simplices, &ramp.over(extent, &near), &near),
        SolidDensity::Profile(profile) => profile.moments(corners, triangles, &near),
        SolidDensity::Polynomial(density) => polynomial(vertices, simplices, density, &near),
        SolidDensity::Vertex(_) | SolidDensity::VertexRamp(_) => by_data(&near)?,
    };
    let volume = volume(vertices, simplices, &near);
    let mass = moments.mass;
    let is_sound = mass > 0.0 && moments.ten().iter().all(|value| value.is_finite());
    let area = area(corners, triangles);
    let body = is_sound.then(|| Body::from_moments(volume, area, &moments, &near));
    body.ok_or(WeighError::Massless { mass })
}
