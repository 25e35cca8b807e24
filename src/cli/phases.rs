//! Phases of a command with their seconds, on stderr where `--verbose` asks for them.

use std::time::Instant;

use crate::cli::options::Common;

/// The time since the last phase ended.
#[derive(Debug)]
pub(crate) struct Phases {
    is_told: bool,
    since: Instant,
}

impl Phases {
    pub(crate) fn new(common: Common) -> Self {
        Self {
            is_told: common.verbose,
            since: Instant::now(),
        }
    }

    /// Tells that `what` is done, and begins the next phase.
    pub(crate) fn end(&mut self, what: &str) {
        if self.is_told {
            eprintln!("{what} in {:.3} s", self.since.elapsed().as_secs_f64());
        }
        self.since = Instant::now();
    }
}
