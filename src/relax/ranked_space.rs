//! A space of which every rank knows all sites and builds its share of the cells.
//!
//! Each move of the driver is made by every rank alike; only what it asks of the space is shared out. So all methods
//! run over ranks, with the bits of one process, and the time of their cells is divided; their vectors are not: a
//! rank holds all sites, and a quasi-Newton descent its pairs of steps and changes, 24 bytes per site and vector.

use std::sync::Mutex;

use nalgebra::{Point3, SVector, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::integrals::exact_sum::exact_sums;
use crate::parallel::map;
use crate::relax::cell_check::{CellsError, EnergyKind};
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::objective::{CellTerms, ObjectiveScratch};
use crate::relax::optimum::EnergyOptimum;
use crate::relax::ranked_sites::RankedSites;
use crate::relax::ranks::{Ranks, RanksError};
use crate::relax::relaxation_space::{
    CellCrowding, CellResult, EnergySpec, ObjectiveValue, RelaxationError, RelaxationSpace,
};
use crate::relax::space::Space;
use crate::voronoi::cell::Cell;

/// A space whose cells the ranks share.
pub(crate) struct RankedSpace<'a> {
    ranks: &'a dyn Ranks,
    space: &'a Space,
    /// How wide the halos were that the last cells needed, and of how many sites.
    widths: Mutex<(Vec<f64>, usize)>,
}

/// The terms that the cell of one site adds to the gradients by others.
struct Push {
    from: u64,
    to: usize,
    term: Vector3<f64>,
}

impl<'a> RankedSpace<'a> {
    /// The space of ranks that all hold the same sites.
    pub(crate) fn new(ranks: &'a dyn Ranks, space: &'a Space) -> Self {
        let widths = Mutex::default();
        Self {
            ranks,
            space,
            widths,
        }
    }

