//! Densities of tetrahedral meshes that are linear in every tetrahedron, after the mesh is cut where they
//! bend (\[BL\] Appendix B).

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::mass::cut::{CutMesh, cut, cut_at};
use crate::mass::density::SolidDensity;
use crate::mesh::tets::{TetMesh, VertexData};

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
    /// The density has no linear pieces.
    #[error("a polynomial is not linear in every tetrahedron, however the mesh is cut")]
    NotLinear,
    /// No vertex data, or several and no name.
    #[error("`vertex` density needs one field of vertex data to choose; the mesh has {there}")]
    WhichField {
        /// The names there are.
        there: String,
    },
}

/// A mesh and the density at its vertices, linear in every tetrahedron.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LinearPieces {
    /// The mesh, cut where the density bends; it keeps its vertex data.
    pub(crate) mesh: TetMesh,
    /// One for each vertex.
    pub(crate) densities: Vec<f64>,
}

/// The data by which a mesh is cut ride along under a name that no file can give them.
const CARRIED: &str = "\0";

/// `mesh` cut where `density` bends, and the densities at its vertices; `extent` is the whole body's box,
/// over which ramps run.
///
/// # Errors
///
/// If the density is a polynomial of higher degree, or needs vertex data that are not there.
pub(crate) fn linear_pieces(
    mesh: &TetMesh,
    density: &SolidDensity,
    extent: &Bounds<3>,
) -> Result<LinearPieces, WeighError> {
    let uncut = |density_at: &dyn Fn(&Point3<f64>) -> f64| LinearPieces {
        mesh: mesh.clone(),
        densities: mesh.vertices.iter().map(density_at).collect(),
    };
    match density {
        SolidDensity::Constant(value) => Ok(uncut(&|_| *value)),
        SolidDensity::Ramp(ramp) => {
            let origin = extent.center();
            let linear = ramp.over(extent, &origin);
            Ok(uncut(&|vertex| {
                linear.value + linear.gradient.dot(&(vertex - origin))
            }))
        }
        SolidDensity::Polynomial(polynomial) if polynomial.degree() > 1 => {
            Err(WeighError::NotLinear)
        }
        SolidDensity::Polynomial(polynomial) => Ok(uncut(&|vertex| polynomial.at(vertex))),
        SolidDensity::Profile(profile) => {
            let direction = profile.direction();
            let cut_at_break =
                |mesh: TetMesh, plane: &[f64; 2]| cut(&mesh, direction, plane[0]).mesh;
            let mesh = profile.breaks().iter().fold(mesh.clone(), cut_at_break);
            let densities = mesh.vertices.iter().map(|vertex| profile.at_point(vertex));
            let densities = densities.collect();
            Ok(LinearPieces { mesh, densities })
        }
        SolidDensity::Vertex(name) => Ok(LinearPieces {
            mesh: mesh.clone(),
            densities: field(mesh, name.as_deref())?.to_vec(),
        }),
        SolidDensity::VertexRamp(ramp) => {
            let data = field(mesh, ramp.name.as_deref())?.to_vec();
            let (mesh, data) = cut_at_values(mesh, data, &ramp.bends());
            let densities = data.into_iter().map(|value| ramp.at(value)).collect();
            Ok(LinearPieces { mesh, densities })
        }
    }
}

/// The mesh cut where its vertex `data`, linear in every tetrahedron, take one of `values`; and the data of
/// what is cut.
fn cut_at_values(mesh: &TetMesh, data: Vec<f64>, values: &[f64]) -> (TetMesh, Vec<f64>) {
    let mut mesh = mesh.clone();
    mesh.vertex_data.push(VertexData {
        name: CARRIED.into(),
        values: data,
        fault: None,
    });
    for value in values {
        let carried = mesh.vertex_data.last().map_or(&[][..], |data| &data.values);
        let distances: Vec<f64> = carried.iter().map(|data| data - value).collect();
        let CutMesh { mesh: parts, .. } = cut_at(&mesh, &distances);
        mesh = parts;
    }
    let data = mesh.vertex_data.pop().map(|data| data.values);
    (mesh, data.unwrap_or_default())
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
