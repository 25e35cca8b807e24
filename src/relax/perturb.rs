//! Perturbations that take sites out of a local minimum: noise, and sites exchanged for holes.
//!
//! What a descent leaves of a cubic tessellation is mostly perfect, with a few point defects: a row
//! that holds one site too many, somewhere else a hole where a site is missing. Neither can heal
//! alone, and noise would have to carry a site all the way from one to the other. An exchange takes
//! it out of the crowded row, where cells have the least energy, and puts it into the hole, the place
//! farthest from every site (the swap of k-means: Kanungo et al., Comput. Geom. 28, 2004). A descent
//! then closes the gap in the row. The caller keeps the outcome only if the energy fell.

use nalgebra::{Point, SVector};

use crate::geometry::random::Random;
use crate::relax::optimum::{optimal_energy, optimal_side};
use crate::relax::plan::{Perturbation, PerturbationKind};
use crate::relax::relaxation_space::{CellCrowding, RelaxationError, RelaxationSpace};
use crate::relax::state::RunState;

/// Cells of more than this many times the perfect cube's energy get noise.
const IMPERFECT: f64 = 1.003;

/// So many exchanges of a single site may fail before noise is tried.
const PATIENCE: u64 = 4;

/// The least share of the greatest noise that an exchange's noise may have.
const LEAST_NOISE: f64 = 0.25;

/// A vertex of a cell farther from its site than this share of the mean cell's side belongs to a
/// hole; in a perfect cube all vertices are at half of it.
const HOLE: f64 = 0.58;

/// Two holes, or two sites taken out, lie at least so many sides apart: a hole has many vertices,
/// and neighbors taken out together would leave a new one.
const APART: f64 = 1.2;

/// Energies and distances are compared after so much noise, so that the same exchange is not tried
/// again and again.
const JITTER: f64 = 0.03;

/// At most so many sites are exchanged at once.
const MOST_PAIRS: usize = 1000;

/// Perturbs `sites`, given whether the last round was the best, and returns how many evaluations
/// of a cell that took.
pub(crate) fn perturb<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    perturbation: &Perturbation,
    is_better: bool,
    sites: &mut [Point<f64, D>],
    state: &mut RunState<D>,
) -> Result<f64, RelaxationError<S::Error>> {
    let left = 1.0 - state.round as f64 / perturbation.rounds as f64;
    state.round += 1;
    state.perturbed += 1;
    let mut random = Random::stream(perturbation.seed, state.perturbed);
    let side = optimal_side::<D>(space.volume(), sites.len());
    match perturbation.kind {
        PerturbationKind::Anneal => {
            let deviation = perturbation.noise * left.powf(perturbation.fall) * side;
            shake(space, sites, deviation, &mut random, |_| true);
            state.pairs = 0;
            Ok(0.0)
        }
        PerturbationKind::Exchange => {
            if let Some((_, best)) = &state.best {
                sites.copy_from_slice(best);
            }
            let cells = space.crowding(sites)?;
            let pairs = next_pairs(state, is_better, sites.len());
            state.pairs = exchange(space, sites, &cells, pairs, &mut random);
            if state.pairs == 0 {
                state.failures = 0;
                let size = LEAST_NOISE + (1.0 - LEAST_NOISE) * random.uniform();
                let deviation = perturbation.noise * size * side;
                let cube = optimal_energy::<D>(space.volume(), sites.len(), 1);
                let limit = IMPERFECT * space.varying_density().unwrap_or(1.0) * cube;
                let is_imperfect = |site: usize| cells[site].energy >= limit;
                shake(space, sites, deviation, &mut random, is_imperfect);
            }
            Ok(sites.len() as f64)
        }
    }
}

/// How many sites to exchange next: all that there is room for after the start and after noise, as
/// many as last time if that helped, else half as many; none once single ones keep failing.
fn next_pairs<const D: usize>(state: &mut RunState<D>, is_better: bool, count: usize) -> usize {
    if is_better {
        state.failures = 0;
    } else if state.pairs == 1 {
        state.failures += 1;
    }
    match (state.pairs, is_better) {
        _ if state.failures >= PATIENCE => 0,
        (0, _) => count,
        (pairs, true) => pairs,
        (pairs, false) => (pairs / 2).max(1),
    }
}

/// Displaces the sites of which `is_moved` by Gaussian noise of standard deviation `deviation` (L)
/// along every axis, within the domain.
fn shake<const D: usize>(
    space: &impl RelaxationSpace<D>,
    sites: &mut [Point<f64, D>],
    deviation: f64,
    random: &mut Random,
    is_moved: impl Fn(usize) -> bool,
) {
    for (number, site) in sites.iter_mut().enumerate() {
        let noise = SVector::from_fn(|_, _| random.gaussian()) * deviation;
        if is_moved(number) {
            *site = space.displaced(site, noise);
        }
    }
}

/// Moves up to `pairs` sites from crowded cells to holes and returns how many.
fn exchange<const D: usize>(
    space: &impl RelaxationSpace<D>,
    sites: &mut [Point<f64, D>],
    cells: &[CellCrowding<D>],
    pairs: usize,
    random: &mut Random,
) -> usize {
    let side = optimal_side::<D>(space.volume(), sites.len());
    let pairs = pairs.min(MOST_PAIRS);
    let is_apart = |chosen: &[Point<f64, D>], point: &Point<f64, D>| {
        let mut others = chosen.iter();
        others.all(|other| space.displacement(other, point).amax() > APART * side)
    };
    let mut holes: Vec<Point<f64, D>> = Vec::new();
    for cell in order_by(cells, |cell| -cell.distance, random) {
        let CellCrowding {
            vertex, distance, ..
        } = &cells[cell];
        if holes.len() < pairs && *distance > HOLE * side && is_apart(&holes, vertex) {
            holes.push(*vertex);
        }
    }
    let mut removed: Vec<Point<f64, D>> = Vec::new();
    for site in order_by(cells, |cell| cell.energy, random) {
        if removed.len() < holes.len() && is_apart(&removed, &sites[site]) {
            removed.push(sites[site]);
            sites[site] = holes[removed.len() - 1];
        }
    }
    removed.len()
}

/// The cells in the order of a size that is read with some noise.
fn order_by<const D: usize>(
    cells: &[CellCrowding<D>],
    size: impl Fn(&CellCrowding<D>) -> f64,
    random: &mut Random,
) -> Vec<usize> {
    let mut sizes: Vec<(f64, usize)> = cells
        .iter()
        .enumerate()
        .map(|(cell, of)| (size(of) * (1.0 + JITTER * random.gaussian()), cell))
        .collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    sizes.into_iter().map(|(_, cell)| cell).collect()
}
