//! A run from its first record to its last file, or from where an earlier process left it.

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::Point;

use chebloyd::export::log::read_log;
use chebloyd::export::run::description;
use chebloyd::export::run::directory::RunDirectory;
use chebloyd::export::run::error::RunError;
use chebloyd::export::{sites, whole_file};
use chebloyd::plot::convergence::{Run, convergence};
use chebloyd::plot::svg::svg;
use chebloyd::relax::driver::{RunEnd, drive};
use chebloyd::relax::metrics::{CellFigures, Figures};
use chebloyd::relax::record::{Record, optimal_energy};
use chebloyd::relax::state::RunState;
use chebloyd::scene::description::Scene;
use chebloyd::scene::plan::plan;

use crate::cli::arguments::Common;
use crate::cli::failure::Failure;
use crate::cli::ground::Ground;
use crate::cli::interrupt;
use crate::cli::progress::Progress;
use crate::cli::question::question;
use crate::cli::stdout;
use crate::cli::summary::{INTERRUPTED, summary};

/// What `run.json` holds.
pub(crate) type Description = description::Description<Scene, Figures>;

/// A run that is about to begin or to go on.
pub(crate) struct Job<'a, const D: usize, G> {
    ground: &'a G,
    directory: RunDirectory,
    description: Description,
    sites: Vec<Point<f64, D>>,
    /// The last record in the log, which describes `sites`; none at the beginning.
    last: Option<Record>,
    /// The state of the run after that record.
    state: RunState<D>,
}

impl<'a, const D: usize, G: Ground<D>> Job<'a, D, G> {
    /// A new run in the directory `out`.
    pub(crate) fn start(
        ground: &'a G,
        scene: Scene,
        sites: Vec<Point<f64, D>>,
        out: &Path,
    ) -> Result<Self, Failure> {
        let volume = ground.volume();
        let description = Description {
            program: env!("CARGO_PKG_NAME").to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene,
            sites: sites.len(),
            domain_volume: volume,
            optimal_energy: optimal_energy::<D>(volume, sites.len(), 1),
            initial: None,
            last: None,
            ended: None,
            seconds: 0.0,
            threads: rayon::current_num_threads(),
        };
        let state = fresh_state(&description.scene, sites.len());
        let directory = RunDirectory::create(out, &description).map_err(Failure::input)?;
        Ok(Self {
            ground,
            directory,
            description,
            sites,
            last: None,
            state,
        })
    }

    /// The run of `directory` from its last checkpoint, or from the start if it has none.
    pub(crate) fn resume(
        ground: &'a G,
        mut directory: RunDirectory,
        mut description: Description,
    ) -> Result<Self, Failure> {
        let checkpoint = directory.checkpoint().map_err(Failure::input)?;
        let (sites, last, state) = match checkpoint {
            Some(checkpoint) => {
                let asked = description.scene.method.iterations();
                if asked < checkpoint.iteration {
                    return Err(already_further(asked, checkpoint.iteration));
                }
                let last = directory.log().rewind(checkpoint.iteration);
                let last = last.map_err(Failure::input)?;
                let state = state_of(&checkpoint.memory, description.sites, &last)?;
                (checkpoint.sites, Some(last), state)
            }
            None => {
                let sites = ground.place(&description.scene)?;
                directory.log().clear().map_err(Failure::input)?;
                let state = fresh_state(&description.scene, sites.len());
                (sites, None, state)
            }
        };
        description.last = None;
        description.ended = None;
        description.threads = rayon::current_num_threads();
        directory.describe(&description).map_err(Failure::input)?;
        Ok(Self {
            ground,
            directory,
            description,
            sites,
            last,
            state,
        })
    }

    /// Runs to the end and leaves all files.
    pub(crate) fn run(mut self, common: Common) -> Result<(), Failure> {
        interrupt::listen()?;
        if self.description.initial.is_none() {
            self.description.initial = Some(self.figures(&self.cells()?));
            self.directory
                .describe(&self.description)
                .map_err(Failure::run)?;
        }
        let ended = self.relax(common)?;
        let cells = self.cells()?;
        self.leave_files(&cells)?;
        self.description.last = Some(self.figures(&cells));
        self.description.ended = Some(ended.to_owned());
        self.description.seconds = self.last.as_ref().map_or(0.0, |record| record.seconds);
        self.directory
            .describe(&self.description)
            .map_err(Failure::run)?;
        if common.quiet {
            return Ok(());
        }
        let done = self.last.as_ref().map_or(0, |record| record.iteration);
        stdout::print(summary(&self.description, done, self.directory.path()))
    }

