//! Densities as texts and field files give them: the mass of solids, and values at points.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use thiserror::Error as ThisError;

use crate::domain::error::DomainError;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::MomentErrors;
use crate::integrals::cell_moments::of_cells;
use crate::integrals::expression::Expression;
use crate::integrals::mesh_moments::at_vertices;
use crate::integrals::radial::Radial;
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mass::evaluate::{DensityFunction, density_function, vertex_function};
use crate::mass::numeric::{
    BodyErrors, FormulaField, MissedTolerance, NumericError, NumericMoments, boundary,
    formula_moments, radial_moments, sampled_moments,
};
use crate::mass::tet_values::TetValues;
use crate::mass::weigh::{WeighError, bounds, weigh};
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;
use crate::parallel::map;
use crate::scene::error::Error;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile, FieldFormula};
use crate::scene::field_text::{FieldText, FieldTextError};
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
    /// One constant for each of the solid's tetrahedra.
    Tets(Vec<f64>),
    /// A function of the distance from a point.
    Radial(Radial),
    /// A formula.
    Formula(Expression),
    /// A formula sampled at the vertices of the solid's tetrahedra, linear in between.
    Sampled(Expression),
}

/// The mass properties of a solid, with bounds of their errors where its density has no closed integral.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weighed {
    pub(crate) body: Body,
    /// Of its moments, and the point from which those are measured.
    pub(crate) errors: Option<(MomentErrors, Point3<f64>)>,
    /// Where the tolerance was not reached.
    pub(crate) missed: Option<MissedTolerance>,
}

impl Weighed {
    /// A body without errors but rounding.
    fn exactly(body: Body) -> Self {
        Self {
            body,
            errors: None,
            missed: None,
        }
    }

    /// The same with its density scaled so that it weighs `mass`.
    pub(crate) fn weighing(&self, mass: f64) -> Self {
        let factor = mass / self.body.mass;
        Self {
            body: self.body.weighing(mass),
            errors: self
                .errors
                .map(|(errors, near)| (errors.times(factor), near)),
            ..*self
        }
    }

