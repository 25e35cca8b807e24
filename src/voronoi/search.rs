//! The sites that shape a cell: bisectors of ever farther sites until the security radius.
//!
//! A site farther from x than twice the farthest vertex of the cell so far cannot cut it any more
//! (\[RSL\] section 3). The nearest few dozen sites come sorted and shape the cell; of what lies
//! beyond, only that is looked at which the far vertices of the cell can feel. So a cell
//! that reaches far out of a crowd, or a crowd that lies uneven, costs little more than others.

use nalgebra::Point3;

use crate::geometry::clip::Clip;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::small_polyhedron_clip::Full;
use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::far::FarVertices;
use crate::voronoi::in_order::{Next, Queue};
use crate::voronoi::index::SiteIndex;
use crate::voronoi::shape::Shape;
use crate::voronoi::surroundings::{DISORDER, Surroundings};

/// The square that is seen before anything is.
const NOTHING_SEEN: f64 = -1.0;

/// Two sites in one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Duplicate {
    /// The smaller index.
    pub first: u32,
    /// The greater index.
    pub second: u32,
}

/// How the sites that shape a cell are looked for. Which way shows in the order of cuts only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    /// The sites around look around as well: what is gathered for one serves them all.
    Crowd,
    /// They do not.
    Alone,
    /// One after the other, by distance: cuts are then made in the only order that depends on
    /// nothing but where the sites are.
    InOrder,
}

/// Why a cell could not be finished.
pub(crate) enum Halt {
    Full,
    Duplicate(Duplicate),
}

/// The search for the sites that shape a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Search {
    surroundings: Surroundings,
    far: FarVertices,
    stack: Vec<Subtree>,
    queue: Queue,
}

/// Where a search is.
struct Task<'a, S> {
    index: &'a SiteIndex,
    place: usize,
    site: Point3<f64>,
    shape: &'a mut S,
    /// The squared distance from which on no site cuts.
    needed: f64,
    /// The squared distance within which all sites have been tried.
    seen: f64,
}

impl Search {
    /// Cuts a shape by all bisectors of the site in `place`.
    pub(crate) fn shape(
        &mut self,
        index: &SiteIndex,
        (place, manner): (usize, Manner),
        shape: &mut impl Shape,
    ) -> Result<(), Halt> {
        if manner == Manner::InOrder {
            return self.shape_in_order(index, place, shape);
        }
        // An earlier search may have been halted.
        self.stack.clear();
        let needed = 4.0 * shape.radius_squared();
        let usual = index.first_look_squared(place);
        let limit = usual.min(needed);
        let seen = if manner == Manner::Crowd {
            self.surroundings.look(index, place, (limit, usual))
        } else {
            self.surroundings.look_alone(index, place, limit)
        };
        let mut task = Task {
            index,
            place,
            site: index.position(place),
            shape,
            needed,
            seen,
        };
        let near = self.surroundings.near();
        let twins = near.take_while(|candidate| candidate.distance_squared <= 0.0);
        if let Some(twin) = twins.min_by_key(|twin| index.site(twin.place as usize)) {
            return Err(Halt::Duplicate(task.duplicate(twin)));
        }
        for candidate in self.surroundings.near() {
            if candidate.distance_squared < task.needed {
                task.try_cut(candidate)?;
            } else if candidate.distance_squared > DISORDER * task.needed {
                break;
            }
        }
        if task.needed > seen {
            task.shape.list_beyond(0.25 * task.seen, &mut self.far);
            if manner == Manner::Crowd {
                self.look_beyond(&mut task)?;
            } else {
                self.look_everywhere(&mut task)?;
            }
        }
        Ok(())
    }

    /// As [`Search::shape`], by ever farther sites, those equally far by label.
    fn shape_in_order(
        &mut self,
        index: &SiteIndex,
        place: usize,
        shape: &mut impl Shape,
    ) -> Result<(), Halt> {
        let Self { far, queue, .. } = self;
        let mut task = Task {
            index,
            place,
            site: index.position(place),
            needed: 4.0 * shape.radius_squared(),
            shape,
            seen: NOTHING_SEEN,
        };
        task.shape.list_beyond(0.25 * task.seen, far);
        queue.clear();
        for shift in 0..index.shifts().len() {
            queue.push_subtree(Subtree::whole(shift));
        }
        while let Some(next) = queue.pop() {
            match next {
                Next::Candidate(candidate) => task.try_far(&candidate, far)?,
                Next::Subtree(subtree) => task.open(&subtree, far, queue),
            }
        }
        Ok(())
    }

