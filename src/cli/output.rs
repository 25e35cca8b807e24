//! The files that a command is about to write, checked against those that are there and those that it reads.
//!
//! One rule for every command: a file that is there is replaced by `--force` only, and an input of the
//! same command never, by whatever name or link it is reached. The check comes before anything is
//! written.

use std::path::{Path, PathBuf};

use crate::cli::failure::Failure;
use crate::export::atomic_write::partial;

/// What a command may replace, and how another place is chosen.
#[derive(Debug)]
pub(crate) struct OutputRule<'a> {
    /// The files that the command reads.
    pub(crate) inputs: &'a [PathBuf],
    /// Whether files that are there may be replaced.
    pub(crate) force: bool,
    /// The option that names the output.
    pub(crate) option: &'a str,
}

impl OutputRule<'_> {
    /// Refuses the first of `outputs` that must not be written; changes nothing.
    ///
    /// # Errors
    /// When it is an input or a directory, or is there and may not be replaced.
    pub(crate) fn check(&self, outputs: &[PathBuf]) -> Result<(), Failure> {
        for output in outputs {
            self.refuse_input(output)?;
            let (path, option) = (output.display(), self.option);
            if output.is_dir() {
                return Err(Failure::input(format!(
                    "{path} is a directory; name a file by {option}"
                )));
            }
            if !self.force && output.symlink_metadata().is_ok() {
                return Err(Failure::input(format!(
                    "{path} is there already; replace it by --force, or choose another place by \
                     {option}"
                )));
            }
        }
        Ok(())
    }

    /// Refuses an output, or the file that holds it while it is written, that is an input.
    fn refuse_input(&self, output: &Path) -> Result<(), Failure> {
        let is_input =
            |input: &&PathBuf| is_same_file(output, input) || is_same_file(&partial(output), input);
        let Some(input) = self.inputs.iter().find(is_input) else {
            return Ok(());
        };
        let (path, input, option) = (output.display(), input.display(), self.option);
        Err(Failure::input(format!(
            "{path} would replace {input}, which this command reads: that is never done, --force or \
             not; choose another place by {option}"
        )))
    }
}

/// Whether two paths lead to one file that is there, through links of either kind too.
fn is_same_file(one: &Path, other: &Path) -> bool {
    identity(one).is_some_and(|identity_of_one| identity(other) == Some(identity_of_one))
}

/// The device and the number of a file on it: the same for all its names.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    let metadata = path.metadata().ok()?;
    Some((metadata.dev(), metadata.ino()))
}

/// The path without links, in the system's own spelling.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}
