//! One run as the JSON that a page reads: its description, its records as columns, remarks, its cells.

use serde_json::{Value, json};

use crate::relax::optimum::EnergyReference;
use crate::relax::record::Record;
use crate::report::cells::PackedCells;

/// Up to so many records of a run are in the page: some 300 kB, and more than a curve has pixels.
const MOST_RECORDS: usize = 2000;

/// A run on a page.
#[derive(Clone, Debug)]
pub(crate) struct ReportedRun {
    /// Its name.
    pub(crate) name: String,
    /// Its `run.json`.
    pub(crate) description: Value,
    /// Its log.
    pub(crate) records: Vec<Record>,
    /// Sentences that the page says about it.
    pub(crate) notes: Vec<String>,
    /// Its cells, if they are shown.
    pub(crate) cells: Option<PackedCells>,
}

impl ReportedRun {
    /// The run as JSON, without the numbers of its cells.
    #[must_use]
    pub(crate) fn to_json(&self) -> Value {
        json!({
            "name": self.name,
            "run": self.description,
            "records": columns(&thinned(&self.records)),
            "record_count": self.records.len(),
            "asymptotic": self.records.first().is_some_and(is_asymptotic),
            "notes": self.notes,
            "cells": self.cells.as_ref().map(|cells| &cells.header),
        })
    }
}

fn is_asymptotic(record: &Record) -> bool {
    record.energy_reference == Some(EnergyReference::AsymptoticOptimum)
}

/// The records, or of many those with the least and the greatest energy of every stretch of equal length,
/// the first and the last.
fn thinned(records: &[Record]) -> Vec<&Record> {
    if records.len() <= MOST_RECORDS {
        return records.iter().collect();
    }
    let mut kept = vec![0, records.len() - 1];
    let stretches = MOST_RECORDS / 2 - 1;
    for stretch in 0..stretches {
        let place = |k: usize| k * records.len() / stretches;
        let energy = |&k: &usize| records[k].energy_percent;
        let within = || place(stretch)..place(stretch + 1);
        kept.extend(within().min_by(|a, b| energy(a).total_cmp(&energy(b))));
        kept.extend(within().max_by(|a, b| energy(a).total_cmp(&energy(b))));
    }
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|k| &records[k]).collect()
}

fn columns(records: &[&Record]) -> Value {
    let column = |read: fn(&Record) -> f64| -> Vec<f64> {
        records.iter().map(|record| read(record)).collect()
    };
    let iterations: Vec<u64> = records.iter().map(|record| record.iteration).collect();
    json!({
        "iteration": iterations,
        "energy_percent": column(|record| record.energy_percent),
        "energy_mean": column(|record| record.energy_mean),
        "energy_max": column(|record| record.energy_max),
        "movement_percent": column(|record| record.movement_percent),
        "movement_mean": column(|record| record.movement_mean),
        "movement_max": column(|record| record.movement_max),
        "evaluations": column(|record| record.evaluations),
        "seconds": column(|record| record.seconds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relax::optimum::EnergyOptimum;
    use crate::relax::record::{Movement, Totals};

    #[test]
    fn a_long_log_keeps_its_ends_and_its_extremes() {
        let optimum = EnergyOptimum::of_equal_cubes(1.0);
        let energies = (0..50_000_u64).map(|k| match k {
            12_345 => 9.0,
            31_007 => 0.1,
            _ => 2.0 + (k % 97) as f64 * 1e-3,
        });
        let records: Vec<Record> = (0..)
            .zip(energies)
            .map(|(iteration, chebyshev)| {
                let totals = Totals {
                    count: 1,
                    chebyshev,
                    ..Totals::default()
                };
                Record::new::<3>(iteration, (1.0, &optimum), &totals, Movement::default())
            })
            .collect();
        let kept: Vec<u64> = thinned(&records)
            .iter()
            .map(|record| record.iteration)
            .collect();
        assert!(kept.len() <= MOST_RECORDS && kept.len() > MOST_RECORDS / 2);
        assert!(kept.is_sorted_by(|a, b| a < b));
        for iteration in [0, 12_345, 31_007, 49_999] {
            assert!(kept.contains(&iteration), "{iteration}");
        }
        assert_eq!(thinned(&records[..MOST_RECORDS]).len(), MOST_RECORDS);
    }
}
