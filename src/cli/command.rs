//! From the command line to the command.

use crate::cli::arguments::{Arguments, Command, Common};
use crate::cli::failure::Failure;
use crate::cli::{bench, completions, fragments, man, mass, measure, plot, relax, schema};

/// Runs the command that `arguments` name.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = arguments.common;
    set_threads(common)?;
    match &arguments.command {
        Command::Relax(options) => relax::run(options, common),
        Command::Measure(options) => measure::run(options),
        Command::Mass(options) => mass::run(options),
        Command::Plot(options) => plot::run(options, common),
        Command::Fragments(options) => fragments::run(options, common),
        Command::Bench(options) => bench::run(options, common.threads),
        Command::Schema => schema::run(),
        Command::Completions(options) => completions::run(options),
        Command::Man(options) => man::run(options),
    }
}

fn set_threads(common: Common) -> Result<(), Failure> {
    let Some(threads) = common.threads else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads as usize)
        .build_global()
        .map_err(|error| Failure::run(format!("cannot start {threads} threads: {error}")))
}
