//! Checkpoints: the sites of one iteration, bit for bit, from which a resumed run starts.
//!
//! `checkpoint.bin` is a line of JSON (its layout and counts) followed by the coordinates, site by
//! site, as little-endian f64, and then by the numbers of the method's own memory, if it has any.
//!
//! Everything after a checkpoint can be computed again, so they need not be frequent: a
//! [`Pace`] spaces them so that writing them takes little of a run's time.

use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use nalgebra::Point;
use serde::{Deserialize, Serialize};

use crate::export::atomic_write;
use crate::export::run::error::RunError;

/// The version of the file's layout.
const FORMAT: u32 = 1;

/// Checkpoints are at least this far apart: what a killed run loses at most, beside one iteration.
const LEAST_INTERVAL: Duration = Duration::from_secs(1);

/// And this many times as far apart as one takes to write: 4 % of a run's time.
const INTERVAL_PER_WRITE: u32 = 25;

/// The first line of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct CheckpointHeader {
    format: u32,
    dimension: usize,
    sites: usize,
    iteration: u64,
    /// How many numbers the method remembers.
    #[serde(default)]
    memory: usize,
}

/// A run's state after some iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedCheckpoint<const D: usize> {
    /// Moves made so far.
    pub iteration: u64,
    /// The sites' positions (L).
    pub sites: Vec<Point<f64, D>>,
    /// What the method remembers beside them.
    pub memory: Vec<f64>,
}

/// Writes a checkpoint at `path`, whole or not at all.
///
/// # Errors
/// [`RunError::File`].
pub fn write<const D: usize>(
    path: &Path,
    iteration: u64,
    sites: &[Point<f64, D>],
    memory: &[f64],
) -> Result<(), RunError> {
    let header = CheckpointHeader {
        format: FORMAT,
        dimension: D,
        sites: sites.len(),
        iteration,
        memory: memory.len(),
    };
    let written = atomic_write::write(path, |file| {
        serde_json::to_writer(&mut *file, &header).map_err(io::Error::from)?;
        file.write_all(b"\n")?;
        let coordinates = sites.iter().flat_map(|site| site.iter());
        for value in coordinates.chain(memory) {
            file.write_all(&value.to_le_bytes())?;
        }
        Ok(())
    });
    written.map_err(RunError::file("write", path))
}

/// Reads the checkpoint at `path`; none if there is no such file.
///
/// # Errors
/// [`RunError::File`], or [`RunError::Damaged`] when it is not one of `D` dimensions.
pub fn read<const D: usize>(path: &Path) -> Result<Option<SavedCheckpoint<D>>, RunError> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(RunError::file("read", path)(error)),
    };
    parse(&bytes)
        .map(Some)
        .map_err(|message| RunError::damaged(path, message))
}

fn parse<const D: usize>(bytes: &[u8]) -> Result<SavedCheckpoint<D>, String> {
    let end = bytes.iter().position(|&byte| byte == b'\n');
    let end = end.ok_or("it has no header")?;
    let header: CheckpointHeader =
        serde_json::from_slice(&bytes[..end]).map_err(|error| error.to_string())?;
    let data = &bytes[end + 1..];
    if header.format != FORMAT || header.dimension != D {
        return Err(format!(
            "it has format {} and dimension {} where {FORMAT} and {D} are expected",
            header.format, header.dimension
        ));
    }
    let sites = header.sites.checked_mul(8 * D);
    let memory = header.memory.checked_mul(8);
    let size = sites.zip(memory).and_then(|(a, b)| a.checked_add(b));
    let (Some(sites), true) = (sites, size == Some(data.len())) else {
        let CheckpointHeader { sites, memory, .. } = header;
        return Err(format!(
            "it does not hold {sites} sites and {memory} numbers"
        ));
    };
    let (sites, memory) = data.split_at(sites);
    Ok(SavedCheckpoint {
        iteration: header.iteration,
        sites: sites.chunks_exact(8 * D).map(point).collect(),
        memory: memory.chunks_exact(8).map(|b| point::<1>(b).x).collect(),
    })
}

fn point<const D: usize>(bytes: &[u8]) -> Point<f64, D> {
    let coordinate = |axis: usize| {
        let mut value = [0; 8];
        value.copy_from_slice(&bytes[8 * axis..8 * axis + 8]);
        f64::from_le_bytes(value)
    };
    Point::from(std::array::from_fn::<f64, D, _>(coordinate))
}

/// When the next checkpoint is due.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    last: Instant,
    interval: Duration,
}

impl Pace {
    /// The pace after a checkpoint just written that took `cost`.
    #[must_use]
    pub fn after(cost: Duration) -> Self {
        Self {
            last: Instant::now(),
            interval: LEAST_INTERVAL.max(cost * INTERVAL_PER_WRITE),
        }
    }

    /// Whether the next checkpoint is due.
    #[must_use]
    pub fn is_due(&self) -> bool {
        self.last.elapsed() >= self.interval
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_checkpoint_reads_back_to_the_bit() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("checkpoint.bin");
        assert_eq!(read::<3>(&path).expect("nothing is not an error"), None);
        let sites = vec![
            Point::from([0.1, -0.0, 1e-300]),
            Point::from([0.2, 0.3, 0.1 + 0.2]),
        ];
        write(&path, 7, &sites, &[0.1 + 0.2, -0.0]).expect("room for a checkpoint");
        let again = read::<3>(&path)
            .expect("what was written reads")
            .expect("a file");
        assert_eq!(again.iteration, 7);
        let memory: Vec<u64> = again.memory.iter().map(|x| x.to_bits()).collect();
        assert_eq!(memory, [(0.1_f64 + 0.2).to_bits(), (-0.0_f64).to_bits()]);
        let bits = |sites: &[Point<f64, 3>]| -> Vec<u64> {
            let values = sites.iter().flat_map(|site| site.iter().copied());
            values.map(f64::to_bits).collect()
        };
        assert_eq!(bits(&again.sites), bits(&sites));
        assert!(read::<2>(&path).is_err());
    }

    #[test]
    fn a_damaged_checkpoint_is_refused() {
        for bytes in [
            &b""[..],
            b"{}\n",
            b"no header",
            b"{\"format\":1,\"dimension\":3,\"sites\":2,\"iteration\":1}\n1234",
        ] {
            assert!(parse::<3>(bytes).is_err());
        }
    }
}
