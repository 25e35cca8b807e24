//! Candidate neighbors of a site, ordered by distance and gathered once for the sites of a subtree.
//!
//! The sites of a small subtree have almost the same candidates. So the tree is searched once for such a
//! neighborhood, and what lies within reach is copied by component, in single precision about the
//! middle of the subtree ([`NeighborhoodBuffer`]). Each site then filters the copy without a branch;
//! what passes, with a margin for the rounding, is measured again in double precision.
//!
//! Candidates within the initial radius form the first set. Those beyond it, up to the reach and in
//! leaves that are partly within it, are kept apart for cells that need more.

use nalgebra::{Point3, Vector3};
use wide::i32x8;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::voronoi::kd_tree::candidates::{
    Candidate, CandidateList, CandidateSoa, ROUNDING, Subtree,
};
use crate::voronoi::kd_tree::tree::KdTree;

/// The most sorted candidates: more take longer to sort than they save, and the radius is reduced.
const MOST_SORTED: usize = 256;

/// The bits of a sorting key that number a candidate: as many as [`MOST_SORTED`] takes.
const NUMBER: i32 = 0xff;

/// Up to so many near sites are ranked by comparing all with all: there is no branch in that.
const RANKED_BY_COMPARISON: usize = 64;

/// Keys compared together, eight at a time.
const BLOCK: usize = 16;

/// The candidates of one site, and the memory to find them.
#[derive(Clone, Debug, Default)]
pub(crate) struct NeighborQuery {
    buffer: NeighborhoodBuffer,
    /// The sites within the initial radius.
    near: CandidateList,
    /// Their sorting keys.
    keys: Vec<i32>,
    /// Their numbers, nearest first.
    order: Vec<u8>,
    /// Sites beyond the initial radius.
    others: CandidateList,
}

impl NeighborQuery {
    /// Gathers the candidates of the site in `place` as far as the root of `limit`, or less far where
    /// these are too many, and returns the squared distance within which all are found. The buffer
    /// depends on `initial` alone, the limit that neighboring sites have in common.
    pub(crate) fn gather(
        &mut self,
        tree: &KdTree,
        place: usize,
        (limit, initial): (f64, f64),
    ) -> f64 {
        self.buffer.gather(tree, place, initial);
        let site = tree.position(place);
        self.buffer.measure(&site);
        let mut limit = limit.min(self.buffer.near_squared());
        for _ in 0..MOST_REDUCTIONS {
            if self.select_within(tree, place, &site, limit) {
                self.sort(tree);
                return limit;
            }
            limit *= 0.25;
        }
        self.select_none()
    }

    /// Selects nothing; the squared distance searched is then negative.
    fn select_none(&mut self) -> f64 {
        self.near.clear();
        self.order.clear();
        -1.0
    }

    /// The sites within the initial radius in the order of [`Candidate::compare`].
    pub(crate) fn near(&self) -> impl Iterator<Item = &Candidate> {
        let order = self.order.iter();
        let candidates = self.near.candidates();
        order.map(|&number| &candidates[usize::from(number)])
    }

    /// Orders the candidates by their keys, no two of which agree, and then near ties by themselves: keys
    /// hold the distance to 2⁻¹² only.
    fn sort(&mut self, tree: &KdTree) {
        let count = self.keys.len();
        self.order.clear();
        if count > RANKED_BY_COMPARISON {
            self.keys.sort_unstable();
            let numbers = self.keys.iter().map(|key| (key & NUMBER) as u8);
            self.order.extend(numbers);
        } else {
            self.rank_by_comparison(count);
        }
        self.sort_near_ties(tree);
    }

    /// Sorts by insertion what is sorted but for near ties.
    fn sort_near_ties(&mut self, tree: &KdTree) {
        let near = self.near.candidates();
        for end in 1..self.order.len() {
            let number = self.order[end];
            let candidate = &near[usize::from(number)];
            let mut place = end;
            while place > 0 {
                let before = &near[usize::from(self.order[place - 1])];
                if before.distance_squared < candidate.distance_squared
                    || before.compare(candidate, tree).is_lt()
                {
                    break;
                }
                self.order[place] = self.order[place - 1];
                place -= 1;
            }
            self.order[place] = number;
        }
    }

