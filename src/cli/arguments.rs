//! What can be said on the command line.

use clap::{Args, Parser, Subcommand};

use crate::cli::{bench, completions, fragments, man, mass, measure, plot, relax};

/// Relaxes point sets under the Chebyshev norm until their Voronoi cells are near-cubic.
///
/// Exit codes: 0 done, 1 the run failed, 2 bad input or usage.
#[derive(Debug, Parser)]
#[command(name = "chebloyd", version, propagate_version = true)]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What every command understands.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Common {
    /// How many threads compute; results do not depend on it [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub(crate) threads: Option<u32>,
    /// Print errors only
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Relax(relax::Options),
    Measure(measure::Options),
    Mass(mass::Options),
    Plot(plot::Options),
    Fragments(fragments::Options),
    Bench(bench::Options),
    /// Print the JSON Schema of scenes
    Schema,
    Completions(completions::Options),
    Man(man::Options),
}
