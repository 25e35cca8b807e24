//! `chebloyd plot`: the curves of runs, drawn from their logs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::Value;

use crate::cli::cell_files::PNG_SCALE;
use crate::cli::failure::{Failure, format_of, print, write_file};
use crate::cli::options::Common;
use crate::cli::output::OutputRule;
use crate::cli::overlay::read_overlay;
use crate::export::run::log::read_log;
use crate::plot::convergence::{EnergyAxis, convergence_of};
use crate::plot::series::RunGroup;
use crate::plot::{png, svg};
use crate::relax::record::Record;

/// Draw the energy and movement curves of one or several runs
///
/// With --band runs of one kind become one curve, the mean over them, in a band from the least to the
/// greatest. Runs are of one kind whose run.json beside the log says the same scene but for seeds and
/// output; where there is none, whose names differ in their last digits only. Beyond its end a run keeps its
/// last energy; movements are averaged over the runs that still go on.
#[derive(Debug, Args)]
pub(crate) struct PlotOptions {
    /// Logs of runs, or the directories that hold them
    #[arg(required = true, value_name = "LOG.jsonl")]
    logs: Vec<PathBuf>,
    /// The picture to write: .svg or .png
    #[arg(long, short, value_name = "FILE", default_value = "convergence.svg")]
    output: PathBuf,
    /// Draw runs that differ in their seeds only as their mean and a band
    #[arg(long)]
    band: bool,
    /// Draw points upon the curves: a CSV file with columns iteration, energy_percent, movement_percent
    #[arg(long, value_name = "FILE.csv")]
    overlay: Vec<PathBuf>,
    /// The ends of the energy axis in percent [default: those of the curves]
    #[arg(long, value_name = "LO,HI", value_parser = range, allow_hyphen_values = true)]
    range: Option<Ends>,
    /// Draw energies on a linear axis from 100 %, as the paper does
    #[arg(long)]
    linear: bool,
    /// Replace FILE if it is there
    #[arg(long)]
    force: bool,
}

/// The ends of a range, the lesser first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ends(pub(crate) [f64; 2]);

/// Two numbers, the lesser first.
pub(crate) fn range(text: &str) -> Result<Ends, String> {
    let numbers = text.split_once(',').and_then(|(low, high)| {
        let [low, high] = [low, high].map(|number| number.trim().parse::<f64>().ok());
        low.zip(high)
    });
    match numbers {
        Some((low, high)) if low.is_finite() && high.is_finite() && low < high => {
            Ok(Ends([low, high]))
        }
        _ => Err("two numbers LO,HI with LO below HI are needed, such as 100,110".to_owned()),
    }
}

pub(crate) fn run(options: &PlotOptions, common: Common) -> Result<(), Failure> {
    let format = format_of(&options.output, ["svg", "png"])?;
    let logs: Vec<PathBuf> = options.logs.iter().map(|path| log_in(path)).collect();
    let inputs: Vec<PathBuf> = logs.iter().chain(&options.overlay).cloned().collect();
    let rule = OutputRule {
        inputs: &inputs,
        force: options.force,
        option: "-o",
    };
    rule.check(std::slice::from_ref(&options.output))?;
    let records = logs
        .iter()
        .map(|path| records(path))
        .collect::<Result<Vec<_>, _>>()?;
    let overlays = options.overlay.iter().map(|path| read_overlay(path));
    let overlays = overlays.collect::<Result<Vec<_>, _>>()?;
    let axis = EnergyAxis {
        range: options.range.map(|ends| ends.0),
        is_linear: options.linear,
    };
    let groups = groups(&logs, &records, options.band);
    let figure = convergence_of(&groups, &overlays, axis);
    let bytes = match format {
        "svg" => svg::svg(&figure).into_bytes(),
        _ => png::png(&figure, PNG_SCALE).map_err(Failure::run)?,
    };
    write_file(&options.output, |file| file.write_all(&bytes)).map_err(Failure::input)?;
    if common.quiet {
        return Ok(());
    }
    print(format!("{}\n", options.output.display()))
}

/// Every run by itself, or those of one kind together.
fn groups<'a>(logs: &[PathBuf], records: &'a [Vec<Record>], is_band: bool) -> Vec<RunGroup<'a>> {
    let mut kinds: Vec<(String, Vec<String>, RunGroup<'a>)> = Vec::new();
    for (number, (log, records)) in logs.iter().zip(records).enumerate() {
        let kind = if is_band {
            kind(log)
        } else {
            number.to_string()
        };
        match kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, names, group)) => {
                names.push(name(log));
                group.logs.push(records);
            }
            None => {
                let group = RunGroup {
                    name: String::new(),
                    logs: vec![records],
                };
                kinds.push((kind, vec![name(log)], group));
            }
        }
    }
    let named = kinds.into_iter().map(|(_, names, group)| RunGroup {
        name: common_name(&names),
        ..group
    });
    named.collect()
}

/// What runs of one kind have in common: the scene without seeds and output, or the name without its last
/// digits.
fn kind(log: &Path) -> String {
    let description = std::fs::read(log.with_file_name("run.json")).ok();
    let description = description.and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    let scene = description.and_then(|mut value| value.get_mut("scene").map(Value::take));
    match scene {
        Some(mut scene) => {
            if let Some(keys) = scene.as_object_mut() {
                keys.remove("output");
            }
            without_seeds(&mut scene);
            scene.to_string()
        }
        None => without_number(&name(log)).to_owned(),
    }
}

fn without_seeds(value: &mut Value) {
    match value {
        Value::Object(keys) => {
            keys.remove("seed");
            keys.values_mut().for_each(without_seeds);
        }
        Value::Array(values) => values.iter_mut().for_each(without_seeds),
        _ => {}
    }
}

fn without_number(name: &str) -> &str {
    name.trim_end_matches(|letter: char| letter.is_ascii_digit())
}

/// How all names begin, and how many they are.
fn common_name(names: &[String]) -> String {
    let [first, others @ ..] = names else {
        return String::new();
    };
    if others.is_empty() {
        return first.clone();
    }
    let is_common = |end: &usize| {
        let begins = first.get(..*end);
        begins.is_some_and(|begin| others.iter().all(|name| name.starts_with(begin)))
    };
    let end = (0..=first.len()).rev().find(is_common).unwrap_or_default();
    let begin = without_number(&first[..end]);
    let begin = begin.trim_end_matches(['-', '_', '.', ' ']);
    let begin = if begin.is_empty() { first } else { begin };
    format!("{begin} ({} runs)", names.len())
}

/// The log itself where `path` is a run's directory.
fn log_in(path: &Path) -> PathBuf {
    if path.is_dir() {
        path.join("log.jsonl")
    } else {
        path.to_owned()
    }
}

fn records(path: &Path) -> Result<Vec<Record>, Failure> {
    let records = read_log(path).map_err(Failure::input)?;
    if records.is_empty() {
        return Err(Failure::input(format!(
            "{} holds no records",
            path.display()
        )));
    }
    Ok(records)
}

/// The name of a run: the directory where the log has its usual name, else the file.
fn name(path: &Path) -> String {
    let own = path.file_stem().unwrap_or_default();
    let folder = path.parent().and_then(Path::file_name);
    let name = if own == "log" {
        folder.unwrap_or(own)
    } else {
        own
    };
    name.to_string_lossy().into_owned()
}
