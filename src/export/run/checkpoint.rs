//! Checkpoints: the sites and the record of one iteration, bit for bit, from which a resumed run starts.
//!
//! `checkpoint.bin` is a line of JSON (its layout and counts, the run's identity, the record), filled up
//! with blanks to whole words of eight bytes, followed by the coordinates, site by site, as
//! little-endian f64, by the numbers of the method's own memory, if it has any, and by the
//! [`Checksum`] of all these words: no changed bit goes unnoticed.
//!
//! Everything after a checkpoint can be computed again, so they need not be frequent: a
//! [`Pace`] spaces them so that writing them takes little of a run's time.

use std::io::{self, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use nalgebra::Point;
use serde::{Deserialize, Serialize};

use crate::export::atomic_write;
use crate::export::run::checksum::Checksum;
use crate::export::run::error::RunError;
use crate::relax::record::Record;

/// The version of the file's layout.
const FORMAT: u32 = 2;

/// The last version without a checksum.
const UNCHECKED: u32 = 1;

/// The bytes of a word.
const WORD: usize = 8;

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
    /// How many numbers the method remembers.
    memory: usize,
    /// The identity of the run.
    run: String,
    record: Record,
}

/// What all versions of the first line have in common.
#[derive(Deserialize)]
struct AnyHeader {
    format: u32,
}

/// A run's state after some iteration.
#[derive(Clone, Debug, PartialEq)]
pub struct SavedCheckpoint<const D: usize> {
    /// The identity of the run.
    pub run: String,
    /// The record of the sites.
    pub record: Record,
    /// The sites' positions (L).
    pub sites: Vec<Point<f64, D>>,
    /// What the method remembers beside them.
    pub memory: Vec<f64>,
}

/// Gives its argument all sites in their order, block by block.
pub(crate) type Blocks<'a, const D: usize> = dyn FnMut(&mut dyn FnMut(&[Point<f64, D>])) + 'a;

/// Writes a checkpoint of the run with the identity `run` at `path`, whole or not at all.
///
/// # Errors
/// [`RunError::File`].
pub fn write<const D: usize>(
    path: &Path,
    run: &str,
    record: &Record,
    sites: &[Point<f64, D>],
    memory: impl Iterator<Item = f64> + Clone,
) -> Result<(), RunError> {
    let blocks = &mut |add: &mut dyn FnMut(&[Point<f64, D>])| add(sites);
    write_blocks(path, (run, record), sites.len(), blocks, memory)
}

/// As [`write`] for `count` sites that come in blocks.
///
/// # Errors
/// [`RunError::File`].
pub(crate) fn write_blocks<const D: usize>(
    path: &Path,
    (run, record): (&str, &Record),
    count: usize,
    blocks: &mut Blocks<'_, D>,
    memory: impl Iterator<Item = f64> + Clone,
) -> Result<(), RunError> {
    let header = CheckpointHeader {
        format: FORMAT,
        dimension: D,
        sites: count,
        memory: memory.clone().count(),
        run: run.to_owned(),
        record: record.clone(),
    };
    let written = atomic_write::write(path, |file| {
        let mut line = serde_json::to_vec(&header).map_err(io::Error::from)?;
        line.resize((line.len() + 1).next_multiple_of(WORD) - 1, b' ');
        line.push(b'\n');
        let mut checksum = Checksum::default();
        checksum.add_bytes(&line);
        file.write_all(&line)?;
        let mut written = Ok(());
        let mut add = |value: f64| {
            checksum.add(value.to_bits());
            if written.is_ok() {
                written = file.write_all(&value.to_le_bytes());
            }
        };
        blocks(&mut |sites| {
            sites
                .iter()
                .flat_map(|site| site.iter())
                .for_each(|&x| add(x))
        });
        memory.for_each(add);
        written?;
        file.write_all(&checksum.sum().to_le_bytes())
    });
    written.map_err(RunError::file("write", path))
}

