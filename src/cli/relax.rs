//! `chebloyd relax`: a run in a directory, new or taken up again.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use crate::cli::failure::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::options::{
    Common, MethodOptions, SceneOptions, change, finite, given, given_values, named, space,
};
use crate::cli::output::OutputRule;
use crate::cli::plot::{Ends, range};
use crate::cli::run::{FiledRun, RunDescription};
use crate::export::run::directory::RunDirectory;
use crate::scene::overrides::Overrides;
use crate::scene::run::plane;

pub(crate) const METHODS: [(&str, &str); 3] = [
    ("lloyd", "Every site moves to its cell's center"),
    (
        "quasi-newton",
        "All sites descend together along the exact global objective",
    ),
    (
        "anneal",
        "Descents from noise that falls round by round; the best sites are kept",
    ),
];

const GOALS: [(&str, &str); 3] = [
    (
        "cubes",
        "Every cell a cube, as near as the number of sites allows",
    ),
    (
        "mesh",
        "Cells to mesh with, in rows along the axes: random sites become a lattice first",
    ),
    ("squares", "In the plane: every cell a square"),
];

/// Relax sites until their cells are near-cubic
///
/// Leaves log.jsonl, run.json, sites.csv, the cells and the convergence curves in a directory.
/// Ctrl-C finishes the iteration under way and leaves complete files, with every site in sites.csv; a
/// second one ends at once.
#[derive(Debug, Args)]
pub(crate) struct RelaxOptions {
    #[command(flatten)]
    scene: SceneOptions,
    /// The directory of the run
    #[arg(long, value_name = "DIR", default_value = "relaxed")]
    out: PathBuf,
    /// Replace the run and the files that DIR holds, but never a file that this run reads
    #[arg(long)]
    force: bool,
    /// Go on with the run that DIR holds
    #[arg(long, conflicts_with_all = ["force", "method", "goal", "coarse_to_fine", "SceneOptions", "MethodOptions"])]
    resume: bool,
    /// How many moves, those before a resumption counted
    #[arg(long, value_name = "K")]
    iterations: Option<u64>,
    /// Stop when movement_percent falls below T
    #[arg(long, value_name = "T", value_parser = finite)]
    tolerance: Option<f64>,
    /// How the sites move
    #[arg(long, value_name = "NAME", value_parser = named(&METHODS))]
    method: Option<String>,
    /// What the cells are to become; chooses the method
    #[arg(long, value_name = "NAME", conflicts_with = "method", value_parser = named(&GOALS))]
    goal: Option<String>,
    /// Relax one site in 8^L first, then split each into eight, L times (in the plane four)
    #[arg(long, value_name = "L")]
    coarse_to_fine: Option<u32>,
    /// The energies in percent that the colors of cells.svg and cells.png span, such as 100,110; with
    /// --resume an ended run's pictures are drawn anew [default: those of most cells]
    #[arg(long, value_name = "LO,HI", value_parser = range, allow_hyphen_values = true)]
    range: Option<Ends>,
    /// Write no cells.vtu
    #[arg(long)]
    no_cells_file: bool,
    /// Write no pictures: neither cells.png and cells.svg nor convergence.svg
    #[arg(long)]
    no_pictures: bool,
    /// Compress cells.vtu by zlib
    #[arg(long, conflicts_with = "no_cells_file")]
    compress: bool,
    /// Print what run.json holds at the end, as one JSON object, instead of a summary
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    of_method: MethodOptions,
}

pub(crate) fn run(options: &RelaxOptions, common: Common) -> Result<(), Failure> {
    if options.resume {
        resume(options, common)
    } else {
        start(options, common)
    }
}

fn start(options: &RelaxOptions, common: Common) -> Result<(), Failure> {
    let interrupt = Interrupt::listen()?;
    if !options.force {
        RunDirectory::check_vacant(&options.out).map_err(Failure::input)?;
    }
    let mut scene = options.scene.scene(options.overrides())?;
    scene.output.range = options.range.map(|ends| ends.0).or(scene.output.range);
    check_goal(options.goal.as_deref(), scene.dimension)?;
    if options.goal.as_deref() == Some("mesh") {
        scene.set_mesh_start(options.iterations);
    }
    let inputs = options.scene.inputs(&scene);
    check_outputs(&options.out, &inputs, options.force)?;
    if scene.dimension == 2 {
        let plane = plane(&scene).map_err(Failure::input)?;
        return FiledRun::start(&plane, scene, &options.out, interrupt)?.run(common, options.json);
    }
    FiledRun::start(&space(&scene)?, scene, &options.out, interrupt)?.run(common, options.json)
}

/// Refuses the goal of the other dimension.
fn check_goal(goal: Option<&str>, dimension: usize) -> Result<(), Failure> {
    match (goal, dimension) {
        (Some(goal @ ("cubes" | "mesh")), 2) => Err(Failure::input(format!(
            "--goal {goal} is for sites in space, the scene has \"dimension\": 2; say --goal squares",
        ))),
        (Some("squares"), 3) => Err(Failure::input(
            "--goal squares is for sites in the plane; say --goal cubes, or set \"dimension\": 2 in the scene",
        )),
        _ => Ok(()),
    }
}

/// Refuses a directory in which a run would replace other files than it may.
pub(crate) fn check_outputs(out: &Path, inputs: &[PathBuf], force: bool) -> Result<(), Failure> {
    let mut outputs = RunDirectory::files(out);
    if !force {
        outputs.retain(|file| !RunDirectory::is_empty_log(file));
    }
    let rule = OutputRule {
        inputs,
        force,
        option: "--out",
    };
    rule.check(&outputs)
}

fn resume(options: &RelaxOptions, common: Common) -> Result<(), Failure> {
    let interrupt = Interrupt::listen()?;
    let found = RunDirectory::reopen::<RunDescription>(&options.out).map_err(Failure::input)?;
    let (directory, mut description) = (found.directory, found.description);
    change(&mut description.scene, &options.overrides())?;
    let range = options.range.map(|ends| ends.0);
    description.scene.output.range = range.or(description.scene.output.range);
    check_outputs(&options.out, &description.scene.files(), true)?;
    if description.scene.dimension == 2 {
        let plane = plane(&description.scene).map_err(Failure::input)?;
        return FiledRun::resume(&plane, directory, description, interrupt)?
            .run(common, options.json);
    }
    let space = space(&description.scene)?;
    FiledRun::resume(&space, directory, description, interrupt)?.run(common, options.json)
}

impl RelaxOptions {
    fn overrides(&self) -> Overrides {
        let mut overrides = Overrides {
            scene: given(json!({
                "method": self.method, "coarse_to_fine": self.coarse_to_fine,
            })),
            method: given(&self.of_method),
            ..Overrides::default()
        };
        match self.goal.as_deref() {
            None => {}
            Some("mesh") => overrides.set_mesh(),
            Some(_) => overrides.set_cubes(),
        }
        let unless = |is_off: bool| is_off.then_some(false);
        overrides.output = given_values(json!({
            "cells_file": unless(self.no_cells_file), "pictures": unless(self.no_pictures),
            "compress": self.compress.then_some(true),
        }));
        let ends = json!({ "iterations": self.iterations, "tolerance": self.tolerance });
        overrides.method.extend(given(ends));
        overrides
    }
}
