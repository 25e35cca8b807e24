//! Solids from mesh files as a scene's domain, and how they are scaled.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::domain as space;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::mesh::formats::read::{load_labeled, load_within};
use crate::mesh::report::SurfaceReport;
use crate::mesh::similarity::Similarity;
use crate::mesh::validate::{Solid, validate_surface};
use crate::scene::error::Error;
use crate::scene::numbers::{dimensions_match, point};

/// A solid with the groups of its triangles.
#[derive(Debug)]
pub(crate) struct GroupedSolid {
    /// The solid.
    pub(crate) solid: SurfaceSolid,
    /// The group of every triangle.
    pub(crate) groups: Vec<u32>,
    /// The names of the groups.
    pub(crate) names: Vec<String>,
}

/// A mesh file and the box into which its solid is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshDomain {
    /// The file.
    pub file: PathBuf,
    /// Where the solid is brought; by default it stays as it is.
    pub scale_to: Option<ScaleTo>,
    /// How far apart vertices of an open mesh may be to be merged, in the file's unit; by default
    /// little more than their rounding.
    pub weld: Option<f64>,
}

/// A box into which a solid is fitted: scaled alike along all axes to the largest size that fits,
/// and centered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "`scale_to` is \"unit_cube\", a cube's side such as 2.5, or a box \
                 {\"min\": [x, y, z], \"max\": [x, y, z]}"
)]
pub enum ScaleTo {
    /// The unit cube.
    Named(Named),
    /// The cube [0, s]³ of this side s.
    Cube(f64),
    /// This box.
    Box(ScaleBox),
}

/// Boxes with names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Named {
    /// [0, 1]³.
    #[serde(alias = "unit-cube", alias = "unit cube")]
    UnitCube,
}

/// A box by its corners.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScaleBox {
    /// The corner with the least coordinates.
    pub min: Vec<f64>,
    /// The corner with the greatest coordinates.
    pub max: Vec<f64>,
}

