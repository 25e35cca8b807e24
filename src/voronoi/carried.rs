//! What one diagram leaves to the next: the patterns of its cells, while sites move little.
//!
//! Near convergence most cells keep their `pattern` from one iteration to the next, and the others
//! change in few places. Then no neighbor need be searched and no plane tried: the vertices are where
//! their three planes meet now.
//!
//! # What is flipped, and what is rebuilt
//!
//! Sites that move change partners by flips (`corners`), five at a time. Cells notice: an edge has
//! come to run the wrong way. Such a cell makes the flip in its pattern, is realized again and tells
//! the cells of the other four sites, which make the same flip. Whoever is told of a flip and sees
//! nothing of the kind denies it, and all five cells are rebuilt.
//!
//! A cell is rebuilt too if it has no pattern or if its realization (`realize`) is in doubt even
//! after flips; what is built is in doubt also where other sites touch it (`touch`). If a rebuilt
//! cell turns out to have other vertices than the others took it to have, the cells around those
//! vertices are rebuilt; if it is itself in doubt, or was, all its neighbors are. This goes on until
//! nothing is left to do.
//!
//! A vertex comes or goes in a carried cell by a flip of the sites around it only, which all five cells
//! make or none; and no rebuilt cell around it may differ. So in the end the cells around any vertex of a
//! carried cell hold that vertex as well, and are beyond doubt themselves. (Lists of neighbors that
//! agree would not do: where a new edge between i and j opens in the middle of the facet between a
//! and b, no list of a or b changes, and those of i and j agree as long as both ignore it.)
//!
//! # Why carried cells are right
//!
//! The P_i, carried, flipped or not, or rebuilt, are convex, P_i holds site i, and its facets are
//! bisectors. Assume that q inside a carried P_i is nearer to site j, and go straight from q to j.
//! Leaving a carried cell through a facet one enters the cell beyond, which has the same facet since it
//! has the same vertices. Let g be the squared distance to the site of the cell one is in less that to
//! j. Along the way g is linear within a cell and continuous, and its slope falls at every bisector that
//! is crossed: g is concave. Rebuilt cells are right, so once one of them is entered one goes on in the
//! true diagram; in any case the way ends in the cell that holds j. That is P_j, since the P tile
//! space and P_j holds j; there g vanishes. A concave function that ends in 0 with slope 0 is never
//! positive, but g(q) > 0. So there is no such q: this is the Delaunay lemma. ∎
//!
//! The volumes of all cells may well add up to the domain's where some are wrong.
//!
//! # Why it cannot be told from a rebuilt one
//!
//! Around a vertex of a carried cell all cells are beyond doubt, so for some ρ, the margin times the
//! flatness allowed, they fill the ball of radius ρ about it. Every other site is farther away than
//! theirs by a share of ρ that only very near sites make small, which is a doubt of its own. All this
//! is far above rounding, so that a cold build finds the same pattern, and no touch. It then hands the
//! cell to the same realization, with the same doubts. So whether cells are carried shows in no bit of
//! any result: runs that are resumed, and begin without patterns, agree with uninterrupted ones.
//!
//! Lattices are always in doubt, and near them the least move makes eight sites change partners at
//! every vertex: such cells are never carried. A sample tells, and then all cells stay as they were
//! cut. Single cells in doubt are cut by ever farther sites, an order that the sites alone decide, for
//! the index is carried too: its sites stay sorted as they were while they have not moved far.

use std::sync::Arc;

use rayon::prelude::*;

use crate::domain::shape::displacement;
use crate::voronoi::diagram::Diagram;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::packed::Packed;
use crate::voronoi::room::room;

/// Patterns are tried as long as sites have moved by less than this share of the diagonal of a cube
/// of the mean volume: beyond, more than half of the cells change, and many in ways that are not told.
pub const WORTH: f64 = 0.014;

/// The memory that is asked for (bytes per site): twice what it takes.
const BYTES: u64 = 800;

/// The index is made anew after sites have moved by this share of that diagonal in all: its boxes
/// have come to overlap.
const DRIFTED: f64 = 0.5;

