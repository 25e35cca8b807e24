//! Field files (`field.json`): a density as `stand` and `spin` found it, for `--density @field.json`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::domain::SceneDomain;

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
