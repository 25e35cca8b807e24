//! A run over ranks from its input to its files, as one rank sees it.
//!
//! Lloyd's iteration holds no more than each rank's own sites (`relax::ranked_lloyd`). All other methods are driven
//! by every rank alike, which share the cells (`relax::ranked_space`).

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::Point3;

use crate::cli::agreement::together;
use crate::cli::failure::{Failure, print};
use crate::cli::first_rank::{FirstRank, IfFirst, keep_lloyd, leave_sites};
use crate::cli::interrupt::Interrupt;
use crate::cli::ranked_cells::{ranks_with_sites, write_list, write_piece};
use crate::cli::stopwatch::{cpu_seconds, peak_memory};
use crate::export::run::error::RunError;
use crate::relax::driver::RunEnd;
use crate::relax::metrics::{CellMetrics, Metrics};
use crate::relax::plan::Plan;
use crate::relax::ranked_lloyd::{RankedRun, is_plain};
use crate::relax::ranked_sites::{RankedSites, Spent};
use crate::relax::ranked_space::RankedSpace;
use crate::relax::ranks::{Ranks, any, from_first, share_bytes};
use crate::relax::record::Record;
use crate::relax::relaxation::{Checkpoint, continue_run};
use crate::relax::space::Space;
use crate::relax::state::RunState;
use crate::scene::description::Scene;
use crate::scene::run::{energy_spec, plan};

/// The exit code of SIGTERM, where another rank received the signal.
const TERMINATED: u8 = 143;

/// What has been asked of this rank from outside.
pub(crate) struct Signals {
    pub(crate) interrupt: Interrupt,
    /// Whether a checkpoint is wanted.
    pub(crate) keep: Arc<AtomicBool>,
}

/// A run whose input has been read.
pub(crate) struct RankedJob<'a> {
    /// The directory of the run.
    pub(crate) out: &'a Path,
    /// Moves between two checkpoints.
    pub(crate) interval: u64,
    /// Whether what each rank has done is printed.
    pub(crate) tells_timings: bool,
    /// Whether no progress is told.
    pub(crate) is_quiet: bool,
    pub(crate) ranks: &'a dyn Ranks,
    pub(crate) space: &'a Space,
    pub(crate) scene: Scene,
    /// Where the run goes on; nothing at its start.
    pub(crate) last: Option<Record>,
    pub(crate) signals: Signals,
}

