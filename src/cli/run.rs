//! A run of `chebloyd relax` in its directory: log, checkpoints, progress bar, Ctrl-C, final files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Point;

use crate::cli::cell_files::DrawCells;
use crate::cli::failure::{Failure, print, write_file};
use crate::cli::options::Common;
use crate::export::run::directory;
use crate::export::run::directory::RunDirectory;
use crate::export::run::error::RunError;
use crate::export::run::log::read_log;
use crate::export::sites;
use crate::plot::convergence::{Run, convergence};
use crate::plot::svg::svg;
use crate::relax::driver::RunEnd;
use crate::relax::metrics::{CellMetrics, Metrics};
use crate::relax::record::{Record, optimal_energy};
use crate::relax::relaxation::Checkpoint;
use crate::relax::state::RunState;
use crate::scene::description::Scene;
use crate::scene::run::{energy_spec, relax};

/// How `run.json` calls the end that Ctrl-C brings.
const INTERRUPTED: &str = "interrupted";

const TEMPLATE: &str = "{bar:30} {pos}/{len}  {msg}  {elapsed} (left: {eta})";

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// The exit code of a program that Ctrl-C ended.
const KILLED: i32 = 130;

/// What `run.json` holds.
pub(crate) type RunDescription = directory::Description<Scene, Metrics>;

/// A run that is about to begin or to go on.
pub(crate) struct FiledRun<'a, const D: usize, S> {
    space: &'a S,
    directory: RunDirectory,
    description: RunDescription,
    checkpoint: Checkpoint<D>,
}

