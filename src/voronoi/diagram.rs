//! The Voronoi diagram of all sites: validated input, cells visited in parallel, results in site order.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use nalgebra::Point3;
use rayon::prelude::*;
use thiserror::Error;

use crate::domain::domain::Domain;
use crate::parallel::{Memories, discard, map, map_runs};
use crate::voronoi::cell::{Cell, CellBuilder};
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::search::Duplicate;

/// The cells of a thread's task: enough to outweigh its memory, few enough to balance.
const CELLS_PER_TASK: usize = 64;

/// How many cells' results are kept at a time when they are streamed: enough for all threads, some
/// megabytes for results of the size of a cell.
const CELLS_PER_CHUNK: usize = 4096;

/// A flag that stops work when it is raised, if there is one.
pub(crate) type StopFlag = Option<Arc<AtomicBool>>;

/// Why a place has no result.
enum Halt {
    Duplicate(Duplicate),
    Stopped,
}

/// The clipped Voronoi diagram of sites in a domain.
///
/// It holds a spatial index, not the cells: those are built when they are visited, each in the memory
/// of the one before, so that a diagram of 10⁷ sites takes no memory for its cells.
#[derive(Debug)]
pub struct Diagram<'a> {
    domain: &'a dyn Domain,
    sites: Cow<'a, [Point3<f64>]>,
    /// Built on first use; none if that was stopped.
    tree: OnceLock<Option<KdTree>>,
    stop: StopFlag,
}

/// Why sites have no diagram. Indices count from zero.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Diagram, DiagramError};
///
/// let cube = Cuboid::unit();
/// let outside = Diagram::new(&cube, &[[0.5, 0.5, 1.5]]);
/// assert!(matches!(outside, Err(DiagramError::Outside { site: 0, .. })));
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum DiagramError {
    /// There are no sites.
    #[error("there are no sites; at least one is needed")]
    NoSites,
    /// More sites than the index can number.
    #[error("{count} sites are more than the {} that can be numbered", u32::MAX - 1)]
    TooManySites {
        /// How many.
        count: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("site {site} lies at {position:?}; coordinates must be finite")]
    NotFinite {
        /// The site's index.
        site: usize,
        /// Its position.
        position: [f64; 3],
    },
    /// A site lies outside the domain.
    #[error("site {site} at {position:?} lies outside the domain; move or remove it")]
    Outside {
        /// The site's index.
        site: usize,
        /// Its position.
        position: [f64; 3],
    },
    /// Two sites lie in the same place.
    #[error(
        "sites {first} and {second} are duplicates: both lie at {position:?} (or at periodic \
         images of it); remove one of them"
    )]
    Duplicate {
        /// The smaller index.
        first: usize,
        /// The greater index.
        second: usize,
        /// The position of the first.
        position: [f64; 3],
    },
    /// A site was chosen that is not there.
    #[error("there is no site {site} among {count}; the first is 0")]
    NoSuchSite {
        /// Its index.
        site: usize,
        /// How many sites there are.
        count: usize,
    },
    /// The flag of [`Diagram::stop_by`] was raised.
    #[error("the work was stopped before its end")]
    Stopped,
}

impl<'a> Diagram<'a> {
    /// The diagram of `sites` in `domain`; sites are `[f64; 3]` or nalgebra's points.
    ///
    /// # Errors
    /// When there are no sites, or one is not finite or outside the domain. Duplicates are found
    /// when cells are built.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Diagram};
    ///
    /// let cube = Cuboid::unit();
    /// let diagram = Diagram::new(&cube, &[[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]])?;
    /// let volumes = diagram.map_cells(|cell| cell.volume())?;
    /// assert!(volumes.iter().all(|volume| (volume - 0.5).abs() < 1e-15));
    /// assert_eq!(diagram.locate([0.9, 0.1, 0.2]), Some(1));
    /// # Ok::<(), chebloyd::DiagramError>(())
    /// ```
    pub fn new<P: Copy + Into<Point3<f64>>>(
        domain: &'a dyn Domain,
        sites: &[P],
    ) -> Result<Self, DiagramError> {
        let points = sites.iter().map(|&site| site.into()).collect();
        Self::of(domain, Cow::Owned(points))
    }

    /// As [`Diagram::new`], without a copy of the sites.
    pub(crate) fn borrowed(
        domain: &'a dyn Domain,
        sites: &'a [Point3<f64>],
    ) -> Result<Self, DiagramError> {
        Self::of(domain, Cow::Borrowed(sites))
    }

