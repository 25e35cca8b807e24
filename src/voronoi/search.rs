//! Selection of the bisectors that cut a cell, up to its security radius.
//!
//! A site farther from x than twice the farthest vertex of the cell so far can no longer cut it
//! (\[RSL\] section 3: the security radius). The nearest few dozen candidates come sorted and cut the
//! cell; of what lies beyond, only subtrees and sites inside the ball of a far vertex are tested
//! ([`VertexBalls`]). So an elongated cell beside a dense cluster costs little more than others.
//!
//! \[RSL\] Ray, Sokolov, Lefebvre & Lévy, *Meshless Voronoi on the GPU*, 2018.

use nalgebra::{Point3, Vector3};
use wide::f64x4;

use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::{Full, SmallClipScratch};
use crate::voronoi::kd_tree::candidates::{Candidate, Subtree};
use crate::voronoi::kd_tree::neighborhood::{DISORDER, NeighborQuery};
use crate::voronoi::kd_tree::tree::KdTree;

/// Two sites in one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Duplicate {
    /// The smaller index.
    pub(crate) first: u32,
    /// The greater index.
    pub(crate) second: u32,
}

/// Why a cell could not be built.
pub(crate) enum BuildError {
    /// It has more vertices than the fixed slots hold.
    Full,
    /// Another site lies in the same place.
    Duplicate(Duplicate),
}

/// Memory of the search for the bisectors that cut a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct BisectorSearch {
    query: NeighborQuery,
    balls: VertexBalls,
    stack: Vec<Subtree>,
}

/// The state of a search.
struct SearchState<'a, S> {
    tree: &'a KdTree,
    place: usize,
    site: Point3<f64>,
    cell: &'a mut S,
    /// The squared distance beyond which no site cuts.
    reach_squared: f64,
    /// The squared distance within which all sites have been tried.
    searched_squared: f64,
}

impl BisectorSearch {
    /// Cuts `cell` by all bisectors of the site in `place` that change it.
    pub(crate) fn cut_all(
        &mut self,
        tree: &KdTree,
        place: usize,
        cell: &mut impl ClipTarget,
    ) -> Result<(), BuildError> {
        // An earlier search may have ended in an error.
        self.stack.clear();
        let reach_squared = 4.0 * cell.radius_squared();
        let initial = tree.initial_radius_squared(place);
        let limit = initial.min(reach_squared);
        let mut state = SearchState {
            tree,
            place,
            site: tree.position(place),
            cell,
            reach_squared,
            searched_squared: self.query.gather(tree, place, (limit, initial)),
        };
        self.cut_by_sorted(&mut state)?;
        if state.reach_squared > state.searched_squared {
            let least = 0.25 * state.searched_squared;
            state.cell.list_beyond(least, &mut self.balls);
            self.search_beyond(&mut state)?;
        }
        Ok(())
    }

    /// Cuts by the sorted candidates, of which none may lie in the site itself.
    #[inline]
    fn cut_by_sorted(
        &self,
        state: &mut SearchState<'_, impl ClipTarget>,
    ) -> Result<(), BuildError> {
        let near = self.query.near();
        let duplicates = near.take_while(|candidate| candidate.distance_squared <= 0.0);
        if let Some(other) = duplicates.min_by_key(|other| state.tree.site(other.place as usize)) {
            return Err(BuildError::Duplicate(state.duplicate(other)));
        }
        for candidate in self.query.near() {
            if candidate.distance_squared < state.reach_squared {
                state.try_cut(candidate)?;
            } else if candidate.distance_squared > DISORDER * state.reach_squared {
                break;
            }
        }
        Ok(())
    }

    /// Tries the sites beyond the sorted ones that lie in the ball of a far vertex.
    fn search_beyond(
        &mut self,
        state: &mut SearchState<'_, impl ClipTarget>,
    ) -> Result<(), BuildError> {
        let Self {
            query,
            balls,
            stack,
        } = self;
        let range = (state.searched_squared, state.reach_squared);
        for candidate in query.gathered(state.tree, state.place, range) {
            state.try_far(candidate, balls)?;
        }
        for subtree in query.beyond(state.reach_squared) {
            if subtree.gap_squared >= state.reach_squared {
                break;
            }
            stack.push(*subtree);
            state.descend(stack, balls)?;
        }
        Ok(())
    }
}

