//! The scene's `sites`: the keys that name the points to relax.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::error::Error;
use crate::scene::numbers::{dimensions_match, rows_match};

/// A source of sites by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Sites {
    /// Uniformly distributed over the domain.
    Random(Random),
    /// A grid over the domain's bounding box, those of its points that the domain holds.
    Grid(Grid),
    /// The points themselves.
    List(Vec<Vec<f64>>),
    /// A `.csv`, `.npy`, `.xyz`, `.txt` or `.json` file, relative to the scene's folder.
    File(PathBuf),
    /// The points that a program hands over, one after the other; no text names them.
    #[serde(skip)]
    Given(Arc<[f64]>),
}

/// Uniform random sites.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Random {
    /// How many.
    pub count: usize,
    /// The same seed gives the same sites everywhere.
    #[serde(default = "one")]
    pub seed: u64,
}

/// Sites on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Grid cells per axis; a site lies in the middle of each.
    pub counts: Vec<usize>,
    /// The width of the box around a grid cell's middle, in grid cells, over which its site is
    /// spread uniformly: 0 for the exact grid, 1 for anywhere in the grid cell.
    #[serde(default)]
    pub jitter: f64,
    /// The same seed gives the same jitter everywhere.
    #[serde(default = "one")]
    pub seed: u64,
}

impl Sites {
    pub(crate) fn anchor(&mut self, folder: &Path) {
        if let Self::File(path) = self {
            *path = folder.join(&path);
        }
    }

    /// How many sites there will be at most; a file tells only when it is read.
    pub(crate) fn announced(&self) -> Option<u64> {
        match self {
            Self::Random(random) => Some(random.count as u64),
            Self::Grid(grid) => Some(grid.counts.iter().fold(1, |product: u64, &count| {
                product.saturating_mul(count as u64)
            })),
            Self::List(list) => Some(list.len() as u64),
            Self::File(_) | Self::Given(_) => None,
        }
    }

    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        match self {
            Self::Random(random) if random.count == 0 => {
                Err(Error::value("sites.random.count", "0 sites have no cells"))
            }
            Self::Grid(grid) => grid.validate(dimension),
            Self::List(list) if list.is_empty() => {
                Err(Error::value("sites.list", "0 sites have no cells"))
            }
            Self::List(list) => rows_match("sites.list", list, dimension),
            Self::Given(numbers) if numbers.is_empty() => {
                Err(Error::value("sites", "0 sites have no cells"))
            }
            Self::Given(numbers) if !numbers.len().is_multiple_of(dimension) => {
                let message = format!("{} numbers are no points of {dimension}", numbers.len());
                Err(Error::value("sites", message))
            }
            Self::Random(_) | Self::File(_) | Self::Given(_) => Ok(()),
        }
    }
}

impl Grid {
    fn validate(&self, dimension: usize) -> Result<(), Error> {
        dimensions_match("sites.grid.counts", self.counts.len(), dimension)?;
        if self.counts.contains(&0) {
            return Err(Error::value("sites.grid.counts", "0 sites have no cells"));
        }
        if !(0.0..=1.0).contains(&self.jitter) {
            let message = format!("{:?} is not between 0 and 1", self.jitter);
            return Err(Error::value("sites.grid.jitter", message));
        }
        Ok(())
    }
}

fn one() -> u64 {
    1
}
