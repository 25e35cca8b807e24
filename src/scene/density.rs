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
use crate::scene::domain::Domain;
use crate::scene::error::Error;

/// Background density: text, or one of the keys.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the density is a text such as \"1 + 2*x\" or an object with exactly one of the \
                 keys `polynomial`, `data`, `size`"
)]
pub enum Density {
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

impl Density {
    /// The domain with this density, for energies of order `order`, and what was repaired in its
    /// mesh.
    pub(crate) fn weigh(
        &self,
        domain: &Domain,
        order: u32,
    ) -> Result<(Box<dyn space::Domain>, Vec<String>), Error> {
        match (self, domain) {
            (Self::Text(text), Domain::Tets(mesh)) => {
                let (tets, notes) = mesh.tet_solid()?;
                if tets.mesh().data(text).is_none() {
                    return Ok((Box::new(weighted(Box::new(tets), text)?), notes));
                }
                Ok((Box::new(by_data(tets, text, |value| value)?), notes))
            }
            (Self::Text(text) | Self::Polynomial { polynomial: text }, _) => {
                let (domain, notes) = domain.solid()?;
                Ok((Box::new(weighted(domain, text)?), notes))
            }
            (Self::Data { data }, Domain::Tets(mesh)) => {
                let (tets, notes) = mesh.tet_solid()?;
                Ok((Box::new(by_data(tets, data, |value| value)?), notes))
            }
            (Self::Size { size }, Domain::Tets(mesh)) => {
                let (tets, notes) = mesh.tet_solid()?;
                if tets.mesh().data(size).is_none() {
                    return Ok((Box::new(sized(Box::new(tets), size, order)?), notes));
                }
                let density = |h: f64| h.powi(-3 - order as i32);
                Ok((Box::new(by_data(tets, size, density)?), notes))
            }
            (Self::Size { size }, _) => {
                let (domain, notes) = domain.solid()?;
                Ok((Box::new(sized(domain, size, order)?), notes))
            }
            (Self::Data { .. }, _) => {
                let message = "values at vertices tell of a solid's interior only where \
                               tetrahedra fill it, {\"tets\": …}; for other domains give a \
                               polynomial, or {\"size\": polynomial}";
                Err(Error::value("density", message))
            }
        }
    }
}

/// The domain with the density that the text says.
fn weighted(domain: Box<dyn space::Domain>, text: &str) -> Result<WeightedDomain, Error> {
    Ok(WeightedDomain::new(domain, polynomial(text)?)?)
}

/// The domain with the density for cells of the size that the text says.
fn sized(domain: Box<dyn space::Domain>, text: &str, order: u32) -> Result<WeightedDomain, Error> {
    Ok(WeightedDomain::sized(domain, &polynomial(text)?, order)?)
}

/// The tetrahedra with a function of their data as density.
fn by_data(
    tets: TetSolid,
    name: &str,
    density: impl Fn(f64) -> f64,
) -> Result<WeightedDomain, Error> {
    let mesh = tets.mesh();
    let Some(values) = mesh.data(name) else {
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
    let values: Vec<f64> = values.iter().map(|&value| density(value)).collect();
    Ok(tets.with_density(&values)?)
}

fn polynomial(text: &str) -> Result<Polynomial, Error> {
    text.parse()
        .map_err(|error| Error::value("density", format!("`{text}`: {error}")))
}