impl<S: ClipTarget> SearchState<'_, S> {
    /// Tries the sites of the subtrees on the stack.
    fn descend(
        &mut self,
        stack: &mut Vec<Subtree>,
        balls: &mut VertexBalls,
    ) -> Result<(), BuildError> {
        while let Some(subtree) = stack.pop() {
            if subtree.gap_squared >= self.reach_squared {
                continue;
            }
            let by = self.tree.images()[subtree.shift as usize].by;
            let here = self.site - by;
            if !balls.meet(&self.tree.bounds(subtree.node), &here) {
                continue;
            }
            if self.tree.is_leaf(subtree.node) {
                for place in self.tree.places(subtree.node) {
                    if place != self.place {
                        let at = (place, subtree.shift);
                        let candidate = Candidate::new(self.tree, &self.site, at, &by);
                        self.try_far(&candidate, balls)?;
                    }
                }
            } else {
                let [near, other] = subtree.children(self.tree, &here);
                stack.push(other);
                stack.push(near);
            }
        }
        Ok(())
    }

    /// Cuts by a candidate beyond the sorted ones, if it cuts at all.
    #[inline]
    fn try_far(
        &mut self,
        candidate: &Candidate,
        balls: &mut VertexBalls,
    ) -> Result<(), BuildError> {
        let square = candidate.distance_squared;
        let may_cut = square > self.searched_squared && square < self.reach_squared;
        // A site in the same place cuts nothing, and is an error.
        if !may_cut || square > 0.0 && !balls.exceed(&candidate.bisector()) {
            return Ok(());
        }
        self.try_cut(candidate)?;
        self.cell.list_beyond(0.25 * self.searched_squared, balls);
        Ok(())
    }

    #[inline]
    fn try_cut(&mut self, candidate: &Candidate) -> Result<(), BuildError> {
        if candidate.distance_squared <= 0.0 {
            return Err(BuildError::Duplicate(self.duplicate(candidate)));
        }
        let tree = self.tree;
        let label = || candidate.label(tree);
        match self.cell.cut(&candidate.bisector(), label) {
            Ok(Clip::Unchanged) => {}
            Ok(_) => self.reach_squared = 4.0 * self.cell.radius_squared(),
            Err(Full) => return Err(BuildError::Full),
        }
        Ok(())
    }

    /// The site and another in its place.
    #[cold]
    fn duplicate(&self, candidate: &Candidate) -> Duplicate {
        let site = self.tree.site(self.place);
        let other = self.tree.site(candidate.place as usize);
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

/// A polyhedron about the origin that can be cut: in fixed slots, or of any size.
pub(crate) trait ClipTarget {
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full>;

    fn radius_squared(&self) -> f64;

    /// Lists the vertices farther from the origin than the root of `square`.
    fn list_beyond(&self, square: f64, balls: &mut VertexBalls);
}

impl ClipTarget for (&mut SmallPolyhedron, &mut SmallClipScratch) {
    #[inline]
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full> {
        self.0.clip(half_space, label, self.1)
    }

    #[inline]
    fn radius_squared(&self) -> f64 {
        self.0.radius_squared()
    }

    fn list_beyond(&self, square: f64, balls: &mut VertexBalls) {
        balls.clear();
        let compact = &self.0;
        for slot in compact.beyond(square) {
            balls.push([
                compact.x[slot],
                compact.y[slot],
                compact.z[slot],
                compact.square[slot],
            ]);
        }
    }
}

impl ClipTarget for (&mut Polyhedron, &mut ClipScratch) {
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full> {
        Ok(clip(self.0, half_space, label(), self.1))
    }

    fn radius_squared(&self) -> f64 {
        self.0.radius_squared()
    }

    fn list_beyond(&self, square: f64, balls: &mut VertexBalls) {
        balls.clear();
        for vertex in self.0.vertices() {
            let distance = vertex.coords.norm_squared();
            if distance > square {
                balls.push([vertex.x, vertex.y, vertex.z, distance]);
            }
        }
    }
}

/// The vertices of a cell, relative to its site, that sites farther than some distance may cut.
///
/// A site p cuts the vertex v exactly if it lies in the ball about v through the site in the origin:
/// |p − v| < |v|. So neither a site farther than 2 |v| cuts it, nor any site in a box that does not
/// meet the ball. The union of the balls of all vertices contains every site that cuts the cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct VertexBalls {
    blocks: Vec<[f64x4; 4]>,
    /// How many vertices there are in the blocks.
    count: usize,
}

impl VertexBalls {
    /// Removes all vertices.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Adds a vertex, the last number being its squared distance.
    #[inline]
    pub(crate) fn push(&mut self, vertex: [f64; 4]) {
        let lane = self.count % 4;
        if lane == 0 {
            // Lanes without a vertex hold the site itself, which no site cuts and whose ball is empty.
            self.blocks.push([f64x4::ZERO; 4]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (lanes, number) in block.iter_mut().zip(vertex) {
                lanes.as_mut_array()[lane] = number;
            }
        }
        self.count += 1;
    }

    /// Whether one of the vertices lies beyond the half-space, as computed.
    #[inline]
    #[must_use]
    pub(crate) fn exceed(&self, half_space: &HalfSpace) -> bool {
        let [a, b, c] = [0, 1, 2].map(|axis| f64x4::splat(half_space.normal[axis]));
        let offset = f64x4::splat(half_space.offset);
        let mut cut = 0;
        for [x, y, z, _] in &self.blocks {
            cut |= (offset - (a * *x + b * *y + c * *z)).to_bitmask();
        }
        cut != 0
    }

    /// Whether the ball of one of the vertices meets the box, for a cell whose site is at `here`.
    #[inline]
    #[must_use]
    pub(crate) fn meet(&self, bounds: &Bounds<3>, here: &Point3<f64>) -> bool {
        let [min, max] = [&bounds.min, &bounds.max].map(|end| {
            let end: Vector3<f64> = end - here;
            [0, 1, 2].map(|axis| f64x4::splat(end[axis]))
        });
        for [x, y, z, square] in &self.blocks {
            let mut excess = -*square;
            for (axis, along) in [x, y, z].into_iter().enumerate() {
                let outside = (min[axis] - *along).fast_max(*along - max[axis]);
                let gap = outside.fast_max(f64x4::ZERO);
                excess += gap * gap;
            }
            if excess.to_bitmask() != 0 {
                return true;
            }
        }
        false
    }
}