impl RankedJob<'_> {
    /// Runs to the end and leaves all files. The first rank has the files, and what the method remembers.
    pub(crate) fn run(
        &self,
        mut first: Option<FirstRank>,
        sites: RankedSites<'_>,
        state: Vec<f64>,
    ) -> Result<(), Failure> {
        let plan = plan(&self.scene, sites.count);
        let ended = match is_plain(&plan) {
            true => self.lloyd(&plan, first.as_mut(), sites),
            false => self.driven(&plan, first.as_mut(), (sites, state)),
        }?;
        match ended {
            RunEnd::Interrupted => {
                let code = self.signals.interrupt.exit_code();
                Err(Failure::Interrupted(code.unwrap_or(TERMINATED)))
            }
            _ => Ok(()),
        }
    }

    fn lloyd(
        &self,
        plan: &Plan,
        mut first: IfFirst<'_>,
        mut sites: RankedSites<'_>,
    ) -> Result<RunEnd, Failure> {
        self.measure_first(first.as_deref_mut(), &mut sites)?;
        (sites.spent, sites.clock) = (Spent::default(), cpu_seconds);
        let mut run = RankedRun::new(sites, plan, self.last.as_ref());
        let mut failure = None;
        let ended = run.run(self.last.as_ref(), &mut |record, sites| {
            let keep = |first: IfFirst<'_>| keep_lloyd(first, record, sites);
            self.after(record, (first.as_deref_mut(), &mut failure), keep)
        });
        let ended = ended.map_err(Failure::run)?;
        self.told(failure)?;
        let record = first.as_deref().and_then(|first| first.last.clone());
        let record = self.broadcast_record(record)?;
        let kept = keep_lloyd(first.as_deref_mut(), &record, &run.sites);
        together(self.ranks, kept.map_err(Failure::run))?;
        self.tell_spent(&run.sites.spent)?;
        self.leave(first, &mut run.sites, ended)?;
        Ok(ended)
    }

    fn driven(
        &self,
        plan: &Plan,
        mut first: IfFirst<'_>,
        (mut sites, state): (RankedSites<'_>, Vec<f64>),
    ) -> Result<RunEnd, Failure> {
        let space = RankedSpace::new(self.ranks, self.space);
        let mut checkpoint = self.shared(sites.everywhere(), &state)?;
        self.measure_first(first.as_deref_mut(), &mut sites)?;
        drop(sites);
        let mut failure = None;
        let mut observe = |record: &Record, sites: &[Point3<f64>], state: &RunState<3>| {
            let keep = |first: IfFirst<'_>| match first {
                Some(first) => first.directory.keep(record, sites, state.numbers()),
                None => Ok(()),
            };
            self.after(record, (first.as_deref_mut(), &mut failure), keep)
        };
        let ended = continue_run(&space, plan, &mut checkpoint, &mut observe);
        let ended = ended.map_err(Failure::run)?;
        self.told(failure)?;
        self.keep_last(first.as_deref_mut(), &checkpoint)?;
        let all = checkpoint.finest_sites(&space).map_err(Failure::run)?;
        let mut sites = RankedSites::of_all(self.ranks, self.space, &all);
        self.leave(first, &mut sites, ended)?;
        Ok(ended)
    }

    /// The checkpoint with which a run ends.
    fn keep_last(&self, first: IfFirst<'_>, checkpoint: &Checkpoint) -> Result<(), Failure> {
        let kept = first
            .zip(checkpoint.record.as_ref())
            .map(|(first, record)| {
                let directory = &mut first.directory;
                directory.keep(record, &checkpoint.sites, checkpoint.numbers())
            });
        together(self.ranks, kept.unwrap_or(Ok(())).map_err(Failure::run))
    }

    /// The failure of a file, if there was one.
    fn told(&self, failure: Option<RunError>) -> Result<(), Failure> {
        let told = failure.map_or(Ok(()), Err);
        together(self.ranks, told.map_err(Failure::run))
    }

    /// Where the run begins or goes on, on all ranks; the first one has what the method remembers.
    fn shared(&self, sites: Vec<Point3<f64>>, state: &[f64]) -> Result<Checkpoint, Failure> {
        let words = state.iter().map(|number| number.to_bits()).collect();
        let words = from_first(self.ranks, words);
        let state: Vec<f64> = words.into_iter().map(f64::from_bits).collect();
        match self.last.clone() {
            None => Ok(Checkpoint::at_start(sites)),
            Some(last) => Checkpoint::from_parts(sites, last, &state).map_err(Failure::run),
        }
    }

    /// The figures of the first sites, where `run.json` has none.
    fn measure_first(
        &self,
        first: IfFirst<'_>,
        sites: &mut RankedSites<'_>,
    ) -> Result<(), Failure> {
        let is_measured = first
            .as_deref()
            .is_some_and(|first| first.description.initial.is_some());
        if any(self.ranks, is_measured) {
            return Ok(());
        }
        let (_, figures) = self.measured(sites)?;
        let described = first.map_or(Ok(()), |first| {
            first.description.initial = Some(figures);
            first.directory.describe(&first.description)
        });
        together(self.ranks, described.map_err(Failure::run))
    }

    /// The figures of the own sites' cells, and of all together.
    fn measured(
        &self,
        sites: &mut RankedSites<'_>,
    ) -> Result<(Vec<CellMetrics<3>>, Metrics), Failure> {
        let cells = sites.own_metrics(energy_spec(&self.scene));
        let cells = cells.map_err(Failure::run)?;
        let iteration = self.last.as_ref().map_or(0, |record| record.iteration);
        let figures = sites.metrics(&cells).checked(iteration);
        Ok((cells, figures.map_err(Failure::run)?))
    }

    /// What follows a record, decided by all ranks together.
    fn after(
        &self,
        record: &Record,
        (mut first, failure): (IfFirst<'_>, &mut Option<RunError>),
        keep: impl FnOnce(IfFirst<'_>) -> Result<(), RunError>,
    ) -> ControlFlow<()> {
        let is_stopped = any(self.ranks, self.signals.interrupt.exit_code().is_some());
        let is_asked = any(self.ranks, self.signals.keep.swap(false, Ordering::SeqCst));
        let is_due = record.iteration.is_multiple_of(self.interval);
        let appended = first.as_deref_mut().map_or(Ok(()), |first| {
            self.show(record);
            first.append(record)
        });
        let kept = match is_due || is_asked || is_stopped {
            true => keep(first),
            false => Ok(()),
        };
        *failure = appended.and(kept).err();
        match is_stopped | any(self.ranks, failure.is_some()) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn show(&self, record: &Record) {
        if !self.is_quiet {
            let line = format!(
                "{}: energy {:.4} %, movement {:.4} %, {:.1} s",
                record.iteration, record.energy_percent, record.movement_percent, record.seconds
            );
            // Where stderr is closed nothing is told.
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    /// The last record in the log, on all ranks.
    fn broadcast_record(&self, record: Option<Record>) -> Result<Record, Failure> {
        let bytes = record.map_or(Ok(Vec::new()), |record| serde_json::to_vec(&record));
        let bytes = together(self.ranks, bytes.map_err(Failure::run))?;
        let all = share_bytes(self.ranks, &bytes);
        serde_json::from_slice(&all[0]).map_err(Failure::run)
    }

    /// The cells of each rank and their list, where they are wanted.
    fn leave_cells(
        &self,
        first: Option<&FirstRank>,
        sites: &mut RankedSites<'_>,
        cells: &[CellMetrics<3>],
    ) -> Result<(), Failure> {
        let output = &self.scene.output;
        if !(output.cells && output.cells_file) {
            return Ok(());
        }
        together(self.ranks, write_piece(self.out, sites, cells))?;
        let pieces = ranks_with_sites(self.ranks, cells.len());
        let listed = first.map_or(Ok(()), |first| write_list(&first.directory, &pieces));
        together(self.ranks, listed)
    }

    /// What each rank has done, where that is wanted: one JSON object a line.
    fn tell_spent(&self, spent: &Spent) -> Result<(), Failure> {
        let own = serde_json::json!({
            "rank": self.ranks.rank(),
            "diagrams": spent.diagrams,
            "own": spent.own,
            "halo": spent.halo,
            "bytes": spent.bytes,
            "cpu_cells": spent.cells,
            "exchange": spent.exchange,
            "peak_memory": peak_memory(),
        });
        let all = share_bytes(self.ranks, format!("{own}\n").as_bytes());
        let is_told = self.tells_timings && self.ranks.rank() == 0;
        if is_told { print(all.concat()) } else { Ok(()) }
    }

    /// Sites, cells and the description of what the run has left.
    fn leave(
        &self,
        mut first: IfFirst<'_>,
        sites: &mut RankedSites<'_>,
        ended: RunEnd,
    ) -> Result<(), Failure> {
        let (cells, figures) = self.measured(sites)?;
        let written = leave_sites(first.as_deref_mut(), sites);
        together(self.ranks, written)?;
        self.leave_cells(first.as_deref(), sites, &cells)?;
        let described = first.map_or(Ok(()), |first| {
            first.description.last = Some(figures);
            first.description.ended = Some(named_end(ended).to_owned());
            first.description.seconds = first.last.as_ref().map_or(0.0, |last| last.seconds);
            first.directory.describe(&first.description)
        });
        together(self.ranks, described.map_err(Failure::run))
    }
}

fn named_end(ended: RunEnd) -> &'static str {
    match ended {
        RunEnd::Iterations => "iterations",
        RunEnd::Tolerance => "tolerance",
        RunEnd::Interrupted => "interrupted",
    }
}
