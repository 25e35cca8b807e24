//! Densities as texts and field files give them: the mass of solids, and values at points.

use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};
use thiserror::Error as ThisError;

use crate::domain::error::DomainError;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::at_vertices;
use crate::mass::body::Body;
use crate::mass::density::{DensityError, SolidDensity};
use crate::mass::evaluate::{DensityFunction, density_function, vertex_function};
use crate::mass::weigh::{WeighError, bounds, weigh};
use crate::mesh::validate::Solid;
use crate::scene::error::Error;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile, FieldFormula};
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A density over solids.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Field {
    /// A function of position, or vertex data that the solid's file holds.
    Solid(SolidDensity),
    /// One density for each Voronoi cell of sites.
    Cells {
        /// The sites.
        sites: Vec<Point3<f64>>,
        /// One for each.
        values: Vec<f64>,
    },
    /// Values at the vertices of the solid's tetrahedra, linear in between.
    Vertices(Vec<f64>),
}

/// A field with the file that it was read from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GivenField {
    /// The density.
    pub(crate) field: Field,
    /// The field file, none for a text.
    pub(crate) file: Option<PathBuf>,
    /// The box of the solid that the file was made for.
    bounds: Option<FieldBounds>,
}

/// Why a text or a file is no density of a solid.
#[derive(Debug, ThisError)]
pub(crate) enum FieldError {
    /// The text is no density.
    #[error(transparent)]
    Text(#[from] DensityError),
    /// The field file cannot be used.
    #[error(transparent)]
    File(#[from] Error),
    /// The text in a field file is no density.
    #[error("{path}: {error}", path = path.display())]
    TextInFile {
        /// The file.
        path: PathBuf,
        /// Why.
        error: DensityError,
    },
    /// The solid cannot be weighed.
    #[error(transparent)]
    Weigh(#[from] WeighError),
    /// The field's cells are not those of this solid.
    #[error("{0} (the field's cells must be of the solid that is weighed)")]
    Cells(#[from] DiagramError),
    /// The solid has no cells.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Vertex values for another mesh.
    #[error(
        "the field has {values} values and the mesh {vertices} vertices: it is of another mesh"
    )]
    Vertices {
        /// How many the field has.
        values: usize,
        /// How many the mesh has.
        vertices: usize,
    },
}

impl GivenField {
    /// A density by its text: `@FILE` is a field file.
    ///
    /// # Errors
    /// When the text is no density or the file no field.
    pub(crate) fn read(text: &str) -> Result<Self, FieldError> {
        let Some(file) = text.trim().strip_prefix('@') else {
            return Ok(Self {
                field: Field::Solid(text.parse()?),
                file: None,
                bounds: None,
            });
        };
        let path = Path::new(file);
        let FieldFile {
            density, bounds, ..
        } = FieldFile::read(path)?;
        let field = Field::of_file(density).map_err(|error| FieldError::TextInFile {
            path: path.to_owned(),
            error,
        })?;
        Ok(Self {
            field,
            file: Some(path.to_owned()),
            bounds,
        })
    }

    /// A sentence where the field was made for a solid in another place, or of another size.
    pub(crate) fn note(&self, extent: &Bounds<3>) -> Option<String> {
        let FieldBounds { min, max } = self.bounds?;
        let slack = 1e-6 * extent.extent().amax();
        let is_far =
            |one: [f64; 3], other: &Point3<f64>| (Point3::from(one) - other).amax() > slack;
        let file = self.file.as_deref().unwrap_or(Path::new("")).display();
        (is_far(min, &extent.min) || is_far(max, &extent.max)).then(|| {
            format!(
                "{file} was made for a solid between {min:?} and {max:?}; this one lies between \
                 {:?} and {:?}",
                <[f64; 3]>::from(extent.min),
                <[f64; 3]>::from(extent.max)
            )
        })
    }
}

impl Field {
    /// The density that a field file holds.
    fn of_file(density: FieldDensity) -> Result<Self, DensityError> {
        Ok(match density {
            FieldDensity::Text(text) => Self::Solid(text.parse()?),
            FieldDensity::Cells { sites, values, .. } => Self::Cells {
                sites: sites.into_iter().map(Point3::from).collect(),
                values,
            },
            FieldDensity::Vertices { values } => Self::Vertices(values),
            FieldDensity::Clamp { low, high, of } => Self::Solid(clamped(low, high, &of)?),
        })
    }

    /// The mass properties of `solid` of this density; `extent` is the whole body's box.
    ///
    /// # Errors
    /// When the mass is not positive, or the field is not of this solid.
    pub(crate) fn weigh(&self, solid: &Solid, extent: &Bounds<3>) -> Result<Body, FieldError> {
        match self {
            Self::Solid(density) => Ok(weigh(solid, density, extent)?),
            Self::Vertices(values) => {
                let mesh = tets_of(solid, values)?;
                let near = bounds(solid).center();
                let moments = at_vertices(&mesh.vertices, &mesh.tets, values, &near);
                body(solid, extent, &moments, &near)
            }
            Self::Cells { sites, values } => {
                let shape = shape(solid)?;
                let (diagram, near) = (Diagram::borrowed(&shape, sites)?, bounds(solid).center());
                let cells = diagram.map_cells(|cell| cell.moments())?;
                let mut moments = Moments::default();
                for ((cell, site), &value) in cells.iter().zip(sites).zip(values) {
                    moments += cell.translated(&(site - near)) * value;
                }
                body(solid, extent, &moments, &near)
            }
        }
    }

    /// The density as a function of position.
    ///
    /// # Errors
    /// When the field is not of this solid.
    pub(crate) fn function<'a>(
        &'a self,
        solid: &'a Solid,
        extent: &Bounds<3>,
    ) -> Result<DensityFunction<'a>, FieldError> {
        Ok(match self {
            Self::Solid(density) => density_function(solid, density, extent)?,
            Self::Vertices(values) => vertex_function(tets_of(solid, values)?, values),
            Self::Cells { sites, values } => {
                let point = |site: &Point3<f64>| Bounds {
                    min: *site,
                    max: *site,
                };
                let tree = Bvh::new(sites.iter().map(point));
                Box::new(move |place| {
                    let to = |site: u32| (sites[site as usize] - place).norm_squared();
                    let nearest = tree.nearest(place, 0, to);
                    nearest.map_or(f64::NAN, |(site, _)| values[site as usize])
                })
            }
        })
    }
}

