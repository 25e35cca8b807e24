//! A run's log: appended record by record, cut back to where a run goes on, read back.

use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::export::run::error::RunError;
use crate::relax::record::Record;

/// The log of a run that is going on: a line of JSON per record.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    /// The log at `path`, made if it is not there, with what it holds.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn open(path: &Path) -> Result<Self, RunError> {
        let file = OpenOptions::new()
            .read(true)
            .append(true)
            .create(true)
            .open(path)
            .map_err(RunError::file("open", path))?;
        Ok(Self {
            path: path.to_owned(),
            file,
        })
    }

    /// The file itself, for locking.
    pub(crate) fn file(&self) -> &File {
        &self.file
    }

    /// Empties the log.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn clear(&mut self) -> Result<(), RunError> {
        self.cut(0)
    }

    /// Appends a record as one line, which is in the file when this returns.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn append(&mut self, record: &impl Serialize) -> Result<(), RunError> {
        let mut line = serde_json::to_vec(record)
            .map_err(|error| RunError::file("write", &self.path)(error.into()))?;
        line.push(b'\n');
        self.file
            .write_all(&line)
            .map_err(RunError::file("write", &self.path))
    }

    /// Waits until what was appended is on the disk.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn sync(&self) -> Result<(), RunError> {
        self.file
            .sync_data()
            .map_err(RunError::file("write", &self.path))
    }

    /// Drops all after the record of `iteration`, a torn last line too, and returns that record.
    ///
    /// # Errors
    /// [`RunError::Damaged`] when the records 0 to `iteration` are not all there.
    pub fn rewind(&mut self, iteration: u64) -> Result<Record, RunError> {
        let mut bytes = Vec::new();
        self.file
            .read_to_end(&mut bytes)
            .map_err(RunError::file("read", &self.path))?;
        let mut length = 0;
        for (line, expected) in bytes.split_inclusive(|&byte| byte == b'\n').zip(0_u64..) {
            length += line.len();
            let whole = line.ends_with(b"\n");
            let record: Option<Record> = serde_json::from_slice(line).ok();
            match record.filter(|record| whole && record.iteration == expected) {
                Some(record) if expected == iteration => {
                    self.cut(length as u64)?;
                    return Ok(record);
                }
                Some(_) => {}
                None => break,
            }
        }
        let message = format!("it does not hold all records up to iteration {iteration}");
        Err(RunError::damaged(&self.path, message))
    }

    fn cut(&mut self, length: u64) -> Result<(), RunError> {
        self.file
            .set_len(length)
            .map_err(RunError::file("write", &self.path))
    }
}

/// The reason why a log cannot be read.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn record(iteration: u64) -> Record {
        Record {
            iteration,
            energy_mean: 0.1,
            energy_max: 0.2,
            energy_percent: 104.0,
            movement_mean: 0.0,
            movement_max: 0.0,
            movement_percent: 0.0,
            evaluations: 3.5,
            seconds: 0.25,
            energy_reference: None,
            stage: Default::default(),
        }
    }

    #[test]
    fn rewinding_drops_later_records_and_a_torn_line() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("log.jsonl");
        let mut log = Log::open(&path).expect("a new log");
        for iteration in 0..4 {
            log.append(&record(iteration)).expect("room for a line");
        }
        let all = std::fs::read(&path).expect("the log");
        std::fs::write(&path, &all[..all.len() - 5]).expect("room for it");

        let mut log = Log::open(&path).expect("the log again");
        assert!(log.rewind(3).is_err(), "the last line is torn");
        let mut log = Log::open(&path).expect("the log again");
        assert_eq!(log.rewind(1).expect("line 1 is whole"), record(1));
        log.append(&record(2)).expect("room for a line");
        let lines = std::fs::read_to_string(&path).expect("the log");
        assert_eq!(lines.lines().count(), 3);
        assert_eq!(lines.as_bytes(), &all[..lines.len()]);
    }
}
