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

    /// Makes `last` the last record: drops what comes after it and every line before it that is no
    /// record in its place, adds it where it is not there, and returns how many records are missing
    /// before it.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn rewind(&mut self, last: &Record) -> Result<u64, RunError> {
        let mut bytes = Vec::new();
        self.file
            .read_to_end(&mut bytes)
            .map_err(RunError::file("read", &self.path))?;
        let (mut kept, mut count, mut next) = (Vec::new(), 0, 0);
        for line in bytes.split_inclusive(|&byte| byte == b'\n') {
            let record: Option<Record> = serde_json::from_slice(line).ok();
            let in_place = |record: &Record| (next..last.iteration).contains(&record.iteration);
            if let Some(record) = record.filter(in_place).filter(|_| line.ends_with(b"\n")) {
                kept.extend_from_slice(line);
                count += 1;
                next = record.iteration + 1;
            }
        }
        if bytes.starts_with(&kept) {
            self.cut(kept.len() as u64)?;
        } else {
            self.clear()?;
            self.file
                .write_all(&kept)
                .map_err(RunError::file("write", &self.path))?;
        }
        self.append(last)?;
        Ok(last.iteration - count)
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

        let rewind = |iteration: u64| {
            let mut log = Log::open(&path).expect("the log again");
            log.rewind(&record(iteration)).expect("room for a line")
        };
        assert_eq!(rewind(3), 0, "the torn line is replaced");
        assert_eq!(std::fs::read(&path).expect("the log"), all);
        assert_eq!(rewind(1), 0);
        let lines = std::fs::read_to_string(&path).expect("the log");
        assert_eq!(lines.lines().count(), 2);
        assert_eq!(lines.as_bytes(), &all[..lines.len()]);
    }

    #[test]
    fn a_log_with_gaps_keeps_its_usable_records() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("log.jsonl");
        let line = |iteration| serde_json::to_string(&record(iteration)).expect("JSON") + "\n";
        let (other, damaged) = (line(9), line(1).replace("104", "1x4"));
        let text = format!("{}{damaged}{}{other}{}", line(0), line(2), line(3));
        std::fs::write(&path, text).expect("room for it");
        let mut log = Log::open(&path).expect("the log");
        assert_eq!(log.rewind(&record(4)).expect("room for it"), 1);
        let lines = std::fs::read_to_string(&path).expect("the log");
        assert_eq!(lines, [line(0), line(2), line(3), line(4)].concat());

        std::fs::remove_file(&path).expect("a file to remove");
        let mut log = Log::open(&path).expect("a new log");
        assert_eq!(log.rewind(&record(4)).expect("room for it"), 4);
        assert_eq!(std::fs::read_to_string(&path).expect("the log"), line(4));
    }
}
