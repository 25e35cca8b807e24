//! What lies around neighboring sites, gathered once for all of them.
//!
//! The sites of a small node of the index look at much the same surroundings. So the tree is walked
//! once for such a neighborhood: the leaves within reach are copied side by side, and each site
//! then passes over the copy in blocks, without a branch in the tree.

use nalgebra::Point3;
use wide::f64x4;

use crate::geometry::bounds::Bounds;
use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::index::SiteIndex;

/// Sites handled together.
const BLOCK: usize = 4;

/// Sites gathered at most: more would take longer to pass over than they are worth.
const MOST: usize = 4096;

/// How often the reach is drawn in, each time to a quarter of its square, before it is given up.
const DRAWN_IN: usize = 40;

/// A leaf that has been gathered: a run of sites.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    count: u32,
    place: u32,
    shift: u32,
}

/// The surroundings of a neighborhood.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crowd {
    /// The index's stamp and the node; zero is none.
    of: (u64, u32),
    /// Coordinates of the gathered sites, unshifted, with a block of slack at the end.
    positions: [Vec<f64>; 3],
    runs: Vec<Run>,
    /// The runs' boxes, shifted: the least and the greatest coordinates.
    boxes: [[Vec<f64>; 3]; 2],
    /// What has not been gathered, nearest to the node first.
    pub(crate) beyond: Vec<Subtree>,
    /// The squared distance from the node within which all has been gathered (L²).
    pub(crate) reach_squared: f64,
    stack: Vec<Subtree>,
    /// Squared distances of the boxes from the site that looks.
    gaps: Vec<f64>,
}

impl Crowd {
    /// Gathers what lies around the neighborhood of the site in `place`, as far as the root of `reach_squared`
    /// or less far where that is too much.
    pub(crate) fn gather(&mut self, index: &SiteIndex, place: usize, reach_squared: f64) {
        let of = (index.stamp(), index.neighborhood(place));
        if self.of == of {
            return;
        }
        self.of = of;
        self.reach_squared = reach_squared;
        let around = index.bounds(of.1);
        let mut tries = 0;
        while !self.gather_within(index, &around) {
            tries += 1;
            self.reach_squared *= 0.25;
            if tries > DRAWN_IN {
                self.reach_squared = -1.0;
            }
        }
        self.beyond.sort_unstable_by(|a, b| {
            let by_gap = a.gap_squared.total_cmp(&b.gap_squared);
            by_gap.then_with(|| (a.shift, a.node).cmp(&(b.shift, b.node)))
        });
        for coordinates in &mut self.positions {
            let padded = coordinates.len() + BLOCK;
            coordinates.resize(padded, 0.0);
        }
        let padded = self.runs.len().next_multiple_of(BLOCK);
        for coordinates in self.boxes.iter_mut().flatten() {
            coordinates.resize(padded, f64::INFINITY);
        }
        self.gaps.resize(padded, 0.0);
    }

    fn gather_within(&mut self, index: &SiteIndex, around: &Bounds<3>) -> bool {
        self.runs.clear();
        self.beyond.clear();
        self.gaps.clear();
        let positions = self.positions.iter_mut();
        positions
            .chain(self.boxes.iter_mut().flatten())
            .for_each(Vec::clear);
        for shift in 0..index.shifts().len() as u32 {
            self.stack.clear();
            self.stack.push(Subtree {
                gap_squared: 0.0,
                node: 1,
                shift,
            });
            while let Some(subtree) = self.stack.pop() {
                let by = index.shifts()[shift as usize].by;
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
                    self.add(index, &subtree, &bounds);
                    if self.positions[0].len() > MOST {
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

    fn add(&mut self, index: &SiteIndex, leaf: &Subtree, bounds: &Bounds<3>) {
        let places = index.places(leaf.node);
        self.runs.push(Run {
            first: self.positions[0].len() as u32,
            count: places.len() as u32,
            place: places.start as u32,
            shift: leaf.shift,
        });
        for axis in 0..3 {
            let coordinates = places.clone().map(|place| index.position(place)[axis]);
            self.positions[axis].extend(coordinates);
            self.boxes[0][axis].push(bounds.min[axis]);
            self.boxes[1][axis].push(bounds.max[axis]);
        }
    }

    /// Measures how far the runs are from `site`, for the visits to come.
    pub(crate) fn measure(&mut self, site: &Point3<f64>) {
        let [min, max] = &self.boxes;
        for (block, gaps) in self.gaps.chunks_exact_mut(BLOCK).enumerate() {
            let mut sum = f64x4::ZERO;
            for axis in 0..3 {
                let here = f64x4::splat(site[axis]);
                let [low, high] = [min, max].map(|ends| load(&ends[axis], block * BLOCK));
                let outside = (low - here).fast_max(here - high);
                let gap = outside.fast_max(f64x4::ZERO);
                sum += gap * gap;
            }
            gaps.copy_from_slice(&sum.to_array());
        }
    }

    /// Visits the gathered sites whose squared distance from `site` exceeds `above` and is at most
    /// `limit`. The site in `place` and its images are left out. Needs a measure from the same site.
    #[inline]
    pub(crate) fn visit(
        &self,
        index: &SiteIndex,
        (place, site): (usize, &Point3<f64>),
        (above, limit): (f64, f64),
        mut visit: impl FnMut(Candidate),
    ) {
        let [xs, ys, zs] = &self.positions;
        let [x, y, z] = [site.x, site.y, site.z].map(f64x4::splat);
        let [least, most] = [above, limit].map(f64x4::splat);
        let runs = self.runs.iter().zip(&self.gaps);
        for (run, _) in runs.filter(|(_, gap)| **gap <= limit) {
            let by = index.shifts()[run.shift as usize].by;
            let shift = [by.x, by.y, by.z].map(f64x4::splat);
            for start in (0..run.count).step_by(BLOCK) {
                let at = (run.first + start) as usize;
                let [x, y, z] = [
                    load(xs, at) - x + shift[0],
                    load(ys, at) - y + shift[1],
                    load(zs, at) - z + shift[2],
                ];
                let squares = x * x + y * y + z * z;
                let rest = (run.count - start).min(BLOCK as u32);
                let within = !(most - squares).to_bitmask() & (least - squares).to_bitmask();
                let mut found = within & (u32::MAX >> (u32::BITS - rest));
                while found != 0 {
                    let lane = found.trailing_zeros();
                    found &= found - 1;
                    let candidate = (run.place + start + lane) as usize;
                    if candidate != place {
                        visit(Candidate::new(index, site, (candidate, run.shift), &by));
                    }
                }
            }
        }
    }
}

/// The four numbers from `start` on.
#[inline]
fn load(numbers: &[f64], start: usize) -> f64x4 {
    let mut block = [0.0; BLOCK];
    block.copy_from_slice(&numbers[start..start + BLOCK]);
    f64x4::new(block)
}

/// The squared distance of two boxes (L²).
fn gap_squared(one: &Bounds<3>, other: &Bounds<3>) -> f64 {
    let gap = |axis: usize| {
        let outside = (one.min[axis] - other.max[axis]).max(other.min[axis] - one.max[axis]);
        outside.max(0.0)
    };
    gap(0) * gap(0) + gap(1) * gap(1) + gap(2) * gap(2)
}