    /// Ranks each of the first `count` keys by the number of smaller ones.
    #[inline]
    fn rank_by_comparison(&mut self, count: usize) {
        self.order.resize(count, 0);
        self.keys.resize(count.next_multiple_of(BLOCK), i32::MAX);
        let blocks = self.keys.as_chunks::<BLOCK>().0;
        for (number, &key) in self.keys[..count].iter().enumerate() {
            let mut less = i32x8::ZERO;
            for block in blocks {
                for &lanes in block.as_chunks().0 {
                    less += i32x8::new(lanes).simd_lt(i32x8::splat(key));
                }
            }
            // A comparison that holds is −1.
            let rank = -less.to_array().iter().sum::<i32>();
            self.order[rank as usize] = number as u8;
        }
    }

    /// The gathered sites farther than the root of `searched` and within that of `reach_squared`, in no order.
    pub(crate) fn gathered(
        &mut self,
        tree: &KdTree,
        place: usize,
        (searched, reach_squared): (f64, f64),
    ) -> &[Candidate] {
        let site = tree.position(place);
        let from = (place, &site);
        self.buffer
            .find_all(tree, from, (searched, reach_squared), &mut self.others);
        self.others.candidates()
    }

    /// The squared distance from the site within which all sites have been gathered.
    pub(crate) fn gathered_squared(&self) -> f64 {
        self.buffer.reach_squared
    }

    /// What has not been gathered and may be nearer to the neighborhood than the root of `reach_squared`,
    /// nearest first; the gaps are those to the neighborhood.
    pub(crate) fn beyond(&mut self, reach_squared: f64) -> &[Subtree] {
        self.buffer.beyond(reach_squared)
    }

    fn select_within(
        &mut self,
        tree: &KdTree,
        place: usize,
        site: &Point3<f64>,
        limit: f64,
    ) -> bool {
        self.buffer.find(tree, (place, site), limit, &mut self.near);
        self.list_keys()
    }

    /// Lists the keys of the near sites, if these are not too many.
    fn list_keys(&mut self) -> bool {
        let near = self.near.candidates();
        if near.len() > MOST_SORTED {
            return false;
        }
        self.keys.clear();
        self.keys
            .extend(near.iter().enumerate().map(|(number, candidate)| {
                let order = (candidate.distance_squared.to_bits() >> 32) as i32 & !NUMBER;
                order | number as i32
            }));
        true
    }
}

/// Sites gathered at most: more take longer to filter than they save, and the reach is reduced.
const MOST_GATHERED: usize = 4096;

/// How often a reach is reduced, each time to a quarter of its square, before nothing is gathered.
const MOST_REDUCTIONS: usize = 40;

/// Candidates are gathered beyond the initial radius by this factor, squared: most cells need no more.
const GATHER_FACTOR_SQUARED: f64 = 1.15;

/// The candidates of all sites of a neighborhood.
#[derive(Clone, Debug, Default)]
pub(crate) struct NeighborhoodBuffer {
    /// The node of the tree; zero is none.
    node: u32,
    middle: Point3<f64>,
    /// By what lengths are divided: about the size of what is gathered.
    unit: f64,
    /// The gathered sites: those within the initial radius, and others.
    sets: [CandidateSoa; 2],
    /// What has not been gathered.
    beyond: Vec<Subtree>,
    /// Whether that is sorted, nearest to the node first.
    is_sorted: bool,
    /// The squared distance from the node within which all has been gathered (L²).
    reach_squared: f64,
    stack: Vec<Subtree>,
}

impl NeighborhoodBuffer {
    /// Gathers the candidates of the neighborhood of the site in `place`, for initial radii up to the
    /// root of `near_squared`, or less where these are too many.
    pub(crate) fn gather(&mut self, tree: &KdTree, place: usize, near_squared: f64) {
        let node = tree.neighborhood(place);
        if self.node == node {
            return;
        }
        self.node = node;
        self.reach_squared = GATHER_FACTOR_SQUARED * near_squared;
        let around = tree.bounds(node);
        self.middle = around.center();
        let unit = self.reach_squared.max(0.0).sqrt() + around.extent().max();
        self.unit = if unit > 0.0 { unit } else { 1.0 };
        let mut tries = 0;
        while !self.gather_within(tree, &around) {
            tries += 1;
            self.reach_squared *= 0.25;
            if tries > MOST_REDUCTIONS {
                self.reach_squared = -1.0;
            }
        }
        self.is_sorted = false;
        self.sets.iter_mut().for_each(CandidateSoa::close);
    }