/// clamp(low, high, formula).
fn clamped(
    low: f64,
    high: Option<f64>,
    formula: &FieldFormula,
) -> Result<SolidDensity, DensityError> {
    let FieldFormula::Affine { value, gradient } = formula else {
        return Ok(SolidDensity::Constant(low));
    };
    let gradient = Vector3::from(*gradient);
    let slope = gradient.norm();
    let Some(direction) = gradient.try_normalize(0.0) else {
        let value = value.max(low).min(high.unwrap_or(f64::INFINITY));
        return Ok(SolidDensity::Constant(value));
    };
    let start = (low - value) / slope;
    let high = high.unwrap_or(low + slope * 1e12);
    let breaks = vec![[start, low], [start + (high - low) / slope, high]];
    let profile = crate::mass::profile::Profile::new(&direction, breaks)?;
    Ok(SolidDensity::Profile(profile))
}

/// The body of these moments about `near`, with the solid's volume and area.
fn body(
    solid: &Solid,
    extent: &Bounds<3>,
    moments: &Moments,
    near: &Point3<f64>,
) -> Result<Body, FieldError> {
    let mass = moments.mass;
    if !(mass > 0.0 && moments.ten().iter().all(|value| value.is_finite())) {
        return Err(WeighError::Massless { mass }.into());
    }
    let plain = weigh(solid, &SolidDensity::Constant(1.0), extent)?;
    Ok(Body::from_moments(
        plain.volume,
        plain.surface_area,
        moments,
        near,
    ))
}

/// The solid's tetrahedra, for one value at each vertex.
fn tets_of<'a>(
    solid: &'a Solid,
    values: &[f64],
) -> Result<&'a crate::mesh::tets::TetMesh, FieldError> {
    let Solid::Tets(sound, _) = solid else {
        return Err(WeighError::VertexOfSurface.into());
    };
    let mesh = sound.mesh();
    if mesh.vertices.len() != values.len() {
        return Err(FieldError::Vertices {
            values: values.len(),
            vertices: mesh.vertices.len(),
        });
    }
    Ok(mesh)
}

/// The solid as a domain of cells.
pub(crate) fn shape(solid: &Solid) -> Result<SurfaceSolid, DomainError> {
    match solid {
        Solid::Surface(closed, _) => SurfaceSolid::new(closed),
        Solid::Tets(sound, _) => Ok(TetSolid::new(sound)?.into_boundary()),
    }
}
