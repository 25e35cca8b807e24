//! The scene's `density`: the weight of the domain's volume in the energies.
//!
//! A polynomial holds for any domain, and so does a size that is one. Values at tetrahedron
//! vertices, be they densities or sizes, make a density that is linear on every tetrahedron. Fields of
//! other kinds are cut into regions (`scene::background`).

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::domain as space;
use crate::domain::domain::WeightedDomain;
use crate::domain::tet_mesh::TetSolid;
use crate::geometry::bounds::Bounds;
use crate::integrals::polynomial::Polynomial;
use crate::mass::density::SolidDensity;
use crate::mass::linear_pieces::{LinearPieces, linear_pieces};
use crate::mass::numeric::FormulaField;
use crate::mesh::validate::validate_tets;
use crate::scene::background::by_field;
use crate::scene::domain::SceneDomain;
use crate::scene::error::Error;
use crate::scene::field::{Field, FieldError, GivenField};

/// Background density: text, or one of the keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the density is a text such as \"1 + 2*x\" or an object with exactly one of the \
                 keys `polynomial`, `data`, `size`"
)]
pub enum SceneDensity {
    /// The name of the vertex data of tetrahedra, else a density as `chebloyd mass --density` takes it:
    /// a polynomial, a formula, a kind with settings, or `@field.json`.
    Text(String),
    /// A polynomial in x, y and z.
    Polynomial {
        /// For example `1 + 2*x^2 - y*z`.
        polynomial: String,
    },
    /// Vertex data of tetrahedra.
    Data {
        /// The field's name in the file.
        data: String,
    },
    /// The wanted edge length h of the cells: density h^−(3+p).
    Size {
        /// The name of the vertex data of tetrahedra, else a polynomial or another formula.
        size: String,
    },
}

impl SceneDensity {
    /// The polynomial of a density in the plane.
    ///
    /// # Errors
    /// [`Error::Value`] for other densities and for text that is no polynomial.
    pub(crate) fn in_plane(&self) -> Result<Polynomial, Error> {
        let (Self::Text(text) | Self::Polynomial { polynomial: text }) = self else {
            let message = "in the plane a density is a polynomial in x and y, such as \"1 + 8*x\"";
            return Err(Error::value("density", message));
        };
        text.parse()
            .map_err(|error| Error::value("density", format!("`{text}`: {error}")))
    }

    /// The domain with this density, for energies of order `order`, and what was repaired in its
    /// mesh or approximated.
    pub(crate) fn weigh(
        &self,
        domain: &SceneDomain,
        order: u32,
    ) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        let exponent = -3 - order as i32;
        let (text, of_value): (&str, &dyn Fn(f64) -> f64) = match self {
            Self::Text(text) | Self::Polynomial { polynomial: text } => (text, &|value| value),
            Self::Data { data } => (data, &|value| value),
            Self::Size { size } => (size, &|h: f64| h.powi(exponent)),
        };
        let (domain, mut notes): (Box<dyn space::Domain>, _) = match (self, domain) {
            (Self::Text(_) | Self::Data { .. } | Self::Size { .. }, SceneDomain::Tets(mesh)) => {
                let (tets, mut notes) = mesh.tet_solid()?;
                if matches!(self, Self::Data { .. }) || tets.mesh().field(text).is_some() {
                    return Ok((Box::new(by_data(tets, text, of_value)?), notes));
                }
                match over_tets(tets, text, of_value)? {
                    TetField::Weighed(weighed) => return Ok((Box::new(weighed), notes)),
                    TetField::Plain(tets) => (Box::new(tets), std::mem::take(&mut notes)),
                }
            }
            (Self::Data { .. }, _) => {
                let message = "vertex data give the density of a solid only where tetrahedra fill \
                               it, {\"tets\": …}; for other domains give a polynomial, or \
                               {\"size\": polynomial}";
                return Err(Error::value("density", message));
            }
            _ => domain.solid()?,
        };
        let weighted = match (text.parse::<Polynomial>(), self) {
            (Ok(size), Self::Size { .. }) => WeightedDomain::sized(domain, &size, order)?,
            (Ok(density), _) => WeightedDomain::new(domain, density)?,
            (Err(error), Self::Polynomial { .. }) => {
                return Err(Error::value("density", format!("`{text}`: {error}")));
            }
            (Err(_), _) => {
                let sized = matches!(self, Self::Size { .. }).then_some(exponent);
                let (weighted, note) = by_field(domain, &given(text)?, sized)?;
                notes.extend(note);
                weighted
            }
        };
        Ok((Box::new(weighted), notes))
    }

    /// The integral of the density that a size makes where the order counts nothing: ∫ h⁻³, how many cells
    /// of edge h there are.
    pub(crate) fn mass(&self, domain: &SceneDomain) -> Result<f64, Error> {
        let (weighed, _) = self.weigh(domain, 0)?;
        Ok(weighed.mean_density() * weighed.volume())
    }

    /// The field file that the density is read from.
    pub(crate) fn file(&self) -> Option<&Path> {
        let (Self::Text(text) | Self::Size { size: text }) = self else {
            return None;
        };
        text.strip_prefix('@').map(Path::new)
    }

    /// Makes the path of a field file start at `folder`.
    pub(crate) fn anchor(&mut self, folder: &Path) {
        let file = self.file().map(|file| folder.join(file));
        let (Self::Text(text) | Self::Size { size: text }, Some(file)) = (self, file) else {
            return;
        };
        *text = format!("@{}", file.display());
    }
}

