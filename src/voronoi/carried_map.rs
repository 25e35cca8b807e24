//! The cells of a diagram, carried from an earlier one where that is right.
//!
//! Which cells are rebuilt, and why the others may be carried: see [`carried`].
//!
//! [`carried`]: crate::voronoi::carried

use rayon::prelude::*;

use crate::voronoi::carried::Carried;
use crate::voronoi::carry::{Carrier, Standing};
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError, bring_into_order};
use crate::voronoi::packed::{CELLS, Packed};
use crate::voronoi::search::Duplicate;

/// Of so many sites one is in the sample that tells how often cells are in doubt, up to
/// [`LARGEST_SAMPLE`] in all.
const SITES_PER_SAMPLE: usize = 256;
const LARGEST_SAMPLE: usize = 64;

/// A cell in doubt costs seven tenths more than one that nobody wants to carry, a carried one a
/// quarter less: where one in so many is in doubt, nothing is gained.
const WORTH_DOUBTING: usize = 4;

/// What has become of the cells of [`CELLS`] ranks.
struct Chunk<Answer> {
    packed: Packed,
    answers: Vec<Answer>,
    /// Which of them have been rebuilt.
    rebuilt: u64,
    /// The ranks of cells that must be rebuilt too.
    marks: Vec<u32>,
    duplicate: Option<Duplicate>,
}

/// A thread's memory: for the cells, and for whoever asks them.
type Desk<Memory> = (Carrier, Memory);

impl Diagram<'_> {
    /// Asks every cell as [`Diagram::map`] does, but takes over from `carried` what has not changed
    /// since, and leaves there what may be of use to the next diagram of as many sites in the same
    /// domain.
    ///
    /// Cells with a pattern are realized from it. So the answers do not depend on what `carried`
    /// holds, though they may differ from those of [`Diagram::map`] by rounding. Where a sample of
    /// the cells is in doubt too often for that to pay, as in lattices, nothing is taken over and
    /// the answers are those of [`Diagram::map`].
    ///
    /// # Errors
    /// [`DiagramError::Duplicate`] for the first pair of sites in one place.
    pub fn map_carried<Memory: Default, Answer: Send>(
        &self,
        carried: &mut Carried,
        ask: impl Fn(&mut Memory, Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        let places = self.places();
        carried.meet(self, &places);
        let mut old = carried.take();
        old.resize_with(self.len().div_ceil(CELLS), Packed::default);
        let standing = Standing::new(self.domain(), &self.index, carried, &places);
        if doubts_many(&standing) {
            carried.put(Vec::new(), self.len());
            return self.map(ask);
        }
        let visit_one = |(carrier, memory): &mut Desk<Memory>, (number, old)| {
            let mut chunk = visit(&standing, carrier, number, old, |cell| ask(memory, cell));
            if !carried.keeps() {
                chunk.packed = Packed::default();
            }
            chunk
        };
        let first = old.into_par_iter().enumerate();
        let mut chunks: Vec<Chunk<Answer>> =
            first.map_init(Desk::<Memory>::default, visit_one).collect();
        while let Some(wanted) = wanted(&mut chunks) {
            let marked = chunks.par_iter_mut().enumerate().zip(wanted);
            marked.filter(|(_, wanted)| *wanted != 0).for_each_init(
                Desk::<Memory>::default,
                |(carrier, memory), ((number, chunk), wanted)| {
                    let ask = |cell: Cell<'_>| ask(memory, cell);
                    chunk.revisit(&standing, carrier, number, wanted, ask);
                },
            );
        }
        if chunks.iter().any(|chunk| chunk.duplicate.is_some()) {
            carried.forget();
            // Says which sites they are.
            return self.map(ask);
        }
        Ok(settle(carried, chunks))
    }
}

