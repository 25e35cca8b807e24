//! Field files (`field.json`): a density as `stand` and `spin` found it, for `--density @field.json`.

use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::domain::SceneDomain;
use crate::scene::error::{Error, json_error};

/// A density over a solid, as a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FieldFile {
    /// The JSON Schema's address, for editors.
    #[serde(rename = "$schema", default, skip_serializing_if = "Option::is_none")]
    pub(crate) schema: Option<String>,
    /// The density.
    pub(crate) density: FieldDensity,
    /// The solid that it was made for: its box, so that prints can be placed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) bounds: Option<FieldBounds>,
}

/// The box of the solid that a field was made for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FieldBounds {
    /// The lowest corner.
    pub(crate) min: [f64; 3],
    /// The highest corner.
    pub(crate) max: [f64; 3],
}

/// The kinds of density that a field file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum FieldDensity {
    /// clamp(low, high, value + gradient·y).
    Clamp {
        /// The least density.
        low: f64,
        /// The greatest density; none is unbounded.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        high: Option<f64>,
        /// What is clamped.
        of: FieldFormula,
    },
    /// Any text that `--density` takes.
    Text(String),
    /// One density for each Voronoi cell of `sites` in `domain`, which is the solid.
    Cells {
        /// The cells' sites.
        sites: Vec<[f64; 3]>,
        /// Their densities, in the same order.
        values: Vec<f64>,
        /// The solid.
        domain: SceneDomain,
    },
    /// Values at the vertices of a tetrahedral mesh, linear in between.
    Vertices {
        /// One for each vertex, in the file's order.
        values: Vec<f64>,
    },
}

/// What a clamp is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum FieldFormula {
    /// value + gradient·y.
    Affine {
        /// At the coordinates' origin.
        value: f64,
        /// Its growth along the axes.
        gradient: [f64; 3],
    },
    /// A polynomial, for densities over points (`print`, `points:N`).
    Polynomial(String),
}

impl FieldFile {
    /// Reads the field at `path`: paths in it absolute, every number finite.
    ///
    /// # Errors
    /// When the file cannot be read or holds no field; names place and mend.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let read = |source| Error::Read {
            path: path.to_owned(),
            source,
        };
        let text = std::fs::read_to_string(path).map_err(read)?;
        if text.trim().is_empty() {
            let message = "the file is empty; a field needs {\"density\": …}";
            return Err(refused(path, message));
        }
        let mut field: Self = serde_json::from_str(&text)
            .map_err(|error| json_error(&error, path, &text, |it| it))?;
        let folder = path.parent().unwrap_or(Path::new("")).join(".");
        let folder = folder.canonicalize().map_err(read)?;
        if let FieldDensity::Cells { domain, .. } = &mut field.density {
            domain.fill_defaults(3);
            domain.anchor(&folder);
        }
        let fault = field.density.fault();
        fault.map_or(Ok(field), |fault| Err(refused(path, &fault)))
    }

    /// The JSON Schema of field files, for editors.
    pub(crate) fn schema() -> serde_json::Value {
        schemars::schema_for!(Self).to_value()
    }
}

impl FieldDensity {
    /// What makes no sense in its numbers.
    fn fault(&self) -> Option<String> {
        match self {
            Self::Clamp {
                low,
                high: Some(high),
                ..
            } if high < low => Some(format!(
                "`density.clamp`: `high` {high} is below `low` {low}; leave `high` out for none"
            )),
            Self::Cells { sites, values, .. }
                if sites.is_empty() || sites.len() != values.len() =>
            {
                Some(format!(
                    "`density.cells` has {} sites and {} values; every site needs one value",
                    sites.len(),
                    values.len()
                ))
            }
            _ => None,
        }
    }
}

fn refused(path: &Path, message: &str) -> Error {
    Error::File {
        path: path.to_owned(),
        message: message.to_owned(),
    }
}