    /// The bounds of the errors of `parts` together, `body`, in a box of diagonal `extent`; none where all
    /// are exact.
    pub(crate) fn errors_of(parts: &[Self], body: &Body, extent: f64) -> Option<BodyErrors> {
        let center = body.center_of_mass();
        let about = parts.iter().filter_map(|part| part.errors);
        let about = about.map(|(errors, near)| errors.moved((center - near).norm()));
        let sum = about.reduce(|sum, errors| sum.plus(&errors))?;
        Some(BodyErrors::of(body, &sum, &center, extent))
    }
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
    Text(#[from] FieldTextError),
    /// The field file cannot be used.
    #[error(transparent)]
    File(#[from] Error),
    /// The text in a field file is no density.
    #[error("{path}: {error}", path = path.display())]
    TextInFile {
        /// The file.
        path: PathBuf,
        /// Why.
        error: FieldTextError,
    },
    /// The solid cannot be weighed.
    #[error(transparent)]
    Weigh(#[from] WeighError),
    /// The field's cells are not those of this solid.
    #[error("{0} (the field's cells must be of the solid that is weighed)")]
    Cells(#[from] DiagramError),
    /// A formula has no integral.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The solid has no cells.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Values of tetrahedra for a surface.
    #[error("`cell:` density needs a tetrahedral mesh with cell data; this is a surface")]
    CellOfSurface,
    /// Values of tetrahedra for another mesh.
    #[error("the field has {values} values and the mesh {tets} tetrahedra: it is of another mesh")]
    Tets {
        /// How many the field has.
        values: usize,
        /// How many the mesh has.
        tets: usize,
    },
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
    /// A density of no file.
    pub(crate) fn of(field: Field) -> Self {
        Self {
            field,
            file: None,
            bounds: None,
        }
    }

    /// A density by its text: `@FILE` is a field file.
    ///
    /// # Errors
    /// When the text is no density or the file no field.
    pub(crate) fn read(text: &str) -> Result<Self, FieldError> {
        let Some(file) = text.trim().strip_prefix('@') else {
            return Ok(Self {
                field: Field::of_text(text)?,
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

    /// The box of the solid that the field was made for.
    pub(crate) fn bounds(&self) -> Option<Bounds<3>> {
        let FieldBounds { min, max } = self.bounds?;
        Some(Bounds {
            min: min.into(),
            max: max.into(),
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
    /// The density of a text, not a file's name.
    pub(crate) fn of_text(text: &str) -> Result<Self, FieldTextError> {
        Ok(match text.parse()? {
            FieldText::Solid(density) => Self::Solid(density),
            FieldText::Radial(density) => Self::Radial(density),
            FieldText::Formula(formula) => Self::Formula(formula),
            FieldText::Sampled(formula) => Self::Sampled(formula),
        })
    }

    /// The density that a field file holds.
    pub(crate) fn of_file(density: FieldDensity) -> Result<Self, FieldTextError> {
        Ok(match density {
            FieldDensity::Text(text) => Self::of_text(&text)?,
            FieldDensity::Cells { sites, values, .. } => Self::Cells {
                sites: sites.into_iter().map(Point3::from).collect(),
                values,
            },
            FieldDensity::Vertices { values } => Self::Vertices(values),
            FieldDensity::Clamp { low, high, of } => match of {
                FieldFormula::Affine { value, gradient } => {
                    let high = high.unwrap_or(f64::INFINITY);
                    Self::Solid(SolidDensity::clamp(low, high, value, &gradient.into())?)
                }
                FieldFormula::Polynomial(text) => {
                    let high = high.map_or(String::new(), |high| format!("min({high:?}, "));
                    let close = if high.is_empty() { "" } else { ")" };
                    Self::of_text(&format!("max({low:?}, {high}{text}{close})"))?
                }
            },
        })
    }

    /// The mass properties of `solid` of this density; `extent` is the whole body's box.
    ///
    /// # Errors
    /// When the mass is not positive, or the field is not of this solid.
    pub(crate) fn weigh(
        &self,
        solid: &Solid,
        extent: &Bounds<3>,
        tolerance: Option<f64>,
    ) -> Result<Weighed, FieldError> {
        let near = bounds(solid).center();
        let exact = |moments| body(solid, extent, &moments, &near).map(Weighed::exactly);
        match self {
            Self::Solid(density) => {
                let body = weigh(solid, density, extent)?;
                Ok(Weighed::exactly(body))
            }
            Self::Vertices(values) => {
                let mesh = tets_of(solid, values.len())?;
                exact(at_vertices(&mesh.vertices, &mesh.tets, values, &near))
            }
            Self::Tets(values) => {
                let mesh = tets_with(solid, values.len())?;
                exact(of_cells(&mesh.vertices, &mesh.tets, values, &near))
            }
            Self::Cells { sites, values } => exact(cell_moments(solid, sites, values, &near)?),
            Self::Radial(density) => numeric(solid, extent, &radial_moments(solid, density)),
            Self::Formula(formula) => {
                numeric(solid, extent, &formula_moments(solid, formula, tolerance)?)
            }
            Self::Sampled(formula) => {
                let (mesh, values) = sampled(solid, formula)?;
                numeric(
                    solid,
                    extent,
                    &sampled_moments(solid, mesh, formula, &values)?,
                )
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
            Self::Vertices(values) => {
                vertex_function(tets_of(solid, values.len())?, values.as_slice().into())
            }
            Self::Tets(values) => {
                let mesh = tets_with(solid, values.len())?;
                let tets = TetValues::new(mesh, Cow::Borrowed(&[]));
                Box::new(move |point| {
                    let tet = tets.tet_at(point);
                    tet.map_or(f64::NAN, |tet| values[tet as usize])
                })
            }
            Self::Radial(density) => Box::new(|point| density.at(point)),
            Self::Formula(formula) => {
                let field = FormulaField::new(formula, || boundary(solid));
                Box::new(move |point| field.at(point, &mut 0))
            }
            Self::Sampled(formula) => {
                let (mesh, values) = sampled(solid, formula)?;
                vertex_function(mesh, values.into())
            }
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

/// The moments from `near` of cells with one density each.
fn cell_moments(
    solid: &Solid,
    sites: &[Point3<f64>],
    values: &[f64],
    near: &Point3<f64>,
) -> Result<Moments, FieldError> {
    let shape = shape(solid)?;
    let cells = Diagram::borrowed(&shape, sites)?.map_cells(|cell| cell.moments())?;
    let mut moments = Moments::default();
    for ((cell, site), &value) in cells.iter().zip(sites).zip(values) {
        moments += cell.translated(&(site - near)) * value;
    }
    Ok(moments)
}

/// A formula's values at the vertices of the solid's tetrahedra.
fn sampled<'a>(
    solid: &'a Solid,
    formula: &Expression,
) -> Result<(&'a TetMesh, Vec<f64>), FieldError> {
    let Solid::Tets(sound, _) = solid else {
        return Err(WeighError::VertexOfSurface.into());
    };
    let field = FormulaField::new(formula, || boundary(solid));
    let vertices = &sound.mesh().vertices;
    let values = map(vertices.len(), &|vertex| {
        field.at(&vertices[vertex], &mut 0)
    });
    Ok((sound.mesh(), values))
}

/// The body of moments that are not exact.
fn numeric(solid: &Solid, extent: &Bounds<3>, sum: &NumericMoments) -> Result<Weighed, FieldError> {
    Ok(Weighed {
        body: body(solid, extent, &sum.moments, &sum.near)?,
        errors: Some((sum.errors, sum.near)),
        missed: sum.missed,
    })
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
    let (volume, area) = (plain.volume, plain.surface_area);
    Ok(Body::from_moments(volume, area, moments, near))
}

/// The solid's tetrahedra, for one value at each vertex.
fn tets_of(solid: &Solid, values: usize) -> Result<&TetMesh, FieldError> {
    let Solid::Tets(sound, _) = solid else {
        return Err(WeighError::VertexOfSurface.into());
    };
    let mesh = sound.mesh();
    if mesh.vertices.len() != values {
        return Err(FieldError::Vertices {
            values,
            vertices: mesh.vertices.len(),
        });
    }
    Ok(mesh)
}

/// The solid's tetrahedra, of which there are so many.
fn tets_with(solid: &Solid, values: usize) -> Result<&TetMesh, FieldError> {
    match solid {
        Solid::Tets(sound, _) if sound.mesh().tets.len() == values => Ok(sound.mesh()),
        Solid::Tets(sound, _) => Err(FieldError::Tets {
            values,
            tets: sound.mesh().tets.len(),
        }),
        Solid::Surface(..) => Err(FieldError::CellOfSurface),
    }
}

/// The solid as a domain of cells.
pub(crate) fn shape(solid: &Solid) -> Result<SurfaceSolid, DomainError> {
    match solid {
        Solid::Surface(closed, _) => SurfaceSolid::new(closed),
        Solid::Tets(sound, _) => Ok(TetSolid::new(sound)?.into_boundary()),
    }
}
