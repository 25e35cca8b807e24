//! `chebloyd plot`: the curves of runs, drawn from their logs.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::cell_files::PNG_SCALE;
use crate::cli::failure::{Failure, format_of, print, write_file};
use crate::cli::options::Common;
use crate::cli::output::OutputRule;
use crate::export::run::log::read_log;
use crate::plot::convergence::{Run, convergence};
use crate::plot::{png, svg};
use crate::relax::record::Record;

/// Draw the energy and movement curves of one or several runs
#[derive(Debug, Args)]
pub(crate) struct PlotOptions {
    /// Logs of runs, or the directories that hold them
    #[arg(required = true, value_name = "LOG.jsonl")]
    logs: Vec<PathBuf>,
    /// The picture to write: .svg or .png
    #[arg(long, short, value_name = "FILE", default_value = "convergence.svg")]
    output: PathBuf,
    /// Replace FILE if it is there
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(options: &PlotOptions, common: Common) -> Result<(), Failure> {
    let format = format_of(&options.output, ["svg", "png"])?;
    let logs: Vec<PathBuf> = options.logs.iter().map(|path| log_in(path)).collect();
    let rule = OutputRule {
        inputs: &logs,
        force: options.force,
        option: "-o",
    };
    rule.check(std::slice::from_ref(&options.output))?;
    let records = logs
        .iter()
        .map(|path| records(path))
        .collect::<Result<Vec<_>, _>>()?;
    let names: Vec<String> = logs.iter().map(|path| name(path)).collect();
    let runs: Vec<Run<'_>> = names
        .iter()
        .zip(&records)
        .map(|(name, records)| Run { name, records })
        .collect();
    let figure = convergence(&runs);
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
