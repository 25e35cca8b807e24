//! What lies around neighboring sites, gathered once for all of them.
//!
//! The sites of a small node of the index look at much the same surroundings. So the tree is walked
//! once for such a neighborhood, and what lies within reach is copied side by side, in single
//! precision about the middle of the node. Each site then passes over the copy without a branch. What
//! that finds near, with a margin for the rounding, is measured again in full.
//!
//! What is within a first look comes first. What lies beyond that, up to the reach and in leaves that
//! are partly within it, is kept apart, for sites that have to look farther.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::voronoi::candidate::Subtree;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::layer::{Found, Layer, ROUNDING};

/// Sites gathered at most: more would take longer to pass over than they are worth.
const MOST: usize = 4096;

/// How often a reach is drawn in, each time to a quarter of its square, before it is given up.
pub(crate) const DRAWN_IN: usize = 40;

/// How much farther than a first look surroundings are gathered, squared: most cells find
/// all that they need there.
const GATHERED: f64 = 1.15;

/// The surroundings of a neighborhood.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crowd {
    /// The index's stamp and the node; zero is none.
    of: (u64, u32),
    middle: Point3<f64>,
    /// By what lengths are divided: about the size of what is gathered.
    unit: f64,
    /// The gathered sites: those within a first look, and others.
    layers: [Layer; 2],
    /// What has not been gathered.
    beyond: Vec<Subtree>,
    /// Whether that is sorted, nearest to the node first.
    is_sorted: bool,
    /// The squared distance from the node within which all has been gathered (L²).
    reach_squared: f64,
    stack: Vec<Subtree>,
}

impl Crowd {
    /// Gathers what lies around the neighborhood of the site in `place`, for first looks as far as the
    /// root of `near_squared` or less far where that is too much.
    pub(crate) fn gather(&mut self, index: &SiteIndex, place: usize, near_squared: f64) {
        let of = (index.stamp(), index.neighborhood(place));
        if self.of == of {
            return;
        }
        self.of = of;
        self.reach_squared = GATHERED * near_squared;
        let around = index.bounds(of.1);
        self.middle = around.center();
        let unit = self.reach_squared.max(0.0).sqrt() + around.extent().max();
        self.unit = if unit > 0.0 { unit } else { 1.0 };
        let mut tries = 0;
        while !self.gather_within(index, &around) {
            tries += 1;
            self.reach_squared *= 0.25;
            if tries > DRAWN_IN {
                self.reach_squared = -1.0;
            }
        }
        self.is_sorted = false;
        self.layers.iter_mut().for_each(Layer::close);
    }

    /// What has not been gathered, nearest to the node first; nothing if all of it is farther from the
    /// node than the root of `needed`.
    pub(crate) fn beyond(&mut self, needed: f64) -> &[Subtree] {
        if needed <= self.reach_squared {
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

    fn gather_within(&mut self, index: &SiteIndex, around: &Bounds<3>) -> bool {
        self.beyond.clear();
        self.layers.iter_mut().for_each(Layer::clear);
        let half = around.extent() / 2.0;
        for (shift, image) in index.shifts().iter().enumerate() {
            self.stack.clear();
            self.stack.push(Subtree::whole(shift));
            while let Some(subtree) = self.stack.pop() {
                let by = image.by;
                let bounds = index.bounds(subtree.node);
                let bounds = Bounds {
                    min: bounds.min + by,
                    max: bounds.max + by,
                };
                let gap_squared = gap_squared(&bounds, around);
                if gap_squared > self.reach_squared {
                    self.beyond.push(Subtree {
                        gap_squared,
                        ..subtree
                    });
                } else if index.is_leaf(subtree.node) {
                    self.add(index, &subtree, &half);
                    if self.layers.iter().map(Layer::len).sum::<usize>() > MOST {
                        return false;
                    }
                } else {
                    for side in [1, 0] {
                        let node = 2 * subtree.node + side;
                        self.stack.push(Subtree { node, ..subtree });
                    }
                }
            }
        }
        true
    }

    fn add(&mut self, index: &SiteIndex, leaf: &Subtree, half: &Vector3<f64>) {
        let origin = self.middle - index.shifts()[leaf.shift as usize].by;
        let per_unit = 1.0 / self.unit;
        let near_squared = self.near_squared() * (1.0 + ROUNDING);
        let places = index.places(leaf.node);
        let [near, far] = &mut self.layers;
        near.reserve(places.len());
        far.reserve(places.len());
        for place in places {
            let about = index.position(place) - origin;
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
    /// which is within a first look. They must have been measured.
    pub(crate) fn find(
        &mut self,
        index: &SiteIndex,
        from: (usize, &Point3<f64>),
        limit: f64,
        found: &mut Found,
    ) {
        found.clear();
        if limit >= 0.0 {
            self.layers[0].find((index, self.unit), from, (-1.0, limit), found);
        }
    }

    /// Finds all gathered sites whose squared distance from `site`, which is in `place`, exceeds
    /// `above` and is at most `limit`. Those within a first look must have been measured.
    pub(crate) fn find_all(
        &mut self,
        index: &SiteIndex,
        from: (usize, &Point3<f64>),
        range: (f64, f64),
        found: &mut Found,
    ) {
        found.clear();
        let here = self.seen(from.1);
        self.layers[1].measure(&here);
        for layer in &mut self.layers {
            layer.find((index, self.unit), from, range, found);
        }
    }

    /// Measures how far the sites within a first look are from `site`, for the visits to come.
    pub(crate) fn measure(&mut self, site: &Point3<f64>) {
        let here = self.seen(site);
        self.layers[0].measure(&here);
    }

    /// The squared distance from the node within which all is in the first layer (L²).
    pub(crate) fn near_squared(&self) -> f64 {
        self.reach_squared / GATHERED
    }

    /// Where `site` is about the middle, in units.
    fn seen(&self, site: &Point3<f64>) -> Vector3<f64> {
        (site - self.middle) * (1.0 / self.unit)
    }
}

/// The squared distance of two boxes (L²).
fn gap_squared(one: &Bounds<3>, other: &Bounds<3>) -> f64 {
    // Not f64::max, whose care for NaN costs more than the rest.
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    let gap = |axis: usize| {
        let below = other.min[axis] - one.max[axis];
        greater(greater(one.min[axis] - other.max[axis], below), 0.0)
    };
    gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2)
}
