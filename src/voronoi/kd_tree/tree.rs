//! A balanced k-d tree over the sites, the spatial index of the diagram.
//!
//! Every node's sites are halved across the longest side of the least box around them, so that
//! leaves hold a few sites each however dense the sites are and whatever the domain's shape. All leaves
//! are equally deep: node n has the children 2n and 2n + 1, the root is node 1, and which places a
//! node covers follows from its number alone. Sites are stored in leaf order, so that work on one
//! after the other is local in memory; a site's *place* is its position in that order.

use std::ops::Range;
use std::sync::atomic::{self, AtomicU32};

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;
use wide::f64x2;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::parallel::{RUN, discard, map, map_runs};
use crate::voronoi::kd_tree::sort::{SortEntry, sort, start};

/// The most sites of a leaf. Fewer cost more steps through the tree, more are tested without effect.
const LEAF: usize = 12;

/// How many levels above the leaves neighborhoods are gathered.
const NEIGHBORHOOD: u32 = 2;

/// The initial radius about a site holds about so many sites.
const INITIAL_CANDIDATES: f64 = 36.0;

/// The density of sites is estimated from boxes of at least so many.
const DENSITY_SAMPLE: usize = 32;

/// A k-d tree over sites.
#[derive(Clone, Debug)]
pub(crate) struct KdTree {
    depth: u32,
    /// Per inner node: the boxes around the sites of its children. The first is unused.
    pairs: Vec<ChildBoxes>,
    bounds: Bounds<3>,
    sites: Vec<u32>,
    positions: Vec<Point3<f64>>,
    images: Vec<PeriodicImage>,
    /// Squared initial radius per squared diagonal of the box that estimates the density.
    radius_ratio_squared: f64,
}

impl KdTree {
    /// Sorts `sites`, which lie within one period along axes that have one; `None` once `is_stopped` holds.
    pub(crate) fn new(
        sites: impl IndexedParallelIterator<Item = Point3<f64>>,
        periods: [Option<f64>; 3],
        is_stopped: &(impl Fn() -> bool + Sync),
    ) -> Option<Self> {
        let entry = |(site, position): (usize, Point3<f64>)| SortEntry {
            position,
            site: site as u32,
        };
        let mut entries: Vec<SortEntry> = sites.enumerate().map(entry).collect();
        let mut depth = 0;
        while entries.len().div_ceil(1 << depth) > LEAF {
            depth += 1;
        }
        let total = entries.len();
        sort(&mut entries, total, (0, 0), (depth, is_stopped));
        if is_stopped() {
            return None;
        }
        let mut tree = Self {
            depth,
            pairs: map(1 << depth, &|_| ChildBoxes::default()),
            bounds: Bounds::empty(),
            sites: map(entries.len(), &|place| entries[place].site),
            positions: map(entries.len(), &|place| entries[place].position),
            images: images(periods),
            radius_ratio_squared: 0.0,
        };
        discard(entries);
        tree.enclose();
        let sampled = tree.len() as f64 / f64::from(1 << tree.density_level());
        tree.radius_ratio_squared = (INITIAL_CANDIDATES / sampled).powf(2.0 / 3.0) * 0.125;
        Some(tree)
    }

    /// How many sites there are.
    pub(crate) fn len(&self) -> usize {
        self.sites.len()
    }

    /// Per site: its place.
    pub(crate) fn places_of_sites(&self) -> Vec<u32> {
        let places: Vec<AtomicU32> = map(self.len(), &|_| AtomicU32::new(0));
        map_runs(self.len(), RUN, |run| {
            for place in run {
                places[self.sites[place] as usize].store(place as u32, atomic::Ordering::Relaxed);
            }
        });
        places.into_iter().map(AtomicU32::into_inner).collect()
    }

    /// The index in the caller's order of the site in `place`.
    pub(crate) fn site(&self, place: usize) -> u32 {
        self.sites[place]
    }

    /// The indices of all sites, by place.
    pub(crate) fn sites(&self) -> &[u32] {
        &self.sites
    }

    /// The position of the site in `place`.
    pub(crate) fn position(&self, place: usize) -> Point3<f64> {
        self.positions[place]
    }

    /// The leaf that covers a place.
    pub(crate) fn leaf(&self, place: usize) -> u32 {
        // The last leaf that begins at or before the place.
        let number = (((place as u64 + 1) << self.depth) - 1) / self.len() as u64;
        (1 << self.depth) + number as u32
    }

    /// The node whose sites, the one in `place` among them, share one neighborhood.
    pub(crate) fn neighborhood(&self, place: usize) -> u32 {
        self.leaf(place) >> self.depth.min(NEIGHBORHOOD)
    }

    /// The periodic images of all sites; the first is the identity.
    pub(crate) fn images(&self) -> &[PeriodicImage] {
        &self.images
    }

    /// Whether a node has no children.
    pub(crate) fn is_leaf(&self, node: u32) -> bool {
        node >> self.depth != 0
    }

    /// The places that a leaf covers.
    pub(crate) fn places(&self, leaf: u32) -> Range<usize> {
        let number = u64::from(leaf) - (1 << self.depth);
        let [first, end] =
            [number, number + 1].map_each(|leaf| start(self.len(), leaf, self.depth));
        first..end
    }

