//! One cell on its way from one diagram to the next: realized anew from its pattern, or rebuilt.

use nalgebra::{Point3, Vector3};

use crate::domain::space::Domain;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::body::Body;
use crate::voronoi::carried::Carried;
use crate::voronoi::cell::{Cell, CellBuilder};
use crate::voronoi::index::SiteIndex;
use crate::voronoi::packed::{Across, IMAGES, Packed, Ranks, Record, image_of};
use crate::voronoi::pattern::Pattern;
use crate::voronoi::realize::Realizer;
use crate::voronoi::search::{Company, Duplicate};

/// Sites as they stand now, by rank.
pub(crate) struct Standing<'a> {
    pub(crate) domain: &'a dyn Domain,
    pub(crate) index: &'a SiteIndex,
    pub(crate) numbers: Ranks<'a>,
    /// Per site: its place in the index.
    pub(crate) places: &'a [u32],
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

/// The memory in which patterns become cells.
#[derive(Debug, Default)]
struct Mold {
    pattern: Pattern,
    across: Vec<Across>,
    realizer: Realizer,
    start: Polyhedron,
    body: Body,
}

impl<'a> Standing<'a> {
    /// Sites in an index, numbered as in an earlier one.
    pub(crate) fn new(
        domain: &'a dyn Domain,
        index: &'a SiteIndex,
        carried: &'a Carried,
        places: &'a [u32],
    ) -> Self {
        let periods = domain.periods().map(Option::unwrap_or_default);
        let shift = |number: usize| {
            let copies = image_of(number as u8).map(f64::from);
            Vector3::from([0, 1, 2].map(|axis| copies[axis] * periods[axis]))
        };
        Self {
            domain,
            index,
            numbers: carried.numbers(),
            places,
            positions: carried.positions(),
            shifts: std::array::from_fn(shift),
        }
    }
}

impl Carrier {
    /// Asks the cell that its old record gives between the sites as they stand now; `None` if that
    /// is in doubt.
    pub(crate) fn carry<Answer>(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        record: &Record<'_>,
        ask: impl FnOnce(Cell<'_>) -> Answer,
    ) -> Option<Answer> {
        let numbers = &standing.numbers;
        let mold = &mut self.mold;
        if !record.read(numbers, &mut mold.pattern) {
            return None;
        }
        mold.across.clear();
        mold.across.extend(record.beyond());
        mold.realize(standing, rank).then(|| {
            ask(Cell {
                site: numbers.sites[rank],
                position: standing.positions[rank],
                body: &mold.body,
            })
        })
    }

    /// Whether the cell of the site in `place` of the index has no pattern, or is in doubt.
    pub(crate) fn is_in_doubt(&mut self, standing: &Standing<'_>, place: usize) -> bool {
        let Self { builder, mold, .. } = self;
        let rank = standing.numbers.ranks[standing.index.site(place) as usize] as usize;
        let built = builder.build_in(Company::Crowd, standing.domain, standing.index, place);
        !built.is_ok_and(|built| mold.take_over(standing, rank, &built))
    }

    /// Builds a cell, asks it and puts its record where the numbered one is, or if none is known,
    /// behind all others. Lists the neighbors that may no longer agree with how the cell was.
    pub(crate) fn rebuild<Answer>(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        (packed, number, is_known): (&mut Packed, usize, bool),
        marks: &mut Vec<u32>,
        ask: impl FnOnce(Cell<'_>) -> Answer,
    ) -> Result<Answer, Duplicate> {
        let Self { builder, mold, old } = self;
        let numbers = &standing.numbers;
        let place = standing.places[numbers.sites[rank] as usize] as usize;
        let (domain, index) = (standing.domain, standing.index);
        let had_pattern = is_known && packed.record(number).read(numbers, old);
        let company = if had_pattern {
            Company::Alone
        } else {
            Company::Crowd
        };
        let mut built = builder.build_in(company, domain, index, place)?;
        let mut has_pattern = mold.take_over(standing, rank, &built);
        if company == Company::Alone && !has_pattern {
            // What is kept as it was cut is always cut in the same order.
            built = builder.build_in(Company::Crowd, domain, index, place)?;
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
        if has_pattern {
            self.across.clear();
            let labels = self.pattern.labels().iter();
            (self.across).extend(labels.map(|&label| standing.numbers.across(label)));
        }
        has_pattern && self.realize(standing, rank)
    }

    /// Realizes the pattern in hand; returns whether the cell is beyond doubt.
    fn realize(&mut self, standing: &Standing<'_>, rank: usize) -> bool {
        let here = standing.positions[rank];
        let cell = self.body.slots();
        self.pattern.write(cell);
        self.realizer.clear();
        let mut has_start = false;
        for (across, label) in self.across.iter().zip(self.pattern.labels()) {
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
            let wall = self.start.labels.iter().position(|other| other == label);
            let Some(wall) = wall else {
                return false;
            };
            (self.realizer).add(&self.start.planes[wall], false, cell);
        }
        self.realizer.realize(cell)
    }
}