    /// What has not been gathered, nearest to the node first; nothing if all of it is farther from the
    /// node than the root of `reach_squared`.
    pub(crate) fn beyond(&mut self, reach_squared: f64) -> &[Subtree] {
        if reach_squared <= self.reach_squared {
            return &[];
        }
        if !self.is_sorted {
            self.beyond.sort_unstable_by(|a, b| {
                let by_gap = a.gap_squared.total_cmp(&b.gap_squared);
                by_gap.then_with(|| (a.shift, a.node).cmp(&(b.shift, b.node)))
            });
            self.is_sorted = true;
        }
        &self.beyond
    }

    /// Gathers what is within reach of the box, and lists the other subtrees; false if that is too much.
    fn gather_within(&mut self, tree: &KdTree, around: &Bounds<3>) -> bool {
        self.beyond.clear();
        self.sets.iter_mut().for_each(CandidateSoa::clear);
        let half = around.extent() / 2.0;
        for (shift, image) in tree.images().iter().enumerate() {
            self.stack.clear();
            self.stack.push(Subtree::whole(shift));
            while let Some(mut subtree) = self.stack.pop() {
                let bounds = tree.bounds(subtree.node).translated(&image.by);
                subtree.gap_squared = gap_squared(&bounds, around);
                if subtree.gap_squared > self.reach_squared {
                    self.beyond.push(subtree);
                } else if tree.is_leaf(subtree.node) {
                    self.add(tree, &subtree, &half);
                    if self.sets.iter().map(CandidateSoa::len).sum::<usize>() > MOST_GATHERED {
                        return false;
                    }
                } else {
                    let children = [1, 0].map_each(|side| 2 * subtree.node + side);
                    let children = children.map(|node| Subtree { node, ..subtree });
                    self.stack.extend(children);
                }
            }
        }
        true
    }

    fn add(&mut self, tree: &KdTree, leaf: &Subtree, half: &Vector3<f64>) {
        let origin = self.middle - tree.images()[leaf.shift as usize].by;
        let per_unit = 1.0 / self.unit;
        let near_squared = self.near_squared() * (1.0 + ROUNDING);
        let places = tree.places(leaf.node);
        let [near, far] = &mut self.sets;
        near.reserve(places.len());
        far.reserve(places.len());
        for place in places {
            let about = tree.position(place) - origin;
            let gap = |axis: usize| {
                let gap = about[axis].abs() - half[axis];
                if gap > 0.0 { gap } else { 0.0 }
            };
            let gap_squared = gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2);
            let (name, about) = ((place as u32, leaf.shift), about * per_unit);
            near.push_if(gap_squared <= near_squared, name, &about);
            far.push_if(gap_squared > near_squared, name, &about);
        }
    }

    /// Finds the sites whose squared distance from `site`, which is in `place`, is at most `limit`,
    /// which is within the initial radius. They must have been measured.
    pub(crate) fn find(
        &mut self,
        tree: &KdTree,
        from: (usize, &Point3<f64>),
        limit: f64,
        found: &mut CandidateList,
    ) {
        found.clear();
        if limit >= 0.0 {
            self.sets[0].find((tree, self.unit), from, (-1.0, limit), found);
        }
    }

    /// Finds all gathered sites whose squared distance from `site`, which is in `place`, exceeds
    /// `above` and is at most `limit`. Those within the initial radius must have been measured.
    pub(crate) fn find_all(
        &mut self,
        tree: &KdTree,
        from: (usize, &Point3<f64>),
        range: (f64, f64),
        found: &mut CandidateList,
    ) {
        found.clear();
        let here = self.in_units(from.1);
        self.sets[1].measure(&here);
        for set in &mut self.sets {
            set.find((tree, self.unit), from, range, found);
        }
    }

    /// Measures how far the sites within the initial radius are from `site`, for the queries that follow.
    pub(crate) fn measure(&mut self, site: &Point3<f64>) {
        let here = self.in_units(site);
        self.sets[0].measure(&here);
    }

    /// The squared distance from the node within which all is in the first set (L²).
    pub(crate) fn near_squared(&self) -> f64 {
        self.reach_squared / GATHER_FACTOR_SQUARED
    }

    /// The position of `site` about the middle, in units.
    fn in_units(&self, site: &Point3<f64>) -> Vector3<f64> {
        (site - self.middle) * (1.0 / self.unit)
    }
}

/// The squared distance of two boxes (L²).
fn gap_squared(one: &Bounds<3>, other: &Bounds<3>) -> f64 {
    // Not f64::max: its treatment of NaN costs more than the rest.
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    let gap = |axis: usize| {
        let below = other.min[axis] - one.max[axis];
        greater(greater(one.min[axis] - other.max[axis], below), 0.0)
    };
    gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2)
}
