//! The command `chebloyd`: its arguments, its subcommands, its exit code.

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

use crate::cli::failure::Failure;
use crate::cli::options::Common;
use crate::cli::{
    bench, cpu_features, describe, fragments, integrate, mass, measure, mesh, octree, plot, print,
    print_options, relax, report, spin, stand,
};

/// Relaxes point sets under the Chebyshev norm until their Voronoi cells are near-cubic.
///
/// Exit codes: 0 done, 1 the run failed, 2 bad input or usage, 130 interrupted (by SIGTERM 143).
#[derive(Debug, Parser)]
#[command(name = "chebloyd", version, propagate_version = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Relax(relax::RelaxOptions),
    Measure(measure::MeasureOptions),
    Mass(mass::MassOptions),
    Integrate(integrate::IntegrateOptions),
    Mesh(mesh::MeshOptions),
    Spin(spin::SpinOptions),
    Stand(stand::StandOptions),
    Octree(octree::OctreeOptions),
    Plot(plot::PlotOptions),
    Report(report::ReportOptions),
    Print(Box<print_options::PrintOptions>),
    Fragments(fragments::FragmentsOptions),
    Bench(bench::BenchOptions),
    Schema(describe::SchemaOptions),
    Completions(describe::CompletionsOptions),
    Man(describe::ManOptions),
}

/// Runs the command line of this process: prints results, or an error once, and returns the exit
/// code.
#[must_use]
pub fn command_line() -> ExitCode {
    ExitCode::from(command_line_of(std::env::args_os()))
}

/// As [`command_line`], of these arguments, of which the first is the program's name. Help and wrong usage
/// end the process.
#[must_use]
pub fn command_line_of(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let ran = cpu_features::check().and_then(|()| {
        let arguments = Arguments::parse_from(arguments);
        set_threads(arguments.common)?;
        run(&arguments)
    });
    match ran {
        Ok(()) => 0,
        Err(failure @ Failure::Interrupted(_)) => failure.code(),
        Err(failure) => {
            // Where stderr is closed the exit code alone remains.
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            failure.code()
        }
    }
}

/// Runs the command that `arguments` name.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let common = arguments.common;
    match &arguments.command {
        Command::Relax(options) => relax::run(options, common),
        Command::Measure(options) => measure::run(options),
        Command::Mass(options) => mass::run(options),
        Command::Integrate(options) => integrate::run(options),
        Command::Mesh(options) => mesh::run(options, common),
        Command::Spin(options) => spin::run(options, common),
        Command::Stand(options) => stand::run(options, common),
        Command::Octree(options) => octree::run(options),
        Command::Plot(options) => plot::run(options, common),
        Command::Report(options) => report::run(options, common),
        Command::Print(options) => print::run(options, common),
        Command::Fragments(options) => fragments::run(options, common),
        Command::Bench(options) => bench::run(options, common.threads),
        Command::Schema(options) => describe::schema(options),
        Command::Completions(options) => describe::completions(options, Arguments::command()),
        Command::Man(options) => describe::man(options, Arguments::command()),
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
