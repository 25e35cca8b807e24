//! Ctrl-C: the first one asks the run to end well, the second one ends it.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::cli::failure::Failure;

static ASKED: AtomicBool = AtomicBool::new(false);

/// What a shell expects of a program that Ctrl-C ended.
const KILLED: i32 = 130;

/// From now on SIGINT, SIGTERM and SIGHUP only ask, once.
pub(crate) fn listen() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            std::process::exit(KILLED);
        }
    })
    .map_err(|error| Failure::run(format!("cannot listen for Ctrl-C: {error}")))
}

/// Whether the run has been asked to end.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}