/// Whether more cells are in doubt than pay, as a sample of them tells. That depends on nothing but
/// where the sites are now.
fn doubts_many(standing: &Standing<'_>) -> bool {
    let sites = standing.positions.len();
    let count = sites.div_ceil(SITES_PER_SAMPLE).min(LARGEST_SAMPLE);
    let mut carrier = Carrier::default();
    let places = (0..count).map(|number| (2 * number + 1) * sites / (2 * count));
    let doubts = places.filter(|&place| carrier.is_in_doubt(standing, place));
    doubts.count() * WORTH_DOUBTING > count
}

/// Carries or rebuilds the cells of a chunk.
fn visit<Answer>(
    standing: &Standing<'_>,
    carrier: &mut Carrier,
    number: usize,
    packed: Packed,
    mut ask: impl FnMut(Cell<'_>) -> Answer,
) -> Chunk<Answer> {
    let mut chunk = Chunk {
        packed,
        answers: Vec::with_capacity(CELLS),
        rebuilt: 0,
        marks: Vec::new(),
        duplicate: None,
    };
    let is_known = !chunk.packed.is_empty();
    let ranks = number * CELLS..standing.positions.len().min((number + 1) * CELLS);
    for (cell, rank) in ranks.enumerate() {
        if is_known
            && let record = chunk.packed.record(cell)
            && let Some(answer) = carrier.carry(standing, rank, &record, &mut ask)
        {
            chunk.answers.push(answer);
            continue;
        }
        let records = (&mut chunk.packed, cell, is_known);
        match carrier.rebuild(standing, rank, records, &mut chunk.marks, &mut ask) {
            Ok(answer) => chunk.answers.push(answer),
            Err(duplicate) => {
                chunk.duplicate = Some(duplicate);
                break;
            }
        }
        chunk.rebuilt |= 1 << cell;
    }
    chunk.close();
    chunk
}

impl<Answer> Chunk<Answer> {
    /// Rebuilds the cells of a mask.
    fn revisit(
        &mut self,
        standing: &Standing<'_>,
        carrier: &mut Carrier,
        number: usize,
        wanted: u64,
        mut ask: impl FnMut(Cell<'_>) -> Answer,
    ) {
        for cell in (0..self.answers.len()).filter(|cell| wanted >> cell & 1 == 1) {
            let rank = number * CELLS + cell;
            let records = (&mut self.packed, cell, true);
            match carrier.rebuild(standing, rank, records, &mut self.marks, &mut ask) {
                Ok(answer) => self.answers[cell] = answer,
                Err(duplicate) => {
                    self.duplicate = Some(duplicate);
                    return;
                }
            }
        }
        self.rebuilt |= wanted;
        self.close();
    }

    /// Gives back the room that is not needed.
    fn close(&mut self) {
        // The same cells are marked from many sides.
        self.marks.sort_unstable();
        self.marks.dedup();
        self.marks.shrink_to_fit();
        self.packed.close();
    }
}

/// Takes the marks of all chunks; returns, per chunk, which cells are marked and not rebuilt yet,
/// or nothing where there are none or it is too late.
fn wanted<Answer>(chunks: &mut [Chunk<Answer>]) -> Option<Vec<u64>> {
    if chunks.iter().any(|chunk| chunk.duplicate.is_some()) {
        return None;
    }
    let mut wanted = vec![0; chunks.len()];
    let mut any = false;
    for number in 0..chunks.len() {
        for rank in std::mem::take(&mut chunks[number].marks) {
            let (chunk, cell) = (rank as usize / CELLS, rank as usize % CELLS);
            if chunks[chunk].rebuilt >> cell & 1 == 0 {
                wanted[chunk] |= 1 << cell;
                any = true;
            }
        }
    }
    any.then_some(wanted)
}

/// Leaves the records to `carried` and returns the answers in site order.
fn settle<Answer>(carried: &mut Carried, chunks: Vec<Chunk<Answer>>) -> Vec<Answer> {
    let goals = carried.numbers().sites.to_vec();
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
    carried.put(packed, rebuilt);
    bring_into_order(&mut answers, goals);
    answers
}
