//! `chebloyd-mpi relax`: a run over the ranks of a job, which leaves the files that `chebloyd relax` leaves.
//!
//! Every rank reads the scene; rank 0 alone writes. A checkpoint of all sites is written every few moves and when
//! a signal asks the run to end, whole or not at all, so that a job that dies loses one interval at most, and goes
//! on with any number of ranks, or as `chebloyd relax --resume`.

use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Args, Parser, Subcommand};
use serde_json::json;

use crate::cli::agreement::together;
use crate::cli::failure::Failure;
use crate::cli::first_rank::FirstRank;
use crate::cli::interrupt::Interrupt;
use crate::cli::options::{change, finite, given, given_values, named, print_notes};
use crate::cli::output::OutputRule;
use crate::cli::ranked_job::{RankedJob, Signals};
use crate::cli::relax::{METHODS, check_outputs};
use crate::cli::run::{RunDescription, check_scene, describe, last_checkpoint};
use crate::export::run::directory::{PIECES, RunDirectory};
use crate::relax::frames::Frames;
use crate::relax::ranks::{Ranks, share_bytes};
use crate::relax::record::Record;
use crate::relax::relaxation::Checkpoint;
use crate::relax::relaxation_space::Norm;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::read;
use crate::scene::run::{self, RunSpace};

/// Relax sites over the ranks of an MPI job
#[derive(Debug, Parser)]
#[command(name = "chebloyd-mpi", version, propagate_version = true)]
struct RanksArguments {
    #[command(subcommand)]
    command: RanksCommand,
}

#[derive(Debug, Subcommand)]
enum RanksCommand {
    Relax(RanksOptions),
}

/// Relax the sites of a scene, distributed over the ranks
///
/// Sites, log and checkpoint have the same bytes, times aside, as those of `chebloyd relax`, for any number of
/// ranks and threads. Lloyd's iteration holds on each rank the rank's own sites and those near to them, every other
/// method all sites. SIGTERM, SIGUSR1 or Ctrl-C to any rank finishes the move under way and leaves a checkpoint.
#[derive(Debug, Args)]
struct RanksOptions {
    /// The scene; with --resume that of the run
    #[arg(value_name = "SCENE.json", required_unless_present = "resume")]
    scene: Option<PathBuf>,
    /// The directory of the run, which all ranks must see
    #[arg(long, value_name = "DIR", default_value = "relaxed")]
    out: PathBuf,
    /// Replace the run that DIR holds
    #[arg(long)]
    force: bool,
    /// Go on with the run that DIR holds
    #[arg(long, conflicts_with_all = ["force", "scene"])]
    resume: bool,
    /// How many moves, those before a resumption counted
    #[arg(long, value_name = "K")]
    iterations: Option<u64>,
    /// Stop when movement_percent falls below T
    #[arg(long, value_name = "T", value_parser = finite)]
    tolerance: Option<f64>,
    /// How the sites move
    #[arg(long, value_name = "NAME", conflicts_with = "resume", value_parser = named(&METHODS))]
    method: Option<String>,
    /// Write no cells: neither cells_R.vtu, one of each rank, nor cells.pvtu
    #[arg(long)]
    no_cells_file: bool,
    /// A checkpoint every K moves [default: the scene's output.checkpoint, else 10]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..))]
    checkpoint: Option<u64>,
    /// Threads of each rank [default: the cores allowed to it, shared by the ranks of its machine]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    threads: Option<u32>,
    /// Tell no progress
    #[arg(long)]
    quiet: bool,
}

/// Runs the command of these arguments, the program's name first, on one rank of several, `neighbors` of which
/// share its cores; returns the exit code, which all ranks agree on but for bad input.
pub fn command_line_over(
    arguments: impl IntoIterator<Item = OsString>,
    ranks: &dyn Ranks,
    neighbors: usize,
) -> u8 {
    let RanksCommand::Relax(options) = RanksArguments::parse_from(arguments).command;
    match relax(&options, ranks, neighbors) {
        Ok(()) => 0,
        Err(failure) => {
            let is_told = matches!(failure, Failure::Interrupted(_)) || ranks.rank() > 0;
            if !is_told {
                // Where stderr is closed the exit code alone remains.
                let _ = writeln!(std::io::stderr(), "error: {failure}");
            }
            failure.code()
        }
    }
}

fn relax(options: &RanksOptions, ranks: &dyn Ranks, neighbors: usize) -> Result<(), Failure> {
    let interrupt = Interrupt::listen()?;
    let signals = Signals {
        keep: keep_flag()?,
        interrupt,
    };
    set_threads(options.threads, neighbors)?;
    let first = (ranks.rank() == 0).then(|| read_run(options, ranks.size()));
    let (first, checkpoint) = together(ranks, first.transpose())?.unzip();
    let (scene, last) = told(ranks, first.as_ref(), checkpoint.as_ref())?;
    let space = together(ranks, space_of(&scene))?;
    signals.interrupt.finish_first();
    let job = RankedJob {
        out: &options.out,
        interval: options.checkpoint.or(scene.output.checkpoint),
        is_quiet: options.quiet,
        ranks,
        neighbors,
        space,
        scene,
        last,
        signals,
    };
    job.run(first, checkpoint)
}