    fn of(domain: &'a dyn Domain, sites: Cow<'a, [Point3<f64>]>) -> Result<Self, DiagramError> {
        if sites.is_empty() {
            return Err(DiagramError::NoSites);
        }
        if sites.len() >= u32::MAX as usize {
            let count = sites.len();
            return Err(DiagramError::TooManySites { count });
        }
        let numbered = sites.par_iter().enumerate();
        let check = |(site, point)| refused_site(domain, site, point);
        if let Some(error) = numbered.find_map_first(check) {
            return Err(error);
        }
        Ok(Self {
            domain,
            sites,
            tree: OnceLock::new(),
            stop: None,
        })
    }

    /// The same diagram, whose work ends in [`DiagramError::Stopped`] soon after another thread has raised
    /// `flag`: within tenths of a second also with 10⁷ sites.
    ///
    /// # Examples
    /// ```
    /// use std::sync::{Arc, atomic::{AtomicBool, Ordering}};
    /// use chebloyd::{Cuboid, Diagram, DiagramError};
    ///
    /// let (cube, flag) = (Cuboid::unit(), Arc::new(AtomicBool::new(false)));
    /// let diagram = Diagram::new(&cube, &[[0.5; 3]])?.stop_by(&flag);
    /// flag.store(true, Ordering::Relaxed);
    /// assert_eq!(diagram.map_cells(|cell| cell.volume()), Err(DiagramError::Stopped));
    /// # Ok::<(), DiagramError>(())
    /// ```
    #[must_use]
    pub fn stop_by(self, flag: &Arc<AtomicBool>) -> Self {
        self.with_stop(&Some(flag.clone()))
    }

    /// As [`Diagram::stop_by`], where there may be no flag.
    pub(crate) fn with_stop(self, stop: &StopFlag) -> Self {
        let stop = stop.clone();
        Self { stop, ..self }
    }

    fn is_stopped(&self) -> bool {
        let stop = self.stop.as_ref();
        stop.is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Sorts the sites into the spatial index now; otherwise the first visit of the cells does.
    pub fn sort_sites(&self) {
        // Whoever visits the cells hears that it was stopped.
        let _ = self.tree();
    }

    /// The k-d tree of the sites, built on first use.
    ///
    /// # Errors
    /// [`DiagramError::Stopped`].
    pub(crate) fn tree(&self) -> Result<&KdTree, DiagramError> {
        if self.is_stopped() {
            return Err(DiagramError::Stopped);
        }
        let tree = self.tree.get_or_init(|| {
            let wrapped = self.sites.par_iter().map(|site| self.domain.wrap(site));
            KdTree::new(wrapped, self.domain.periods(), &|| self.is_stopped())
        });
        tree.as_ref().ok_or(DiagramError::Stopped)
    }

    /// A site's position, within one period along axes that have one.
    pub(crate) fn position(&self, site: u32) -> Point3<f64> {
        self.domain.wrap(&self.sites[site as usize])
    }

    /// How many sites there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sites.len()
    }

    /// Never true: a diagram has at least one site.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }

