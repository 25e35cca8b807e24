//! The memory in which patterns become cells.

use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::body::Body;
use crate::voronoi::cell::Cell;
use crate::voronoi::corners::Corners;
use crate::voronoi::flip::Flip;
use crate::voronoi::pattern::{MOST, Pattern};
use crate::voronoi::ranks::{Across, IMAGES};
use crate::voronoi::realize::Realizer;
use crate::voronoi::standing::Standing;
use crate::voronoi::touch::Touch;

/// How often a pattern is flipped and realized before it is given up.
const MOST_MENDED: usize = 3;

/// The memory in which patterns become cells.
#[derive(Debug, Default)]
pub(crate) struct Mold {
    pub(crate) pattern: Pattern,
    pub(crate) corners: Corners,
    realizer: Realizer,
    touch: Touch,
    start: Polyhedron,
    pub(crate) body: Body,
}

impl Mold {
    /// Takes the pattern of a cell that was built and realizes it; returns whether it has one and is
    /// beyond doubt: sound by itself and touched by no other site.
    pub(crate) fn take_over(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        built: &Cell<'_>,
    ) -> bool {
        let has_pattern =
            (built.compact()).is_some_and(|compact| self.pattern.assign(compact, built.site));
        let is_sound = has_pattern && self.realize(standing, rank);
        let Self { body, touch, .. } = self;
        let cell = body.compact().filter(|_| is_sound);
        cell.is_some_and(|cell| !touch.is_touched(standing.index, rank, cell))
    }

    /// Flips the pattern in hand, which has been realized, where edges run the wrong way, and tells
    /// of it; returns whether the cell is then beyond doubt.
    pub(crate) fn mend(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        told: &mut Vec<Flip>,
    ) -> bool {
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
            let (mut any, mut can_tell) = (false, true);
            self.realizer.visit_reversed(cell, |facets| {
                let four = facets.map(|facet| pattern.labels[usize::from(facet) % MOST]);
                if let Some(view) = corners.flip(&four) {
                    let flip = Flip::told(site, &four, view);
                    can_tell &= flip.is_some();
                    any = true;
                    let same = |other: &Flip| flip.is_some_and(|flip| flip.is_among(other));
                    match told[before..].iter().position(same) {
                        // It takes the other one back.
                        Some(place) => drop(told.remove(before + place)),
                        None => told.extend(flip),
                    }
                }
            });
            if !any || !can_tell || !corners.write(pattern) {
                break;
            }
            if self.realize(standing, rank) {
                return true;
            }
        }
        told.truncate(before);
        false
    }

    /// Whether the cell that has been realized will hardly keep its pattern.
    pub(crate) fn is_fragile(&self) -> bool {
        self.realizer.is_fragile()
    }

    /// The cell that has been realized.
    pub(crate) fn cell(&self, standing: &Standing<'_>, rank: usize) -> Cell<'_> {
        Cell {
            site: standing.numbers.sites[rank],
            position: standing.index.position(rank),
            body: &self.body,
        }
    }

    /// Realizes the pattern in hand; returns whether the cell is beyond doubt.
    pub(crate) fn realize(&mut self, standing: &Standing<'_>, rank: usize) -> bool {
        self.pattern.write(self.body.slots());
        let (labels, count) = (self.pattern.labels, self.pattern.facet_count);
        let across = labels[..count].iter();
        self.place(
            standing,
            rank,
            across.map(|&label| standing.numbers.across(label)),
        )
    }

    /// Places the vertices of a pattern that has been laid out in the body, beyond whose facets lies
    /// what `across` tells; returns whether the cell is beyond doubt.
    #[inline(always)]
    pub(crate) fn place(
        &mut self,
        standing: &Standing<'_>,
        rank: usize,
        across: impl Iterator<Item = Across>,
    ) -> bool {
        let here = standing.index.position(rank);
        let cell = self.body.slots();
        self.realizer.clear();
        let mut has_start = false;
        for (facet, across) in across.enumerate() {
            if let Some((rank, image)) = across.site() {
                let by = standing.shifts[usize::from(image) % IMAGES];
                let away = standing.index.position(rank as usize) - here + by;
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
