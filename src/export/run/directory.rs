//! The directory of one run, held by one process at a time, and its `run.json`.

use std::fs::{self, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Point;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::export::atomic_write;
use crate::export::run::checkpoint::{self, Blocks, Pace, SavedCheckpoint};
use crate::export::run::error::RunError;
use crate::export::run::log::Log;
use crate::relax::optimum::EnergyReference;
use crate::relax::record::Record;

const LOG: &str = "log.jsonl";
const DESCRIPTION: &str = "run.json";
const CHECKPOINT: &str = "checkpoint.bin";

/// The list of the pieces that ranks have written.
pub(crate) const PIECES: &str = "cells.pvtu";

/// What a run leaves beside its log; a new run in the same place removes them.
const OUTPUTS: [&str; 7] = [
    "sites.csv",
    "cells.vtu",
    PIECES,
    "cells.svg",
    "cells.png",
    "convergence.svg",
    CHECKPOINT,
];

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A run's directory, locked until this is dropped or the process ends.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    log: Log,
    pace: Pace,
    /// The identity of the run, for its checkpoints.
    run: String,
}

/// A run found in its directory.
#[derive(Debug)]
pub struct Found<T> {
    /// The directory.
    pub directory: RunDirectory,
    /// Its `run.json`.
    pub description: T,
}

impl RunDirectory {
    /// Refuses a directory that holds a run or can hold none; changes nothing.
    ///
    /// # Errors
    /// [`RunError::Occupied`] or [`RunError::NotADirectory`].
    pub fn check_vacant(path: &Path) -> Result<(), RunError> {
        if path.exists() && !path.is_dir() {
            return Err(RunError::NotADirectory {
                path: path.to_owned(),
            });
        }
        // A run killed before its first word leaves an empty log: that is no run.
        let records = fs::metadata(path.join(LOG)).is_ok_and(|log| log.len() > 0);
        if records || path.join(DESCRIPTION).exists() {
            return Err(RunError::Occupied {
                path: path.to_owned(),
            });
        }
        Ok(())
    }

    /// Every file that a run in the directory `path` may write.
    #[must_use]
    pub fn files(path: &Path) -> Vec<PathBuf> {
        let names = [LOG, DESCRIPTION].into_iter().chain(OUTPUTS);
        names.map(|name| path.join(name)).collect()
    }

    /// Whether a file is the empty log that a run leaves which was killed before its first word.
    #[must_use]
    pub fn is_empty_log(file: &Path) -> bool {
        file.ends_with(LOG)
            && fs::symlink_metadata(file).is_ok_and(|log| log.is_file() && log.len() == 0)
    }

    /// Makes the directory of a new run with the identity `run`, and its parents; what an older run left
    /// there is removed.
    ///
    /// # Errors
    /// [`RunError::InUse`] while another process runs there, [`RunError::File`] when it cannot be
    /// made or written.
    pub fn create(path: &Path, run: &str, description: &impl Serialize) -> Result<Self, RunError> {
        fs::create_dir_all(path).map_err(RunError::file("make the directory", path))?;
        let mut directory = Self::lock(path)?;
        directory.run = run.to_owned();
        directory.remove_pieces()?;
        for name in OUTPUTS {
            directory.remove(name)?;
        }
        directory.describe(description)?;
        directory.log.clear()?;
        Ok(directory)
    }