/// What the first rank has read, on all: the scene, and the record after which the run goes on.
fn told(
    ranks: &dyn Ranks,
    first: Option<&FirstRank>,
    checkpoint: Option<&Checkpoint>,
) -> Result<(Scene, Option<Record>), Failure> {
    let last = checkpoint.and_then(|checkpoint| checkpoint.record.clone());
    let told = first.map_or(Ok(Vec::new()), |first| {
        serde_json::to_vec(&(&first.description.scene, &last))
    });
    let told = together(ranks, told.map_err(Failure::run))?;
    let told = share_bytes(ranks, &told).into_iter().next();
    serde_json::from_slice(&told.unwrap_or_default()).map_err(Failure::run)
}

/// In a pool of its own: the thread that calls exchanges messages, those of the pool compute.
fn set_threads(given: Option<u32>, neighbors: usize) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = given.map_or(cores / neighbors.max(1), |count| count as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1));
    pool.build_global().map_err(Failure::run)
}

/// The space of a scene that runs over ranks.
fn space_of(scene: &Scene) -> Result<Space, Failure> {
    if scene.dimension != 3 || scene.cells == Norm::Linf {
        return Err(Failure::input(
            "over ranks there are L2 cells in space only",
        ));
    }
    let (space, _) = run::space(scene).map_err(Failure::input)?;
    match space.frames() {
        Frames::PerSite(_) => Err(Failure::input(
            "over ranks sites have no frames of their own",
        )),
        _ => Ok(space),
    }
}

#[cfg(unix)]
fn keep_flag() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::<AtomicBool>::default();
    let registered = signal_hook::flag::register(signal_hook::consts::SIGUSR1, flag.clone());
    registered.map_err(|error| Failure::run(format!("cannot listen for SIGUSR1: {error}")))?;
    Ok(flag)
}

#[cfg(not(unix))]
fn keep_flag() -> Result<Arc<AtomicBool>, Failure> {
    Ok(Arc::default())
}

/// The run that begins or goes on, its files and its sites; asked of the first rank of `size`.
fn read_run(options: &RanksOptions, size: usize) -> Result<(FirstRank, Checkpoint), Failure> {
    match &options.scene {
        Some(scene) => start(options, scene, size),
        None => resume(options),
    }
}

fn start(
    options: &RanksOptions,
    path: &Path,
    size: usize,
) -> Result<(FirstRank, Checkpoint), Failure> {
    if !options.force {
        RunDirectory::check_vacant(&options.out).map_err(Failure::input)?;
    }
    let (mut scene, notes) = read::noted(path).map_err(Failure::input)?;
    print_notes(&notes);
    change(&mut scene, &options.overrides())?;
    let mut inputs = scene.files();
    inputs.push(path.to_owned());
    check_outputs(&options.out, &inputs, options.force)?;
    check_pieces(options, &inputs, size)?;
    let space = space_of(&scene)?;
    let placed = space.placed(&scene).map_err(Failure::input)?;
    print_notes(&placed.notes);
    let description = describe(&space, scene, &placed)?;
    let directory = RunDirectory::create(&options.out, &description.identity, &description);
    let first = FirstRank {
        directory: directory.map_err(Failure::input)?,
        description,
        last: None,
    };
    Ok((first, Checkpoint::at_start(placed.sites)))
}

/// Refuses pieces that would replace files that they may not.
fn check_pieces(options: &RanksOptions, inputs: &[PathBuf], size: usize) -> Result<(), Failure> {
    let names = (0..size)
        .map(RunDirectory::piece)
        .chain([PIECES.to_owned()]);
    let files: Vec<_> = names.map(|name| options.out.join(name)).collect();
    let rule = OutputRule {
        inputs,
        force: options.force,
        option: "--out",
    };
    rule.check(&files)
}

fn resume(options: &RanksOptions) -> Result<(FirstRank, Checkpoint), Failure> {
    let found = RunDirectory::reopen::<RunDescription>(&options.out).map_err(Failure::input)?;
    let (mut directory, mut description) = (found.directory, found.description);
    change(&mut description.scene, &options.overrides())?;
    check_scene(&description, directory.path())?;
    let space = space_of(&description.scene)?;
    let checkpoint = last_checkpoint(&space, &mut directory, &description)?;
    (description.ended, description.last) = (None, None);
    directory.describe(&description).map_err(Failure::input)?;
    let first = FirstRank {
        directory,
        description,
        last: checkpoint.record.clone(),
    };
    Ok((first, checkpoint))
}

impl RanksOptions {
    fn overrides(&self) -> Overrides {
        let ends = json!({ "iterations": self.iterations, "tolerance": self.tolerance });
        let no_cells = self.no_cells_file.then_some(false);
        Overrides {
            scene: given(json!({ "method": self.method })),
            method: given(ends),
            output: given_values(json!({ "cells_file": no_cells })),
            ..Overrides::default()
        }
    }
}
