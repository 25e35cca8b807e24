//! The scene's `domain`, read as numbers or mesh files and made a domain of the plane or of space.
//!
//! How many numbers there are is validated here; what they are worth together, by the domain itself
//! when [`SceneDomain::solid`] or [`SceneDomain::plane`] builds from them.

use std::path::{Path, PathBuf};

use nalgebra::{Point2, Vector2, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain as space;
use crate::domain::planar::PlaneDomain;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::half_space::HalfSpace;
use crate::mesh::similarity::Similarity;
use crate::scene::error::Error;
use crate::scene::mesh_domain::GroupedSolid;
use crate::scene::mesh_domain::{MeshDomain, ScaleTo};
use crate::scene::numbers::{dimensions_match, point, rows_match};

/// A domain by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "DomainKeys", into = "DomainKeys")]
pub enum SceneDomain {
    /// An axis-aligned box, periodic along any of its axes.
    Box(BoxDomain),
    /// The intersection of half-spaces `[n_x, n_y, n_z, d]`: the points y with n·y ≤ d
    /// (in the plane `[n_x, n_y, d]`).
    HalfSpaces(Vec<Vec<f64>>),
    /// A polygon (in the plane only).
    Polygon(Loops),
    /// The solid within a closed surface (in space only).
    Surface(MeshDomain),
    /// The solid that tetrahedra fill (in space only).
    Tets(MeshDomain),
}

/// The corners of a polygon: one loop, or several, of which those within others are holes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "a polygon is a list of corners [x, y], or a list of such lists: loops, of which those within \
                 others are holes"
)]
pub enum Loops {
    /// One loop.
    One(Vec<Vec<f64>>),
    /// Several loops.
    Several(Vec<Vec<Vec<f64>>>),
}

/// An axis-aligned box. Lists left out are those of the unit box without periodic axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxDomain {
    /// The corner with the least coordinates; the origin by default.
    #[serde(default)]
    pub min: Vec<f64>,
    /// The corner with the greatest coordinates; (1, 1, 1) by default.
    #[serde(default)]
    pub max: Vec<f64>,
    /// Along which axes the box repeats itself; none by default.
    #[serde(default)]
    pub periodic: Vec<bool>,
}

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
    /// A polygon (in the plane only): its corners in order, either way round, or a list of such loops, of
    /// which those within others are holes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polygon: Option<Loops>,
    /// The solid within a closed surface: an OBJ, OFF, STL, PLY, 3MF or VTK file, relative to the scene's
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
    /// How far apart vertices of a mesh that is open may be to be merged, in the file's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    weld: Option<f64>,
}

impl TryFrom<DomainKeys> for SceneDomain {
    type Error = String;

    fn try_from(keys: DomainKeys) -> Result<Self, String> {
        let scale_to = keys.scale_to;
        let weld = keys.weld;
        let mesh = |file: PathBuf| MeshDomain {
            file,
            scale_to: scale_to.clone(),
            weld,
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
            (Some(_), None) if weld.is_some() => {
                Err("`weld` is for `surface` and `tets`, whose vertices a file names".to_owned())
            }
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

impl From<SceneDomain> for DomainKeys {
    fn from(domain: SceneDomain) -> Self {
        let mut keys = Self::default();
        match domain {
            SceneDomain::Box(domain) => keys.cuboid = Some(domain),
            SceneDomain::HalfSpaces(rows) => keys.half_spaces = Some(rows),
            SceneDomain::Polygon(corners) => keys.polygon = Some(corners),
            SceneDomain::Surface(mesh) => {
                keys.surface = Some(mesh.file);
                keys.scale_to = mesh.scale_to;
                keys.weld = mesh.weld;
            }
            SceneDomain::Tets(mesh) => {
                keys.tets = Some(mesh.file);
                keys.scale_to = mesh.scale_to;
                keys.weld = mesh.weld;
            }
        }
        keys
    }
}

impl Default for SceneDomain {
    fn default() -> Self {
        Self::Box(BoxDomain::default())
    }
}

impl SceneDomain {
    pub(crate) fn fill_defaults(&mut self, dimension: usize) {
        if let Self::Box(domain) = self {
            fill(&mut domain.min, 0.0, dimension);
            fill(&mut domain.max, 1.0, dimension);
            fill(&mut domain.periodic, false, dimension);
        }
    }

    /// Whether it is a convex solid without periods.
    pub(crate) fn is_plain(&self) -> bool {
        match self {
            Self::Box(domain) => !domain.periodic.contains(&true),
            Self::HalfSpaces(_) => true,
            Self::Polygon(_) | Self::Surface(_) | Self::Tets(_) => false,
        }
    }

    /// Validates the shape of the numbers.
    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        match self {
            Self::Box(domain) => domain.validate(dimension),
            Self::HalfSpaces(rows) => validate_half_spaces(rows, dimension),
            Self::Polygon(loops) => loops.validate(dimension),
            Self::Surface(mesh) | Self::Tets(mesh) => mesh.validate(dimension),
        }
    }

    /// Makes a relative path start at `folder`.
    /// The mesh file.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::Surface(mesh) | Self::Tets(mesh) => Some(&mesh.file),
            Self::Box(_) | Self::HalfSpaces(_) | Self::Polygon(_) => None,
        }
    }

    pub(crate) fn anchor(&mut self, folder: &Path) {
        if let Self::Surface(mesh) | Self::Tets(mesh) = self {
            mesh.anchor(folder);
        }
    }

