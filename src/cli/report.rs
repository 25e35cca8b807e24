//! `chebloyd report`: runs as one page for a browser, with curves, cells to turn and cut, and figures.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Point;
use serde_json::{Value, json};

use crate::cli::failure::{Failure, print, print_note, write_file};
use crate::cli::options::{Common, finite, space};
use crate::cli::output::OutputRule;
use crate::cli::report_cells::{AxisPlane, CellChoice, ShowCells, shown_cells};
use crate::cli::run::RunDescription;
use crate::export::run::checkpoint;
use crate::export::run::log::read_log;
use crate::relax::record::Record;
use crate::report::cells::ShownCells;
use crate::report::html;
use crate::report::run::ReportedRun;
use crate::scene::run::plane;
use crate::scene::site_file;

/// The files of a run that a page is made from.
const INPUTS: [&str; 4] = ["run.json", "log.jsonl", "sites.csv", "checkpoint.bin"];

/// Make one page of runs, for any browser and without a network
///
/// The page holds the curves of energy and movement, one over the other (a pointer or the arrow keys read
/// values), the cells in 3-D to turn, to cut along any axis and to color by energy, volume, cubeness,
/// facets and others, the figures before and after, and the scenes. Cells are computed from the sites that
/// the runs left; cells.vtu is not needed. A run that has not ended shows what its checkpoint holds.
#[derive(Debug, Args)]
pub(crate) struct ReportOptions {
    /// Directories of runs, as `relax --out` left them
    #[arg(required = true, value_name = "RUN_DIR")]
    runs: Vec<PathBuf>,
    /// The page to write
    #[arg(long, short, value_name = "FILE", default_value = "report.html")]
    output: PathBuf,
    /// The page's title [default: the names of the runs]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Show all cells of runs of up to N; of larger ones those that touch a plane
    #[arg(long, value_name = "N", default_value = "10000")]
    most_cells: usize,
    /// That plane, its place in the scene's unit [default: across the shortest side, near the middle]
    #[arg(long, value_name = "AXIS[=PLACE]", value_parser = axis_plane)]
    plane: Option<AxisPlane>,
    /// Leave the cells out
    #[arg(long, conflicts_with_all = ["most_cells", "plane"])]
    no_cells: bool,
    /// Print what the page shows as one JSON object
    #[arg(long)]
    json: bool,
    /// Replace FILE if it is there
    #[arg(long)]
    force: bool,
}

/// `x`, `y=0.5`, …
fn axis_plane(text: &str) -> Result<AxisPlane, String> {
    let (name, place) = match text.split_once('=') {
        Some((name, place)) => (name, Some(finite(place)?)),
        None => (text, None),
    };
    let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
    let axis = axis.ok_or("an axis is needed: x, y or z, and a place: z=0.5")?;
    Ok(AxisPlane { axis, place })
}

/// A run as its directory holds it.
struct RunOnDisk {
    path: PathBuf,
    description: RunDescription,
    /// `run.json` as it stands.
    text: Value,
    records: Vec<Record>,
}

pub(crate) fn run(options: &ReportOptions, common: Common) -> Result<(), Failure> {
    let runs = options.runs.iter().map(|path| RunOnDisk::read(path));
    let runs = runs.collect::<Result<Vec<_>, _>>()?;
    let inputs: Vec<PathBuf> = runs.iter().flat_map(RunOnDisk::inputs).collect();
    let rule = OutputRule {
        inputs: &inputs,
        force: options.force,
        option: "-o",
    };
    rule.check(std::slice::from_ref(&options.output))?;
    let names = names(&options.runs);
    let reported = runs.into_iter().zip(&names);
    let reported = reported.map(|(run, name)| run.reported(name, options));
    let reported = reported.collect::<Result<Vec<_>, _>>()?;
    let title = options.title.clone().unwrap_or_else(|| names.join(", "));
    write_file(&options.output, |file| html::write(file, &title, &reported))
        .map_err(Failure::run)?;
    tell(options, common, &reported)
}

/// Prints what the page shows, or its name.
fn tell(options: &ReportOptions, common: Common, runs: &[ReportedRun]) -> Result<(), Failure> {
    if options.json {
        return print(summary(&options.output, runs)?);
    }
    for run in runs {
        for note in &run.notes {
            print_note(format!("{}: {note}", run.name));
        }
    }
    if common.quiet {
        return Ok(());
    }
    print(format!("{}\n", options.output.display()))
}

/// What is printed with `--json`.
fn summary(output: &Path, runs: &[ReportedRun]) -> Result<String, Failure> {
    let bytes = fs::metadata(output).map_err(Failure::run)?.len();
    let of_run = |run: &ReportedRun| {
        let header = run.cells.as_ref().map(|cells| &cells.header);
        let key = |name: &str| header.map_or(Value::Null, |header| header[name].clone());
        json!({
            "name": run.name,
            "records": run.records.len(),
            "ended": run.description["ended"],
            "cells": key("cells"),
            "cells_total": key("total"),
            "selection": key("selection"),
            "notes": run.notes,
        })
    };
    let runs: Vec<Value> = runs.iter().map(of_run).collect();
    let object = json!({ "output": output, "bytes": bytes, "runs": runs });
    let text = serde_json::to_string_pretty(&object).map_err(Failure::run)?;
    Ok(text + "\n")
}