    /// Opens the directory of a run to go on with.
    ///
    /// # Errors
    /// [`RunError::NoRun`], [`RunError::InUse`], [`RunError::Damaged`] or [`RunError::File`].
    pub fn reopen<T: DeserializeOwned>(path: &Path) -> Result<Found<T>, RunError> {
        let description_path = path.join(DESCRIPTION);
        let text = match fs::read(&description_path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(RunError::NoRun {
                    path: path.to_owned(),
                });
            }
            Err(error) => return Err(RunError::file("read", &description_path)(error)),
        };
        let description = serde_json::from_slice(&text)
            .map_err(|error| RunError::damaged(&description_path, error.to_string()))?;
        Ok(Found {
            directory: Self::lock(path)?,
            description,
        })
    }

    /// The last checkpoint of the run with the identity `run`; none if it was killed before the first.
    ///
    /// # Errors
    /// [`RunError::Damaged`], also for a checkpoint of another run, or [`RunError::File`].
    pub fn checkpoint<const D: usize>(
        &mut self,
        run: &str,
    ) -> Result<Option<SavedCheckpoint<D>>, RunError> {
        self.run = run.to_owned();
        let path = self.file(CHECKPOINT);
        let saved = checkpoint::read(&path)?;
        if saved
            .as_ref()
            .is_some_and(|saved: &SavedCheckpoint<D>| saved.run != run)
        {
            let message = "it is another run's; put back this run's own, or remove it, and the run \
                           goes on from its first sites";
            return Err(RunError::damaged(&path, message));
        }
        Ok(saved)
    }

    /// The run's log.
    pub fn log(&mut self) -> &mut Log {
        &mut self.log
    }

    /// The directory itself.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of the file `name` in the directory.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes `run.json`.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn describe(&self, description: &impl Serialize) -> Result<(), RunError> {
        let path = self.file(DESCRIPTION);
        atomic_write::write(&path, |file| {
            serde_json::to_writer_pretty(&mut *file, description)?;
            io::Write::write_all(file, b"\n")
        })
        .map_err(RunError::file("write", &path))
    }

    /// Appends a record to the log and writes a checkpoint: `every` so many moves, else if it is time for one.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn record<const D: usize>(
        &mut self,
        record: &Record,
        sites: &[Point<f64, D>],
        memory: impl Iterator<Item = f64> + Clone,
        every: Option<u64>,
    ) -> Result<(), RunError> {
        self.log.append(record)?;
        let is_due = match every {
            Some(moves) => record.iteration.is_multiple_of(moves),
            None => record.iteration == 0 || self.pace.is_due(),
        };
        if is_due {
            self.keep(record, sites, memory)?;
        }
        Ok(())
    }

    /// Writes the checkpoint of a `record` that is in the log, whether it is time or not.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub fn keep<const D: usize>(
        &mut self,
        record: &Record,
        sites: &[Point<f64, D>],
        memory: impl Iterator<Item = f64> + Clone,
    ) -> Result<(), RunError> {
        let blocks = &mut |add: &mut dyn FnMut(&[Point<f64, D>])| add(sites);
        self.keep_blocks(record, sites.len(), blocks, memory)
    }

    /// As [`RunDirectory::keep`] for `count` sites that come in blocks.
    ///
    /// # Errors
    /// [`RunError::File`].
    pub(crate) fn keep_blocks<const D: usize>(
        &mut self,
        record: &Record,
        count: usize,
        blocks: &mut Blocks<'_, D>,
        memory: impl Iterator<Item = f64> + Clone,
    ) -> Result<(), RunError> {
        let start = Instant::now();
        self.log.sync()?;
        let path = self.file(CHECKPOINT);
        checkpoint::write_blocks(&path, (&self.run, record), count, blocks, memory)?;
        self.pace = Pace::after(start.elapsed());
        Ok(())
    }

    fn lock(path: &Path) -> Result<Self, RunError> {
        let log = Log::open(&path.join(LOG))?;
        // A file system that cannot lock is no reason not to run.
        if let Err(TryLockError::WouldBlock) = log.file().try_lock() {
            return Err(RunError::InUse {
                path: path.to_owned(),
            });
        }
        // What a process that was killed while it wrote has left.
        for file in Self::files(path) {
            let _ = fs::remove_file(atomic_write::partial(&file));
        }
        Ok(Self {
            path: path.to_owned(),
            log,
            pace: Pace::after(std::time::Duration::ZERO),
            run: String::new(),
        })
    }

    /// The cells of a rank.
    #[must_use]
    pub(crate) fn piece(rank: usize) -> String {
        format!("cells_{rank}.vtu")
    }

    /// Removes the cells of ranks, where their list says that they are an older run's.
    pub(crate) fn remove_pieces(&self) -> Result<(), RunError> {
        let Ok(list) = fs::read_to_string(self.file(PIECES)) else {
            return Ok(());
        };
        let named = list.split("Source=\"").skip(1);
        for name in named.filter_map(|rest| rest.split('"').next()) {
            let rank = name
                .strip_prefix("cells_")
                .and_then(|rest| rest.strip_suffix(".vtu"));
            if rank.is_some_and(|rank| rank.parse::<u32>().is_ok()) {
                self.remove(name)?;
            }
        }
        Ok(())
    }

    fn remove(&self, name: &str) -> Result<(), RunError> {
        let path = self.file(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(RunError::file("remove", &path)(error))
            }
            _ => Ok(()),
        }
    }
}

