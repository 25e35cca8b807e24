//! The keys of a scene's `domain`, of which one names the kind.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::domain::{BoxDomain, Domain};
use crate::scene::mesh_domain::{MeshDomain, ScaleTo};

/// Where the sites live: exactly one of `box`, `half_spaces`, `polygon`, `surface` and `tets`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomainKeys {
    /// An axis-aligned box, periodic along any of its axes.
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    cuboid: Option<BoxDomain>,
    /// The intersection of half-spaces `[n_x, n_y, n_z, d]`: the points y with n·y ≤ d
    /// (in the plane `[n_x, n_y, d]`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    half_spaces: Option<Vec<Vec<f64>>>,
    /// The corners of a convex polygon in order, either way round (in the plane only).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polygon: Option<Vec<Vec<f64>>>,
    /// The solid within a closed surface: an OBJ, OFF, STL or PLY file, relative to the scene's
    /// folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    surface: Option<PathBuf>,
    /// The solid that tetrahedra fill: a MEDIT, Gmsh, TetGen or VTK file, relative to the scene's
    /// folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tets: Option<PathBuf>,
    /// The box into which a mesh is fitted: `"unit_cube"`, a side length, or `min` and `max`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scale_to: Option<ScaleTo>,
}

impl TryFrom<DomainKeys> for Domain {
    type Error = String;

    fn try_from(keys: DomainKeys) -> Result<Self, String> {
        let scale_to = keys.scale_to;
        let mesh = |file: PathBuf| MeshDomain {
            file,
            scale_to: scale_to.clone(),
        };
        let kinds = [
            keys.cuboid.map(Self::Box),
            keys.half_spaces.map(Self::HalfSpaces),
            keys.polygon.map(Self::Polygon),
            keys.surface.map(|file| Self::Surface(mesh(file))),
            keys.tets.map(|file| Self::Tets(mesh(file))),
        ];
        let mut kinds = kinds.into_iter().flatten();
        match (kinds.next(), kinds.next()) {
            (Some(domain @ (Self::Surface(_) | Self::Tets(_))), None) => Ok(domain),
            (Some(_), None) if scale_to.is_some() => Err(
                "`scale_to` is for `surface` and `tets`; a domain of numbers has its size"
                    .to_owned(),
            ),
            (Some(domain), None) => Ok(domain),
            _ => Err(
                "the domain needs exactly one of `box`, `half_spaces`, `polygon`, `surface` \
                      and `tets`"
                    .to_owned(),
            ),
        }
    }
}

impl From<Domain> for DomainKeys {
    fn from(domain: Domain) -> Self {
        let mut keys = Self::default();
        match domain {
            Domain::Box(domain) => keys.cuboid = Some(domain),
            Domain::HalfSpaces(rows) => keys.half_spaces = Some(rows),
            Domain::Polygon(corners) => keys.polygon = Some(corners),
            Domain::Surface(mesh) => {
                keys.surface = Some(mesh.file);
                keys.scale_to = mesh.scale_to;
            }
            Domain::Tets(mesh) => {
                keys.tets = Some(mesh.file);
                keys.scale_to = mesh.scale_to;
            }
        }
        keys
    }
}
