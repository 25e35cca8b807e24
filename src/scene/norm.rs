//! The scene's `norm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::relax::relaxation_space;

/// The distance a site minimizes over its cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Norm {
    /// The Chebyshev distance: cells become near-cubic.
    #[default]
    Linf,
    /// The Euclidean distance: the classical control.
    L2,
}

impl From<Norm> for relaxation_space::Norm {
    fn from(norm: Norm) -> Self {
        match norm {
            Norm::Linf => Self::Linf,
            Norm::L2 => Self::L2,
        }
    }
}
