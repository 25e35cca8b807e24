//! `chebloyd relax`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use chebloyd::export::run::directory::RunDirectory;
use chebloyd::scene::description::Scene;
use chebloyd::scene::method::MethodName;
use chebloyd::scene::overrides::Overrides;
use chebloyd::scene::validate;

use crate::cli::arguments::Common;
use crate::cli::failure::Failure;
use crate::cli::ground::{Ground, plane, space};
use crate::cli::job::{Description, Job};
use crate::cli::method_options::MethodOptions;
use crate::cli::scene_options::SceneOptions;

/// Relax sites until their cells are near-cubic
///
/// Leaves log.jsonl, run.json, sites.csv, the cells and the convergence curves in a directory.
/// Ctrl-C finishes the iteration under way and leaves complete files; a second one ends at once.
#[derive(Debug, Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// The directory of the run
    #[arg(long, value_name = "DIR", default_value = "relaxed")]
    out: PathBuf,
    /// Replace the run that DIR holds
    #[arg(long)]
    force: bool,
    /// Go on with the run that DIR holds
    #[arg(long, conflicts_with_all = ["force", "scene", "sites", "count", "seed", "norm", "method", "goal", "coarse_to_fine", "order"])]
    #[arg(conflicts_with_all = MethodOptions::NAMES)]
    resume: bool,
    /// How many moves, those before a resumption counted
    #[arg(long, value_name = "K")]
    iterations: Option<u64>,
    /// Stop when movement_percent falls below T
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// How the sites move
    #[arg(long, value_name = "NAME")]
    method: Option<Method>,
    /// What the cells are to become; chooses the method
    #[arg(long, value_name = "NAME", conflicts_with = "method")]
    goal: Option<Goal>,
    /// Relax one site in 8^L first, then split each into eight, L times
    #[arg(long, value_name = "L")]
    coarse_to_fine: Option<u32>,
    #[command(flatten)]
    of_method: MethodOptions,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Method {
    /// Every site moves to its cell's center
    Lloyd,
    /// All sites descend together along the exact global objective
    QuasiNewton,
    /// Descents from noise that falls round by round; the best sites are kept
    Anneal,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Goal {
    /// Every cell a cube, as near as the number of sites allows
    Cubes,
}

pub(crate) fn run(options: &Options, common: Common) -> Result<(), Failure> {
    if options.resume {
        resume(options, common)
    } else {
        start(options, common)
    }
}

fn start(options: &Options, common: Common) -> Result<(), Failure> {
    if !options.force {
        RunDirectory::check_vacant(&options.out).map_err(Failure::input)?;
    }
    let scene = options.scene.scene(options.overrides())?;
    match scene.dimension {
        2 => start_on(&plane(&scene)?, scene, options, common),
        _ => start_on(&space(&scene)?, scene, options, common),
    }
}

fn resume(options: &Options, common: Common) -> Result<(), Failure> {
    let found = RunDirectory::reopen::<Description>(&options.out).map_err(Failure::input)?;
    let (directory, mut description) = (found.directory, found.description);
    let scene = &mut description.scene;
    options.overrides().apply(scene).map_err(Failure::input)?;
    validate::scene(scene).map_err(Failure::input)?;
    match description.scene.dimension {
        2 => Job::resume(&plane(&description.scene)?, directory, description)?.run(common),
        _ => Job::resume(&space(&description.scene)?, directory, description)?.run(common),
    }
}

fn start_on<const D: usize>(
    ground: &impl Ground<D>,
    scene: Scene,
    options: &Options,
    common: Common,
) -> Result<(), Failure> {
    let sites = ground.place(&scene)?;
    Job::start(ground, scene, sites, &options.out)?.run(common)
}

impl Options {
    fn overrides(&self) -> Overrides {
        Overrides {
            iterations: self.iterations,
            tolerance: self.tolerance,
            method: self.method.map(|method| match method {
                Method::Lloyd => MethodName::Lloyd,
                Method::QuasiNewton => MethodName::QuasiNewton,
                Method::Anneal => MethodName::Anneal,
            }),
            is_for_cubes: self.goal.is_some(),
            coarse_to_fine: self.coarse_to_fine,
            of_method: self.of_method.overrides(),
            ..Overrides::default()
        }
    }
}
