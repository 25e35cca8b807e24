//! `chebloyd-mpi relax`: a run over the ranks of a job, which leaves the files that `chebloyd relax` leaves.
//!
//! Every rank reads the scene; rank 0 alone writes. A checkpoint of all sites is written every few moves and when
//! a signal asks the run to end, whole or not at all, so that a job that dies loses one interval at most, and goes
//! on with any number of ranks, or as `chebloyd relax --resume`.

use std::ffi::OsString;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::{Args, Parser, Subcommand};
use nalgebra::Point3;
use serde_json::json;

use crate::cli::failure::{Failure, write_file};
use crate::cli::interrupt::Interrupt;
use crate::cli::options::{change, finite, given, print_notes};
use crate::cli::relax::check_outputs;
use crate::cli::run::{RunDescription, describe, last_checkpoint};
use crate::export::run::directory::RunDirectory;
use crate::export::run::error::RunError;
use crate::export::sites::write_csv;
use crate::relax::driver::RunEnd;
use crate::relax::frames::Frames;
use crate::relax::ranks::{RankedRun, Ranks};
use crate::relax::record::Record;
use crate::relax::relaxation_space::Norm;
use crate::relax::space::Space;
use crate::relax::state::RunState;
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::read;
use crate::scene::run::{self, RunSpace, plan};

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

/// Relax the sites of a scene by Lloyd's iteration, distributed over the ranks
///
/// Sites, log and checkpoint have the same bytes, times aside, as those of `chebloyd relax`, for any number of
/// ranks and threads. SIGTERM, SIGUSR1 or Ctrl-C to any rank finishes the move under way and leaves a checkpoint.
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
    /// A checkpoint every K moves
    #[arg(long, value_name = "K", default_value = "10", value_parser = clap::value_parser!(u64).range(1..))]
    checkpoint: u64,
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
    let first = (ranks.rank() == 0).then(|| FirstRank::read(options));
    let first = together(ranks, first.transpose())?;
    let told = first
        .as_ref()
        .map(|first| serde_json::to_vec(&(&first.description.scene, &first.last)));
    let told = together(ranks, told.transpose().map_err(Failure::run))?;
    let told = broadcast(ranks, told.unwrap_or_default());
    let (scene, last): (Scene, Option<Record>) =
        serde_json::from_slice(&told).map_err(Failure::run)?;
    let space = together(ranks, space_of(&scene))?;
    signals.interrupt.finish_first();
    let job = RankedJob {
        options,
        ranks,
        space,
        scene,
        last,
        signals,
    };
    job.run(first)
}

/// In a pool of its own: the thread that calls exchanges messages, those of the pool compute.
fn set_threads(given: Option<u32>, neighbors: usize) -> Result<(), Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = given.map_or(cores / neighbors.max(1), |count| count as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1));
    pool.build_global().map_err(Failure::run)
}

/// What every rank has, or a failure on all if there is one on any.
fn together<T>(ranks: &dyn Ranks, own: Result<T, Failure>) -> Result<T, Failure> {
    let mut code = [own
        .as_ref()
        .map_or_else(|failure| f64::from(failure.code()), |_| 0.0)];
    ranks.largest(&mut code);
    match own {
        Ok(_) if code[0] >= BAD_INPUT => Err(Failure::input("another rank says why")),
        Ok(_) if code[0] > 0.0 => Err(Failure::run("another rank says why")),
        own => own,
    }
}

/// The bytes that rank 0 has.
fn broadcast(ranks: &dyn Ranks, bytes: Vec<u8>) -> Vec<u8> {
    let mut words = vec![bytes.len() as u64];
    words.extend(bytes.chunks(8).map(|chunk| {
        let mut word = [0; 8];
        word[..chunk.len()].copy_from_slice(chunk);
        u64::from_le_bytes(word)
    }));
    let parts = match ranks.rank() {
        0 => vec![words; ranks.size()],
        _ => vec![Vec::new(); ranks.size()],
    };
    let came = ranks.exchange(parts).into_iter().next().unwrap_or_default();
    let (length, words) = came
        .split_first()
        .map_or((0, &[][..]), |(length, words)| (*length, words));
    let mut bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.truncate(length as usize);
    bytes
}

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

/// What has been asked of this rank from outside.
struct Signals {
    interrupt: Interrupt,
    /// Whether a checkpoint is wanted.
    keep: Arc<AtomicBool>,
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

/// The files and all sites, which rank 0 holds.
struct FirstRank {
    directory: RunDirectory,
    description: RunDescription,
    sites: Vec<Point3<f64>>,
    last: Option<Record>,
}

impl FirstRank {
    fn read(options: &RanksOptions) -> Result<Self, Failure> {
        match &options.scene {
            Some(scene) => Self::start(options, scene),
            None => Self::resume(options),
        }
    }

    fn start(options: &RanksOptions, path: &Path) -> Result<Self, Failure> {
        if !options.force {
            RunDirectory::check_vacant(&options.out).map_err(Failure::input)?;
        }
        let (mut scene, notes) = read::noted(path).map_err(Failure::input)?;
        print_notes(&notes);
        change(&mut scene, &options.overrides())?;
        let mut inputs = scene.files();
        inputs.push(path.to_owned());
        check_outputs(&options.out, &inputs, options.force)?;
        let space = space_of(&scene)?;
        let placed = space.placed(&scene).map_err(Failure::input)?;
        print_notes(&placed.notes);
        let description = describe(&space, scene, &placed)?;
        let directory = RunDirectory::create(&options.out, &description.identity, &description);
        Ok(Self {
            directory: directory.map_err(Failure::input)?,
            description,
            sites: placed.sites,
            last: None,
        })
    }

