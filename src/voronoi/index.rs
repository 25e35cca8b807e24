//! The spatial index: a balanced k-d tree over the sites.
//!
//! Every node's sites are halved across the longest side of the least box around them, so that
//! leaves hold a few sites each wherever the sites crowd and whatever the domain's shape. All leaves
//! are equally deep: node n has the children 2n and 2n + 1, the root is node 1, and which places a
//! node covers follows from its number alone. Sites are stored in leaf order, in which work on one
//! after the other stays in one corner of the memory.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::Point3;
use rayon::prelude::*;
use wide::f64x2;

use crate::geometry::bounds::Bounds;
use crate::voronoi::leaf_order::{Entry, sort, start};
use crate::voronoi::shifts::{Shift, shifts};
use crate::voronoi::siblings::Pair;

/// Sites a leaf at most. Fewer cost more steps through the tree, more are looked at in vain.
const LEAF: usize = 12;

/// How many levels above the leaves surroundings are gathered.
const NEIGHBORHOOD: u32 = 2;

/// The first look around a site goes to where about so many sites should be.
const FIRST_LOOK: f64 = 36.0;

/// A box of this many sites or more tells how densely they lie.
const CROWD: usize = 32;

/// The next index's stamp, by which memories tell whether they know an index.
static STAMPS: AtomicU64 = AtomicU64::new(1);

/// A k-d tree over sites.
#[derive(Clone, Debug)]
pub struct SiteIndex {
    depth: u32,
    /// Per inner node: the boxes around the sites of its children. The first is unused.
    pairs: Vec<Pair>,
    bounds: Bounds<3>,
    sites: Vec<u32>,
    positions: Vec<Point3<f64>>,
    shifts: Vec<Shift>,
    stamp: u64,
    /// Squared first look per squared diagonal of a crowd's box.
    look: f64,
}

impl SiteIndex {
    /// Sorts `sites`, which lie within one period along axes that have one.
    #[must_use]
    pub fn new(
        sites: impl IndexedParallelIterator<Item = Point3<f64>>,
        periods: [Option<f64>; 3],
    ) -> Self {
        let entry = |(site, position): (usize, Point3<f64>)| Entry {
            position,
            site: site as u32,
        };
        let mut entries: Vec<Entry> = sites.enumerate().map(entry).collect();
        let mut depth = 0;
        while entries.len().div_ceil(1 << depth) > LEAF {
            depth += 1;
        }
        let total = entries.len();
        sort(&mut entries, total, (0, 0), depth);
        let mut index = Self {
            depth,
            pairs: vec![Pair::default(); 1 << depth],
            bounds: Bounds::empty(),
            sites: entries.par_iter().map(|entry| entry.site).collect(),
            positions: entries.par_iter().map(|entry| entry.position).collect(),
            shifts: shifts(periods),
            stamp: STAMPS.fetch_add(1, Ordering::Relaxed),
            look: 0.0,
        };
        drop(entries);
        index.enclose();
        let crowd = index.len() as f64 / f64::from(1 << index.crowd_level());
        index.look = (FIRST_LOOK / crowd).powf(2.0 / 3.0) * 0.125;
        index
    }

    /// How many sites there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.sites.len()
    }

    /// Whether there are no sites.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }

    /// Per site: its place.
    #[must_use]
    pub(crate) fn places_of_sites(&self) -> Vec<u32> {
        let mut places = vec![0; self.len()];
        for (place, &site) in self.sites.iter().enumerate() {
            places[site as usize] = place as u32;
        }
        places
    }

    /// The index in the caller's order of the site in `place`.
    #[must_use]
    pub fn site(&self, place: usize) -> u32 {
        self.sites[place]
    }

    /// The indices of all sites, by place.
    #[must_use]
    pub fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// The position of the site in `place`.
    #[must_use]
    pub fn position(&self, place: usize) -> Point3<f64> {
        self.positions[place]
    }

    /// A number that no other index has, and is not zero.
    #[must_use]
    pub fn stamp(&self) -> u64 {
        self.stamp
    }

    /// The leaf that covers a place.
    #[must_use]
    pub fn leaf(&self, place: usize) -> u32 {
        // The last leaf that begins at or before the place.
        let number = (((place as u64 + 1) << self.depth) - 1) / self.len() as u64;
        (1 << self.depth) + number as u32
    }

    /// The node whose sites, the one in `place` among them, look at the same surroundings.
    #[must_use]
    pub fn neighborhood(&self, place: usize) -> u32 {
        self.leaf(place) >> self.depth.min(NEIGHBORHOOD)
    }

    /// The images in which sites are looked for; the first is the site itself.
    #[must_use]
    pub fn shifts(&self) -> &[Shift] {
        &self.shifts
    }

    /// Whether a node has no children.
    #[must_use]
    pub fn is_leaf(&self, node: u32) -> bool {
        node >> self.depth != 0
    }

    /// The places that a leaf covers.
    #[must_use]
    pub fn places(&self, leaf: u32) -> Range<usize> {
        let number = u64::from(leaf) - (1 << self.depth);
        let [first, end] = [number, number + 1].map(|leaf| start(self.len(), leaf, self.depth));
        first..end
    }

    /// The squared distances from `here` to the boxes of an inner node's children (L²).
    #[must_use]
    #[inline]
    pub fn gaps_squared(&self, node: u32, here: &Point3<f64>) -> [f64; 2] {
        let pair = &self.pairs[node as usize];
        let mut sum = f64x2::ZERO;
        for axis in 0..3 {
            let here = f64x2::splat(here[axis]);
            let outside = (pair.min[axis] - here).fast_max(here - pair.max[axis]);
            let gap = outside.fast_max(f64x2::ZERO);
            sum += gap * gap;
        }
        sum.to_array()
    }

    /// The box around a node's sites.
    #[must_use]
    pub fn bounds(&self, node: u32) -> Bounds<3> {
        if node == 1 {
            return self.bounds;
        }
        let (pair, lane) = (&self.pairs[node as usize / 2], node as usize % 2);
        let corner = |ends: &[f64x2; 3]| Point3::from(ends.map(|end| end.to_array()[lane]));
        Bounds {
            min: corner(&pair.min),
            max: corner(&pair.max),
        }
    }

    /// The squared distance within which the site in `place` looks around first (L²).
    #[must_use]
    pub fn first_look_squared(&self, place: usize) -> f64 {
        let node = self.leaf(place) >> (self.depth - self.crowd_level());
        self.look * self.bounds(node).extent().norm_squared()
    }

    /// The deepest level whose nodes hold a crowd.
    fn crowd_level(&self) -> u32 {
        let crowds = (self.len() / CROWD).max(1);
        crowds.ilog2().min(self.depth)
    }

    /// Computes all boxes, from the leaves up.
    fn enclose(&mut self) {
        if self.depth == 0 {
            self.bounds = Bounds::of(&self.positions);
            return;
        }
        let leaves = 1u32 << (self.depth - 1);
        let mut lowest = std::mem::take(&mut self.pairs);
        let around = |leaf: u32| Bounds::of(&self.positions[self.places(leaf)]);
        let fill = |(node, pair): (usize, &mut Pair)| {
            let node = leaves + node as u32;
            *pair = Pair::new([around(2 * node), around(2 * node + 1)]);
        };
        let lowest_level = &mut lowest[leaves as usize..];
        lowest_level.par_iter_mut().enumerate().for_each(fill);
        for node in (1..leaves as usize).rev() {
            lowest[node] = Pair::new([lowest[2 * node].both(), lowest[2 * node + 1].both()]);
        }
        self.bounds = lowest[1].both();
        self.pairs = lowest;
    }
}
