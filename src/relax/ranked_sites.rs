//! Sites distributed over ranks, and the cells of each rank's own.
//!
//! Sites belong to the rank in whose brick they lie; bricks halve the sites again and again. Before every
//! diagram a rank is sent all sites within a width of its brick, its halo, in their true positions in the whole
//! domain, and builds the cells of its own sites only. A cell that reaches as far as r is right if every site within
//! r is known, so that a brick needs the width max(r − distance to the brick's open sides); where that is more
//! than it had, all is done again with as much, which is enough: more sites make cells smaller.
//!
//! Local indices are in the order of the sites' numbers, and cells are cut in an order that depends on distances and
//! indices alone (`voronoi::search`): what a cell becomes does not depend on who holds its neighbors.

use std::cmp::Ordering;
use std::time::Instant;

use nalgebra::Point3;
use rayon::prelude::*;

use crate::arrays::MapEach;
use crate::integrals::exact_sum::{ExactSum, exact_sums};
use crate::relax::bricks::Bricks;
use crate::relax::cell_check::{CellFigures, CellSums, CellsError, DomainTotals, EnergyKind};
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::metrics::{CellMetrics, FacetHistogram, Metrics, Reduction};
use crate::relax::ranks::{Ranks, RanksError, SomeSites, agreed, renumbered, total};
use crate::relax::relaxation_space::{EnergySpec, RelaxationSpace};
use crate::relax::space::{Space, SpaceError};
use crate::voronoi::cell::Cell;

/// The first width, in sides of the mean cell: enough for most random sites.
const FIRST_WIDTH: f64 = 3.5;

/// The next width is this times what the last diagram needed: it needs less from move to move.
const SPARE: f64 = 1.05;

/// Sites by whose places bricks are divided, per rank.
const SAMPLE: usize = 4096;

/// What diagrams over ranks have taken so far, on one of them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spent {
    /// How many diagrams were made, those made again for a wider halo counted.
    pub(crate) diagrams: u64,
    /// Own sites, over all diagrams.
    pub(crate) own: u64,
    /// Sites of halos, over all diagrams.
    pub(crate) halo: u64,
    /// Bytes that came from other ranks, for halos and in migrations.
    pub(crate) bytes: u64,
    /// The time by [`RankedSites::clock`] of indexes and cells (s).
    pub(crate) cells: f64,
    /// The time of exchanges, waits included (s).
    pub(crate) exchange: f64,
}

/// Sites distributed over ranks, as one of them sees it.
pub(crate) struct RankedSites<'a> {
    pub(crate) ranks: &'a dyn Ranks,
    pub(crate) space: &'a Space,
    /// How many sites there are in all.
    pub(crate) count: usize,
    bricks: Bricks,
    /// How wide the halo of each rank is (L).
    pub(crate) widths: Vec<f64>,
    pub(crate) own: SomeSites,
    /// The numbers of the sites among which the last cells were built.
    pub(crate) known: Vec<u64>,
    pub(crate) spent: Spent,
    /// The time that this process has computed (s); nothing is measured unless somebody gives a clock.
    pub(crate) clock: fn() -> f64,
}

impl<'a> RankedSites<'a> {
    /// Sites of which every rank has some, with numbers from 0 on over all of them.
    pub(crate) fn new(ranks: &'a dyn Ranks, space: &'a Space, some: SomeSites) -> Self {
        let mut count = [some.numbers.len() as i64];
        ranks.add(&mut count);
        let none = Bricks::new(&space.bounds(), space.periods(), Vec::new(), ranks.size());
        let mut sites = Self::of_bricks(ranks, space, none, some, count[0] as usize);
        sites.divide(SAMPLE * ranks.size());
        sites.migrate();
        sites
    }

    /// Sites that every rank has, all of them in the order of their numbers.
    pub(crate) fn of_all(ranks: &'a dyn Ranks, space: &'a Space, all: &[Point3<f64>]) -> Self {
        let step = all.len().div_ceil(SAMPLE * ranks.size()).max(1);
        let sample = all.iter().step_by(step).map(|site| space.wrap(site));
        let (bounds, periods, rank) = (space.bounds(), space.periods(), ranks.rank());
        let bricks = Bricks::new(&bounds, periods, sample.collect(), ranks.size());
        let is_own = |(_, site): &(usize, &Point3<f64>)| {
            let site = space.wrap(site);
            // Far from the brick is a quick no.
            let is_far = bricks.gap(rank, &site) > 0.0;
            !is_far && bricks.owner(&site) == rank
        };
        let own: Vec<_> = all.par_iter().enumerate().filter(is_own).collect();
        let own = SomeSites {
            numbers: own.iter().map(|(number, _)| *number as u64).collect(),
            positions: own.iter().map(|(_, site)| **site).collect(),
        };
        Self::of_bricks(ranks, space, bricks, own, all.len())
    }

