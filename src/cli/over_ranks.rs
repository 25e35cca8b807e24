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
use crate::cli::identity::of_scene;
use crate::cli::interrupt::Interrupt;
use crate::cli::options::{change, finite, given, given_values, named, print_notes};
use crate::cli::output::OutputRule;
use crate::cli::ranked_job::{RankedJob, Signals};
use crate::cli::ranked_place::{Counted, PlacedPart, place};
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
use crate::scene::run;

/// Moves between two checkpoints, where nobody says how many.
const MOVES_PER_CHECKPOINT: u64 = 10;

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
    /// Print what each rank has done in Lloyd's iteration, one JSON object a line: diagrams, own and halo sites over
    /// all of them, bytes that came, CPU seconds of indexes and cells, seconds of exchanges with their waits, bytes
    #[arg(long)]
    timings: bool,
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
    let found = (ranks.rank() == 0).then(|| Found::read(options, ranks.size()));
    let mut found = together(ranks, found.transpose())?;
    let (scene, last) = told(ranks, found.as_ref())?;
    let space = together(ranks, space_of(&scene))?;
    let placed = match &mut found {
        Some(found) if options.resume => PlacedPart::resumed(found),
        _ if options.resume => PlacedPart::default(),
        _ => place(ranks, &space, &scene)?,
    };
    let (sites, counted) = placed.distributed(ranks, &space)?;
    let fits = run::check_memory_over_ranks(&scene, counted.sites, [ranks.size(), neighbors]);
    together(ranks, fits.map_err(Failure::input))?;
    let begun = found.map(|found| found.begin(options, &space, counted));
    let (first, state) = together(ranks, begun.transpose())?.unzip();
    signals.interrupt.finish_first();
    let job = RankedJob {
        out: &options.out,
        interval: options.interval(&scene),
        tells_timings: options.timings,
        is_quiet: options.quiet,
        ranks,
        space: &space,
        scene,
        last,
        signals,
    };
    job.run(first, sites, state.unwrap_or_default())
}

/// What the first rank has read, on all: the scene, and the record after which the run goes on.
fn told(ranks: &dyn Ranks, found: Option<&Found>) -> Result<(Scene, Option<Record>), Failure> {
    let told = found.map_or(Ok(Vec::new()), |found| {
        let checkpoint = found.resumed.as_ref().map(|(_, checkpoint)| checkpoint);
        let last = checkpoint.and_then(|checkpoint| checkpoint.record.as_ref());
        serde_json::to_vec(&(&found.scene, last))
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

/// What the first rank has found: a scene, or a run that goes on.
struct Found {
    scene: Scene,
    resumed: Option<(FirstRank, Checkpoint)>,
}

impl Found {
    fn read(options: &RanksOptions, size: usize) -> Result<Self, Failure> {
        match &options.scene {
            Some(scene) => Self::scene(options, scene, size),
            None => Self::run(options),
        }
    }

    fn scene(options: &RanksOptions, path: &Path, size: usize) -> Result<Self, Failure> {
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
        let resumed = None;
        Ok(Self { scene, resumed })
    }

    fn run(options: &RanksOptions) -> Result<Self, Failure> {
        let found = RunDirectory::reopen::<RunDescription>(&options.out);
        let found = found.map_err(Failure::input)?;
        let (mut directory, mut description) = (found.directory, found.description);
        change(&mut description.scene, &options.overrides())?;
        check_scene(&description, directory.path())?;
        let space = space_of(&description.scene)?;
        let checkpoint = last_checkpoint(&space, &mut directory, &description)?;
        (description.ended, description.last) = (None, None);
        directory.describe(&description).map_err(Failure::input)?;
        let scene = description.scene.clone();
        let last = checkpoint.record.clone();
        let first = FirstRank {
            directory,
            description,
            last,
        };
        let resumed = Some((first, checkpoint));
        Ok(Self { scene, resumed })
    }

    /// The files of the run, and what its method remembers.
    fn begin(
        self,
        options: &RanksOptions,
        space: &Space,
        counted: Counted,
    ) -> Result<(FirstRank, Vec<f64>), Failure> {
        if let Some((first, checkpoint)) = self.resumed {
            return Ok((first, checkpoint.state_numbers()));
        }
        let identity = format!("{}-{}", of_scene(&self.scene)?, counted.sum);
        let counts = [counted.sites, counted.dropped];
        let description = describe(space, self.scene, counts, identity)?;
        let directory = RunDirectory::create(&options.out, &description.identity, &description);
        let first = FirstRank {
            directory: directory.map_err(Failure::input)?,
            description,
            last: None,
        };
        Ok((first, Vec::new()))
    }
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

impl PlacedPart {
    /// The sites of a run that goes on, which the first rank has.
    fn resumed(found: &mut Found) -> Self {
        let checkpoint = found.resumed.as_mut().map(|(_, checkpoint)| checkpoint);
        let sites = checkpoint.map(|checkpoint| std::mem::take(&mut checkpoint.sites));
        Self::of_first(sites.unwrap_or_default())
    }
}

impl RanksOptions {
    /// Moves between two checkpoints.
    fn interval(&self, scene: &Scene) -> u64 {
        let given = self.checkpoint.or(scene.output.checkpoint);
        given.unwrap_or(MOVES_PER_CHECKPOINT)
    }

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
