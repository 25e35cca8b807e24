//! The scene on the command line, and what replaces its parts.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use chebloyd::scene::description::Scene;
use chebloyd::scene::norm::Norm;
use chebloyd::scene::overrides::Overrides;
use chebloyd::scene::{read, validate};

use crate::cli::failure::Failure;

/// Which tessellation: a scene, or other sites in it.
#[derive(Debug, Args)]
pub(crate) struct SceneOptions {
    /// The scene [default: 1000 random sites in the unit cube]
    #[arg(value_name = "SCENE.json")]
    scene: Option<PathBuf>,
    /// Take the sites from a .csv, .npy, .xyz, .txt or .json file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["count", "seed"])]
    sites: Option<PathBuf>,
    /// Leave out sites outside the domain instead of refusing them
    #[arg(long)]
    drop_outside: bool,
    /// Number of random sites
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// Seed of random sites, or of a grid's jitter
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The distance to integrate and to minimize
    #[arg(long, value_name = "NORM")]
    norm: Option<NormName>,
    /// The order p of the Chebyshev energy, the integral of the distance to the power p [default: 1]
    #[arg(long, value_name = "P")]
    order: Option<u32>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum NormName {
    /// Chebyshev: cells become near-cubic
    Linf,
    /// Euclidean: the classical control
    L2,
}

impl SceneOptions {
    /// The scene, changed as told by these options and by `others`, and judged.
    pub(crate) fn scene(&self, others: Overrides) -> Result<Scene, Failure> {
        let mut scene = match &self.scene {
            Some(path) => read::unchecked(path).map_err(Failure::input)?,
            None => Scene::embedded(),
        };
        let overrides = Overrides {
            sites: self.sites.clone(),
            drop_outside: self.drop_outside,
            count: self.count,
            seed: self.seed,
            norm: self.norm.map(|name| match name {
                NormName::Linf => Norm::Linf,
                NormName::L2 => Norm::L2,
            }),
            order: self.order,
            ..others
        };
        overrides.apply(&mut scene).map_err(Failure::input)?;
        validate::scene(&scene).map_err(Failure::input)?;
        Ok(scene)
    }
}
