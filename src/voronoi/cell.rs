//! One Voronoi cell: bisectors of ever farther sites until the security radius.
//!
//! A site farther from x than twice the farthest vertex of the cell so far cannot cut it any more
//! (\[RSL\] section 3). Candidates come from the index ring by ring, sorted within a ring, so that
//! most cuts happen early and shape the final cell.

use nalgebra::Point3;

use crate::domain::beyond::Beyond;
use crate::domain::space::{Domain, PieceScratch};
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::index::{Candidate, SiteIndex};

/// A cell under the caller's eyes, in coordinates relative to its site.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// The site's index.
    pub site: u32,
    /// The site's position.
    pub position: Point3<f64>,
    /// The cell, clipped to the domain's convex start; its site is the origin.
    pub polyhedron: &'a Polyhedron,
}

/// The memory in which cells are built, one after the other.
#[derive(Clone, Debug, Default)]
pub struct CellBuilder {
    polyhedron: Polyhedron,
    clip: ClipScratch,
    piece: PieceScratch,
    candidates: Vec<Candidate>,
}

/// Two sites in one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Duplicate {
    /// The smaller index.
    pub first: u32,
    /// The greater index.
    pub second: u32,
}

impl CellBuilder {
    /// Builds the cell of the site in `place` of the index.
    ///
    /// # Errors
    /// When another site, or an image of one, lies in the same place.
    pub fn build(
        &mut self,
        domain: &dyn Domain,
        index: &SiteIndex,
        place: usize,
    ) -> Result<Cell<'_>, Duplicate> {
        let (site, position) = (index.site(place), index.position(place));
        domain.start(&position, site, &mut self.polyhedron);
        let bin = index.bin(place);
        let mut needed = 4.0 * self.polyhedron.radius_squared();
        self.candidates.clear();
        for ring in 1.. {
            let candidates = &mut self.candidates;
            let any = index.collect_ring(place, bin, ring, needed, candidates);
            let reach = index.reach(place, bin, ring);
            // The nearest first: what lies beyond the reach is often not needed any more then.
            needed = self.cut(index, place, reach * reach, needed)?;
            needed = self.cut(index, place, f64::INFINITY, needed)?;
            self.candidates.clear();
            if reach * reach < needed && !domain.is_convex() {
                // What lies outside the domain needs no security.
                let radius = domain.radius_squared(&position, &self.polyhedron, &mut self.piece);
                needed = needed.min(4.0 * radius);
            }
            if reach * reach >= needed || !any {
                break;
            }
        }
        Ok(Cell {
            site,
            position,
            polyhedron: &self.polyhedron,
        })
    }

    /// Cuts by the candidates within `reach_squared`, nearest first, and keeps the others for
    /// later. Takes and returns the squared security distance.
    fn cut(
        &mut self,
        index: &SiteIndex,
        place: usize,
        reach_squared: f64,
        mut needed: f64,
    ) -> Result<f64, Duplicate> {
        let limit = reach_squared.min(needed);
        let near = partition(&mut self.candidates, |c| c.distance_squared <= limit);
        self.candidates[..near].sort_unstable_by(|a, b| {
            let by_distance = a.distance_squared.total_cmp(&b.distance_squared);
            by_distance.then_with(|| (a.place, a.image).cmp(&(b.place, b.image)))
        });
        for candidate in self.candidates.drain(..near) {
            if candidate.distance_squared > needed {
                break;
            }
            let other = index.site(candidate.place as usize);
            if candidate.distance_squared <= 0.0 {
                let site = index.site(place);
                let (first, second) = (site.min(other), site.max(other));
                return Err(Duplicate { first, second });
            }
            let bisector = HalfSpace::bisector(index.displacement(place, &candidate));
            let image = candidate.image;
            let label = Beyond::Neighbor { site: other, image }.label();
            if clip(&mut self.polyhedron, &bisector, label, &mut self.clip) == Clip::Cut {
                needed = needed.min(4.0 * self.polyhedron.radius_squared());
            }
        }
        Ok(needed)
    }
}

/// Moves the items that satisfy the predicate to the front and returns how many there are.
fn partition<T>(items: &mut [T], is_front: impl Fn(&T) -> bool) -> usize {
    let mut front = 0;
    for item in 0..items.len() {
        if is_front(&items[item]) {
            items.swap(front, item);
            front += 1;
        }
    }
    front
}
