//! Records of a run: one line of its log per move.

use nalgebra::Point;
#[cfg(feature = "scene")]
use serde::{Deserialize, Serialize};

use crate::integrals::exact_sum::{ExactSum, exact_sums};
use crate::parallel::{RUN, map_runs};
use crate::relax::optimum::{EnergyOptimum, EnergyReference, optimal_side};
use crate::relax::relaxation_space::{CellResult, ObjectiveValue, RelaxationSpace};

/// The state of a run after `iteration` moves: one flat JSON object of `log.jsonl`.
///
/// Energies are those of the sites in their own diagram, in the scene's norm and order, except
/// `energy_percent`, which is always the p = 1 Chebyshev energy relative to equal cubes
/// (\[BL\] Fig. 13), so that runs compare.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Relaxation};
///
/// let outcome = Relaxation::new(Cuboid::unit()).run(&mut vec![[0.3; 3], [0.6; 3]])?;
/// let energies: Vec<f64> = outcome.records.iter().map(|record| record.energy_percent).collect();
/// assert!(energies[50] < energies[0]);
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Record {
    /// Moves made so far; 0 describes the initial sites.
    pub iteration: u64,
    /// Mean energy of the cells (L^(D+p)).
    pub energy_mean: f64,
    /// Largest energy of a cell (L^(D+p)).
    pub energy_max: f64,
    /// 100 · mean p = 1 Chebyshev energy / that of a cube of the mean volume; with a density / that of
    /// the asymptotic optimum, which few sites may pass below.
    pub energy_percent: f64,
    /// Mean distance between the sites before and after the last move (L); 0 for iteration 0.
    pub movement_mean: f64,
    /// Largest such distance (L).
    pub movement_max: f64,
    /// 100 · `movement_mean` / diagonal of a cube of the mean volume (\[BL\] Fig. 13).
    pub movement_percent: f64,
    /// Energy evaluations so far, per site.
    pub evaluations: f64,
    /// Wall time since the run began (s).
    pub seconds: f64,
    /// What `energy_percent` is relative to, if not equal cubes.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub energy_reference: Option<EnergyReference>,
    /// The part of its plan that the run is in.
    #[cfg_attr(feature = "scene", serde(flatten))]
    pub stage: Stage,
}

/// The part of its plan that a run is in; empty for plain Lloyd and plain descents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize))]
pub struct Stage {
    /// Levels still to come, in coarse-to-fine runs.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub level: Option<u32>,
    /// Perturbations made on this level, in runs that have them.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub round: Option<u64>,
    /// How many sites this level has, in coarse-to-fine runs.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub sites: Option<usize>,
    /// Whether the move that led here was a lengthened one, in accelerated runs of Lloyd's.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub lengthened: Option<bool>,
}

/// How far sites went in one move (L).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Movement {
    /// The mean over the sites.
    pub mean: f64,
    /// The largest of them.
    pub max: f64,
}

impl Movement {
    /// The movement of `sites` to `targets`, the short way round where the space is periodic.
    pub fn between<const D: usize>(
        space: &impl RelaxationSpace<D>,
        sites: &[Point<f64, D>],
        targets: &[Point<f64, D>],
    ) -> Self {
        let sums = MovementSums::of(space, sites, targets);
        Self {
            mean: sums.total.value() / sites.len() as f64,
            max: sums.max,
        }
    }

    /// 100 · mean / diagonal of a cube of the mean of `count` cells' volumes.
    #[must_use]
    pub fn percent<const D: usize>(&self, volume: f64, count: usize) -> f64 {
        let diagonal = optimal_side::<D>(volume, count) * (D as f64).sqrt();
        100.0 * self.mean / diagonal
    }
}

/// The sum of the ways of some sites, exactly, and the longest.
#[derive(Clone, Debug, Default)]
pub(crate) struct MovementSums {
    pub(crate) total: ExactSum,
    pub(crate) max: f64,
}

impl MovementSums {
    /// The ways of `sites` to `targets`.
    pub(crate) fn of<const D: usize>(
        space: &impl RelaxationSpace<D>,
        sites: &[Point<f64, D>],
        targets: &[Point<f64, D>],
    ) -> Self {
        let runs = map_runs(sites.len(), RUN, |run| {
            let mut sums = Self::default();
            for (site, target) in sites[run.clone()].iter().zip(&targets[run]) {
                let distance = space.displacement(site, target).norm();
                sums.total.add(distance);
                sums.max = sums.max.max(distance);
            }
            sums
        });
        let mut sums = Self::default();
        for run in runs {
            sums.total.merge(run.total);
            sums.max = sums.max.max(run.max);
        }
        sums
    }
}

/// The totals of a diagram's cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// How many cells there are.
    pub count: usize,
    /// The sum of their energies (L^(D+p)).
    pub energy: f64,
    /// The largest of them (L^(D+p)).
    pub energy_max: f64,
    /// The sum of their p = 1 Chebyshev energies, per mean density (L^(D+1)).
    pub chebyshev: f64,
}

impl Totals {
    /// The totals of `cells`.
    #[must_use]
    pub fn of_cells<const D: usize>(cells: &[CellResult<D>]) -> Self {
        let [energy, chebyshev] = exact_sums(cells, |cell| [cell.energy, cell.chebyshev]);
        let largest = map_runs(cells.len(), RUN, |run| {
            let energies = cells[run].iter().map(|cell| cell.energy);
            energies.fold(0.0, f64::max)
        });
        Self {
            count: cells.len(),
            energy: energy.value(),
            energy_max: largest.into_iter().fold(0.0, f64::max),
            chebyshev: chebyshev.value(),
        }
    }

    /// The totals that the objective was summed with.
    #[must_use]
    pub fn of_objective<const D: usize>(objective: &ObjectiveValue<D>) -> Self {
        Self {
            count: objective.energies.len(),
            energy: objective.energy,
            energy_max: objective.energy_max,
            chebyshev: objective.chebyshev,
        }
    }
}

impl Record {
    /// The record of `totals` in a domain of volume `volume` after `movement`; `evaluations`, `seconds` and `stage` are left empty.
    #[must_use]
    pub fn new<const D: usize>(
        iteration: u64,
        (volume, optimum): (f64, &EnergyOptimum),
        totals: &Totals,
        movement: Movement,
    ) -> Self {
        let Totals {
            count,
            energy,
            energy_max,
            chebyshev,
        } = *totals;
        let cells = count as f64;
        Self {
            iteration,
            energy_mean: energy / cells,
            energy_max,
            energy_percent: optimum.percent::<D>(chebyshev / cells, count),
            movement_mean: movement.mean,
            movement_max: movement.max,
            movement_percent: movement.percent::<D>(volume, count),
            evaluations: 0.0,
            seconds: 0.0,
            energy_reference: optimum.named(),
            stage: Stage::default(),
        }
    }

    /// The first figure that is no number, with its name.
    pub(crate) fn not_finite(&self) -> Option<(&'static str, f64)> {
        let figures = [
            ("energy_mean", self.energy_mean),
            ("energy_max", self.energy_max),
            ("energy_percent", self.energy_percent),
            ("movement_mean", self.movement_mean),
            ("movement_max", self.movement_max),
            ("movement_percent", self.movement_percent),
            ("evaluations", self.evaluations),
            ("seconds", self.seconds),
        ];
        figures.into_iter().find(|(_, value)| !value.is_finite())
    }
}
