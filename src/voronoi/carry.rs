//! One cell on its way from one diagram to the next: realized anew from its pattern, or rebuilt.

use nalgebra::{Point3, Vector3};

use crate::domain::space::Domain;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::body::Body;
use crate::voronoi::cell::{Cell, CellBuilder};
use crate::voronoi::corners::Corners;
use crate::voronoi::flip::{Flip, Heard};
use crate::voronoi::index::SiteIndex;
use crate::voronoi::packed::{Across, IMAGES, Packed, Ranks, image_of};
use crate::voronoi::pattern::{MOST, Pattern};
use crate::voronoi::realize::Realizer;
use crate::voronoi::search::{Duplicate, Manner};

/// Sites as they stand now. Their ranks are their places in the index.
pub(crate) struct Standing<'a> {
    pub(crate) domain: &'a dyn Domain,
    pub(crate) index: &'a SiteIndex,
    pub(crate) numbers: Ranks<'a>,
    /// Per rank: the site's position.
    pub(crate) positions: &'a [Point3<f64>],
    /// Per number of an image: its displacement (L).
    pub(crate) shifts: [Vector3<f64>; IMAGES],
}

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

/// How often a pattern is flipped and realized before it is given up.
const MOST_MENDED: usize = 3;

/// The memory in which patterns become cells.
#[derive(Debug, Default)]
struct Mold {
    pattern: Pattern,
    corners: Corners,
    across: Vec<Across>,
    realizer: Realizer,
    start: Polyhedron,
    body: Body,
}

impl<'a> Standing<'a> {
    /// Sites in an index, which `ranks` gives per site.
    pub(crate) fn new(domain: &'a dyn Domain, index: &'a SiteIndex, ranks: &'a [u32]) -> Self {
        let periods = domain.periods().map(Option::unwrap_or_default);
        let shift = |number: usize| {
            let copies = image_of(number as u8).map(f64::from);
            Vector3::from([0, 1, 2].map(|axis| copies[axis] * periods[axis]))
        };
        Self {
            domain,
            index,
            numbers: Ranks {
                sites: index.sites(),
                ranks,
            },
            positions: index.positions(),
            shifts: std::array::from_fn(shift),
        }
    }
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
            match flip.hear(site, &mut mold.corners, !is_rebuilt) {
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
        packed.put(number, &mold.pattern, numbers);
        if !mold.realize(standing, rank) {
            if is_denied || !mold.mend(standing, rank, &mut news.flips) {
                return Followed::InDoubt;
            }
            packed.put(number, &mold.pattern, numbers);
        }
        if is_denied {
            return Followed::InDoubt;
        }
        Followed::Changed(ask(mold.cell(standing, rank)))
    }

    /// Whether the cell of a site has no pattern, or is in doubt.
    pub(crate) fn is_in_doubt(&mut self, standing: &Standing<'_>, site: usize) -> bool {
        let Self { builder, mold, .. } = self;
        let rank = standing.numbers.ranks[site] as usize;
        let built = builder.build_in(Manner::InOrder, standing.domain, standing.index, rank);
        !built.is_ok_and(|built| mold.take_over(standing, rank, &built))
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

impl Mold {
    /// Takes the pattern of a cell that was built and realizes it; returns whether it has one and is
    /// beyond doubt.
    fn take_over(&mut self, standing: &Standing<'_>, rank: usize, built: &Cell<'_>) -> bool {
        let has_pattern =
            (built.compact()).is_some_and(|compact| self.pattern.assign(compact, built.site));
        has_pattern && self.realize(standing, rank)
    }

    /// Flips the pattern in hand, which has been realized, where edges run the wrong way, and tells
    /// of it; returns whether the cell is then beyond doubt.
    fn mend(&mut self, standing: &Standing<'_>, rank: usize, told: &mut Vec<Flip>) -> bool {
        let (site, before) = (standing.numbers.sites[rank], told.len());
        for _ in 0..MOST_MENDED {
            let cell = self.body.slots();
            if cell.planes.len() < self.pattern.facet_count || !self.realizer.is_finite() {
                break;
            }
            let Self {
                pattern, corners, ..
            } = self;
            corners.assign(pattern);
            let (flipped, mut can_tell) = (told.len(), true);
            self.realizer.visit_reversed(cell, |facets| {
                let four = facets.map(|facet| pattern.labels[usize::from(facet) % MOST]);
                if let Some(view) = corners.flip(&four) {
                    let flip = Flip::told(site, &four, view);
                    can_tell &= flip.is_some();
                    told.extend(flip);
                }
            });
            if told.len() == flipped || !can_tell || !corners.write(pattern) {
                break;
            }
            if self.realize(standing, rank) {
                return true;
            }
        }
        told.truncate(before);
        false
    }

    /// The cell that has been realized.
    fn cell(&self, standing: &Standing<'_>, rank: usize) -> Cell<'_> {
        Cell {
            site: standing.numbers.sites[rank],
            position: standing.positions[rank],
            body: &self.body,
        }
    }

    /// Realizes the pattern in hand; returns whether the cell is beyond doubt.
    fn realize(&mut self, standing: &Standing<'_>, rank: usize) -> bool {
        self.pattern.write(self.body.slots());
        let mut across = std::mem::take(&mut self.across);
        across.clear();
        let labels = self.pattern.labels().iter();
        across.extend(labels.map(|&label| standing.numbers.across(label)));
        let is_sound = self.place(standing, rank, across.iter().copied());
        self.across = across;
        is_sound
    }

    /// Places the vertices of a pattern that has been laid out in the body, beyond whose facets lies
    /// what `across` tells; returns whether the cell is beyond doubt.
    #[inline(always)]
    fn place(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        across: impl Iterator<Item = Across>,
    ) -> bool {
        let here = standing.positions[rank];
        let cell = self.body.slots();
        self.realizer.clear();
        let mut has_start = false;
        for (facet, across) in across.enumerate() {
            if let Some((rank, image)) = across.site() {
                let by = standing.shifts[usize::from(image) % IMAGES];
                let away = standing.positions[rank as usize] - here + by;
                (self.realizer).add(&HalfSpace::bisector(away), true, cell);
                continue;
            }
            if !has_start {
                let site = standing.numbers.sites[rank];
                standing.domain.start(&here, site, &mut self.start);
                has_start = true;
            }
            let label = cell.labels[facet];
            let wall = self.start.labels.iter().position(|&other| other == label);
            let Some(wall) = wall else {
                return false;
            };
            (self.realizer).add(&self.start.planes[wall], false, cell);
        }
        self.realizer.realize(cell)
    }
}