/// The density of a text or a field file.
fn given(text: &str) -> Result<Field, Error> {
    match GivenField::read(text) {
        Ok(given) => Ok(given.field),
        Err(FieldError::File(error)) => Err(error),
        Err(error) => Err(Error::value("density", error.to_string())),
    }
}

/// Tetrahedra with a density at their vertices, or without one.
enum TetField {
    Weighed(WeightedDomain),
    Plain(TetSolid),
}

/// The tetrahedra with the density of a text, where that is given at their vertices or clamps such data.
fn over_tets(tets: TetSolid, text: &str, of_value: impl Fn(f64) -> f64) -> Result<TetField, Error> {
    let refused = |error: &dyn std::fmt::Display| Error::value("density", error.to_string());
    if text.parse::<Polynomial>().is_ok() {
        return Ok(TetField::Plain(tets));
    }
    let values = match given(text)? {
        Field::Vertices(values) => values,
        Field::Sampled(formula) => {
            let field = FormulaField::new(&formula, || tets.mesh().boundary());
            let vertices = tets.mesh().vertices.iter();
            vertices.map(|vertex| field.at(vertex, &mut 0)).collect()
        }
        Field::Solid(density @ (SolidDensity::Vertex(_) | SolidDensity::VertexRamp(_))) => {
            let extent = Bounds::of(&tets.mesh().vertices);
            let pieces = linear_pieces(tets.mesh(), &density, &extent);
            let LinearPieces { mesh, densities } = pieces.map_err(|error| refused(&error))?;
            let (mesh, _) = validate_tets(&mesh).map_err(|error| refused(&error))?;
            let values: Vec<f64> = densities.into_iter().map(of_value).collect();
            let weighed = TetSolid::new(&mesh)?.with_density(&values)?;
            return Ok(TetField::Weighed(weighed));
        }
        _ => return Ok(TetField::Plain(tets)),
    };
    if values.len() != tets.mesh().vertices.len() {
        let (values, vertices) = (values.len(), tets.mesh().vertices.len());
        return Err(refused(&FieldError::Vertices { values, vertices }));
    }
    let values: Vec<f64> = values.into_iter().map(of_value).collect();
    Ok(TetField::Weighed(tets.with_density(&values)?))
}

/// The tetrahedra with a function of their data as density.
fn by_data(
    tets: TetSolid,
    name: &str,
    density: impl Fn(f64) -> f64,
) -> Result<WeightedDomain, Error> {
    let mesh = tets.mesh();
    let Some(field) = mesh.field(name) else {
        let known = mesh.vertex_data.iter().map(|field| field.name.as_str());
        let known = known.collect::<Vec<_>>().join(", ");
        let message = format!("the mesh has no vertex data `{name}`; it has: {known}");
        return Err(Error::value("density", message));
    };
    let values = field
        .checked()
        .map_err(|fault| Error::value("density", fault))?;
    let values: Vec<f64> = values.iter().map(|&value| density(value)).collect();
    Ok(tets.with_density(&values)?)
}