/// Reads the checkpoint at `path`; none if there is no such file.
///
/// # Errors
/// [`RunError::File`], or [`RunError::Damaged`] when it is not one of `D` dimensions or any bit of it
/// has changed since it was written.
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
    let line = &bytes[..end.ok_or("it has no header")?];
    if serde_json::from_slice(line).is_ok_and(|header: AnyHeader| header.format == UNCHECKED) {
        return Err("an older version wrote it, without a checksum".to_owned());
    }
    check(bytes)?;
    let header: CheckpointHeader =
        serde_json::from_slice(line).map_err(|error| error.to_string())?;
    if header.format != FORMAT || header.dimension != D {
        return Err(format!(
            "it has format {} and dimension {} where {FORMAT} and {D} are expected",
            header.format, header.dimension
        ));
    }
    let data = &bytes[line.len() + 1..bytes.len() - WORD];
    let sites = header.sites.checked_mul(WORD * D);
    let memory = header.memory.checked_mul(WORD);
    let size = sites.zip(memory).and_then(|(a, b)| a.checked_add(b));
    let (Some(sites), true) = (sites, size == Some(data.len())) else {
        let CheckpointHeader { sites, memory, .. } = header;
        return Err(format!(
            "it does not hold {sites} sites and {memory} numbers"
        ));
    };
    let (sites, memory) = data.split_at(sites);
    Ok(SavedCheckpoint {
        run: header.run,
        record: header.record,
        sites: sites.chunks_exact(WORD * D).map(point).collect(),
        memory: memory.chunks_exact(WORD).map(|b| point::<1>(b).x).collect(),
    })
}

/// Refuses bytes that are not whole words with their checksum behind them.
fn check(bytes: &[u8]) -> Result<(), String> {
    let (words, rest) = bytes.as_chunks::<WORD>();
    let (Some((written, words)), true) = (words.split_last(), rest.is_empty()) else {
        return Err("it is cut off".to_owned());
    };
    let mut checksum = Checksum::default();
    checksum.add_bytes(words.as_flattened());
    let (sum, written) = (checksum.sum(), u64::from_le_bytes(*written));
    if sum != written {
        return Err(format!(
            "it was changed or cut off after it was written: its checksum is {sum:016x}, not \
             {written:016x}"
        ));
    }
    Ok(())
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

    const RUN: &str = "0123-4567";

    fn record() -> Record {
        let text = r#"{"iteration":7,"energy_mean":0.1,"energy_max":0.30000000000000004,
            "energy_percent":104.0,"movement_mean":0.0,"movement_max":0.0,"movement_percent":0.0,
            "evaluations":3.5,"seconds":0.25,"level":1}"#;
        serde_json::from_str(text).expect("a record")
    }

    /// A checkpoint, and its bytes.
    fn written(folder: &Path) -> (SavedCheckpoint<3>, Vec<u8>) {
        let path = folder.join("checkpoint.bin");
        let saved = SavedCheckpoint {
            run: RUN.to_owned(),
            record: record(),
            sites: vec![
                Point::from([0.1, -0.0, 1e-300]),
                Point::from([0.2, 0.3, 0.1 + 0.2]),
            ],
            memory: vec![0.1 + 0.2, -0.0],
        };
        let memory = saved.memory.iter().copied();
        write(&path, RUN, &saved.record, &saved.sites, memory).expect("room for it");
        (saved, std::fs::read(&path).expect("it is there"))
    }

    #[test]
    fn a_checkpoint_reads_back_to_the_bit() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("checkpoint.bin");
        assert_eq!(read::<3>(&path).expect("nothing is not an error"), None);
        let (saved, _) = written(folder.path());
        let again = read::<3>(&path).expect("what was written reads");
        let again = again.expect("a file");
        let bits = |saved: &SavedCheckpoint<3>| -> Vec<u64> {
            let values = saved.sites.iter().flat_map(|site| site.iter());
            values.chain(&saved.memory).map(|x| x.to_bits()).collect()
        };
        assert_eq!(bits(&again), bits(&saved));
        assert_eq!((again.run, again.record), (saved.run, saved.record));
        assert!(read::<2>(&path).is_err());
    }

    #[test]
    fn every_flipped_bit_and_every_cut_is_refused() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let (_, bytes) = written(folder.path());
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut flipped = bytes.clone();
                flipped[place] ^= 1 << bit;
                assert!(parse::<3>(&flipped).is_err(), "bit {bit} of byte {place}");
            }
            assert!(parse::<3>(&bytes[..place]).is_err(), "{place} bytes");
        }
        let longer = [&bytes[..], &[0; 8]].concat();
        assert!(parse::<3>(&longer).is_err());
    }

    #[test]
    fn what_is_no_checkpoint_is_refused_with_the_reason() {
        for bytes in [&b""[..], b"{}\n", b"no header", b"{\"format\":2}\n  "] {
            assert!(parse::<3>(bytes).is_err());
        }
        let older = b"{\"format\":1,\"dimension\":3,\"sites\":2,\"iteration\":1}\n1234";
        let message = parse::<3>(older).expect_err("it has no checksum");
        assert!(message.contains("older version"), "{message}");
    }
}
