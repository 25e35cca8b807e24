//! Failures with their exit codes, results on standard output, and files written whole.

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

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

    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Run(_) => ExitCode::from(1),
            Self::Input(_) => ExitCode::from(2),
            Self::Interrupted(code) => ExitCode::from(*code),
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

/// Prints `bytes` on standard output. A reader that has left (`| head`) is no failure.
pub(crate) fn print(bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
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

/// Writes a file, or leaves the one that is there; the error names the path.
pub(crate) fn write_file(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), String> {
    atomic_write::write(path, content)
        .map_err(|error| format!("cannot write {}: {error}", path.display()))
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
