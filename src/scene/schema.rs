//! The scene's JSON Schema, for editors.

use crate::scene::description::Scene;

/// The JSON Schema of [`Scene`].
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(Scene).to_value()
}