/// The content of `run.json`, written when a run starts, with `ended` empty.
///
/// `S` is the scene and `M` the measures of a tessellation, as they read and write themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description<S, M> {
    /// The program's name.
    pub program: String,
    /// The program's version.
    pub version: String,
    /// Checksums of the scene, the files that it names and the first sites; those of older versions
    /// have none.
    #[serde(default)]
    pub identity: String,
    /// The scene with every default filled in.
    pub scene: S,
    /// How many sites there are.
    pub sites: usize,
    /// How many sites outside the domain were left out.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dropped_outside: usize,
    /// The domain's volume (L^D).
    pub domain_volume: f64,
    /// The mean p = 1 Chebyshev energy of equal cubes, with a density of the asymptotic optimum (L^(D+1)).
    pub optimal_energy: f64,
    /// An estimate of its error (L^(D+1)): 0 for equal cubes.
    #[serde(default)]
    pub optimal_energy_error: f64,
    /// Which of both `energy_percent` is relative to.
    #[serde(default)]
    pub energy_reference: EnergyReference,
    /// The tessellation that the run began with.
    pub initial: Option<M>,
    /// The tessellation that the run ended with.
    #[serde(rename = "final")]
    pub last: Option<M>,
    /// Why the run ended; nothing while it goes on, or when it was killed.
    pub ended: Option<String>,
    /// Wall time since the start (s), earlier parts of a resumed run included.
    pub seconds: f64,
    /// How many threads computed.
    pub threads: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    #[test]
    fn checkpoints_come_every_so_many_moves_and_pieces_go_with_their_list() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut directory = RunDirectory::create(folder.path(), "0-1", &1).expect("room");
        let text = r#"{"iteration":0,"energy_mean":0.1,"energy_max":0.3,"energy_percent":104.0,"movement_mean":0.0,
            "movement_max":0.0,"movement_percent":0.0,"evaluations":3.5,"seconds":0.25}"#;
        let mut record: Record = serde_json::from_str(text).expect("a record");
        for (iteration, kept) in [(0, 0), (1, 0), (2, 0), (3, 3), (4, 3), (5, 3), (6, 6)] {
            record.iteration = iteration;
            let sites = [Point3::new(iteration as f64, 0.5, 0.5)];
            let written = directory.record(&record, &sites, std::iter::empty(), Some(3));
            written.expect("room");
            let saved = directory
                .checkpoint::<3>("0-1")
                .expect("whole")
                .expect("one");
            assert_eq!(
                (saved.record.iteration, saved.sites[0].x),
                (kept, kept as f64)
            );
        }
        drop(directory);
        let leave =
            |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("room");
        for name in ["cells_0.vtu", "cells_2.vtu", "cells_3.vtu", "cells_my.vtu"] {
            leave(name, "");
        }
        leave(
            PIECES,
            r#"<Piece Source="cells_0.vtu"/><Piece Source="cells_2.vtu"/><Piece Source="cells_my.vtu"/>"#,
        );
        RunDirectory::create(folder.path(), "0-2", &2).expect("room");
        let is_there = |name: &str| folder.path().join(name).exists();
        assert!(!is_there("cells_0.vtu") && !is_there("cells_2.vtu") && !is_there(PIECES));
        assert!(
            is_there("cells_3.vtu") && is_there("cells_my.vtu"),
            "not of the run"
        );
    }
}
