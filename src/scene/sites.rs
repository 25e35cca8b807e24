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

/// Uniform random sites, or a lattice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Random {
    /// How many.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// In place of the count: the length of a cell's edge. There are as many sites as cubes of this edge
    /// fill the domain; in a box the product of the sides' own rounded counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<f64>,
    /// The same seed gives the same sites everywhere.
    #[serde(default = "one")]
    pub seed: u64,
    /// Whether the sites are those points of the cubic lattice over the domain's bounding box that the
    /// domain holds, as many as come nearest to the count, without those whose cells are slivers. With one frame for
    /// all cells the lattice and the box are along its axes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub lattice: bool,
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
            Self::Random(random) => random.count.map(|count| count as u64),
            Self::Grid(grid) => Some(grid.counts.iter().fold(1, |product: u64, &count| {
                product.saturating_mul(count as u64)
            })),
            Self::List(list) => Some(list.len() as u64),
            Self::File(_) | Self::Given(_) => None,
        }
    }

    /// Makes random sites those of a lattice.
    pub(crate) fn set_lattice(&mut self) {
        if let Self::Random(random) = self {
            random.lattice = true;
        }
    }

    /// Whether they are those of a lattice.
    pub(crate) fn is_lattice(&self) -> bool {
        matches!(self, Self::Random(random) if random.lattice)
    }

    /// Whether they are counted by the edge of a cell.
    pub(crate) fn has_edge(&self) -> bool {
        matches!(self, Self::Random(random) if random.edge.is_some())
    }

    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        match self {
            Self::Random(random) => random.validate(dimension),
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
            Self::File(_) | Self::Given(_) => Ok(()),
        }
    }
}

impl Random {
    fn validate(&self, dimension: usize) -> Result<(), Error> {
        let refused =
            |key: &str, message: &str| Err(Error::value(format!("sites.random.{key}"), message));
        match (self.count, self.edge) {
            (Some(0), _) => refused("count", "0 sites have no cells"),
            (Some(_), Some(_)) => {
                refused("edge", "the count says it already; leave one of them out")
            }
            (None, None) => refused(
                "count",
                "is missing; say how many sites, or the `edge` of a cell",
            ),
            (None, Some(edge)) if !(edge > 0.0 && edge.is_finite()) => {
                refused("edge", &format!("{edge:?} is not a positive length"))
            }
            (None, Some(_)) if dimension != 3 => {
                refused("edge", "is for sites in space; say a `count` in the plane")
            }
            _ => Ok(()),
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
