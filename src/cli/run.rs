//! A run of `chebloyd relax` in its directory: log, checkpoints, progress bar, Ctrl-C, final files.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};
use nalgebra::Point;

use crate::cli::cell_files::DrawCells;
use crate::cli::failure::{Failure, print, print_note, write_file};
use crate::cli::identity::{identity, of_scene, of_sites};
use crate::cli::interrupt::Interrupt;
use crate::cli::options::{Common, print_notes};
use crate::cli::phases::Phases;
use crate::export::run::directory;
use crate::export::run::directory::RunDirectory;
use crate::export::run::error::RunError;
use crate::export::run::log::read_log;
use crate::export::sites;
use crate::plot::convergence::{Run, convergence};
use crate::plot::svg::svg;
use crate::relax::driver::RunEnd;
use crate::relax::metrics::{CellMetrics, Metrics};
use crate::relax::record::Record;
use crate::relax::relaxation::Checkpoint;
use crate::relax::state::RunState;
use crate::scene::description::Scene;
use crate::scene::run::{RunSpace, all_sites, check_memory, energy_spec, relax};

/// How `run.json` calls the end that Ctrl-C brings.
const INTERRUPTED: &str = "interrupted";

const TEMPLATE: &str = "{bar:30} {pos}/{len}  {msg}  {elapsed} (left: {eta})";

/// What `run.json` holds.
pub(crate) type RunDescription = directory::Description<Scene, Metrics>;

/// A run that is about to begin or to go on.
pub(crate) struct FiledRun<'a, const D: usize, S> {
    space: &'a S,
    directory: RunDirectory,
    description: RunDescription,
    checkpoint: Checkpoint<D>,
    interrupt: Interrupt,
}

impl<'a, const D: usize, S: DrawCells<D>> FiledRun<'a, D, S> {
    /// A new run in the directory `out`.
    pub(crate) fn start(
        space: &'a S,
        scene: Scene,
        out: &Path,
        interrupt: Interrupt,
    ) -> Result<Self, Failure> {
        let placed = space.placed(&scene).map_err(Failure::input)?;
        print_notes(&placed.notes);
        check_memory(&scene, placed.sites.len()).map_err(Failure::input)?;
        let (identity, count) = (identity(&scene, &placed.sites)?, placed.sites.len());
        let description = describe(space, scene, [count, placed.dropped], identity)?;
        interrupt.finish_first();
        let directory = RunDirectory::create(out, &description.identity, &description)
            .map_err(Failure::input)?;
        Ok(Self {
            space,
            directory,
            description,
            checkpoint: Checkpoint::at_start(placed.sites),
            interrupt,
        })
    }

    /// The run of `directory` from its last checkpoint, or from the start if it has none.
    pub(crate) fn resume(
        space: &'a S,
        mut directory: RunDirectory,
        mut description: RunDescription,
        interrupt: Interrupt,
    ) -> Result<Self, Failure> {
        check_scene(&description, directory.path())?;
        interrupt.finish_first();
        let checkpoint = last_checkpoint(space, &mut directory, &description)?;
        let (count, optimum) = (checkpoint.count(), space.optimum());
        description.sites = count;
        description.domain_volume = space.volume();
        description.optimal_energy = optimum.energy::<D>(count);
        description.optimal_energy_error = optimum.energy_error::<D>(count);
        description.energy_reference = optimum.kind;
        description.last = None;
        description.ended = None;
        description.threads = rayon::current_num_threads();
        directory.describe(&description).map_err(Failure::input)?;
        Ok(Self {
            space,
            directory,
            description,
            checkpoint,
            interrupt,
        })
    }

