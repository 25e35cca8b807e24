//! The scene's `output`: which files a run leaves besides its log and its sites.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which files a run leaves besides `log.jsonl`, `run.json` and `sites.csv`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// The cells: `cells.vtu` in space, and a picture of them.
    pub cells: bool,
    /// The energy and movement curves: `convergence.svg`.
    pub plot: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            cells: true,
            plot: true,
        }
    }
}
