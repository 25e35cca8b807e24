//! Errors of a run's directory.

use std::io;
use std::path::{Path, PathBuf};

/// The reason why a run's directory cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Something in the directory cannot be read or written.
    #[error("cannot {action} {path}: {source}", path = path.display())]
    File {
        /// What was tried, for example "write".
        action: &'static str,
        /// On which file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The directory holds a run already.
    #[error(
        "{path} already holds a run; go on with it by --resume, replace it by --force, \
         or choose another directory by --out",
        path = path.display()
    )]
    Occupied {
        /// The directory.
        path: PathBuf,
    },
    /// The directory's name belongs to a file.
    #[error("{path} is not a directory; choose another by --out", path = path.display())]
    NotADirectory {
        /// The file.
        path: PathBuf,
    },
    /// Another process runs in the directory.
    #[error(
        "{path} is in use by another run; wait for it, or choose another directory by --out",
        path = path.display()
    )]
    InUse {
        /// The directory.
        path: PathBuf,
    },
    /// There is no run to go on with.
    #[error("{path} holds no run to resume: it has no run.json", path = path.display())]
    NoRun {
        /// The directory.
        path: PathBuf,
    },
    /// The files of the directory are damaged or contradict each other.
    #[error("{path} cannot be resumed: {message}; start anew with --force", path = path.display())]
    Damaged {
        /// The file at fault.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

impl RunError {
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::File {
            action,
            path,
            source,
        }
    }

    pub(crate) fn damaged(path: &Path, message: impl Into<String>) -> Self {
        Self::Damaged {
            path: path.to_owned(),
            message: message.into(),
        }
    }
}