    /// Runs to the end and leaves all files.
    pub(crate) fn run(mut self, common: Common, json: bool) -> Result<(), Failure> {
        let mut phases = Phases::new(common);
        if self.description.initial.is_none() {
            let sites = &self.checkpoint.sites;
            self.description.initial = Some(self.metrics(sites, &self.cells(sites)?)?);
            self.directory
                .describe(&self.description)
                .map_err(Failure::run)?;
        }
        phases.end("measured the cells of the first sites");
        let mut ended = self.relax(common)?;
        phases.end("relaxed");
        self.keep_last()?;
        let sites = all_sites(self.space, &self.checkpoint).map_err(Failure::run)?;
        // What a descent remembers is several times what the cells take.
        self.checkpoint.state = None;
        let cells = self.cells(&sites)?;
        phases.end("measured the cells of the last sites");
        self.leave_files(&sites, &cells)?;
        phases.end("wrote sites, cells and pictures");
        let last = self.checkpoint.record.as_ref();
        let interrupted = self.interrupt.exit_code();
        if interrupted.is_some() {
            ended = INTERRUPTED;
        }
        self.description.last = Some(self.metrics(&sites, &cells)?);
        self.description.ended = Some(ended.to_owned());
        self.description.seconds = last.map_or(0.0, |record| record.seconds);
        self.directory
            .describe(&self.description)
            .map_err(Failure::run)?;
        if json {
            let text = serde_json::to_string_pretty(&self.description).map_err(Failure::run)?;
            print(text + "\n")?;
        } else if !common.quiet {
            let done = last.map_or(0, |record| record.iteration);
            print(summary(&self.description, done, self.directory.path()))?;
        }
        interrupted.map_or(Ok(()), |code| Err(Failure::Interrupted(code)))
    }

