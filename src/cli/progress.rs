//! The progress bar: iterations, energy, movement. Silent where stderr is no terminal.

use chebloyd::relax::record::Record;
use indicatif::{ProgressBar, ProgressStyle};

use crate::cli::arguments::Common;

const TEMPLATE: &str = "{bar:30} {pos}/{len}  {msg}  {elapsed} (left: {eta})";

/// What the user sees while a run goes on.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// The bar of a run of `iterations`, of which `done` lie behind.
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
