//! One cell on its way from one diagram to the next: realized anew from its pattern, flipped, or rebuilt.

use crate::voronoi::cell::{Cell, CellBuilder};
use crate::voronoi::flip::{Flip, Heard};
use crate::voronoi::mold::Mold;
use crate::voronoi::packed::Packed;
use crate::voronoi::pattern::Pattern;
use crate::voronoi::search::{Duplicate, Manner};
use crate::voronoi::standing::Standing;

/// The memory in which cells are carried, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Carrier {
    builder: CellBuilder,
    mold: Mold,
    /// How a cell was before it is rebuilt.
    old: Pattern,
}

/// What others have to hear of a cell that has changed.
#[derive(Debug, Default)]
pub(crate) struct News {
    /// The ranks of cells that must be rebuilt too.
    pub(crate) marks: Vec<u32>,
    /// What other cells have to follow.
    pub(crate) flips: Vec<Flip>,
}

/// What has become of a cell that was told of flips.
pub(crate) enum Followed<Answer> {
    /// It stays as it is.
    Unchanged,
    /// It has been flipped and asked again.
    Changed(Answer),
    /// It has to be rebuilt.
    InDoubt,
}

impl Carrier {
    /// Asks the cell that its old record gives between the sites as they stand now, after flips where
    /// edges have come to run the wrong way, of which the news tells; `None` if that is in doubt.
    pub(crate) fn carry<Answer>(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        (packed, number): (&mut Packed, usize),
        news: &mut News,
        ask: impl FnOnce(Cell<'_>) -> Answer,
    ) -> Option<Answer> {
        let (numbers, mold) = (&standing.numbers, &mut self.mold);
        let record = packed.record(number);
        if !record.write(numbers, mold.body.slots()) {
            return None;
        }
        if !mold.place(standing, rank, record.beyond()) {
            let is_read = record.read(numbers, &mut mold.pattern);
            if !is_read || !mold.mend(standing, rank, &mut news.flips) {
                return None;
            }
            packed.put(number, &mold.pattern, numbers);
        }
        Some(ask(mold.cell(standing, rank)))
    }

    /// Lets a cell follow the flips of others. One that has been rebuilt is right: whoever tells
    /// something else has to be rebuilt too.
    pub(crate) fn follow<Answer>(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        (packed, number, is_rebuilt): (&mut Packed, usize, bool),
        told: &[(u32, Flip)],
        news: &mut News,
        ask: impl FnOnce(Cell<'_>) -> Answer,
    ) -> Followed<Answer> {
        let (numbers, mold) = (&standing.numbers, &mut self.mold);
        let has_pattern = packed.record(number).read(numbers, &mut mold.pattern);
        mold.corners.clear();
        if has_pattern {
            mold.corners.assign(&mold.pattern);
        }
        let site = numbers.sites[rank];
        let (mut has_followed, mut is_denied) = (false, false);
        for (_, flip) in told {
            match flip.hear(site, &mut mold.corners, is_rebuilt) {
                Heard::Known => {}
                Heard::Followed => has_followed = true,
                Heard::Denied => {
                    is_denied = true;
                    let ranks = flip.sites().map(|site| numbers.ranks[site as usize]);
                    news.marks.extend(ranks);
                }
            }
        }
        if is_rebuilt || !has_followed && !is_denied {
            return Followed::Unchanged;
        }
        if !has_followed || !mold.corners.write(&mut mold.pattern) {
            return Followed::InDoubt;
        }
        // If the cell is rebuilt, this is what others take it to be.
        packed.put(number, &mold.pattern, numbers);
        if is_denied {
            return Followed::InDoubt;
        }
        if !mold.realize(standing, rank) {
            if !mold.mend(standing, rank, &mut news.flips) {
                return Followed::InDoubt;
            }
            packed.put(number, &mold.pattern, numbers);
        }
        Followed::Changed(ask(mold.cell(standing, rank)))
    }

    /// Whether the cell of a site has no pattern, is in doubt or hardly keeps its pattern.
    pub(crate) fn is_fragile(&mut self, standing: &Standing<'_>, site: usize) -> bool {
        let Self { builder, mold, .. } = self;
        let rank = standing.numbers.ranks[site] as usize;
        let built = builder.build_in(Manner::InOrder, standing.domain, standing.index, rank);
        !built.is_ok_and(|built| mold.take_over(standing, rank, &built)) || mold.is_fragile()
    }

    /// Builds a cell, asks it and puts its record where the numbered one is, or if none is known,
    /// behind all others. Lists the neighbors that may no longer agree with how the cell was.
    pub(crate) fn rebuild<Answer>(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        (packed, number, is_known): (&mut Packed, usize, bool),
        News { marks, .. }: &mut News,
        ask: impl FnOnce(Cell<'_>) -> Answer,
    ) -> Result<Answer, Duplicate> {
        let Self { builder, mold, old } = self;
        let numbers = &standing.numbers;
        let (domain, index) = (standing.domain, standing.index);
        let had_pattern = is_known && packed.record(number).read(numbers, old);
        let manner = match (is_known, had_pattern) {
            (false, _) => Manner::Crowd,
            (true, true) => Manner::Alone,
            (true, false) => Manner::InOrder,
        };
        let mut built = builder.build_in(manner, domain, index, rank)?;
        let mut has_pattern = mold.take_over(standing, rank, &built);
        if manner != Manner::InOrder && !has_pattern {
            // What is kept as it was cut is always cut in the same order.
            built = builder.build_in(Manner::InOrder, domain, index, rank)?;
            has_pattern = mold.take_over(standing, rank, &built);
        }
        let is_comparable = had_pattern && has_pattern;
        if is_known && !is_comparable {
            marks.extend(packed.record(number).neighbors());
        }
        if has_pattern {
            packed.put(number, &mold.pattern, numbers);
        } else {
            let labels: Vec<_> = built.polyhedron().facets().map(|f| f.label()).collect();
            packed.put_neighbors(number, &labels, numbers);
        }
        if is_comparable {
            old.visit_differences(&mold.pattern, |around| {
                marks.extend(
                    around
                        .iter()
                        .filter_map(|&label| numbers.across(label).rank()),
                );
            });
        } else if is_known {
            marks.extend(packed.record(number).neighbors());
        }
        let body = if has_pattern { &mold.body } else { built.body };
        Ok(ask(Cell { body, ..built }))
    }
}