    /// Moves the sites, keeping the log; says how it ended.
    fn relax(&mut self, common: Common) -> Result<&'static str, Failure> {
        let scene = &self.description.scene;
        let plan = plan(scene, self.description.sites);
        let resumed = self.last.clone();
        let done = resumed.as_ref().map_or(0, |record| record.iteration);
        let progress = Progress::new(plan.iterations, done, common);
        let (directory, last) = (&mut self.directory, &mut self.last);
        let mut failure: Option<RunError> = None;
        let mut observe = |record: &Record, sites: &[Point<f64, D>], state: &RunState<D>| {
            *last = Some(record.clone());
            progress.show(record);
            failure = directory.record(record, sites, || state.to_numbers()).err();
            let unfinished = record.iteration < plan.iterations;
            if failure.is_some() || (unfinished && interrupt::asked()) {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        };
        let ended = drive(
            self.ground,
            &plan,
            &mut self.sites,
            &mut self.state,
            resumed.as_ref(),
            &mut observe,
        )
        .map_err(Failure::run);
        progress.finish();
        if let Some(failure) = failure {
            return Err(Failure::run(failure));
        }
        Ok(match ended? {
            RunEnd::Iterations => "iterations",
            RunEnd::Tolerance => "tolerance",
            RunEnd::Interrupted => INTERRUPTED,
        })
    }

    /// The checkpoint, the sites, the cells and the curves.
    fn leave_files(&mut self, cells: &[CellFigures<D>]) -> Result<(), Failure> {
        if let Some(last) = &self.last {
            self.directory
                .keep(last, &self.sites, &self.state.to_numbers())
                .map_err(Failure::run)?;
        }
        self.leave("sites.csv", |file| sites::write_csv(&self.sites, file))?;
        let output = &self.description.scene.output;
        if output.cells {
            self.ground
                .draw_cells(&self.sites, cells, &self.directory)
                .map_err(Failure::run)?;
        }
        if output.plot {
            let records = read_log(&self.directory.file("log.jsonl")).map_err(Failure::run)?;
            let runs = [Run {
                name: "energy and movement",
                records: &records,
            }];
            let figure = svg(&convergence(&runs));
            self.leave("convergence.svg", |file| {
                std::io::Write::write_all(file, figure.as_bytes())
            })?;
        }
        Ok(())
    }

    fn leave(
        &self,
        name: &str,
        content: impl FnOnce(&mut std::io::BufWriter<std::fs::File>) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        let path = self.directory.file(name);
        whole_file::write(&path, content)
            .map_err(|error| Failure::run(format!("cannot write {}: {error}", path.display())))
    }

    fn cells(&self) -> Result<Vec<CellFigures<D>>, Failure> {
        let question = question(&self.description.scene);
        self.ground
            .cells(&self.sites, question)
            .map_err(Failure::run)
    }

    fn figures(&self, cells: &[CellFigures<D>]) -> Figures {
        Figures::of(self.ground.volume(), cells)
    }
}

/// The state of a run of `count` sites that a checkpoint remembers: that of
/// plain Lloyd may be no more than its last record.
fn state_of<const D: usize>(
    memory: &[f64],
    count: usize,
    last: &Record,
) -> Result<RunState<D>, Failure> {
    if memory.is_empty() {
        return Ok(RunState::of_lloyd(count, last));
    }
    let damaged = || Failure::input("the checkpoint's memory is damaged");
    RunState::from_numbers(memory).ok_or_else(damaged)
}

/// The state before the first move.
fn fresh_state<const D: usize>(scene: &Scene, count: usize) -> RunState<D> {
    RunState::new(count, plan(scene, count).levels)
}

fn already_further(asked: u64, done: u64) -> Failure {
    Failure::input(format!(
        "the run has {done} iterations already, more than the {asked} asked for; \
         --iterations counts from the start"
    ))
}
