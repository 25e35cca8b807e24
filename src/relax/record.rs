//! Records of a run: one line of its log per move.

use nalgebra::Point;
#[cfg(feature = "scene")]
use serde::{Deserialize, Serialize};

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
    /// 100 · mean p = 1 Chebyshev energy / that of a cube of the mean volume.
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
    pub fn between<'a, const D: usize>(
        space: &impl RelaxationSpace<D>,
        sites: &[Point<f64, D>],
        targets: impl Iterator<Item = &'a Point<f64, D>>,
    ) -> Self {
        let mut movement = Self::default();
        for (site, target) in sites.iter().zip(targets) {
            let distance = space.displacement(site, target).norm();
            movement.mean += distance;
            movement.max = movement.max.max(distance);
        }
        movement.mean /= sites.len() as f64;
        movement
    }

    /// 100 · mean / diagonal of a cube of the mean of `count` cells' volumes.
    #[must_use]
    pub fn percent<const D: usize>(&self, volume: f64, count: usize) -> f64 {
        let diagonal = optimal_side::<D>(volume, count) * (D as f64).sqrt();
        100.0 * self.mean / diagonal
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
        Self {
            count: cells.len(),
            energy: cells.iter().map(|cell| cell.energy).sum(),
            energy_max: cells.iter().map(|cell| cell.energy).fold(0.0, f64::max),
            chebyshev: cells.iter().map(|cell| cell.chebyshev).sum(),
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
    /// The record of `totals` after `movement`; `evaluations`, `seconds` and `stage` are left empty.
    #[must_use]
    pub fn new<const D: usize>(
        iteration: u64,
        volume: f64,
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
            energy_percent: 100.0 * chebyshev / cells / optimal_energy::<D>(volume, count, 1),
            movement_mean: movement.mean,
            movement_max: movement.max,
            movement_percent: movement.percent::<D>(volume, count),
            evaluations: 0.0,
            seconds: 0.0,
            stage: Stage::default(),
        }
    }
}

/// The side of a cube (a square, for D = 2) of the mean cell's volume (L).
#[must_use]
pub(crate) fn optimal_side<const D: usize>(volume: f64, count: usize) -> f64 {
    (volume / count as f64).powf(1.0 / D as f64)
}

/// The order-p Chebyshev energy of that cube about its center, the least that a mean cell can
/// have (L^(D+p)): D/(D+p) · s^(D+p)/2^p, for p = 1 and D = 3 the (3/8) s⁴ of section 3.5.
#[must_use]
pub(crate) fn optimal_energy<const D: usize>(volume: f64, count: usize, order: u32) -> f64 {
    let (d, p) = (D as f64, f64::from(order));
    let side = optimal_side::<D>(volume, count);
    d / (d + p) * side.powf(d + p) / 2.0_f64.powf(p)
}
