//! Selection of the bisectors that cut a cell, up to its security radius.
//!
//! A site farther from x than twice the farthest vertex of the cell so far can no longer cut it
//! (\[RSL\] section 3: the security radius). The nearest few dozen candidates come sorted and cut the
//! cell; of what lies beyond, only subtrees and sites inside the ball of a far vertex are tested
//! ([`VertexBalls`]). So an elongated cell beside a dense cluster costs little more than others.
//!
//! Sites cut in the order of their distances, those at one distance in the order of their indices and
//! images. What lies beyond the sorted ones is searched in rings, each so many times as wide as the last, and
//! what of a ring may still cut is sorted. So a cell's bits depend on its neighbors alone, not on the index:
//! not on other sites, nor on which of them an index holds.
//!
//! \[RSL\] Ray, Sokolov, Lefebvre & Lévy, *Meshless Voronoi on the GPU*, 2018.

use nalgebra::{Point3, Vector3};
use wide::f64x4;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::{Full, SmallClipScratch};
use crate::voronoi::kd_tree::candidates::{Candidate, Subtree};
use crate::voronoi::kd_tree::neighborhood::NeighborQuery;
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
    rings: Rings,
}

/// What is nearer than this share to cutting a cell, or to its reach, is tried when its turn comes: what is left
/// out before must not depend on the state in which the cell then was, up to rounding.
const SLACK: f64 = 1e-10;

/// Each ring reaches so many times as far as the one before, squared.
const RING_FACTOR_SQUARED: f64 = 2.0;

/// What is left to be searched beyond the sorted sites.
#[derive(Clone, Debug, Default)]
struct Rings {
    /// Sites that may cut the cell, in no order.
    sites: Vec<Candidate>,
    /// Subtrees beyond the present ring.
    beyond: Vec<Subtree>,
    /// Subtrees within it.
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
            state.list_far_vertices(&mut self.balls);
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
            } else {
                break;
            }
        }
        Ok(())
    }

    /// Cuts by the sites beyond the sorted ones that lie in the ball of a far vertex, ring by ring.
    fn search_beyond(
        &mut self,
        state: &mut SearchState<'_, impl ClipTarget>,
    ) -> Result<(), BuildError> {
        let Self {
            query,
            balls,
            rings,
        } = self;
        let range = (state.searched_squared, state.reach_squared);
        rings.sites.clear();
        for candidate in query.gathered(state.tree, state.place, range) {
            rings.push(candidate, balls);
        }
        // All sites so near have been gathered.
        let mut ring = query.gathered_squared();
        state.cut_by_ring(rings, balls, ring)?;
        if ring < state.reach_squared {
            rings.beyond.clear();
            rings.beyond.extend(query.beyond(state.reach_squared));
        }
        while ring < state.reach_squared {
            ring = match ring > 0.0 {
                true => ring * RING_FACTOR_SQUARED,
                false => state.reach_squared,
            };
            state.descend(rings, balls, ring);
            state.cut_by_ring(rings, balls, ring)?;
        }
        Ok(())
    }
}

impl Rings {
    /// Keeps a site that may cut: one in the place of the cell's own too, which is an error.
    #[inline]
    fn push(&mut self, candidate: &Candidate, balls: &VertexBalls) {
        if candidate.distance_squared <= 0.0 || balls.may_exceed(&candidate.bisector()) {
            self.sites.push(*candidate);
        }
    }
}

impl<S: ClipTarget> SearchState<'_, S> {
    /// Keeps the sites of the subtrees within a ring that may cut.
    fn descend(&mut self, rings: &mut Rings, balls: &VertexBalls, ring_squared: f64) {
        let reach_squared = self.reach_squared * (1.0 + SLACK);
        let ring_squared = ring_squared.min(reach_squared);
        let stack = &mut rings.stack;
        stack.clear();
        rings.beyond.retain(|subtree| {
            let is_within = subtree.gap_squared < ring_squared;
            if is_within {
                stack.push(*subtree);
            }
            !is_within && subtree.gap_squared < reach_squared
        });
        while let Some(subtree) = rings.stack.pop() {
            let by = self.tree.images()[subtree.shift as usize].by;
            let here = self.site - by;
            if !balls.meet(&self.tree.bounds(subtree.node), &here) {
                continue;
            }
            if self.tree.is_leaf(subtree.node) {
                self.keep_leaf(rings, balls, &subtree, &by);
                continue;
            }
            for child in subtree.children(self.tree, &here) {
                if child.gap_squared < ring_squared {
                    rings.stack.push(child);
                } else if child.gap_squared < reach_squared {
                    rings.beyond.push(child);
                }
            }
        }
    }

    /// Keeps the sites of a leaf that may cut and have not been tried.
    fn keep_leaf(&self, rings: &mut Rings, balls: &VertexBalls, leaf: &Subtree, by: &Vector3<f64>) {
        let reach_squared = self.reach_squared * (1.0 + SLACK);
        for place in self.tree.places(leaf.node) {
            if place != self.place {
                let candidate = Candidate::new(self.tree, &self.site, (place, leaf.shift), by);
                let square = candidate.distance_squared;
                if square > self.searched_squared && square < reach_squared {
                    rings.push(&candidate, balls);
                }
            }
        }
    }

    /// The vertices that sites beyond the sorted ones may cut.
    fn list_far_vertices(&self, balls: &mut VertexBalls) {
        let least = 0.25 * self.searched_squared * (1.0 - SLACK);
        self.cell.list_beyond(least, balls);
    }

    /// Cuts by the sites of a ring in their order; later ones are kept.
    fn cut_by_ring(
        &mut self,
        rings: &mut Rings,
        balls: &mut VertexBalls,
        ring_squared: f64,
    ) -> Result<(), BuildError> {
        if rings.sites.is_empty() {
            return Ok(());
        }
        let tree = self.tree;
        let sites = &mut rings.sites;
        sites.sort_unstable_by(|one, other| one.compare(other, tree));
        let within = sites.partition_point(|site| site.distance_squared <= ring_squared);
        for candidate in &sites[..within] {
            let square = candidate.distance_squared;
            if square >= self.reach_squared {
                break;
            }
            if square <= 0.0 || balls.may_exceed(&candidate.bisector()) {
                self.try_cut(candidate)?;
                self.list_far_vertices(balls);
            }
        }
        sites.drain(..within);
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

    /// Whether one of the vertices lies beyond a bisector, or nearly so: |a·v| ≤ offset + |v|²/2.
    #[inline]
    #[must_use]
    pub(crate) fn may_exceed(&self, bisector: &HalfSpace) -> bool {
        let [a, b, c] = [0, 1, 2].map_each(|axis| f64x4::splat(bisector.normal[axis]));
        let offset = f64x4::splat(bisector.offset * (1.0 - SLACK));
        let slack = f64x4::splat(SLACK);
        let mut cut = 0;
        for [x, y, z, square] in &self.blocks {
            cut |= (offset - slack * *square - (a * *x + b * *y + c * *z)).to_bitmask();
        }
        cut != 0
    }

    /// Whether the ball of one of the vertices meets the box, or nearly so, for a cell whose site is at `here`.
    #[inline]
    #[must_use]
    pub(crate) fn meet(&self, bounds: &Bounds<3>, here: &Point3<f64>) -> bool {
        let [min, max] = [&bounds.min, &bounds.max].map_each(|end| {
            let end: Vector3<f64> = end - here;
            [0, 1, 2].map_each(|axis| f64x4::splat(end[axis]))
        });
        for [x, y, z, square] in &self.blocks {
            let mut excess = -*square * f64x4::splat(1.0 + SLACK);
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