    fn of_bricks(
        ranks: &'a dyn Ranks,
        space: &'a Space,
        bricks: Bricks,
        own: SomeSites,
        count: usize,
    ) -> Self {
        let side = (space.volume() / count as f64).cbrt();
        Self {
            ranks,
            space,
            count,
            bricks,
            widths: vec![FIRST_WIDTH * side; ranks.size()],
            own,
            known: Vec::new(),
            spent: Spent::default(),
            clock: || 0.0,
        }
    }

    /// The rank that owns a site.
    pub(crate) fn owner(&self, site: &Point3<f64>) -> usize {
        self.bricks.owner(&self.space.wrap(site))
    }

    /// The sites in `[first, end)` in the order of their numbers, at rank 0; nothing elsewhere. All ranks must ask.
    #[must_use]
    pub(crate) fn gathered(&self, first: u64, end: u64) -> Vec<Point3<f64>> {
        let mut parts = vec![Vec::new(); self.ranks.size()];
        let place = |number: u64| self.own.numbers.partition_point(|&own| own < number);
        parts[0] = (place(first)..place(end))
            .flat_map(|place| self.own.words(place))
            .collect();
        SomeSites::of_words(&self.ranks.exchange(parts)).positions
    }

    /// All sites in the order of their numbers, on every rank.
    pub(crate) fn everywhere(&self) -> Vec<Point3<f64>> {
        let own = (0..self.own.numbers.len()).flat_map(|place| self.own.words(place));
        SomeSites::of_words(&self.ranks.share(own.collect())).positions
    }

    /// The first two own sites that lie in one place or in images of it, and where: no such pair has two owners.
    pub(crate) fn twins(&self) -> Option<([u64; 2], Point3<f64>)> {
        let (numbers, positions) = (&self.own.numbers, &self.own.positions);
        let place = |own: usize| self.space.wrap(&positions[own]);
        let compare = |a: usize, b: usize| {
            let axes = (0..3).map(|axis| place(a)[axis].partial_cmp(&place(b)[axis]));
            axes.flatten().fold(Ordering::Equal, Ordering::then)
        };
        let mut order: Vec<usize> = (0..numbers.len()).collect();
        order.par_sort_by(|&a, &b| compare(a, b));
        let twins = order
            .windows(2)
            .filter(|pair| compare(pair[0], pair[1]).is_eq());
        let least = twins.min_by_key(|pair| pair[1])?;
        Some(([numbers[least[0]], numbers[least[1]]], positions[least[1]]))
    }

    /// New bricks, of as many sites each, by up to [`SAMPLE`] of the sites of every rank.
    pub(crate) fn divide_again(&mut self) {
        self.divide(SAMPLE);
    }

    fn divide(&mut self, most: usize) {
        let step = self.own.positions.len().div_ceil(most).max(1);
        let picked = self.own.positions.iter().step_by(step);
        let words: Vec<u64> = picked
            .flat_map(|site| <[f64; 3]>::from(self.space.wrap(site)).map(f64::to_bits))
            .collect();
        let came = self.ranks.share(words);
        let all = came.iter().flat_map(|part| part.as_chunks::<3>().0);
        let sample = all
            .map(|words| Point3::from(words.map_each(f64::from_bits)))
            .collect();
        let (bounds, periods) = (self.space.bounds(), self.space.periods());
        self.bricks = Bricks::new(&bounds, periods, sample, self.ranks.size());
    }

    /// Sends sites to their owners.
    pub(crate) fn migrate(&mut self) {
        let owners: Vec<usize> = self
            .own
            .positions
            .par_iter()
            .map(|site| self.owner(site))
            .collect();
        let mut parts = vec![Vec::new(); self.ranks.size()];
        for (place, owner) in owners.into_iter().enumerate() {
            parts[owner].extend(self.own.words(place));
        }
        self.own = self.exchanged(parts);
    }

