//! What gets sites out of a local minimum.

use nalgebra::Point3;

use crate::geometry::random::Random;
use crate::relax::exchange::{Room, exchange, rooms};
use crate::relax::noise::shake;
use crate::relax::plan::{KickStyle, Kicks, Plan};
use crate::relax::record::{optimal_energy, optimal_side};
use crate::relax::space::Space;
use crate::relax::stand::Stand;
use crate::relax::tessellation::Tessellation;
use crate::voronoi::diagram::DiagramError;

/// Cells worth more than this many times the perfect cube get noise.
const IMPERFECT: f64 = 1.003;

/// So many exchanges of a single site may fail before noise is tried.
const PATIENCE: u64 = 4;

/// The least share of the greatest noise that an exchange's noise may have.
const LEAST_NOISE: f64 = 0.25;

/// All cells are cubes if the energy exceeds the least possible one by no more than this share: the
/// last descent does the rest. Far more than the gain that a round must bring.
const PERFECT: f64 = 1e-7;

/// Whether sites of this energy and number have cubes for cells, but for a last descent. Where some
/// places weigh more than others nobody knows the least energy.
pub(crate) fn is_perfect(space: &Space, energy: f64, count: usize, order: u32) -> bool {
    let least = count as f64 * optimal_energy::<3>(space.volume(), count, order);
    !space.domain().has_density() && energy <= least * (1.0 + PERFECT)
}

/// Whether the present level may be kicked again: rounds are left, and its best sites do not yet have
/// cubes for cells.
pub(crate) fn has_kicks_left(space: &Space, plan: &Plan, stand: &Stand) -> bool {
    let (Some(kicks), Some((energy, best))) = (plan.kicks, &stand.best) else {
        return false;
    };
    stand.round < kicks.rounds && !is_perfect(space, *energy, best.len(), plan.question.order)
}

/// Disturbs `sites`, given whether the last round was the best, and returns how many evaluations
/// of a cell that took.
pub(crate) fn kick(
    space: &Space,
    kicks: &Kicks,
    is_better: bool,
    sites: &mut [Point3<f64>],
    stand: &mut Stand,
) -> Result<f64, DiagramError> {
    let left = 1.0 - stand.round as f64 / kicks.rounds as f64;
    stand.round += 1;
    stand.kicked += 1;
    let mut random = Random::stream(kicks.seed, stand.kicked);
    let side = optimal_side::<3>(space.volume(), sites.len());
    match kicks.style {
        KickStyle::Anneal => {
            shake(
                space,
                sites,
                kicks.noise * left.powf(kicks.fall) * side,
                &mut random,
                |_| true,
            );
            stand.pairs = 0;
            Ok(0.0)
        }
        KickStyle::Exchange => {
            if let Some((_, best)) = &stand.best {
                sites.copy_from_slice(best);
            }
            let rooms = rooms(space, sites)?;
            let pairs = next_pairs(stand, is_better, sites.len());
            stand.pairs = exchange(space, sites, &rooms, pairs, &mut random);
            if stand.pairs == 0 {
                stand.failures = 0;
                let size = LEAST_NOISE + (1.0 - LEAST_NOISE) * random.uniform();
                shake_imperfect(space, sites, &rooms, kicks.noise * size * side, &mut random);
            }
            Ok(sites.len() as f64)
        }
    }
}

/// How many sites to exchange next: all that there is room for after the start and after noise, as
/// many as last time if that helped, else half as many; none once single ones keep failing.
fn next_pairs(stand: &mut Stand, is_better: bool, count: usize) -> usize {
    if is_better {
        stand.failures = 0;
    } else if stand.pairs == 1 {
        stand.failures += 1;
    }
    match (stand.pairs, is_better) {
        _ if stand.failures >= PATIENCE => 0,
        (0, _) => count,
        (pairs, true) => pairs,
        (pairs, false) => (pairs / 2).max(1),
    }
}

fn shake_imperfect(
    space: &Space,
    sites: &mut [Point3<f64>],
    rooms: &[Room],
    deviation: f64,
    random: &mut Random,
) {
    let cube = optimal_energy::<3>(space.volume(), sites.len(), 1);
    let limit = IMPERFECT * space.domain().mean_density() * cube;
    let is_imperfect = |site: usize| rooms[site].energy >= limit;
    shake(space, sites, deviation, random, is_imperfect);
}
