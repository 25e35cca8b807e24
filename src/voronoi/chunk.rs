//! Some dozens of cells that are carried together, by one thread at a time.

use crate::voronoi::carry::{Carrier, Followed, News};
use crate::voronoi::cell::Cell;
use crate::voronoi::flip::Flip;
use crate::voronoi::packed::{CELLS, Packed};
use crate::voronoi::search::Duplicate;
use crate::voronoi::standing::Standing;

/// What has become of the cells of [`CELLS`] ranks.
pub(crate) struct Chunk<Answer> {
    pub(crate) packed: Packed,
    pub(crate) answers: Vec<Answer>,
    /// Which of them have been rebuilt.
    pub(crate) rebuilt: u64,
    pub(crate) news: News,
    pub(crate) duplicate: Option<Duplicate>,
}

/// What others have made necessary in a chunk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Errand<'a> {
    /// Which of its cells must be rebuilt.
    pub(crate) marked: u64,
    /// Which flips its cells have to follow, sorted by rank.
    pub(crate) flips: &'a [(u32, Flip)],
}

impl<Answer> Chunk<Answer> {
    /// Carries or rebuilds the cells of the numbered chunk, of which `packed` are the records.
    pub(crate) fn visit(
        standing: &Standing<'_>,
        carrier: &mut Carrier,
        (number, packed): (usize, Packed),
        mut ask: impl FnMut(Cell<'_>) -> Answer,
    ) -> Self {
        let mut chunk = Self {
            packed,
            answers: Vec::with_capacity(CELLS),
            rebuilt: 0,
            news: News::default(),
            duplicate: None,
        };
        let is_known = !chunk.packed.is_empty();
        let ranks = number * CELLS..standing.index.len().min((number + 1) * CELLS);
        for (cell, rank) in ranks.enumerate() {
            let Self { packed, news, .. } = &mut chunk;
            let carried = is_known
                .then(|| carrier.carry(standing, rank, (packed, cell), news, &mut ask))
                .flatten();
            if let Some(answer) = carried {
                chunk.answers.push(answer);
                continue;
            }
            match carrier.rebuild(standing, rank, (packed, cell, is_known), news, &mut ask) {
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

    /// Does what others have made necessary.
    pub(crate) fn revisit(
        &mut self,
        standing: &Standing<'_>,
        carrier: &mut Carrier,
        number: usize,
        errand: Errand<'_>,
        mut ask: impl FnMut(Cell<'_>) -> Answer,
    ) -> Result<(), Duplicate> {
        for cell in (0..self.answers.len()).filter(|cell| errand.marked >> cell & 1 == 1) {
            self.rebuild(standing, carrier, number * CELLS + cell, &mut ask)?;
        }
        for told in errand.flips.chunk_by(|one, other| one.0 == other.0) {
            let rank = told[0].0 as usize;
            let cell = rank % CELLS;
            let is_rebuilt = self.rebuilt >> cell & 1 == 1;
            let record = (&mut self.packed, cell, is_rebuilt);
            match carrier.follow(standing, rank, record, told, &mut self.news, &mut ask) {
                Followed::Unchanged => {}
                Followed::Changed(answer) => self.answers[cell] = answer,
                Followed::InDoubt => self.rebuild(standing, carrier, rank, &mut ask)?,
            }
        }
        self.close();
        Ok(())
    }

    /// Rebuilds a cell that has an answer and a record.
    fn rebuild(
        &mut self,
        standing: &Standing<'_>,
        carrier: &mut Carrier,
        rank: usize,
        ask: impl FnMut(Cell<'_>) -> Answer,
    ) -> Result<(), Duplicate> {
        let cell = rank % CELLS;
        let record = (&mut self.packed, cell, true);
        self.answers[cell] = carrier.rebuild(standing, rank, record, &mut self.news, ask)?;
        self.rebuilt |= 1 << cell;
        Ok(())
    }

    /// Gives back the room that is not needed.
    fn close(&mut self) {
        // The same cells are marked from many sides.
        self.news.marks.sort_unstable();
        self.news.marks.dedup();
        self.news.marks.shrink_to_fit();
        self.packed.close();
    }
}