    /// What `of_cell` says of the own sites' cells, with as wide a halo as they need.
    pub(crate) fn map_own<Memory: Default + Send, Answer: Send>(
        &mut self,
        of_cell: impl Fn(&mut Memory, &Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, RanksError> {
        loop {
            let (known, chosen) = self.with_halo();
            let began = (self.clock)();
            let answers = match chosen.is_empty() {
                true => Ok(Vec::new()),
                false => (self.space).of_chosen(&known.positions, &chosen, &of_cell),
            };
            self.note_diagram(&known, (self.clock)() - began);
            let told = answers.map_err(|error| renumbered(error, &known.numbers).to_string());
            let answers =
                agreed(self.ranks, told).map_err(|message| RanksError::Failed { message })?;
            let mut needed = vec![0.0; self.ranks.size()];
            needed[self.ranks.rank()] = self.needed(answers.iter().map(|(_, reach)| *reach));
            self.ranks.largest(&mut needed);
            let pairs = needed.iter().zip(&self.widths);
            let is_enough = pairs.clone().all(|(needed, width)| needed <= width);
            if is_enough {
                self.widths = needed.iter().map(|needed| SPARE * needed).collect();
                self.known = known.numbers;
                return Ok(answers.into_iter().map(|(answer, _)| answer).collect());
            }
            let wider = pairs.map(|(needed, width)| width.max(SPARE * needed));
            self.widths = wider.collect();
        }
    }

    fn note_diagram(&mut self, known: &SomeSites, seconds: f64) {
        let own = self.own.numbers.len() as u64;
        let spent = &mut self.spent;
        spent.diagrams += 1;
        spent.own += own;
        spent.halo += known.numbers.len() as u64 - own;
        spent.cells += seconds;
    }

    /// The sites that the others send here.
    fn exchanged(&mut self, parts: Vec<Vec<u64>>) -> SomeSites {
        let began = Instant::now();
        let came = self.ranks.exchange(parts);
        self.spent.exchange += began.elapsed().as_secs_f64();
        let others = came
            .iter()
            .enumerate()
            .filter(|(rank, _)| *rank != self.ranks.rank());
        self.spent.bytes += others.map(|(_, part)| 8 * part.len() as u64).sum::<u64>();
        SomeSites::of_words(&came)
    }

    /// Gives `add` what `of_cell` says of the own sites' cells in their order, `held` at a time. The sites lie where
    /// [`map_own`](Self::map_own) was asked last, so that halos are wide enough.
    pub(crate) fn stream_own<Memory: Default + Send, Answer: Send>(
        &mut self,
        held: usize,
        of_cell: impl Fn(&mut Memory, &Cell<'_>) -> Answer + Sync,
        mut add: impl FnMut(Answer),
    ) -> Result<(), SpaceError> {
        let (known, chosen) = self.with_halo();
        for chosen in chosen.chunks(held) {
            let answers = self.space.of_chosen(&known.positions, chosen, &of_cell)?;
            answers.into_iter().for_each(|(answer, _)| add(answer));
        }
        Ok(())
    }

    /// The own sites with those within each rank's width of its brick, and the places of the own.
    fn with_halo(&mut self) -> (SomeSites, Vec<usize>) {
        let (size, rank) = (self.ranks.size(), self.ranks.rank());
        let mut parts = vec![Vec::new(); size];
        let others = (0..size).filter(|&other| other != rank);
        for other in others {
            let is_wanted = |site: &Point3<f64>| {
                self.bricks.gap(other, &self.space.wrap(site)) <= self.widths[other]
            };
            let wanted = self.own.positions.par_iter().enumerate();
            let wanted = wanted.filter(|(_, site)| is_wanted(site));
            parts[other] = wanted
                .flat_map_iter(|(place, _)| self.own.words(place))
                .collect();
        }
        let halo = self.exchanged(parts);
        self.own.merged(&halo)
    }

    /// How wide the halo must be for cells that reach so far (L).
    fn needed(&self, reaches: impl Iterator<Item = f64>) -> f64 {
        let rank = self.ranks.rank();
        let each = self.own.positions.iter().zip(reaches).map(|(site, reach)| {
            let inside = self.bricks.depth(rank, &self.space.wrap(site));
            reach * (1.0 + 1e-9) - inside
        });
        each.fold(0.0, f64::max)
    }

    /// Refuses cells that are no tessellation together; the figures are those of the own sites' cells.
    ///
    /// # Errors
    /// [`CellsError`], the same on all ranks.
    pub(crate) fn check(
        &self,
        figures: &[CellFigures],
        kind: EnergyKind,
    ) -> Result<(), RanksError> {
        let totals = self.space.totals();
        let [volume, energy] = exact_sums(figures, |&(volume, energy)| [volume, energy]);
        let sums = CellSums {
            count: self.count,
            volume: total(self.ranks, &volume),
            energy: total(self.ranks, &energy),
        };
        let numbered = || self.own.numbers.iter().zip(figures.iter().copied());
        let mut cells = numbered();
        let fault = cells.find(|(_, (volume, _))| !totals.is_possible(*volume));
        let fault = fault
            .map(|(site, (volume, _))| format!("the cell of site {site} has the volume {volume}"));
        let cause = agreed(self.ranks, fault.map_or(Ok(()), Err)).err();
        let mut cells = numbered();
        let beyond =
            cells.find_map(|(&site, cell)| DomainTotals::out_of_range(site as usize, cell, kind));
        let beyond = beyond.map(|error: CellsError| error.to_string());
        let beyond = agreed(self.ranks, beyond.map_or(Ok(()), Err));
        if cause.is_none()
            && totals.is_filled(sums.volume)
            && let Err(message) = beyond
        {
            return Err(RanksError::Failed { message });
        }
        let unknown = || "no single cell is at fault".to_owned();
        let is_possible = cause.is_none();
        totals.check_sums::<3>(&sums, is_possible, kind, || cause.unwrap_or_else(unknown))?;
        Ok(())
    }

    /// The figures of the own sites' cells.
    pub(crate) fn own_metrics(
        &mut self,
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<3>>, RanksError> {
        let space = self.space;
        let cells = self.map_own(|memory: &mut CellMemory, cell| {
            memory.load_in_frame(space.domain(), cell, space.frames().of(cell.site));
            memory.metrics(space.domain(), cell, spec)
        })?;
        let figures: Vec<_> = cells
            .iter()
            .map(|cell| (cell.volume, cell.energy))
            .collect();
        self.check(&figures, spec.kind())?;
        let mut numbered = self.own.numbers.iter().zip(&cells);
        let checked = numbered.try_for_each(|(&site, cell)| cell.check(site as usize));
        let checked = agreed(self.ranks, checked.map_err(|error| error.to_string()));
        checked.map_err(|message| RanksError::Failed { message })?;
        Ok(cells)
    }

    /// The figures of all cells together.
    pub(crate) fn metrics(&self, own: &[CellMetrics<3>]) -> Metrics {
        let reduction = OverRanks {
            ranks: self.ranks,
            count: self.count,
        };
        Metrics::reduced(self.space.volume(), &self.space.optimum(), own, &reduction)
    }
}

impl SomeSites {
    /// These sites and others in the order of their numbers, and the places of these.
    fn merged(&self, others: &Self) -> (Self, Vec<usize>) {
        let count = self.numbers.len() + others.numbers.len();
        let mut all = Self {
            numbers: Vec::with_capacity(count),
            positions: Vec::with_capacity(count),
        };
        let mut places = Vec::with_capacity(self.numbers.len());
        let mut other = 0;
        for (number, position) in self.numbers.iter().zip(&self.positions) {
            while other < others.numbers.len() && others.numbers[other] < *number {
                all.numbers.push(others.numbers[other]);
                all.positions.push(others.positions[other]);
                other += 1;
            }
            places.push(all.numbers.len());
            all.numbers.push(*number);
            all.positions.push(*position);
        }
        all.numbers.extend_from_slice(&others.numbers[other..]);
        all.positions.extend_from_slice(&others.positions[other..]);
        (all, places)
    }
}

/// Figures of the cells of all ranks.
struct OverRanks<'a> {
    ranks: &'a dyn Ranks,
    count: usize,
}

impl Reduction for OverRanks<'_> {
    fn count(&self, _: usize) -> usize {
        self.count
    }

    fn total(&self, own: &ExactSum) -> f64 {
        total(self.ranks, own)
    }

    fn largest(&self, own: f64) -> f64 {
        let mut largest = [own];
        self.ranks.largest(&mut largest);
        largest[0]
    }

    fn histogram(&self, own: FacetHistogram) -> FacetHistogram {
        let words = own
            .iter()
            .flat_map(|(&facets, &cells)| [u64::from(facets), cells as u64]);
        let mut all = FacetHistogram::new();
        for part in self.ranks.share(words.collect()) {
            for &[facets, cells] in part.as_chunks::<2>().0 {
                *all.entry(facets as u32).or_insert(0) += cells as usize;
            }
        }
        all
    }
}

impl std::fmt::Debug for RankedSites<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut text = formatter.debug_struct("RankedSites");
        text.field("rank", &self.ranks.rank());
        text.field("own", &self.own.numbers.len());
        text.finish_non_exhaustive()
    }
}