    fn resume(options: &RanksOptions) -> Result<Self, Failure> {
        let found = RunDirectory::reopen::<RunDescription>(&options.out).map_err(Failure::input)?;
        let (mut directory, mut description) = (found.directory, found.description);
        change(&mut description.scene, &options.overrides())?;
        let space = space_of(&description.scene)?;
        let checkpoint = last_checkpoint(&space, &mut directory, &description)?;
        description.ended = None;
        directory.describe(&description).map_err(Failure::input)?;
        Ok(Self {
            directory,
            description,
            sites: checkpoint.sites,
            last: checkpoint.record,
        })
    }

    /// Appends a record to the log; with all sites also writes a checkpoint.
    fn keep(&mut self, record: &Record, sites: Option<&[Point3<f64>]>) -> Result<(), RunError> {
        let is_new = self
            .last
            .as_ref()
            .is_none_or(|last| last.iteration < record.iteration);
        if is_new {
            self.directory.log().append(record)?;
            self.last = Some(record.clone());
        }
        let Some(sites) = sites else { return Ok(()) };
        let state = RunState::<3>::of_lloyd(sites.len(), record).to_numbers();
        self.directory.keep(record, sites, &state)
    }

    /// The last sites, and why the run ended.
    fn end(&mut self, sites: &[Point3<f64>], ended: &str) -> Result<(), Failure> {
        if let Some(last) = self.last.clone() {
            self.keep(&last, Some(sites)).map_err(Failure::run)?;
            self.description.seconds = last.seconds;
        }
        let file = self.directory.file("sites.csv");
        write_file(&file, |file| write_csv(sites, file)).map_err(Failure::run)?;
        self.description.ended = Some(ended.to_owned());
        self.directory
            .describe(&self.description)
            .map_err(Failure::run)
    }
}

/// A run whose input has been read, as one rank sees it.
struct RankedJob<'a> {
    options: &'a RanksOptions,
    ranks: &'a dyn Ranks,
    space: Space,
    scene: Scene,
    last: Option<Record>,
    signals: Signals,
}

impl RankedJob<'_> {
    fn run(&self, mut first: Option<FirstRank>) -> Result<(), Failure> {
        let sites = first.as_mut().map(|first| std::mem::take(&mut first.sites));
        let count = broadcast(
            self.ranks,
            sites
                .as_ref()
                .map_or(Vec::new(), |sites| sites.len().to_string().into()),
        );
        let count = String::from_utf8_lossy(&count)
            .parse()
            .map_err(Failure::run)?;
        let plan = plan(&self.scene, count);
        let run = RankedRun::new(self.ranks, &self.space, &plan, sites, self.last.as_ref());
        let mut run = run.map_err(Failure::input)?;
        let mut failure = None;
        let mut observe = |record: &Record, run: &RankedRun<'_>| {
            let is_stopped = run.any(self.signals.interrupt.exit_code().is_some());
            let is_asked = run.any(self.signals.keep.swap(false, Ordering::SeqCst));
            let is_due =
                is_stopped || is_asked || record.iteration.is_multiple_of(self.options.checkpoint);
            let sites = is_due.then(|| run.gathered()).flatten();
            if let Some(first) = &mut first {
                self.show(record);
                failure = first.keep(record, sites.as_deref()).err();
            }
            match is_stopped | run.any(failure.is_some()) {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let ended = run
            .run(self.last.as_ref(), &mut observe)
            .map_err(Failure::run)?;
        if let Some(failure) = failure {
            return Err(Failure::run(failure));
        }
        let sites = run.gathered().unwrap_or_default();
        let last = first.map_or(Ok(()), |mut first| first.end(&sites, named(ended)));
        together(self.ranks, last)?;
        match ended {
            RunEnd::Interrupted => {
                let code = self.signals.interrupt.exit_code();
                Err(Failure::Interrupted(code.unwrap_or(TERMINATED)))
            }
            _ => Ok(()),
        }
    }

    fn show(&self, record: &Record) {
        if !self.options.quiet {
            let Record {
                iteration,
                energy_percent,
                movement_percent,
                seconds,
                ..
            } = record;
            let line = format!(
                "{iteration}: energy {energy_percent:.4} %, movement {movement_percent:.4} %, {seconds:.1} s"
            );
            // Where stderr is closed nothing is told.
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }
}

/// The exit code of bad input.
const BAD_INPUT: f64 = 2.0;

/// The exit code of SIGTERM, where another rank received the signal.
const TERMINATED: u8 = 143;

fn named(ended: RunEnd) -> &'static str {
    match ended {
        RunEnd::Iterations => "iterations",
        RunEnd::Tolerance => "tolerance",
        RunEnd::Interrupted => "interrupted",
    }
}

impl RanksOptions {
    fn overrides(&self) -> Overrides {
        let ends = json!({ "iterations": self.iterations, "tolerance": self.tolerance });
        Overrides {
            method: given(ends),
            ..Overrides::default()
        }
    }
}