    /// The domain in space, of a validated scene of dimension 3, and what was repaired in its mesh,
    /// one sentence each.
    ///
    /// # Errors
    /// [`Error::Solid`] when the numbers together are no domain, [`Error::Mesh`] when a file gives
    /// no solid.
    pub fn solid(&self) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        let domain: Box<dyn space::Domain> = match self {
            Self::Box(domain) => {
                let periodic = std::array::from_fn(|axis| domain.periodic[axis]);
                Box::new(Cuboid::new(domain.bounds(), periodic)?)
            }
            Self::HalfSpaces(rows) => Box::new(ConvexPolyhedron::new(&numbered(rows, half_space))?),
            Self::Polygon(_) => return Err(polygon_in_space()),
            Self::Surface(mesh) => return mesh.surface(),
            Self::Tets(mesh) => return mesh.tets(),
        };
        Ok((domain, Vec::new()))
    }

    /// The solid of a surface's file with the groups of its triangles, where it has several.
    pub(crate) fn grouped_surface(&self) -> Result<Option<GroupedSolid>, Error> {
        match self {
            Self::Surface(mesh) => mesh.grouped_surface(),
            _ => Ok(None),
        }
    }

    /// The map from the coordinates of the domain's file to its own, if they differ.
    ///
    /// # Errors
    /// [`Error::Mesh`] when the file is no longer there.
    pub(crate) fn similarity(&self) -> Result<Option<Similarity>, Error> {
        match self {
            Self::Surface(mesh) | Self::Tets(mesh) => mesh.similarity(),
            _ => Ok(None),
        }
    }

    /// The domain in the plane, of a validated scene of dimension 2.
    ///
    /// # Errors
    /// [`Error::Plane`] when the numbers together are no domain, [`Error::Value`] for what only
    /// space has.
    pub fn plane(&self) -> Result<PlaneDomain, Error> {
        Ok(match self {
            Self::Box(domain) => {
                let periodic = std::array::from_fn(|axis| domain.periodic[axis]);
                PlaneDomain::rectangle(&domain.bounds())?.repeated(periodic)
            }
            Self::HalfSpaces(rows) => PlaneDomain::from_half_planes(&numbered(rows, half_plane))?,
            Self::Polygon(loops) => PlaneDomain::from_loops(&loops.points())?,
            Self::Surface(mesh) | Self::Tets(mesh) => return Err(mesh.in_plane()),
        })
    }
}

impl Loops {
    fn points(&self) -> Vec<Vec<Point2<f64>>> {
        match self {
            Self::One(corners) => vec![numbered(corners, point)],
            Self::Several(loops) => {
                let points = loops.iter().map(|corners| numbered(corners, point));
                points.collect()
            }
        }
    }

    fn validate(&self, dimension: usize) -> Result<(), Error> {
        if dimension != 2 {
            return Err(polygon_in_space());
        }
        match self {
            Self::One(corners) => rows_match("domain.polygon", corners, 2),
            Self::Several(loops) => {
                let mut numbered = loops.iter().enumerate();
                numbered.try_for_each(|(number, corners)| {
                    rows_match(&format!("domain.polygon[{number}]"), corners, 2)
                })
            }
        }
    }
}

impl BoxDomain {
    fn bounds<const D: usize>(&self) -> Bounds<D> {
        Bounds {
            min: point(&self.min),
            max: point(&self.max),
        }
    }

    fn validate(&self, dimension: usize) -> Result<(), Error> {
        dimensions_match("domain.box.min", self.min.len(), dimension)?;
        dimensions_match("domain.box.max", self.max.len(), dimension)?;
        dimensions_match("domain.box.periodic", self.periodic.len(), dimension)?;
        for (axis, (min, max)) in self.min.iter().zip(&self.max).enumerate() {
            if min >= max {
                return Err(Error::value(
                    "domain.box",
                    format!(
                        "the box has no volume: min {min:?} is not below max {max:?} along axis {axis}"
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn numbered<T>(rows: &[Vec<f64>], make: impl Fn(&[f64]) -> T) -> Vec<T> {
    rows.iter().map(|row| make(row)).collect()
}

fn half_space(row: &[f64]) -> HalfSpace {
    HalfSpace {
        normal: Vector3::new(row[0], row[1], row[2]),
        offset: row[3],
    }
}

fn half_plane(row: &[f64]) -> HalfPlane {
    HalfPlane {
        normal: Vector2::new(row[0], row[1]),
        offset: row[2],
    }
}

fn fill<T: Clone>(list: &mut Vec<T>, value: T, dimension: usize) {
    if list.is_empty() {
        list.resize(dimension, value);
    }
}

fn validate_half_spaces(rows: &[Vec<f64>], dimension: usize) -> Result<(), Error> {
    for (index, row) in rows.iter().enumerate() {
        let key = format!("domain.half_spaces[{index}]");
        if row.len() != dimension + 1 {
            let message = format!(
                "{} numbers where a normal of {dimension} and an offset are needed",
                row.len()
            );
            return Err(Error::value(key, message));
        }
    }
    Ok(())
}

fn polygon_in_space() -> Error {
    let message = "a polygon needs \"dimension\": 2 in the scene";
    Error::value("domain.polygon", message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_without_numbers_is_the_unit_box() {
        let mut domain = SceneDomain::default();
        domain.fill_defaults(2);
        let expected = BoxDomain {
            min: vec![0.0, 0.0],
            max: vec![1.0, 1.0],
            periodic: vec![false, false],
        };
        assert_eq!(domain, SceneDomain::Box(expected));
    }

    #[test]
    fn a_flat_box_is_refused_with_its_axis() {
        let flat = BoxDomain {
            min: vec![0.0, 0.0, 0.0],
            max: vec![1.0, 0.0, 1.0],
            periodic: vec![false; 3],
        };
        let error = SceneDomain::Box(flat).validate(3).unwrap_err().to_string();
        assert!(
            error.contains("no volume") && error.contains("axis 1"),
            "{error}"
        );
    }
}
