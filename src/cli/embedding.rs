//! A command called within another program, such as Python: arguments in, its output and notes out.
//!
//! While [`call`] runs, its thread keeps what the command prints, and signals are the host's: it raises a
//! flag instead.

use std::cell::RefCell;
use std::ffi::OsString;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;

use crate::cli::command::{Arguments, run};
use crate::cli::failure::{Failure, HOST, Host, print};

/// What a command leaves besides its files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CallOutcome {
    /// What it prints on standard output.
    pub output: Vec<u8>,
    /// What there is to say about its input, one sentence each.
    pub notes: Vec<String>,
    /// The exit code and the sentence of its failure.
    pub failure: Option<(u8, String)>,
}

/// Runs the command of these arguments, the program's name left out, in the caller's thread and rayon pool
/// (`--threads` changes nothing). A run ends after the move under way once `stop` is raised.
///
/// # Examples
/// ```
/// let mass = ["mass", "scenes/cube.mesh", "--json"].map(Into::into);
/// let outcome = chebloyd::call(mass.to_vec(), &Default::default());
/// assert!(outcome.failure.is_none() && outcome.output.starts_with(b"{"));
///
/// let misspelt = chebloyd::call(vec!["mass".into(), "--jsn".into()], &Default::default());
/// let (code, message) = misspelt.failure.expect("an unknown option");
/// assert!(code == 2 && message.contains("'--json'"), "{message}");
/// ```
#[must_use]
pub fn call(arguments: Vec<OsString>, stop: &Arc<AtomicBool>) -> CallOutcome {
    let host = Host {
        stop: stop.clone(),
        ..Host::default()
    };
    let outer = HOST.with(|slot| RefCell::replace(slot, Some(host)));
    let name = OsString::from(env!("CARGO_PKG_NAME"));
    let ran = match Arguments::try_parse_from(std::iter::once(name).chain(arguments)) {
        Ok(arguments) => run(&arguments),
        // Help and versions are asked for.
        Err(text) if !text.use_stderr() => print(text.render().to_string()),
        Err(error) => Err(usage(&error)),
    };
    let host = HOST
        .with(|slot| RefCell::replace(slot, outer))
        .unwrap_or_default();
    let failure = ran
        .err()
        .map(|failure| (failure.code(), failure.to_string()));
    CallOutcome {
        output: host.output,
        notes: host.notes,
        failure,
    }
}

/// The sentence of clap's message, without its usage.
fn usage(error: &clap::Error) -> Failure {
    let text = error.render().to_string();
    let text = text.split("\n\nUsage:").next().unwrap_or_default();
    let text = text
        .split("\n\nFor more information")
        .next()
        .unwrap_or_default();
    Failure::input(text.trim().trim_start_matches("error: "))
}
