//! The cells of a diagram, carried from an earlier one where that is right.
//!
//! Which cells are rebuilt, and why the others may be carried: see [`carried`].
//!
//! [`carried`]: crate::voronoi::carried

use std::sync::Arc;

use rayon::prelude::*;

use crate::voronoi::carried::Carried;
use crate::voronoi::carry::Carrier;
use crate::voronoi::cell::Cell;
use crate::voronoi::chunk::{Chunk, Errand};
use crate::voronoi::diagram::{Diagram, DiagramError, bring_into_order};
use crate::voronoi::flip::Flip;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::packed::{CELLS, Packed};
use crate::voronoi::standing::Standing;

/// Of so many sites one is in the sample that tells how many cells are fragile, up to
/// [`LARGEST_SAMPLE`] in all.
const SITES_PER_SAMPLE: usize = 64;
const LARGEST_SAMPLE: usize = 64;

/// Where one cell in so many is fragile, near a lattice, nothing is gained: where one changes, it
/// changes in many places, and so do all around it.
const WORTH_CARRYING: usize = 2;

/// After so many rounds of flips that call for others, the cells are rebuilt.
const MOST_ROUNDS: usize = 8;

/// As they are where there are more flips than so many per cell.
const MOST_FLIPS: usize = 3;

/// A thread's memory: for the cells, and for whoever asks them.
type Desk<Memory> = (Carrier, Memory);

impl Diagram<'_> {
    /// Asks every cell as [`Diagram::map`] does, but takes over from `carried` what has not changed
    /// since, and leaves there what may be of use to the next diagram of as many sites in the same
    /// domain.
    ///
    /// Cells with a pattern are realized from it. So the answers do not depend on what `carried`
    /// holds, though they may differ from those of [`Diagram::map`] by rounding. Where a sample of
    /// the cells is too fragile for that to pay, in lattices and near them, nothing is taken over
    /// and the answers are those of [`Diagram::map`].
    ///
    /// # Errors
    /// [`DiagramError::Duplicate`] for the first pair of sites in one place.
    pub fn map_carried<Memory: Default, Answer: Send>(
        &self,
        carried: &mut Carried,
        ask: impl Fn(&mut Memory, Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        let index = carried.meet(self);
        let mut old = carried.take();
        old.resize_with(self.len().div_ceil(CELLS), Packed::default);
        let standing = Standing::new(self.domain(), &index, carried.ranks());
        if are_fragile(&standing) {
            carried.forget(self.len());
            return self.map(ask);
        }
        let visit_one = |(carrier, memory): &mut Desk<Memory>, chunk| {
            let mut chunk = Chunk::visit(&standing, carrier, chunk, |cell| ask(memory, cell));
            if !carried.keeps() {
                chunk.packed = Packed::default();
            }
            chunk
        };
        let first = old.into_par_iter().enumerate();
        let mut chunks: Vec<Chunk<Answer>> =
            first.map_init(Desk::<Memory>::default, visit_one).collect();
        for round in 0.. {
            let Some(wanted) = Wanted::by(&mut chunks, &standing, round < MOST_ROUNDS) else {
                break;
            };
            chunks.par_iter_mut().enumerate().for_each_init(
                Desk::<Memory>::default,
                |(carrier, memory), (number, chunk)| {
                    let errand = wanted.of_chunk(number);
                    if errand.marked != 0 || !errand.flips.is_empty() {
                        let ask = |cell: Cell<'_>| ask(memory, cell);
                        let done = chunk.revisit(&standing, carrier, number, errand, ask);
                        chunk.duplicate = done.err();
                    }
                },
            );
        }
        if chunks.iter().any(|chunk| chunk.duplicate.is_some()) {
            carried.forget(0);
            // Says which sites they are.
            return self.map(ask);
        }
        Ok(settle(carried, index, chunks))
    }
}

/// Whether more cells are fragile than pay, as a sample of them tells. That depends on nothing but
/// where the sites are now.
fn are_fragile(standing: &Standing<'_>) -> bool {
    let sites = standing.index.len();
    let count = sites.div_ceil(SITES_PER_SAMPLE).min(LARGEST_SAMPLE);
    let mut carrier = Carrier::default();
    let sample = (0..count).map(|number| (2 * number + 1) * sites / (2 * count));
    let fragile = sample.filter(|&site| carrier.is_fragile(standing, site));
    fragile.count() * WORTH_CARRYING > count
}

/// What chunks want of each other.
struct Wanted {
    /// Per chunk: which cells are marked and not rebuilt yet.
    marked: Vec<u64>,
    /// Ranks and what their cells have to follow, sorted.
    flips: Vec<(u32, Flip)>,
}

impl Wanted {
    /// Takes the news of all chunks; returns nothing where there are none or it is too late. Flips
    /// are followed if that `may` be, or else whoever is concerned is marked.
    fn by<Answer>(
        chunks: &mut [Chunk<Answer>],
        standing: &Standing<'_>,
        may_follow: bool,
    ) -> Option<Self> {
        if chunks.iter().any(|chunk| chunk.duplicate.is_some()) {
            return None;
        }
        let (mut marks, mut told) = (Vec::new(), Vec::new());
        for chunk in chunks.iter_mut() {
            marks.append(&mut chunk.news.marks);
            told.append(&mut chunk.news.flips);
        }
        told.sort_unstable();
        let may_follow = may_follow && told.len() <= MOST_FLIPS * CELLS * chunks.len();
        let mut flips = Vec::new();
        for alike in told.chunk_by(Flip::is_among) {
            let may_follow = may_follow && alike.iter().all(|flip| flip.agrees(&alike[0]));
            for site in alike[0].sites() {
                let rank = standing.numbers.ranks[site as usize];
                if !may_follow {
                    marks.push(rank);
                } else if !alike.iter().any(|flip| flip.is_told_by(site)) {
                    flips.push((rank, alike[0]));
                }
            }
        }
        flips.sort_unstable();
        let mut marked = vec![0; chunks.len()];
        for rank in marks {
            let (chunk, cell) = (rank as usize / CELLS, rank as usize % CELLS);
            marked[chunk] |= (1 << cell) & !chunks[chunk].rebuilt;
        }
        let is_empty = flips.is_empty() && marked.iter().all(|&cells| cells == 0);
        (!is_empty).then_some(Self { marked, flips })
    }

    fn of_chunk(&self, number: usize) -> Errand<'_> {
        let before = |number: usize| {
            let is_before = |(rank, _): &(u32, Flip)| *rank as usize / CELLS < number;
            self.flips.partition_point(is_before)
        };
        Errand {
            marked: self.marked[number],
            flips: &self.flips[before(number)..before(number + 1)],
        }
    }
}

/// Leaves the records to `carried` and returns the answers in site order.
fn settle<Answer>(
    carried: &mut Carried,
    index: Arc<SiteIndex>,
    chunks: Vec<Chunk<Answer>>,
) -> Vec<Answer> {
    let goals = index.sites().to_vec();
    let mut answers = Vec::with_capacity(goals.len());
    let mut packed = Vec::new();
    let mut rebuilt = 0;
    for chunk in chunks {
        rebuilt += chunk.rebuilt.count_ones() as usize;
        answers.extend(chunk.answers);
        if carried.keeps() {
            packed.push(chunk.packed);
        }
    }
    carried.put(packed, index, rebuilt);
    bring_into_order(&mut answers, goals);
    answers
}