    /// Moves the sites, keeping the log; returns why it ended.
    fn relax(&mut self, common: Common) -> Result<&'static str, Failure> {
        let scene = &self.description.scene;
        let (iterations, every) = (scene.method.iterations(), scene.output.checkpoint);
        let last = self.checkpoint.record.as_ref();
        let bar = Bar::new(
            iterations,
            last.map_or(0, |record| record.iteration),
            common,
        );
        let (directory, interrupt) = (&mut self.directory, &self.interrupt);
        let mut failure: Option<RunError> = None;
        let mut observe = |record: &Record, sites: &[Point<f64, D>], state: &RunState<D>| {
            bar.show(record);
            let kept = directory.record(record, sites, state.numbers(), every);
            failure = kept.err();
            let is_unfinished = record.iteration < iterations;
            if failure.is_some() || (is_unfinished && interrupt.exit_code().is_some()) {
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

    /// Keeps the checkpoint of the last record, with the sites of its level.
    fn keep_last(&mut self) -> Result<(), Failure> {
        let Checkpoint { record, sites, .. } = &self.checkpoint;
        let Some(record) = record else { return Ok(()) };
        let numbers = self.checkpoint.numbers();
        let kept = self.directory.keep(record, sites, numbers);
        kept.map_err(Failure::run)
    }

    /// All sites, their cells and the curves.
    fn leave_files(
        &mut self,
        sites: &[Point<f64, D>],
        cells: &[CellMetrics<D>],
    ) -> Result<(), Failure> {
        self.leave("sites.csv", |file| sites::write_csv(sites, file))?;
        let output = &self.description.scene.output;
        if output.cells {
            self.space
                .draw_cells(sites, cells, *output, &self.directory)
                .map_err(Failure::run)?;
        }
        if output.plot && output.pictures {
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

    fn cells(&self, sites: &[Point<f64, D>]) -> Result<Vec<CellMetrics<D>>, Failure> {
        let spec = energy_spec(&self.description.scene);
        let cells = self.space.cells(sites, spec);
        cells.map_err(Failure::run)
    }

    fn metrics(
        &self,
        sites: &[Point<f64, D>],
        cells: &[CellMetrics<D>],
    ) -> Result<Metrics, Failure> {
        let last = self.checkpoint.record.as_ref();
        let figures = self.space.figures(sites, cells).map_err(Failure::run)?;
        let iteration = last.map_or(0, |record| record.iteration);
        figures.checked(iteration).map_err(Failure::run)
    }
}

/// What `run.json` holds of a run that is about to begin, with so many sites and so many left out.
pub(crate) fn describe<const D: usize, S: RunSpace<D>>(
    space: &S,
    scene: Scene,
    [sites, dropped_outside]: [usize; 2],
    identity: String,
) -> Result<RunDescription, Failure> {
    let optimum = space.optimum();
    let fits = space.check_scale(sites, energy_spec(&scene));
    fits.map_err(Failure::input)?;
    Ok(RunDescription {
        program: env!("CARGO_PKG_NAME").to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        identity,
        scene,
        sites,
        dropped_outside,
        domain_volume: space.volume(),
        optimal_energy: optimum.energy::<D>(sites),
        optimal_energy_error: optimum.energy_error::<D>(sites),
        energy_reference: optimum.kind,
        initial: None,
        last: None,
        ended: None,
        seconds: 0.0,
        threads: rayon::current_num_threads(),
    })
}

/// The last checkpoint of `directory`, its log cut back to it; else the scene's own sites.
pub(crate) fn last_checkpoint<const D: usize, S: RunSpace<D>>(
    space: &S,
    directory: &mut RunDirectory,
    description: &RunDescription,
) -> Result<Checkpoint<D>, Failure> {
    let run = &description.identity;
    let Some(kept) = directory.checkpoint(run).map_err(Failure::input)? else {
        let sites = space.place(&description.scene).map_err(Failure::input)?;
        if !run.ends_with(&of_sites(&sites)) {
            return Err(other_run(
                directory.path(),
                "the sites that its scene names",
            ));
        }
        directory.log().clear().map_err(Failure::input)?;
        return Ok(Checkpoint::at_start(sites));
    };
    let (wanted, done) = (description.scene.method.iterations(), kept.record.iteration);
    if wanted < done {
        return Err(already_further(wanted, done));
    }
    let checkpoint = Checkpoint::from_parts(kept.sites, kept.record.clone(), &kept.memory);
    let checkpoint = checkpoint.map_err(Failure::input)?;
    let missing = directory.log().rewind(&kept.record);
    let missing = missing.map_err(Failure::input)?;
    if missing > 0 {
        print_note(format!(
            "log.jsonl lacks {missing} of the {done} records before iteration {done}; the run goes \
             on from its checkpoint"
        ));
    }
    Ok(checkpoint)
}

fn already_further(wanted: u64, done: u64) -> Failure {
    Failure::input(format!(
        "the run has {done} iterations already, more than the {wanted} asked for; \
         --iterations counts from the start"
    ))
}

/// Refuses a `run.json` whose scene is not the one that the run began with.
pub(crate) fn check_scene(description: &RunDescription, directory: &Path) -> Result<(), Failure> {
    if description.identity.is_empty() {
        let path = directory.display();
        return Err(Failure::input(format!(
            "{path}/run.json cannot be resumed: an older version wrote it, without the run's \
             identity; start anew with --force"
        )));
    }
    let scene = of_scene(&description.scene)?;
    match description.identity.starts_with(&scene) {
        true => Ok(()),
        false => Err(other_run(
            directory,
            "its scene, or a file that this names,",
        )),
    }
}

/// The refusal of a run of which `part` has changed.
fn other_run(directory: &Path, part: &str) -> Failure {
    let path = directory.display();
    Failure::input(format!(
        "{path}/run.json cannot be resumed: {part} changed after the run began; put back what it began \
         with, or start anew with --force"
    ))
}

/// The run in a few lines, after `done` moves; nothing of a run that has not ended.
fn summary(run: &RunDescription, done: u64, directory: &Path) -> String {
    let [Some(from), Some(to)] = [&run.initial, &run.last] else {
        return String::new();
    };
    let [squareness, four_sided, aligned] = match run.scene.dimension {
        2 => ["squareness", "four-sided cells", "axis-aligned edges"],
        _ => ["cubeness", "six-facet cells", "axis-aligned area"],
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
         {:<20}{:8.3}   → {:.3}\n\
         {:<20}{:8.1} % → {:.1} %\n\
         {:<20}{:8.3}   → {:.3}\n\
         {last_line}\n",
        to.sites,
        run.seconds,
        from.energy_percent,
        to.energy_percent,
        squareness,
        from.cubeness,
        to.cubeness,
        four_sided,
        100.0 * from.six_facet_fraction,
        100.0 * to.six_facet_fraction,
        aligned,
        from.axis_aligned_area,
        to.axis_aligned_area,
    )
}

/// The progress bar: iterations, energy, movement. Silent where stderr is no terminal.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    /// The bar of a run of `iterations`, of which `done` are made.
    pub(crate) fn new(iterations: u64, done: u64, common: Common) -> Self {
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

    pub(crate) fn show(&self, record: &Record) {
        self.0.set_position(record.iteration);
        self.0.set_message(format!(
            "energy {:.2} %  movement {:.3} %",
            record.energy_percent, record.movement_percent
        ));
    }

    pub(crate) fn finish(&self) {
        self.0.finish_and_clear();
    }
}