impl MeshDomain {
    pub(crate) fn anchor(&mut self, folder: &Path) {
        self.file = folder.join(&self.file);
    }

    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        if dimension != 3 {
            return Err(self.in_plane());
        }
        if let Some(weld) = self.weld.filter(|weld| !(weld.is_finite() && *weld >= 0.0)) {
            let message = format!("{weld:?} is not 0 or a positive length");
            return Err(Error::value("domain.weld", message));
        }
        self.scale_to.as_ref().map_or(Ok(()), ScaleTo::validate)
    }

    /// The solid of the file.
    fn load(&self) -> Result<Solid, Error> {
        Ok(load_within(&self.file, self.weld.unwrap_or(0.0))?)
    }

    /// The solid within the file's surface, or within the boundary of its tetrahedra, and what was
    /// repaired.
    pub(crate) fn surface(&self) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        let mut solid = self.load()?;
        self.scale(&mut solid);
        let notes = solid.notes();
        let surface = match solid {
            Solid::Surface(surface, report) => {
                self.refuse_overlaps(&report)?;
                surface
            }
            Solid::Tets(tets, _) => {
                let boundary = validate_surface(&tets.mesh().boundary());
                let (boundary, report) =
                    boundary.map_err(|refusal| self.refused(refusal.to_string()))?;
                self.refuse_overlaps(&report)?;
                boundary
            }
        };
        Ok((Box::new(SurfaceSolid::new(&surface)?), notes))
    }

    /// The solid within the file's surface with walls that end where its groups do, where it has several.
    pub(crate) fn grouped_surface(&self) -> Result<Option<GroupedSolid>, Error> {
        let labeled = load_labeled(&self.file, self.weld.unwrap_or(0.0))?;
        let groups = labeled.elements.groups;
        let mut solid = labeled.solid;
        self.scale(&mut solid);
        let Solid::Surface(surface, _) = solid else {
            return Ok(None);
        };
        let of_triangles = groups.of_elements();
        if groups.names().len() < 2 || of_triangles.len() != surface.mesh().triangles.len() {
            return Ok(None);
        }
        Ok(Some(GroupedSolid {
            solid: SurfaceSolid::new(&surface)?.parted_by(of_triangles),
            groups: of_triangles.to_vec(),
            names: groups.names().to_vec(),
        }))
    }

    /// The solid that the file's tetrahedra fill, and what was repaired.
    pub(crate) fn tets(&self) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        let (tets, notes) = self.tet_solid()?;
        Ok((Box::new(tets), notes))
    }

    /// As [`MeshDomain::tets`], to be given a density.
    pub(crate) fn tet_solid(&self) -> Result<(TetSolid, Vec<String>), Error> {
        let mut solid = self.load()?;
        self.scale(&mut solid);
        let notes = solid.notes();
        match solid {
            Solid::Tets(tets, _) => Ok((TetSolid::new(&tets)?, notes)),
            Solid::Surface(..) => {
                let reason = "holds no tetrahedra; write {\"surface\": …} for a surface";
                Err(self.refused(reason.to_owned()))
            }
        }
    }

    /// Refuses a surface whose winding is not 0 or 1: what it encloses twice would be a domain twice.
    fn refuse_overlaps(&self, report: &SurfaceReport) -> Result<(), Error> {
        let reason = report.no_domain();
        reason.map_or(Ok(()), |reason| {
            Err(self.refused(format!("the surface {reason}")))
        })
    }

    fn scale(&self, solid: &mut Solid) {
        if let Some(similarity) = self.similarity_of(solid) {
            solid.transform(&similarity);
        }
    }

    /// The map from the file's coordinates to the domain's, if they differ.
    pub(crate) fn similarity(&self) -> Result<Option<Similarity>, Error> {
        match self.scale_to {
            None => Ok(None),
            Some(_) => Ok(self.similarity_of(&self.load()?)),
        }
    }

    fn similarity_of(&self, solid: &Solid) -> Option<Similarity> {
        let target = self.scale_to.as_ref().map(ScaleTo::bounds)?;
        let bounds = match solid {
            Solid::Surface(surface, _) => surface.mesh().bounds(),
            Solid::Tets(tets, _) => tets.mesh().bounds(),
        };
        Some(Similarity::into_box(&bounds, &target))
    }

    /// The refusal of a mesh as domain of the plane.
    pub(crate) fn in_plane(&self) -> Error {
        let file = self.file.display();
        let message = format!("{file} bounds a solid in space; set \"dimension\": 3");
        Error::value("domain", message)
    }

    fn refused(&self, message: String) -> Error {
        let path = self.file.clone();
        Error::File { path, message }
    }
}

impl ScaleTo {
    fn bounds(&self) -> Bounds<3> {
        let cube = |side: f64| Bounds {
            min: point(&[0.0; 3]),
            max: point(&[side; 3]),
        };
        match self {
            Self::Named(Named::UnitCube) => cube(1.0),
            Self::Cube(side) => cube(*side),
            Self::Box(ScaleBox { min, max }) => Bounds {
                min: point(min),
                max: point(max),
            },
        }
    }

    fn validate(&self) -> Result<(), Error> {
        const KEY: &str = "domain.scale_to";
        if let Self::Box(ScaleBox { min, max }) = self {
            for (key, corner) in [("domain.scale_to.min", min), ("domain.scale_to.max", max)] {
                dimensions_match(key, corner.len(), 3)?;
            }
        }
        let extent = self.bounds().extent();
        if extent
            .iter()
            .all(|length| length.is_finite() && *length > 0.0)
        {
            Ok(())
        } else {
            let message = match self {
                Self::Cube(side) => format!("the side {side} is not a positive number"),
                _ => "the box has no volume; max must be greater than min".to_owned(),
            };
            Err(Error::value(KEY, message))
        }
    }
}
