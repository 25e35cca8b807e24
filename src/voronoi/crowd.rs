//! What lies around neighboring sites, gathered once for all of them.
//!
//! The sites of a small node of the index look at much the same surroundings. So the tree is walked
//! once for such a neighborhood, and what lies within reach is copied side by side, in single
//! precision about the middle of the node. Each site then passes over the copy without a branch. What
//! that finds near, with a margin for the rounding, is measured again in full.

use nalgebra::Point3;
use wide::f32x8;

use crate::geometry::bounds::Bounds;
use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::index::SiteIndex;

/// Sites handled together.
const BLOCK: usize = 8;

/// Blocks whose sites are picked out together: as many as a set of bits holds. Fewer would have the
/// processor guess too often when a set is empty.
const BLOCKS: usize = u64::BITS as usize / BLOCK;

/// Sites gathered at most: more would take longer to pass over than they are worth.
const MOST: usize = 4096;

/// How often a reach is drawn in, each time to a quarter of its square, before it is given up.
pub(crate) const DRAWN_IN: usize = 40;

/// What single precision may do to a distance, in units: coordinates of at most a few units are good
/// to 2⁻²², with room to spare.
const ROUNDING: f64 = 1e-5;

/// The surroundings of a neighborhood.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crowd {
    /// The index's stamp and the node; zero is none.
    of: (u64, u32),
    middle: Point3<f64>,
    /// By what lengths are divided: about the size of what is gathered.
    unit: f64,
    /// Coordinates of the gathered sites about the middle, in units and whole blocks.
    positions: [Vec<f32>; 3],
    /// Their places and the numbers of their shifts.
    places: Vec<(u32, u32)>,
    /// Their squared distances from the site that looks, in units.
    squares: Vec<f32>,
    /// What has not been gathered, nearest to the node first.
    pub(crate) beyond: Vec<Subtree>,
    /// The squared distance from the node within which all has been gathered (L²).
    pub(crate) reach_squared: f64,
    stack: Vec<Subtree>,
}

impl Crowd {
    /// Gathers what lies around the neighborhood of the site in `place`, as far as the root of
    /// `reach_squared` or less far where that is too much.
    pub(crate) fn gather(&mut self, index: &SiteIndex, place: usize, reach_squared: f64) {
        let of = (index.stamp(), index.neighborhood(place));
        if self.of == of {
            return;
        }
        self.of = of;
        self.reach_squared = reach_squared;
        let around = index.bounds(of.1);
        self.middle = around.center();
        let unit = reach_squared.max(0.0).sqrt() + around.extent().max();
        self.unit = if unit > 0.0 { unit } else { 1.0 };
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
        let padded = self.places.len().next_multiple_of(BLOCK);
        for coordinates in &mut self.positions {
            coordinates.resize(padded, f32::INFINITY);
        }
        self.squares.resize(padded, 0.0);
    }

    fn gather_within(&mut self, index: &SiteIndex, around: &Bounds<3>) -> bool {
        self.places.clear();
        self.beyond.clear();
        self.positions.iter_mut().for_each(Vec::clear);
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
                    self.add(index, &subtree);
                    if self.places.len() > MOST {
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

    fn add(&mut self, index: &SiteIndex, leaf: &Subtree) {
        let origin = self.middle - index.shifts()[leaf.shift as usize].by;
        let per_unit = 1.0 / self.unit;
        let [xs, ys, zs] = &mut self.positions;
        for place in index.places(leaf.node) {
            let about = (index.position(place) - origin) * per_unit;
            xs.push(about.x as f32);
            ys.push(about.y as f32);
            zs.push(about.z as f32);
            self.places.push((place as u32, leaf.shift));
        }
    }

    /// Measures how far all sites are from `site`, for the visits to come.
    pub(crate) fn measure(&mut self, site: &Point3<f64>) {
        let here = (site - self.middle) * (1.0 / self.unit);
        let [x, y, z] = [here.x, here.y, here.z].map(|along| f32x8::splat(along as f32));
        let [xs, ys, zs] = self.positions.each_ref().map(|all| all.as_chunks().0);
        let there = xs.iter().zip(ys).zip(zs);
        for (squares, ((xs, ys), zs)) in self.squares.as_chunks_mut().0.iter_mut().zip(there) {
            let [x, y, z] = [
                f32x8::new(*xs) - x,
                f32x8::new(*ys) - y,
                f32x8::new(*zs) - z,
            ];
            *squares = (x * x + y * y + z * z).to_array();
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
        if limit < 0.0 {
            return;
        }
        let reach = limit.sqrt() / self.unit + ROUNDING;
        let most = f32x8::splat((reach * reach * (1.0 + ROUNDING)) as f32);
        let seen = (above.max(0.0).sqrt() / self.unit - ROUNDING).max(0.0);
        let least = f32x8::splat((seen * seen * (1.0 - ROUNDING)) as f32);
        let (blocks, _) = self.squares.as_chunks::<BLOCK>();
        for (word, blocks) in blocks.chunks(BLOCKS).enumerate() {
            let mut found = 0;
            for (block, squares) in blocks.iter().enumerate() {
                let squares = f32x8::new(*squares);
                let (far, seen) = (
                    (most - squares).to_bitmask(),
                    (squares - least).to_bitmask(),
                );
                found |= u64::from(!(far | seen) & 0xff) << (block * BLOCK);
            }
            while found != 0 {
                let number = word * 64 + found.trailing_zeros() as usize;
                found &= found - 1;
                let Some(&(other, shift)) = self.places.get(number) else {
                    continue;
                };
                if other as usize == place {
                    continue;
                }
                let by = &index.shifts()[shift as usize].by;
                let candidate = Candidate::new(index, site, (other as usize, shift), by);
                if above < candidate.distance_squared && candidate.distance_squared <= limit {
                    visit(candidate);
                }
            }
        }
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
