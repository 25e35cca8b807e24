//! Reading a run's log back.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use crate::relax::record::Record;

/// Why a log cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LogError {
    /// The file cannot be opened or read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The log.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A line is no record.
    #[error("{}, line {line}: not a record of a run: {source}", path.display())]
    Line {
        /// The log.
        path: PathBuf,
        /// Which line, from one.
        line: usize,
        /// What the parser says.
        source: serde_json::Error,
    },
}

/// The records of a `log.jsonl` in file order; none of an empty file.
///
/// A last line that breaks off before its line end is what a killed run leaves: it is dropped.
/// Blank lines are skipped and keys that a [`Record`] does not have are ignored.
///
/// # Errors
/// [`LogError`] naming the file and, for a line that is no record, the line.
pub fn read_log(path: &Path) -> Result<Vec<Record>, LogError> {
    let refuse = |source| LogError::Read {
        path: path.to_owned(),
        source,
    };
    let mut reader = BufReader::new(File::open(path).map_err(refuse)?);
    let mut records = Vec::new();
    let mut text = Vec::new();
    for line in 1.. {
        text.clear();
        if reader.read_until(b'\n', &mut text).map_err(refuse)? == 0 {
            break;
        }
        match serde_json::from_slice(&text) {
            Ok(record) => records.push(record),
            Err(_) if text.trim_ascii().is_empty() || !text.ends_with(b"\n") => {}
            Err(source) => {
                let path = path.to_owned();
                return Err(LogError::Line { path, line, source });
            }
        }
    }
    Ok(records)
}