impl<'a, const D: usize, S: DrawCells<D>> FiledRun<'a, D, S> {
    /// A new run in the directory `out`.
    pub(crate) fn start(space: &'a S, scene: Scene, out: &Path) -> Result<Self, Failure> {
        let sites = space.place(&scene).map_err(Failure::input)?;
        let volume = space.volume();
        let description = RunDescription {
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
        let directory = RunDirectory::create(out, &description).map_err(Failure::input)?;
        Ok(Self {
            space,
            directory,
            description,
            checkpoint: Checkpoint::at_start(sites),
        })
    }

    /// The run of `directory` from its last checkpoint, or from the start if it has none.
    pub(crate) fn resume(
        space: &'a S,
        mut directory: RunDirectory,
        mut description: RunDescription,
    ) -> Result<Self, Failure> {
        let checkpoint = Self::last_checkpoint(space, &mut directory, &description.scene)?;
        description.last = None;
        description.ended = None;
        description.threads = rayon::current_num_threads();
        directory.describe(&description).map_err(Failure::input)?;
        Ok(Self {
            space,
            directory,
            description,
            checkpoint,
        })
    }

    /// The last checkpoint of `directory`, its log cut back to it; else the scene's own sites.
    fn last_checkpoint(
        space: &S,
        directory: &mut RunDirectory,
        scene: &Scene,
    ) -> Result<Checkpoint<D>, Failure> {
        let Some(kept) = directory.checkpoint().map_err(Failure::input)? else {
            let sites = space.place(scene).map_err(Failure::input)?;
            directory.log().clear().map_err(Failure::input)?;
            return Ok(Checkpoint::at_start(sites));
        };
        let wanted = scene.method.iterations();
        if wanted < kept.iteration {
            return Err(already_further(wanted, kept.iteration));
        }
        let last = directory.log().rewind(kept.iteration);
        let last = last.map_err(Failure::input)?;
        Checkpoint::from_parts(kept.sites, last, &kept.memory).map_err(Failure::input)
    }

    /// Runs to the end and leaves all files.
    pub(crate) fn run(mut self, common: Common) -> Result<(), Failure> {
        install_interrupt_handler()?;
        if self.description.initial.is_none() {
            self.description.initial = Some(self.metrics(&self.cells()?)?);
            self.directory
                .describe(&self.description)
                .map_err(Failure::run)?;
        }
        let ended = self.relax(common)?;
        let cells = self.cells()?;
        self.leave_files(&cells)?;
        let last = self.checkpoint.record.as_ref();
        self.description.last = Some(self.metrics(&cells)?);
        self.description.ended = Some(ended.to_owned());
        self.description.seconds = last.map_or(0.0, |record| record.seconds);
        self.directory
            .describe(&self.description)
            .map_err(Failure::run)?;
        if common.quiet {
            return Ok(());
        }
        let done = last.map_or(0, |record| record.iteration);
        print(summary(&self.description, done, self.directory.path()))
    }

    /// Moves the sites, keeping the log; returns why it ended.
    fn relax(&mut self, common: Common) -> Result<&'static str, Failure> {
        let scene = &self.description.scene;
        let iterations = scene.method.iterations();
        let last = self.checkpoint.record.as_ref();
        let bar = Bar::new(
            iterations,
            last.map_or(0, |record| record.iteration),
            common,
        );
        let directory = &mut self.directory;
        let mut failure: Option<RunError> = None;
        let mut observe = |record: &Record, sites: &[Point<f64, D>], state: &RunState<D>| {
            bar.show(record);
            failure = directory.record(record, sites, || state.to_numbers()).err();
            let is_unfinished = record.iteration < iterations;
            if failure.is_some() || (is_unfinished && is_interrupted()) {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        };
        let ended = relax(self.space, scene, &mut self.checkpoint, &mut observe);
        bar.finish();
        if let Some(failure) = failure {
            return Err(Failure::run(failure));
        }
        Ok(match ended.map_err(Failure::run)? {
            RunEnd::Iterations => "iterations",
            RunEnd::Tolerance => "tolerance",
            RunEnd::Interrupted => INTERRUPTED,
        })
    }

    /// The checkpoint, the sites, the cells and the curves.
    fn leave_files(&mut self, cells: &[CellMetrics<D>]) -> Result<(), Failure> {
        let sites = &self.checkpoint.sites;
        if let Some(last) = &self.checkpoint.record {
            self.directory
                .keep(last, sites, &self.checkpoint.state_numbers())
                .map_err(Failure::run)?;
        }
        self.leave("sites.csv", |file| sites::write_csv(sites, file))?;
        let output = &self.description.scene.output;
        if output.cells {
            self.space
                .draw_cells(sites, cells, &self.directory)
                .map_err(Failure::run)?;
        }
        if output.plot {
            let records = read_log(&self.directory.file("log.jsonl")).map_err(Failure::run)?;
            let runs = [Run {
                name: "energy and movement",
                records: &records,
            }];
            let figure = svg(&convergence(&runs));
            self.leave("convergence.svg", |file| file.write_all(figure.as_bytes()))?;
        }
        Ok(())
    }

    fn leave(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        write_file(&self.directory.file(name), content).map_err(Failure::run)
    }

    fn cells(&self) -> Result<Vec<CellMetrics<D>>, Failure> {
        let spec = energy_spec(&self.description.scene);
        let cells = self.space.cells(&self.checkpoint.sites, spec);
        cells.map_err(Failure::run)
    }

    fn metrics(&self, cells: &[CellMetrics<D>]) -> Result<Metrics, Failure> {
        let figures = self.space.figures(&self.checkpoint.sites, cells);
        figures.map_err(Failure::run)
    }
}

fn already_further(wanted: u64, done: u64) -> Failure {
    Failure::input(format!(
        "the run has {done} iterations already, more than the {wanted} asked for; \
         --iterations counts from the start"
    ))
}

/// The run in a few lines, after `done` moves; nothing of a run that has not ended.
fn summary(run: &RunDescription, done: u64, directory: &Path) -> String {
    let [Some(from), Some(to)] = [&run.initial, &run.last] else {
        return String::new();
    };
    let directory = directory.display();
    let last_line = match run.ended.as_deref() {
        Some(INTERRUPTED) => {
            format!("interrupted; go on with: chebloyd relax --resume --out {directory}")
        }
        _ => format!("log, sites and cells are in {directory}"),
    };
    format!(
        "{} sites, {done} iterations in {:.2} s\n\
         energy              {:8.2} % → {:.2} %\n\
         cubeness            {:8.3}   → {:.3}\n\
         six-facet cells     {:8.1} % → {:.1} %\n\
         axis-aligned area   {:8.3}   → {:.3}\n\
         {last_line}\n",
        to.sites,
        run.seconds,
        from.energy_percent,
        to.energy_percent,
        from.cubeness,
        to.cubeness,
        100.0 * from.six_facet_fraction,
        100.0 * to.six_facet_fraction,
        from.axis_aligned_area,
        to.axis_aligned_area,
    )
}

/// The progress bar: iterations, energy, movement. Silent where stderr is no terminal.
struct Bar(ProgressBar);

impl Bar {
    /// The bar of a run of `iterations`, of which `done` are made.
    fn new(iterations: u64, done: u64, common: Common) -> Self {
        if common.quiet {
            return Self(ProgressBar::hidden());
        }
        let bar = ProgressBar::new(iterations).with_position(done);
        if let Ok(style) = ProgressStyle::with_template(TEMPLATE) {
            bar.set_style(style);
        }
        bar.reset_eta();
        Self(bar)
    }

    fn show(&self, record: &Record) {
        self.0.set_position(record.iteration);
        self.0.set_message(format!(
            "energy {:.2} %  movement {:.3} %",
            record.energy_percent, record.movement_percent
        ));
    }

    fn finish(&self) {
        self.0.finish_and_clear();
    }
}

/// Sets a handler by which the first SIGINT, SIGTERM or SIGHUP only sets a flag: the run then
/// ends after its iteration.
fn install_interrupt_handler() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if IS_INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(KILLED);
        }
    })
    .map_err(|error| Failure::run(format!("cannot listen for Ctrl-C: {error}")))
}

fn is_interrupted() -> bool {
    IS_INTERRUPTED.load(Ordering::SeqCst)
}