    /// The domain in which the cells lie.
    #[must_use]
    pub fn domain(&self) -> &'a dyn Domain {
        self.domain
    }

    /// Calls `of_cell` with every cell, in parallel, and returns the results in site order.
    ///
    /// # Errors
    /// [`DiagramError::Duplicate`] for the first pair of sites in one place.
    pub fn map_cells<T: Send>(
        &self,
        of_cell: impl Fn(&Cell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        self.map(|(): &mut (), cell| of_cell(&cell))
    }

    /// Calls `of_cell` with the cells of the chosen sites among all, in parallel, and returns the results in
    /// the order in which they were chosen. Each cell has the bits that [`Diagram::map_cells`] gives it.
    ///
    /// # Errors
    /// [`DiagramError::NoSuchSite`], and [`DiagramError::Duplicate`] where another site lies in the place of a
    /// chosen one.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Diagram, random_sites};
    ///
    /// let cube = Cuboid::unit();
    /// let sites = random_sites(&cube, 100, 1)?;
    /// let diagram = Diagram::new(&cube, &sites)?;
    /// let (all, some) = (diagram.map_cells(|cell| cell.volume())?, [7, 99, 7]);
    /// assert_eq!(diagram.map_cells_of(&some, |cell| cell.volume())?, some.map(|site| all[site]));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn map_cells_of<T: Send>(
        &self,
        chosen: &[usize],
        of_cell: impl Fn(&Cell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        let push = |results: &mut Vec<T>, cell: Cell<'_>| results.push(of_cell(&cell));
        let blocks = self.map_blocks(chosen, CELLS_PER_TASK, push)?;
        let numbered = blocks
            .into_iter()
            .flat_map(|(order, results)| order.into_iter().zip(results));
        let mut all: Vec<(usize, T)> = numbered.collect();
        all.par_sort_unstable_by_key(|(number, _)| *number);
        Ok(all.into_iter().map(|(_, result)| result).collect())
    }

    /// Builds the cells of chosen sites in the order of the index, `size` a block, and lets `push` add each to
    /// its block; returns every block with its cells' numbers among the chosen.
    pub(crate) fn map_blocks<Block: Default + Send>(
        &self,
        chosen: &[usize],
        size: usize,
        push: impl Fn(&mut Block, Cell<'_>) + Sync,
    ) -> Result<Vec<(Vec<usize>, Block)>, DiagramError> {
        let count = self.len();
        if let Some(&site) = chosen.iter().find(|&&site| site >= count) {
            return Err(DiagramError::NoSuchSite { site, count });
        }
        let tree = self.tree()?;
        let places = tree.places_of_sites();
        let chosen = chosen.iter().map(|&site| places[site]);
        let mut order: Vec<(u32, usize)> = chosen.zip(0..).collect();
        // Pairs, not numbers by their places: those are scattered in memory.
        order.par_sort_unstable();
        let memories = Memories::<CellBuilder>::default();
        let of_block = |entries: Range<usize>| {
            let entries = &order[entries];
            let mut block = Block::default();
            memories.lend(|builder| {
                for &(place, _) in entries {
                    let place = place as usize;
                    let cell = self.unless_stopped(|| builder.build(self.domain, tree, place))?;
                    push(&mut block, cell);
                }
                Ok(())
            })?;
            let numbers: Vec<usize> = entries.iter().map(|&(_, number)| number).collect();
            Ok((numbers, block))
        };
        let blocks = map_runs(order.len(), size, of_block);
        all_or_least(blocks).map_err(|halt| self.error(halt))
    }

    /// The site whose cell holds a point, the first of several; `None` outside the domain, and of a
    /// diagram that was stopped.
    #[must_use]
    pub fn locate(&self, point: impl Into<Point3<f64>>) -> Option<usize> {
        let point = self.domain.wrap(&point.into());
        let tree = self.tree().ok().filter(|_| self.domain.contains(&point))?;
        Some(tree.nearest(&point) as usize)
    }

    /// Computes `of_cell` for every cell, in parallel, and returns the results in site order.
    ///
    /// Each thread has its own scratch memory, made by `Scratch::default`. The results do not depend on
    /// the number of threads as long as `of_cell` does not depend on what is left in that memory.
    ///
    /// # Errors
    /// [`DiagramError::Duplicate`] for the first pair of sites in one place.
    pub(crate) fn map<Scratch: Default + Send, T: Send>(
        &self,
        of_cell: impl Fn(&mut Scratch, Cell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        self.map_places(self.built(self.tree()?, of_cell))
    }

    /// What `of_cell` says of the cell in a place.
    fn built<Scratch, T>(
        &self,
        tree: &KdTree,
        of_cell: impl Fn(&mut Scratch, Cell<'_>) -> T + Sync,
    ) -> impl Fn(&mut (CellBuilder, Scratch), usize) -> Result<T, Duplicate> + Sync {
        let domain = self.domain;
        move |(builder, scratch), place| {
            let cell = builder.build(domain, tree, place)?;
            Ok(of_cell(scratch, cell))
        }
    }

    /// As [`Diagram::map`] for results that are copied into the sites' order, which all threads do together.
    pub(crate) fn map_copied<Scratch: Default + Send, T: Copy + Send + Sync + 'static>(
        &self,
        of_cell: impl Fn(&mut Scratch, Cell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        self.copy_places(self.built(self.tree()?, of_cell))
    }

    /// As [`Diagram::map_places`] for results that are copied, which all threads do together.
    pub(crate) fn copy_places<Memory: Default + Send, T: Copy + Send + Sync + 'static>(
        &self,
        one: impl Fn(&mut Memory, usize) -> Result<T, Duplicate> + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        let runs = self.runs_of_places(one)?;
        let places = self.tree()?.places_of_sites();
        let of_site = |site: usize| {
            let place = places[site] as usize;
            runs[place / CELLS_PER_TASK][place % CELLS_PER_TASK]
        };
        let results = map(self.len(), &of_site);
        discard(runs);
        discard(places);
        Ok(results)
    }

    /// Computes `one` for every place of the tree, in parallel; the results, none missing, in site order.
    pub(crate) fn map_places<Memory: Default + Send, T: Send>(
        &self,
        one: impl Fn(&mut Memory, usize) -> Result<T, Duplicate> + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        let runs = self.runs_of_places(one)?;
        let mut results: Vec<Option<T>> = (0..self.len()).map(|_| None).collect();
        let sites = self.tree()?.sites().chunks(CELLS_PER_TASK);
        for (run, sites) in runs.into_iter().zip(sites) {
            if self.is_stopped() {
                return Err(DiagramError::Stopped);
            }
            for (result, &site) in run.into_iter().zip(sites) {
                results[site as usize] = Some(result);
            }
        }
        Ok(results.into_iter().map_while(|result| result).collect())
    }

    /// Computes `one` for every place of the tree, in parallel; the results in runs of [`CELLS_PER_TASK`].
    fn runs_of_places<Memory: Default + Send, T: Send>(
        &self,
        one: impl Fn(&mut Memory, usize) -> Result<T, Duplicate> + Sync,
    ) -> Result<Vec<Vec<T>>, DiagramError> {
        let memories = Memories::<Memory>::default();
        let runs = map_runs(self.len(), CELLS_PER_TASK, |places| {
            memories.lend(|memory| {
                all_or_least(places.map(|place| self.unless_stopped(|| one(memory, place))))
            })
        });
        all_or_least(runs).map_err(|halt| self.error(halt))
    }

    /// Computes what `one` computes unless the work is stopped.
    #[inline]
    fn unless_stopped<T>(&self, one: impl FnOnce() -> Result<T, Duplicate>) -> Result<T, Halt> {
        if self.is_stopped() {
            return Err(Halt::Stopped);
        }
        one().map_err(Halt::Duplicate)
    }

    /// Computes `of_cell` for every cell as [`Diagram::map`] does and passes the results to `take` in site
    /// order, a few thousand at a time, so that they need not fit in memory together.
    ///
    /// # Errors
    /// What `take` returns, and [`DiagramError::Duplicate`] for sites in one place.
    pub(crate) fn stream<Scratch: Default + Send, T: Send, Failure: From<DiagramError>>(
        &self,
        of_cell: impl Fn(&mut Scratch, Cell<'_>) -> T + Sync,
        take: impl FnMut(usize, T) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        self.stream_places(self.built(self.tree()?, of_cell), take)
    }

    /// As [`Diagram::stream`], with what `one` computes for every place of the tree.
    pub(crate) fn stream_places<Memory: Default + Send, T: Send, Failure: From<DiagramError>>(
        &self,
        one: impl Fn(&mut Memory, usize) -> Result<T, Duplicate> + Sync,
        mut take: impl FnMut(usize, T) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let places = self.tree()?.places_of_sites();
        let memories = Memories::<Memory>::default();
        for (chunk, places) in places.chunks(CELLS_PER_CHUNK).enumerate() {
            let runs = map_runs(places.len(), CELLS_PER_TASK, |run| {
                memories.lend(|memory| {
                    let places = places[run].iter().map(|&place| place as usize);
                    let results = places.map(|place| self.unless_stopped(|| one(memory, place)));
                    results.collect::<Vec<Result<T, Halt>>>()
                })
            });
            for (site, result) in (chunk * CELLS_PER_CHUNK..).zip(runs.into_iter().flatten()) {
                take(site, result.map_err(|halt| self.error(halt))?)?;
            }
        }
        Ok(())
    }

    fn error(&self, halt: Halt) -> DiagramError {
        let Halt::Duplicate(Duplicate { first, second }) = halt else {
            return DiagramError::Stopped;
        };
        let position = self.position(first);
        // Of several sites in one place, any two may have been found.
        let is_there = |&site: &u32| (self.position(site) - position).norm_squared() <= 0.0;
        let second = (first + 1..second).find(is_there).unwrap_or(second);
        DiagramError::Duplicate {
            first: first as usize,
            second: second as usize,
            position: position.into(),
        }
    }
}

/// Why a site may not lie where it does.
fn refused_site(domain: &dyn Domain, site: usize, point: &Point3<f64>) -> Option<DiagramError> {
    let position = [point.x, point.y, point.z];
    if !position.iter().all(|x| x.is_finite()) {
        Some(DiagramError::NotFinite { site, position })
    } else if !domain.contains(point) {
        Some(DiagramError::Outside { site, position })
    } else {
        None
    }
}

/// All results, or why there are none: that the work was stopped, or the least pair of duplicates.
fn all_or_least<T>(results: impl IntoIterator<Item = Result<T, Halt>>) -> Result<Vec<T>, Halt> {
    let mut all = Vec::new();
    let mut least: Option<Duplicate> = None;
    for result in results {
        match result {
            Ok(result) => all.push(result),
            Err(Halt::Stopped) => return Err(Halt::Stopped),
            Err(Halt::Duplicate(pair)) => least = Some(least.map_or(pair, |least| pair.min(least))),
        }
    }
    least.map_or(Ok(all), |least| Err(Halt::Duplicate(least)))
}