/// The patterns of a diagram's cells, to be tried in the next one.
#[derive(Debug, Default)]
pub struct Carried {
    /// The index of the sites as they were. Places in it are their *ranks*: near sites have near
    /// ranks for as long as sites move little.
    index: Option<Arc<SiteIndex>>,
    /// Per site: its rank.
    ranks: Vec<u32>,
    /// The records of a few dozen ranks each; none when there is nothing to carry.
    packed: Vec<Packed>,
    keeps: bool,
    rebuilt: usize,
    /// How far sites have moved since the index was made, as a share of the diagonal.
    drift: f64,
    /// The memory that may be taken (bytes); none where the system is asked.
    limit: Option<u64>,
}

impl Carried {
    /// Patterns that are kept only as long as so many bytes are enough for them.
    #[must_use]
    pub fn within(bytes: u64) -> Self {
        Self {
            limit: Some(bytes),
            ..Self::default()
        }
    }

    /// How many cells of the last diagram had to be rebuilt.
    #[must_use]
    pub fn rebuilt(&self) -> usize {
        self.rebuilt
    }

    /// The memory that is held (bytes).
    #[must_use]
    pub fn memory(&self) -> usize {
        let records: usize = self.packed.iter().map(Packed::memory).sum();
        let index = self.index.as_ref().map_or(0, |index| index.memory());
        records + index + size_of::<u32>() * self.ranks.capacity()
    }

    /// Per site: its rank.
    pub(crate) fn ranks(&self) -> &[u32] {
        &self.ranks
    }

    /// Takes the records out.
    pub(crate) fn take(&mut self) -> Vec<Packed> {
        std::mem::take(&mut self.packed)
    }

    /// Whether there is memory for new records.
    pub(crate) fn keeps(&self) -> bool {
        self.keeps
    }

    /// Puts new records in, and the index that ranks their cells.
    pub(crate) fn put(&mut self, packed: Vec<Packed>, index: Arc<SiteIndex>, rebuilt: usize) {
        self.packed = packed;
        self.index = self.keeps.then_some(index);
        self.rebuilt = rebuilt;
    }

    /// Forgets all but how much memory may be taken, and how many cells were rebuilt.
    pub(crate) fn forget(&mut self, rebuilt: usize) {
        *self = Self {
            limit: self.limit,
            rebuilt,
            ..Self::default()
        };
    }

    /// Gets to know where the sites are now and returns their index; forgets the patterns if they
    /// are of no use any more.
    pub(crate) fn meet(&mut self, diagram: &Diagram<'_>) -> Arc<SiteIndex> {
        if let Some(index) = self.follow(diagram) {
            return index;
        }
        self.forget(self.rebuilt);
        let index = diagram.shared_index();
        self.ranks = index.places_of_sites();
        let enough = BYTES * diagram.len() as u64;
        self.keeps = self.limit.unwrap_or_else(room) >= enough;
        Arc::clone(index)
    }

    /// The index of old with the sites where they are now, if there are patterns and they are of use.
    fn follow(&mut self, diagram: &Diagram<'_>) -> Option<Arc<SiteIndex>> {
        let mut index = self.index.take()?;
        if self.packed.is_empty() || index.len() != diagram.len() {
            return None;
        }
        let sites = index.sites().par_iter();
        let positions: Vec<_> = sites.map(|&site| diagram.position(site)).collect();
        let periods = diagram.domain().periods();
        let moved = index.positions().iter().zip(&positions);
        let (way, drift) = moved.fold((0.0, 0.0), |(way, drift), (from, to)| {
            let way = way + displacement(&periods, from, to).norm();
            // Who enters at the opposite side has gone far for the index.
            (way, drift + (to - from).norm())
        });
        let count = diagram.len() as f64;
        let diagonal = 3.0_f64.sqrt() * (diagram.domain().volume() / count).cbrt();
        self.drift += drift / (count * diagonal);
        if way >= WORTH * diagonal * count || self.drift >= DRIFTED {
            return None;
        }
        Arc::make_mut(&mut index).refit(positions);
        Some(index)
    }
}
