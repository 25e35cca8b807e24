//! Failures with their exit codes, results on standard output, and files written whole.

use std::cell::RefCell;
use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use crate::export::atomic_write;

/// The reason why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad input or usage: nothing has been done.
    Input(String),
    /// The work itself failed.
    Run(String),
    /// A signal ended the work, whose files are complete: the exit code.
    Interrupted(u8),
}

impl Failure {
    pub(crate) fn input(error: impl fmt::Display) -> Self {
        Self::Input(error.to_string())
    }

    pub(crate) fn run(error: impl fmt::Display) -> Self {
        Self::Run(error.to_string())
    }

    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Run(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(code) => *code,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Input(message) | Self::Run(message) => formatter.write_str(message),
            Self::Interrupted(_) => formatter.write_str("interrupted"),
        }
    }
}

/// The program within which a command is called: it takes what would be printed, and signals are its own.
#[derive(Debug, Default)]
pub(crate) struct Host {
    pub(crate) output: Vec<u8>,
    pub(crate) notes: Vec<String>,
    /// Raised to end a run.
    pub(crate) stop: Arc<AtomicBool>,
}

thread_local! {
    /// The host of the command that runs in this thread, if it has one.
    pub(crate) static HOST: RefCell<Option<Host>> = const { RefCell::new(None) };
}

/// Lets the host, if there is one, take something.
fn hosted(take: impl FnOnce(&mut Host)) -> bool {
    HOST.with_borrow_mut(|host| host.as_mut().map(take).is_some())
}

/// The host's flag that ends a run.
pub(crate) fn host_stop() -> Option<Arc<AtomicBool>> {
    HOST.with_borrow(|host| host.as_ref().map(|host| host.stop.clone()))
}

/// Prints a note on stderr.
pub(crate) fn print_note(note: impl fmt::Display) {
    if !hosted(|host| host.notes.push(note.to_string())) {
        eprintln!("note: {note}");
    }
}

/// Prints `bytes` on standard output. A reader that has left (`| head`) is no failure.
pub(crate) fn print(bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    if hosted(|host| host.output.extend_from_slice(bytes.as_ref())) {
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    let printed = stdout
        .write_all(bytes.as_ref())
        .and_then(|()| stdout.flush());
    match printed {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::run(format!(
            "cannot write to standard output: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Prints a report as one JSON object, or as its table.
pub(crate) fn print_report(
    report: &impl Serialize,
    as_json: bool,
    table: impl FnOnce() -> String,
) -> Result<(), Failure> {
    if !as_json {
        return print(table());
    }
    print(serde_json::to_string_pretty(report).map_err(Failure::run)? + "\n")
}

/// Writes a file, or leaves the one that is there; the error names the path.
pub(crate) fn write_file(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), String> {
    atomic_write::write(path, content)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// The refusal of a number that no site has.
pub(crate) fn no_site(site: usize, count: usize) -> Failure {
    let message = format!("there is no site {site} among {count}; the first is 0");
    Failure::input(message)
}

/// Which of the extensions a file's name has, without regard to case.
pub(crate) fn format_of<const N: usize>(
    path: &Path,
    known: [&'static str; N],
) -> Result<&'static str, Failure> {
    let extension = path.extension().unwrap_or_default();
    let found = known
        .into_iter()
        .find(|name| extension.eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        let names = known.map(|name| format!(".{name}")).join(" or ");
        let path = path.display();
        Failure::input(format!("cannot tell the format of {path}: name it {names}"))
    })
}