    /// The share of this rank in all sites.
    fn share(&self, all: &[Point3<f64>]) -> RankedSites<'a> {
        let mut share = RankedSites::of_all(self.ranks, self.space, all);
        if let Ok(widths) = self.widths.lock()
            && widths.1 == all.len()
        {
            share.widths.clone_from(&widths.0);
        }
        share
    }

    /// The next cells need halos about as wide as these.
    fn remember(&self, share: &RankedSites<'_>) {
        if let Ok(mut widths) = self.widths.lock() {
            *widths = (share.widths.clone(), share.count);
        }
    }

    /// What `of_cell` says of all cells, each built by one rank, as `W` words.
    fn map<Memory: Default + Send, const W: usize>(
        &self,
        all: &[Point3<f64>],
        of_cell: impl Fn(&mut Memory, &Cell<'_>) -> [u64; W] + Sync,
    ) -> Result<Vec<[u64; W]>, RanksError> {
        let mut share = self.share(all);
        let own = share.map_own(of_cell)?;
        self.remember(&share);
        Ok(self.united(&share, &own))
    }

    /// The words of all cells, from those of each rank's own.
    fn united<const W: usize>(&self, share: &RankedSites<'_>, own: &[[u64; W]]) -> Vec<[u64; W]> {
        let mut words = Vec::with_capacity(own.len() * (W + 1));
        for (number, answer) in share.own.numbers.iter().zip(own) {
            words.push(*number);
            words.extend(answer);
        }
        let mut united = vec![[0; W]; share.count];
        for part in self.ranks.share(words) {
            for words in part.chunks_exact(W + 1) {
                united[words[0] as usize].copy_from_slice(&words[1..]);
            }
        }
        united
    }

    /// The gradients by the own sites: terms are added in the order of the sites that push, as in one process.
    fn gradients(
        &self,
        all: &[Point3<f64>],
        share: &RankedSites<'_>,
        cells: &[CellTerms<3>],
    ) -> Vec<Vector3<f64>> {
        let place_of = |number: u64| share.own.numbers.binary_search(&number).ok();
        let places = map(share.known.len(), &|known| place_of(share.known[known]));
        let pushes = self.pushes(all, share, (cells, &places));
        let mut others = pushes.into_iter().peekable();
        let mut gradients = vec![Vector3::zeros(); cells.len()];
        for (own, cell) in cells.iter().enumerate() {
            let from = share.own.numbers[own];
            while let Some(push) = others.next_if(|push| push.from < from) {
                gradients[push.to] += push.term;
            }
            gradients[own] += cell.gradient;
            for &(neighbor, term) in &cell.across {
                if let Some(to) = places[neighbor as usize] {
                    gradients[to] += term;
                }
            }
        }
        others.for_each(|push| gradients[push.to] += push.term);
        gradients
    }

    /// What cells of other ranks add to the gradients by own sites, in the order of their sites. `places` are
    /// those of the known sites among the own.
    fn pushes(
        &self,
        all: &[Point3<f64>],
        share: &RankedSites<'_>,
        (cells, places): (&[CellTerms<3>], &[Option<usize>]),
    ) -> Vec<Push> {
        let mut parts = vec![Vec::new(); self.ranks.size()];
        for (&from, cell) in share.own.numbers.iter().zip(cells) {
            let others = cell.across.iter();
            for (neighbor, term) in others.filter(|(site, _)| places[*site as usize].is_none()) {
                let to = share.known[*neighbor as usize];
                let [x, y, z] = term.data.0[0].map_each(f64::to_bits);
                parts[share.owner(&all[to as usize])].extend([to, from, x, y, z]);
            }
        }
        let came = self.ranks.exchange(parts);
        let came = came.iter().flat_map(|part| part.as_chunks::<5>().0);
        let pushes = came.filter_map(|&[to, from, x, y, z]| {
            Some(Push {
                from,
                to: share.own.numbers.binary_search(&to).ok()?,
                term: [x, y, z].map_each(f64::from_bits).into(),
            })
        });
        let mut pushes: Vec<_> = pushes.collect();
        // Stable: the terms of one cell stay in its order.
        pushes.sort_by_key(|push| push.from);
        pushes
    }

    /// What every rank knows of each cell: energy, Chebyshev energy, volume, gradient.
    fn terms(&self, all: &[Point3<f64>], order: u32) -> Result<Vec<[u64; 6]>, RanksError> {
        let (space, mut share) = (self.space, self.share(all));
        let cells = share.map_own(|scratch: &mut ObjectiveScratch, cell| {
            scratch.terms(space.domain(), space.frames(), cell, order)
        })?;
        self.remember(&share);
        let gradients = self.gradients(all, &share, &cells);
        let words = cells.iter().zip(&gradients).map(|(cell, gradient)| {
            let [x, y, z] = gradient.data.0[0];
            [cell.energy, cell.chebyshev, cell.volume, x, y, z].map_each(f64::to_bits)
        });
        let words: Vec<_> = words.collect();
        Ok(self.united(&share, &words))
    }
}

