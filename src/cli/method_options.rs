//! How a method is told more than its name.

use clap::Args;

use chebloyd::scene::method_overrides::MethodOverrides;

/// What replaces keys of the scene's method; the scene says the rest.
#[derive(Debug, Args)]
#[command(next_help_heading = "Options of methods")]
pub(crate) struct MethodOptions {
    /// lloyd: go three times as far where that ends lower
    #[arg(long)]
    accelerate: bool,
    /// quasi-newton, anneal: how many of Lloyd's moves come first [default: 0]
    #[arg(long, value_name = "K")]
    warm_up: Option<u64>,
    /// quasi-newton, anneal: steps that the model of the curvature remembers [default: 10]
    #[arg(long, value_name = "M")]
    memory: Option<usize>,
    /// quasi-newton, anneal: end a descent when no component of the projected gradient is larger than
    /// G s^(2+p), s the side of the mean cell [default: 1e-9]
    #[arg(long, value_name = "G")]
    gradient_tolerance: Option<f64>,
    /// anneal: how many rounds [default: 60; for --goal cubes 200]
    #[arg(long, value_name = "R")]
    rounds: Option<u64>,
    /// anneal: the greatest noise, in sides of the mean cell [default: 0.5; for --goal cubes 0.4]
    #[arg(long, value_name = "A")]
    noise: Option<f64>,
}

impl MethodOptions {
    /// The names of the options that a run taken up again cannot be given.
    pub(crate) const NAMES: [&str; 6] = [
        "accelerate",
        "warm_up",
        "memory",
        "gradient_tolerance",
        "rounds",
        "noise",
    ];

    pub(crate) fn overrides(&self) -> MethodOverrides {
        MethodOverrides {
            accelerate: self.accelerate,
            warm_up: self.warm_up,
            memory: self.memory,
            gradient_tolerance: self.gradient_tolerance,
            rounds: self.rounds,
            noise: self.noise,
        }
    }
}