    /// Tries what is farther than the first look and within the flower.
    fn look_beyond(&mut self, task: &mut Task<'_, impl Shape>) -> Result<(), Halt> {
        let Self {
            surroundings,
            far,
            stack,
            ..
        } = self;
        let range = (task.seen, task.needed);
        for candidate in surroundings.gathered(task.index, task.place, range) {
            task.try_far(candidate, far)?;
        }
        for subtree in surroundings.beyond(task.needed) {
            if subtree.gap_squared >= task.needed {
                break;
            }
            stack.push(*subtree);
            task.descend(stack, far)?;
        }
        Ok(())
    }

    /// As [`Search::look_beyond`], for a site whose surroundings have not been gathered.
    fn look_everywhere(&mut self, task: &mut Task<'_, impl Shape>) -> Result<(), Halt> {
        for shift in 0..task.index.shifts().len() {
            self.stack.push(Subtree::whole(shift));
            task.descend(&mut self.stack, &mut self.far)?;
        }
        Ok(())
    }
}

impl<S: Shape> Task<'_, S> {
    /// Puts what a subtree consists of into the queue, unless it cannot cut.
    fn open(&self, subtree: &Subtree, far: &FarVertices, queue: &mut Queue) {
        let by = self.index.shifts()[subtree.shift as usize].by;
        let here = self.site - by;
        let is_near = subtree.gap_squared < self.needed;
        if !is_near || !far.meet(&self.index.bounds(subtree.node), &here) {
            return;
        }
        if !self.index.is_leaf(subtree.node) {
            let children = subtree.children(self.index, &here);
            children
                .into_iter()
                .for_each(|child| queue.push_subtree(child));
            return;
        }
        for place in self.index.places(subtree.node) {
            let at = (place, subtree.shift);
            let candidate = Candidate::new(self.index, &self.site, at, &by);
            if place != self.place && candidate.distance_squared < self.needed {
                queue.push_candidate(candidate, candidate.label(self.index));
            }
        }
    }

    /// Looks through the subtrees on the stack.
    fn descend(&mut self, stack: &mut Vec<Subtree>, far: &mut FarVertices) -> Result<(), Halt> {
        while let Some(subtree) = stack.pop() {
            if subtree.gap_squared >= self.needed {
                continue;
            }
            let by = self.index.shifts()[subtree.shift as usize].by;
            let here = self.site - by;
            if !far.meet(&self.index.bounds(subtree.node), &here) {
                continue;
            }
            if self.index.is_leaf(subtree.node) {
                for place in self.index.places(subtree.node) {
                    if place != self.place {
                        let at = (place, subtree.shift);
                        let candidate = Candidate::new(self.index, &self.site, at, &by);
                        self.try_far(&candidate, far)?;
                    }
                }
            } else {
                let [near, other] = subtree.children(self.index, &here);
                stack.push(other);
                stack.push(near);
            }
        }
        Ok(())
    }

    /// Cuts by a candidate that is farther than the first look, if it cuts at all.
    #[inline]
    fn try_far(&mut self, candidate: &Candidate, far: &mut FarVertices) -> Result<(), Halt> {
        let square = candidate.distance_squared;
        let may_cut = square > self.seen && square < self.needed;
        // A site in the same place cuts nothing, and has to be told of.
        if !may_cut || square > 0.0 && !far.exceed(&candidate.bisector()) {
            return Ok(());
        }
        self.try_cut(candidate)?;
        self.shape.list_beyond(0.25 * self.seen, far);
        Ok(())
    }

    #[inline]
    fn try_cut(&mut self, candidate: &Candidate) -> Result<(), Halt> {
        if candidate.distance_squared <= 0.0 {
            return Err(Halt::Duplicate(self.duplicate(candidate)));
        }
        let index = self.index;
        let label = || candidate.label(index);
        match self.shape.cut(&candidate.bisector(), label) {
            Ok(Clip::Unchanged) => {}
            Ok(_) => self.needed = 4.0 * self.shape.radius_squared(),
            Err(Full) => return Err(Halt::Full),
        }
        Ok(())
    }

    /// The site and another in its place.
    #[cold]
    fn duplicate(&self, candidate: &Candidate) -> Duplicate {
        let site = self.index.site(self.place);
        let other = self.index.site(candidate.place as usize);
        Duplicate {
            first: site.min(other),
            second: site.max(other),
        }
    }
}

impl Candidate {
    #[inline]
    fn bisector(&self) -> HalfSpace {
        HalfSpace {
            normal: self.displacement,
            offset: 0.5 * self.distance_squared,
        }
    }
}
