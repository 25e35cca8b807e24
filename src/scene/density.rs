//! The scene's `density`: the weight of the domain's volume in the energies.
//!
//! A polynomial holds for any domain, and so does a size that is one. Values at tetrahedron
//! vertices, be they densities or sizes, make a density that is linear on every tetrahedron.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::domain::domain as space;
use crate::domain::domain::WeightedDomain;
use crate::domain::tet_mesh::TetSolid;
use crate::integrals::polynomial::Polynomial;
use crate::scene::domain::SceneDomain;
use crate::scene::error::Error;

/// Background density: text, or one of the keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the density is a text such as \"1 + 2*x\" or an object with exactly one of the \
                 keys `polynomial`, `data`, `size`"
)]
pub enum SceneDensity {
    /// The name of the vertex data of tetrahedra, else a polynomial.
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
        /// The name of the vertex data of tetrahedra, else a polynomial.
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
    /// mesh.
    pub(crate) fn weigh(
        &self,
        domain: &SceneDomain,
        order: u32,
    ) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        let (text, of_value): (&str, &dyn Fn(f64) -> f64) = match self {
            Self::Text(text) | Self::Polynomial { polynomial: text } => (text, &|value| value),
            Self::Data { data } => (data, &|value| value),
            Self::Size { size } => (size, &|h: f64| h.powi(-3 - order as i32)),
        };
        let (domain, notes): (Box<dyn space::Domain>, _) = match (self, domain) {
            (Self::Text(_) | Self::Data { .. } | Self::Size { .. }, SceneDomain::Tets(mesh)) => {
                let (tets, notes) = mesh.tet_solid()?;
                if matches!(self, Self::Data { .. }) || tets.mesh().field(text).is_some() {
                    return Ok((Box::new(by_data(tets, text, of_value)?), notes));
                }
                (Box::new(tets), notes)
            }
            (Self::Data { .. }, _) => {
                let message = "vertex data give the density of a solid only where tetrahedra fill \
                               it, {\"tets\": …}; for other domains give a polynomial, or \
                               {\"size\": polynomial}";
                return Err(Error::value("density", message));
            }
            _ => domain.solid()?,
        };
        let polynomial: Polynomial = text
            .parse()
            .map_err(|error| Error::value("density", format!("`{text}`: {error}")))?;
        let weighted = match self {
            Self::Size { .. } => WeightedDomain::sized(domain, &polynomial, order)?,
            _ => WeightedDomain::new(domain, polynomial)?,
        };
        Ok((Box::new(weighted), notes))
    }
}

/// The tetrahedra with a function of their data as density.
fn by_data(
    tets: TetSolid,
    name: &str,
    density: impl Fn(f64) -> f64,
) -> Result<WeightedDomain, Error> {
    let mesh = tets.mesh();
    let Some(field) = mesh.field(name) else {
        let known: Vec<&str> = mesh
            .vertex_data
            .iter()
            .map(|field| field.name.as_str())
            .collect();
        let message = format!(
            "the mesh has no vertex data `{name}`; it has: {}",
            known.join(", ")
        );
        return Err(Error::value("density", message));
    };
    let values = field
        .checked()
        .map_err(|fault| Error::value("density", fault))?;
    let values: Vec<f64> = values.iter().map(|&value| density(value)).collect();
    Ok(tets.with_density(&values)?)
}
