//! One line of a run's log.

use serde::{Deserialize, Serialize};

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
}
