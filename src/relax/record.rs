//! One line of a run's log.

use nalgebra::Point;
use serde::{Deserialize, Serialize};

use crate::relax::tessellation::{Assessment, Tessellation};

/// The state of a run after `iteration` moves: one flat JSON object of `log.jsonl`.
///
/// Energies are those of the sites in their own diagram, in the scene's norm and order, except
/// `energy_percent`, which is always the p = 1 Chebyshev energy relative to equal cubes
/// (\[BL\] Fig. 13), so that runs compare.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Moves made so far; 0 describes the initial sites.
    pub iteration: u64,
    /// Mean energy of the cells (L^(D+p)).
    pub energy_mean: f64,
    /// Largest energy of a cell (L^(D+p)).
    pub energy_max: f64,
    /// 100 · mean p = 1 Chebyshev energy / that of a cube of the mean volume.
    pub energy_percent: f64,
    /// Mean distance that the sites travelled in the last move (L); 0 for iteration 0.
    pub movement_mean: f64,
    /// Largest such distance (L).
    pub movement_max: f64,
    /// 100 · `movement_mean` / diagonal of a cube of the mean volume (\[BL\] Fig. 13).
    pub movement_percent: f64,
    /// Energy evaluations so far, per site.
    pub evaluations: f64,
    /// Wall time since the run began (s).
    pub seconds: f64,
    /// In which part of its plan the run is.
    #[serde(flatten)]
    pub stage: Stage,
}

/// Where in its plan a run is; empty for plain Lloyd and plain descents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// Levels still to come, in coarse-to-fine runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<u32>,
    /// Kicks made on this level, in runs that have them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub round: Option<u64>,
    /// How many sites this level has, in coarse-to-fine runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sites: Option<usize>,
    /// Whether the move that led here was a lengthened one, in accelerated runs of Lloyd's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lengthened: Option<bool>,
}

/// How far sites travelled in one move (L).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Movement {
    /// The mean over the sites.
    pub mean: f64,
    /// The longest way of a site.
    pub max: f64,
}

impl Movement {
    /// The movement of `sites` to `targets`, the short way round where the space is periodic.
    pub fn between<'a, const D: usize>(
        space: &impl Tessellation<D>,
        sites: &[Point<f64, D>],
        targets: impl Iterator<Item = &'a Point<f64, D>>,
    ) -> Self {
        let mut movement = Self::default();
        for (site, target) in sites.iter().zip(targets) {
            let way = space.displacement(site, target).norm();
            movement.mean += way;
            movement.max = movement.max.max(way);
        }
        movement.mean /= sites.len() as f64;
        movement
    }

    /// The [`percent`](Self::percent) of the movement of `sites` to as many `targets`.
    pub fn percent_between<const D: usize>(
        space: &impl Tessellation<D>,
        sites: &[Point<f64, D>],
        targets: &[Point<f64, D>],
    ) -> f64 {
        let movement = Self::between(space, sites, targets.iter());
        movement.percent::<D>(space.volume(), sites.len())
    }

    /// 100 · mean / diagonal of a cube of the mean of `count` cells' volumes.
    #[must_use]
    pub fn percent<const D: usize>(&self, volume: f64, count: usize) -> f64 {
        let diagonal = optimal_side::<D>(volume, count) * (D as f64).sqrt();
        100.0 * self.mean / diagonal
    }
}

impl Record {
    /// The record of `cells`, the answer for every site, after `movement`; `evaluations` and
    /// `seconds` are left at zero.
    #[must_use]
    pub fn new<const D: usize>(
        iteration: u64,
        volume: f64,
        cells: &[Assessment<D>],
        movement: Movement,
    ) -> Self {
        let totals = (
            cells.len(),
            cells.iter().map(|cell| cell.energy).sum(),
            cells.iter().map(|cell| cell.energy).fold(0.0, f64::max),
            cells.iter().map(|cell| cell.chebyshev).sum(),
        );
        Self::of_totals::<D>(iteration, volume, totals, movement)
    }

    /// The record of so many cells with this total energy, largest energy and total p = 1 Chebyshev
    /// energy; `evaluations`, `seconds` and `stage` are left empty.
    #[must_use]
    pub fn of_totals<const D: usize>(
        iteration: u64,
        volume: f64,
        (count, energy, energy_max, chebyshev): (usize, f64, f64, f64),
        movement: Movement,
    ) -> Self {
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
pub fn optimal_side<const D: usize>(volume: f64, count: usize) -> f64 {
    (volume / count as f64).powf(1.0 / D as f64)
}

/// The order-p Chebyshev energy of that cube about its center, the least that a mean cell can
/// have (L^(D+p)): D/(D+p) · s^(D+p)/2^p, for p = 1 and D = 3 the (3/8) s⁴ of section 3.5.
#[must_use]
pub fn optimal_energy<const D: usize>(volume: f64, count: usize, order: u32) -> f64 {
    let (d, p) = (D as f64, f64::from(order));
    let side = optimal_side::<D>(volume, count);
    d / (d + p) * side.powf(d + p) / 2.0_f64.powf(p)
}