impl RelaxationSpace<3> for RankedSpace<'_> {
    type Error = RanksError;

    fn volume(&self) -> f64 {
        self.space.volume()
    }

    fn bounds(&self) -> Bounds<3> {
        self.space.bounds()
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.space.contains(point)
    }

    fn periods(&self) -> [Option<f64>; 3] {
        self.space.periods()
    }

    fn wrap(&self, point: &Point3<f64>) -> Point3<f64> {
        self.space.wrap(point)
    }

    fn varying_density(&self) -> Option<f64> {
        self.space.varying_density()
    }

    fn optimum(&self) -> EnergyOptimum {
        self.space.optimum()
    }

    fn check_scale(&self, count: usize, spec: EnergySpec) -> Result<(), CellsError> {
        self.space.check_scale(count, spec)
    }

    fn displacement(&self, from: &Point3<f64>, to: &Point3<f64>) -> Vector3<f64> {
        self.space.displacement(from, to)
    }

    fn is_box(&self) -> bool {
        self.space.is_box()
    }

    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        self.space.wall_ahead(site, step)
    }

    fn energy(&self, sites: &[Point3<f64>], spec: EnergySpec) -> Result<f64, RanksError> {
        let (domain, frames) = (self.space.domain(), self.space.frames());
        let energies = self.map(sites, |memory: &mut CellMemory, cell| {
            memory.load_in_frame(domain, cell, frames.of(cell.site));
            [memory.energy_at_site(spec).to_bits()]
        })?;
        Ok(energies
            .iter()
            .map(|[energy]| f64::from_bits(*energy))
            .sum())
    }

    fn assess(
        &self,
        sites: &[Point3<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellResult<3>>, RanksError> {
        self.space.check_scale(sites.len(), spec)?;
        let (domain, frames) = (self.space.domain(), self.space.frames());
        let words = self.map(sites, |memory: &mut CellMemory, cell| {
            memory.load_in_frame(domain, cell, frames.of(cell.site));
            words_of_result(&memory.assess(domain, cell, spec))
        })?;
        let cells: Vec<_> = words.into_iter().map(result_of_words).collect();
        let figures = |site: usize| (cells[site].volume, cells[site].energy);
        self.space.check(sites, &figures, spec.kind())?;
        Ok(cells)
    }

    fn objective(
        &self,
        sites: &[Point3<f64>],
        order: u32,
    ) -> Result<ObjectiveValue<3>, RelaxationError<RanksError>> {
        let kind = EnergyKind::Chebyshev(order);
        self.space.totals().check_scale::<3>(sites.len(), kind)?;
        let cells = self.terms(sites, order).map_err(RelaxationError::Space)?;
        let number = |cell: &[u64; 6], place: usize| f64::from_bits(cell[place]);
        let figures = |site: usize| (number(&cells[site], 2), number(&cells[site], 0));
        self.space.check(sites, &figures, kind)?;
        let [energy, chebyshev] = exact_sums(&cells, |cell| [number(cell, 0), number(cell, 1)]);
        let energies: Vec<f64> = cells.iter().map(|cell| number(cell, 0)).collect();
        let gradient = cells
            .iter()
            .map(|cell| [3, 4, 5].map_each(|place| number(cell, place)));
        Ok(ObjectiveValue {
            energy: energy.value(),
            chebyshev: chebyshev.value(),
            energy_max: energies.iter().copied().fold(0.0, f64::max),
            gradient: gradient.map(SVector::from).collect(),
            energies,
        })
    }

    fn crowding(
        &self,
        sites: &[Point3<f64>],
    ) -> Result<Vec<CellCrowding<3>>, RelaxationError<RanksError>> {
        let (domain, frames) = (self.space.domain(), self.space.frames());
        let words = self.map(sites, |memory: &mut CellMemory, cell| {
            memory.load_in_frame(domain, cell, frames.of(cell.site));
            words_of_crowding(&memory.crowding(domain, cell))
        });
        let words = words.map_err(RelaxationError::Space)?;
        Ok(words.into_iter().map(crowding_of_words).collect())
    }
}

fn words_of_crowding(crowding: &CellCrowding<3>) -> [u64; 5] {
    let [x, y, z] = crowding.vertex.coords.data.0[0];
    [crowding.energy, x, y, z, crowding.distance].map(f64::to_bits)
}

fn crowding_of_words(words: [u64; 5]) -> CellCrowding<3> {
    let [energy, x, y, z, distance] = words.map(f64::from_bits);
    CellCrowding {
        energy,
        vertex: Point3::new(x, y, z),
        distance,
    }
}

fn words_of_result(cell: &CellResult<3>) -> [u64; 7] {
    let [x, y, z] = cell.target.coords.data.0[0].map_each(f64::to_bits);
    let [volume, energy, chebyshev] =
        [cell.volume, cell.energy, cell.chebyshev].map_each(f64::to_bits);
    [
        volume,
        energy,
        chebyshev,
        x,
        y,
        z,
        u64::from(cell.evaluations),
    ]
}

fn result_of_words(words: [u64; 7]) -> CellResult<3> {
    let [volume, energy, chebyshev, x, y, z] = std::array::from_fn(|k| f64::from_bits(words[k]));
    CellResult {
        volume,
        energy,
        chebyshev,
        target: Point3::new(x, y, z),
        evaluations: words[6] as u32,
    }
}

impl std::fmt::Debug for RankedSpace<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("RankedSpace")
            .field("rank", &self.ranks.rank())
            .finish_non_exhaustive()
    }
}
