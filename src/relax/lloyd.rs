//! Lloyd's iteration: every site moves to the minimizer of its own cell's energy.
//!
//! With the Chebyshev norm this is the L2∣∞ Lloyd relaxation of \[BL\] section 3.5, with the
//! Euclidean norm the classical one. The loop is the same in the plane and in space.

use std::ops::ControlFlow;
use std::time::Instant;

use nalgebra::Point;

use crate::relax::over_relaxation::{Moves, advance, look};
use crate::relax::record::{Movement, Record};
use crate::relax::tessellation::{Question, Tessellation};

/// When to stop, and what to minimize.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LloydOptions {
    /// Moves in total, those before a resumption counted.
    pub iterations: u64,
    /// Stop after a move with `movement_percent` below this.
    pub tolerance: f64,
    /// What is asked of every cell.
    pub question: Question,
    /// Whether moves are lengthened where that ends lower
    /// ([`over_relaxation`](crate::relax::over_relaxation)).
    pub is_accelerated: bool,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All iterations were made.
    Iterations,
    /// The movement fell below the tolerance.
    Tolerance,
    /// The observer asked to stop.
    Interrupted,
}

/// Is shown a record and the sites it describes, and says whether to go on.
pub type Observer<'a, const D: usize> =
    dyn FnMut(&Record, &[Point<f64, D>]) -> ControlFlow<()> + 'a;

/// Relaxes `sites` in place, from the start or from where `last` was recorded.
///
/// The observer is shown every new record together with the sites that it describes, and may ask
/// to stop. To continue a run, give the record and the sites that the observer was shown: the
/// continued run is bit-identical to an uninterrupted one.
///
/// # Errors
/// When the sites have no diagram; `sites` are then as in the last record shown.
pub fn lloyd<const D: usize, Space: Tessellation<D>>(
    space: &Space,
    sites: &mut [Point<f64, D>],
    options: &LloydOptions,
    last: Option<&Record>,
    observer: &mut Observer<'_, D>,
) -> Result<Ended, Space::Error> {
    let began = Instant::now();
    let count = sites.len() as f64;
    let earlier = last.map_or(0.0, |record| record.seconds);
    let mut evaluations = last.map_or(0.0, |record| (record.evaluations * count).round());
    let mut known = last.cloned();
    let mut iteration = last.map_or(0, |record| record.iteration);
    if let Some(ended) = known.as_ref().and_then(|record| ended(record, options)) {
        return Ok(ended);
    }
    let mut movement = Movement::default();
    let mut now = look(space, sites.to_vec(), options.question)?;
    let moves = Moves {
        question: options.question,
        is_accelerated: options.is_accelerated,
    };
    loop {
        let record = match known.take() {
            Some(record) => record,
            None => {
                evaluations += now.evaluations as f64;
                let mut record = Record::new(iteration, space.volume(), &now.cells, movement);
                let is_moved = options.is_accelerated && iteration > 0;
                record.stage.lengthened = is_moved.then_some(now.is_lengthened);
                record.evaluations = evaluations / count;
                record.seconds = earlier + began.elapsed().as_secs_f64();
                if observer(&record, sites).is_break() {
                    return Ok(Ended::Interrupted);
                }
                record
            }
        };
        if let Some(ended) = ended(&record, options) {
            return Ok(ended);
        }
        now = advance(space, sites, &now.cells, moves)?;
        movement = Movement::between(space, sites, now.sites.iter());
        sites.clone_from_slice(&now.sites);
        iteration += 1;
    }
}

fn ended(record: &Record, options: &LloydOptions) -> Option<Ended> {
    if record.iteration > 0 && record.movement_percent < options.tolerance {
        Some(Ended::Tolerance)
    } else if record.iteration >= options.iterations {
        Some(Ended::Iterations)
    } else {
        None
    }
}
