//! The files of a run over ranks, which the first rank writes: log, checkpoints, sites, description.

use nalgebra::Point3;

use crate::cli::failure::{Failure, write_file};
use crate::cli::run::RunDescription;
use crate::export::run::directory::RunDirectory;
use crate::export::run::error::RunError;
use crate::export::sites::{write_csv_header, write_csv_rows};
use crate::relax::ranked_sites::RankedSites;
use crate::relax::record::Record;
use crate::relax::state::RunState;

/// Sites that the first rank gathers at a time: some ten megabytes.
const BLOCK: u64 = 1 << 19;

/// The files of a run.
pub(crate) struct FirstRank {
    pub(crate) directory: RunDirectory,
    pub(crate) description: RunDescription,
    /// The last record in the log.
    pub(crate) last: Option<Record>,
}

/// The first rank, or nothing on the others.
pub(crate) type IfFirst<'a> = Option<&'a mut FirstRank>;

impl FirstRank {
    /// Appends a record to the log.
    pub(crate) fn append(&mut self, record: &Record) -> Result<(), RunError> {
        self.directory.log().append(record)?;
        self.last = Some(record.clone());
        Ok(())
    }
}

/// Writes the checkpoint of Lloyd's iteration after `record`; all ranks must call, the first one writes.
pub(crate) fn keep_lloyd(
    first: IfFirst<'_>,
    record: &Record,
    sites: &RankedSites<'_>,
) -> Result<(), RunError> {
    let state = RunState::<3>::of_lloyd(sites.count, record);
    taken_by_first(first, sites, |first, blocks| {
        first
            .directory
            .keep_blocks(record, sites.count, blocks, state.numbers())
    })
}

/// Writes `sites.csv`; all ranks must call, the first one writes.
pub(crate) fn leave_sites(first: IfFirst<'_>, sites: &RankedSites<'_>) -> Result<(), Failure> {
    let written = taken_by_first(first, sites, |first, blocks| {
        write_file(&first.directory.file("sites.csv"), |file| {
            write_csv_header::<3>(file)?;
            let mut written = Ok(());
            blocks(&mut |block| {
                if written.is_ok() {
                    written = write_csv_rows(block, file);
                }
            });
            written
        })
    });
    written.map_err(Failure::run)
}

/// Takes blocks of sites in the order of their numbers.
pub(crate) type Take<'a> = dyn FnMut(&[Point3<f64>]) + 'a;

/// Lets `write` ask on the first rank for all sites, block by block, which the others send.
fn taken_by_first<E>(
    first: IfFirst<'_>,
    sites: &RankedSites<'_>,
    write: impl FnOnce(&mut FirstRank, &mut dyn FnMut(&mut Take<'_>)) -> Result<(), E>,
) -> Result<(), E> {
    let all = |take: &mut Take<'_>| {
        for start in (0..sites.count as u64).step_by(BLOCK as usize) {
            take(&sites.gathered(start, start + BLOCK));
        }
    };
    let Some(first) = first else {
        all(&mut |_| ());
        return Ok(());
    };
    let mut is_asked = false;
    let written = write(first, &mut |take| {
        is_asked = true;
        all(take);
    });
    if !is_asked {
        // The others send all the same.
        all(&mut |_| ());
    }
    written
}