    /// The squared distances from `here` to the boxes of an inner node's children (L²).
    #[inline]
    pub(crate) fn gaps_squared(&self, node: u32, here: &Point3<f64>) -> [f64; 2] {
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
    pub(crate) fn bounds(&self, node: u32) -> Bounds<3> {
        if node == 1 {
            return self.bounds;
        }
        let (pair, lane) = (&self.pairs[node as usize / 2], node as usize % 2);
        let corner = |ends: &[f64x2; 3]| Point3::from(ends.map_each(|end| end.to_array()[lane]));
        Bounds {
            min: corner(&pair.min),
            max: corner(&pair.max),
        }
    }

    /// The site nearest to a point, or an image of it; of several the one with the least index.
    pub(crate) fn nearest(&self, point: &Point3<f64>) -> u32 {
        let (mut least, mut site) = (f64::INFINITY, u32::MAX);
        for image in &self.images {
            let here = point - image.by;
            let mut stack = vec![(0.0, 1_u32)];
            while let Some((gap, node)) = stack.pop() {
                if gap > least {
                    continue;
                }
                if !self.is_leaf(node) {
                    stack.extend(self.children(node, &here));
                    continue;
                }
                for place in self.places(node) {
                    let distance = (self.position(place) - here).norm_squared();
                    if (distance, self.site(place)) < (least, site) {
                        (least, site) = (distance, self.site(place));
                    }
                }
            }
        }
        site
    }

    /// The squared distances of a node's children from `here`, and their numbers, the nearer one last.
    fn children(&self, node: u32, here: &Point3<f64>) -> [(f64, u32); 2] {
        let [one, other] = self.gaps_squared(node, here);
        let [one, other] = [(one, 2 * node), (other, 2 * node + 1)];
        if one.0 < other.0 {
            [other, one]
        } else {
            [one, other]
        }
    }

    /// The squared distance within which candidates of the site in `place` are gathered first (L²).
    pub(crate) fn initial_radius_squared(&self, place: usize) -> f64 {
        let node = self.leaf(place) >> (self.depth - self.density_level());
        self.radius_ratio_squared * self.bounds(node).extent().norm_squared()
    }

    /// The deepest level whose nodes hold at least [`DENSITY_SAMPLE`] sites.
    fn density_level(&self) -> u32 {
        let samples = (self.len() / DENSITY_SAMPLE).max(1);
        samples.ilog2().min(self.depth)
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
        let fill = |(node, pair): (usize, &mut ChildBoxes)| {
            let node = leaves + node as u32;
            *pair = ChildBoxes::new([around(2 * node), around(2 * node + 1)]);
        };
        let lowest_level = &mut lowest[leaves as usize..];
        lowest_level.par_iter_mut().enumerate().for_each(fill);
        for node in (1..leaves as usize).rev() {
            lowest[node] = ChildBoxes::new([lowest[2 * node].both(), lowest[2 * node + 1].both()]);
        }
        self.bounds = lowest[1].both();
        self.pairs = lowest;
    }
}

impl Drop for KdTree {
    fn drop(&mut self) {
        discard(std::mem::take(&mut self.pairs));
        discard(std::mem::take(&mut self.sites));
        discard(std::mem::take(&mut self.positions));
    }
}

/// The boxes of two siblings, by component.
#[derive(Clone, Copy, Debug, Default)]
struct ChildBoxes {
    min: [f64x2; 3],
    max: [f64x2; 3],
}

impl ChildBoxes {
    /// The boxes of a node's children.
    fn new([one, other]: [Bounds<3>; 2]) -> Self {
        let lanes = |axis: usize, end: fn(&Bounds<3>) -> &Point3<f64>| {
            f64x2::new([end(&one)[axis], end(&other)[axis]])
        };
        Self {
            min: [0, 1, 2].map_each(|axis| lanes(axis, |bounds| &bounds.min)),
            max: [0, 1, 2].map_each(|axis| lanes(axis, |bounds| &bounds.max)),
        }
    }

    /// The box around both.
    fn both(&self) -> Bounds<3> {
        let ends = |end: f64x2| end.to_array();
        Bounds {
            min: Point3::from(self.min.map_each(|end| ends(end)[0].min(ends(end)[1]))),
            max: Point3::from(self.max.map_each(|end| ends(end)[0].max(ends(end)[1]))),
        }
    }
}

/// A periodic image: by how many periods, and how far (L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PeriodicImage {
    /// How many periods along each axis.
    pub(crate) image: [i8; 3],
    /// The displacement.
    pub(crate) by: Vector3<f64>,
}

/// The image itself first, then its periodic copies.
fn images(periods: [Option<f64>; 3]) -> Vec<PeriodicImage> {
    let copies = periods.map(|period| period.map_or(&[0][..], |_| &[0, 1, -1]));
    let mut images = Vec::new();
    for &z in copies[2] {
        for &y in copies[1] {
            for &x in copies[0] {
                let image = [x, y, z];
                let by = |axis: usize| f64::from(image[axis]) * periods[axis].unwrap_or(0.0);
                images.push(PeriodicImage {
                    image,
                    by: Vector3::new(by(0), by(1), by(2)),
                });
            }
        }
    }
    images
}