/// The runs' names: their directories', or where two have the same one, their paths.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let of_path = |path: &PathBuf| {
        let full = path.canonicalize().unwrap_or_else(|_| path.clone());
        let name = full.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    };
    let short: Vec<String> = paths.iter().map(of_path).collect();
    let is_alone = |name: &String| short.iter().filter(|other| *other == name).count() == 1;
    let named = short
        .iter()
        .zip(paths)
        .map(|(name, path)| match is_alone(name) {
            true => name.clone(),
            false => path.display().to_string(),
        });
    named.collect()
}

fn no_run(path: &Path, error: &io::Error) -> Failure {
    let path = path.display();
    Failure::input(format!(
        "{path} holds no run ({path}/run.json: {error}); name a directory that `chebloyd relax --out {path}` \
         left"
    ))
}

impl RunOnDisk {
    fn read(path: &Path) -> Result<Self, Failure> {
        let place = path.join("run.json");
        let bytes = fs::read(&place).map_err(|error| no_run(path, &error))?;
        let refuse =
            |error: serde_json::Error| Failure::input(format!("{}: {error}", place.display()));
        let log = path.join("log.jsonl");
        let records = if log.exists() {
            read_log(&log).map_err(Failure::input)?
        } else {
            Vec::new()
        };
        Ok(Self {
            path: path.to_owned(),
            description: serde_json::from_slice(&bytes).map_err(refuse)?,
            text: serde_json::from_slice(&bytes).map_err(refuse)?,
            records,
        })
    }

    fn inputs(&self) -> Vec<PathBuf> {
        let own = INPUTS.iter().map(|name| self.path.join(name));
        own.chain(self.description.scene.files()).collect()
    }

    /// The run as the page shows it.
    fn reported(self, name: &str, options: &ReportOptions) -> Result<ReportedRun, Failure> {
        let mut notes = Vec::new();
        if self.records.is_empty() {
            notes.push("its log.jsonl holds no records: there are no curves".to_owned());
        }
        notes.extend(self.end_note());
        let cells = match options.no_cells {
            true => None,
            false => self.shown(options, &mut notes)?,
        };
        Ok(ReportedRun {
            name: name.to_owned(),
            description: self.text,
            records: self.records,
            notes,
            cells: cells.map(|cells| cells.pack()),
        })
    }

    /// The cells that are shown, if there are any.
    fn shown(
        &self,
        options: &ReportOptions,
        notes: &mut Vec<String>,
    ) -> Result<Option<ShownCells>, Failure> {
        let choice = CellChoice {
            most: options.most_cells,
            plane: options.plane,
        };
        let scene = &self.description.scene;
        match scene.dimension {
            2 => self.cells(|| plane(scene).map_err(Failure::input), choice, notes),
            _ => self.cells(|| space(scene), choice, notes),
        }
    }

    /// What is to be said about how the run ended.
    fn end_note(&self) -> Option<String> {
        let path = self.path.display();
        let done = self.records.last().map_or(0, |record| record.iteration);
        let of = self.description.scene.method.iterations();
        let go_on = format!("go on with: chebloyd relax --resume --out {path}");
        match self.description.ended.as_deref() {
            None => Some(format!(
                "the run has not ended, {done} of {of} iterations are made; {go_on}"
            )),
            Some("interrupted") => Some(format!(
                "the run was interrupted after {done} of {of} iterations; {go_on}"
            )),
            Some(_) => None,
        }
    }

    /// The cells of the run's sites.
    fn cells<const D: usize, S: ShowCells<D>>(
        &self,
        space: impl FnOnce() -> Result<S, Failure>,
        choice: CellChoice,
        notes: &mut Vec<String>,
    ) -> Result<Option<ShownCells>, Failure> {
        let Some(sites) = self.sites::<D>(notes)? else {
            return Ok(None);
        };
        let space = space().map_err(|error| self.without_cells(error))?;
        let cells = shown_cells(&space, &self.description.scene, &sites, choice);
        cells.map(Some).map_err(|error| self.without_cells(error))
    }

    /// The sites that the run left or, where it has not ended, those of its checkpoint.
    fn sites<const D: usize>(
        &self,
        notes: &mut Vec<String>,
    ) -> Result<Option<Vec<Point<f64, D>>>, Failure> {
        if self.description.ended.is_some() {
            let sites = site_file::read::<D>(&self.path.join("sites.csv"));
            return sites.map(Some).map_err(|error| self.without_cells(error));
        }
        let saved = checkpoint::read::<D>(&self.path.join("checkpoint.bin"));
        let saved = saved.map_err(|error| self.without_cells(error))?;
        let Some(saved) = saved.filter(|saved| saved.run == self.description.identity) else {
            notes.push("it has no checkpoint yet: there are no cells".to_owned());
            return Ok(None);
        };
        let iteration = saved.record.iteration;
        notes.push(format!("the cells are those after iteration {iteration}"));
        Ok(Some(saved.sites))
    }

    fn without_cells(&self, error: impl std::fmt::Display) -> Failure {
        let path = self.path.display();
        Failure::input(format!(
            "{path} has no cells: {error}; --no-cells leaves them out of the page"
        ))
    }
}
