//! A run from its first record to its last file, or from where an earlier process left it.

use std::ops::ControlFlow;
use std::path::Path;

use nalgebra::Point;

use chebloyd::export::run::directory;
use chebloyd::export::run::directory::RunDirectory;
use chebloyd::export::run::error::RunError;
use chebloyd::export::run::log::read_log;
use chebloyd::export::{atomic_write, sites};
use chebloyd::plot::convergence::{Run, convergence};
use chebloyd::plot::svg::svg;
use chebloyd::relax::figures::{CellFigures, Figures};
use chebloyd::relax::lloyd::{Ended, LloydOptions, lloyd};
use chebloyd::relax::record::{Record, optimal_energy};
use chebloyd::relax::stand::Stand;
use chebloyd::scene::description::Scene;
use chebloyd::scene::plan::plan;

use crate::cli::arguments::Common;
use crate::cli::failure::Failure;
use crate::cli::ground::Ground;
use crate::cli::progress::Progress;
use crate::cli::question::question;
use crate::cli::summary::{INTERRUPTED, summary};
use crate::cli::{interrupt, stdout};

/// What `run.json` holds.
pub(crate) type Description = directory::Description<Scene, Figures>;

/// A run that is about to begin or to go on.
pub(crate) struct Job<'a, const D: usize, G> {
    ground: &'a G,
    directory: RunDirectory,
    description: Description,
    sites: Vec<Point<f64, D>>,
    /// The last record in the log, which describes `sites`; none at the beginning.
    last: Option<Record>,
    /// Where the method stands after that record; none for plain Lloyd and at the beginning.
    stand: Option<Stand>,
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
        let directory = RunDirectory::create(out, &description).map_err(Failure::input)?;
        Ok(Self {
            ground,
            directory,
            description,
            sites,
            last: None,
            stand: None,
        })
    }

    /// The run of `directory` from its last checkpoint, or from the start if it has none.
    pub(crate) fn resume(
        ground: &'a G,
        mut directory: RunDirectory,
        mut description: Description,
    ) -> Result<Self, Failure> {
        let checkpoint = directory.checkpoint().map_err(Failure::input)?;
        let (sites, last, stand) = match checkpoint {
            Some(checkpoint) => {
                let asked = description.scene.method.iterations();
                if asked < checkpoint.iteration {
                    return Err(already_further(asked, checkpoint.iteration));
                }
                let last = directory.log().rewind(checkpoint.iteration);
                let stand = stand(&checkpoint.memory)?;
                (checkpoint.sites, Some(last.map_err(Failure::input)?), stand)
            }
            None => {
                let sites = ground.place(&description.scene)?;
                directory.log().clear().map_err(Failure::input)?;
                (sites, None, None)
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
            stand,
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
        let iterations = scene.method.iterations();
        let resumed = self.last.clone();
        let done = resumed.as_ref().map_or(0, |record| record.iteration);
        let progress = Progress::new(iterations, done, common);
        let (directory, last) = (&mut self.directory, &mut self.last);
        let mut failure: Option<RunError> = None;
        let mut observe = |record: &Record, sites: &[Point<f64, D>], stand: Option<&Stand>| {
            *last = Some(record.clone());
            progress.show(record);
            let memory = || stand.map_or_else(Vec::new, Stand::tape);
            failure = directory.record(record, sites, memory).err();
            let unfinished = record.iteration < iterations;
            if failure.is_some() || (unfinished && interrupt::asked()) {
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(())
        };
        let ended = match &plan {
            None => lloyd(
                self.ground,
                &mut self.sites,
                &LloydOptions {
                    iterations,
                    tolerance: scene.method.tolerance(),
                    question: question(scene),
                    is_accelerated: scene.method.is_accelerated(),
                },
                resumed.as_ref(),
                &mut |record, sites| observe(record, sites, None),
            )
            .map_err(Failure::run),
            Some(plan) => {
                let fresh = || Stand::new(self.description.sites, plan.levels);
                self.ground.travel(
                    plan,
                    &mut self.sites,
                    self.stand.get_or_insert_with(fresh),
                    resumed.as_ref(),
                    &mut |record, sites, stand| observe(record, sites, Some(stand)),
                )
            }
        };
        progress.finish();
        if let Some(failure) = failure {
            return Err(Failure::run(failure));
        }
        Ok(match ended? {
            Ended::Iterations => "iterations",
            Ended::Tolerance => "tolerance",
            Ended::Interrupted => INTERRUPTED,
        })
    }

    /// The checkpoint, the sites, the cells and the curves.
    fn leave_files(&mut self, cells: &[CellFigures<D>]) -> Result<(), Failure> {
        if let Some(last) = &self.last {
            let memory = self.stand.as_ref().map_or_else(Vec::new, Stand::tape);
            self.directory
                .keep(last, &self.sites, &memory)
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
        atomic_write::write(&path, content)
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

/// The stand that a checkpoint remembers, if any.
fn stand(memory: &[f64]) -> Result<Option<Stand>, Failure> {
    if memory.is_empty() {
        return Ok(None);
    }
    match Stand::from_tape(memory) {
        Some(stand) => Ok(Some(stand)),
        None => Err(Failure::input(
            "the checkpoint's memory is damaged".to_owned(),
        )),
    }
}

fn already_further(asked: u64, done: u64) -> Failure {
    Failure::input(format!(
        "the run has {done} iterations already, more than the {asked} asked for; \
         --iterations counts from the start"
    ))
}
