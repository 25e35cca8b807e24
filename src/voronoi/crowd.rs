//! What lies around neighboring sites, gathered once for all of them.
//!
//! The sites of a small node of the index look at much the same surroundings. So the tree is walked
//! once for such a neighborhood, and what lies within reach is copied side by side, in single
//! precision about the middle of the node. Each site then passes over the copy without a branch. What
//! that finds near, with a margin for the rounding, is measured again in full.

use nalgebra::Point3;
use wide::{f32x8, u16x8};

use crate::geometry::bounds::Bounds;
use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::index::SiteIndex;

/// Sites handled together.
const BLOCK: usize = 8;

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
    /// The numbers of those that are near, and room for a block beyond them.
    numbers: Vec<u16>,
    /// What has not been gathered.
    beyond: Vec<Subtree>,
    /// Whether that is sorted, nearest to the node first.
    is_sorted: bool,
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
        self.is_sorted = false;
        let padded = self.places.len().next_multiple_of(BLOCK);
        for coordinates in &mut self.positions {
            coordinates.resize(padded, f32::INFINITY);
        }
        self.squares.resize(padded, 0.0);
        self.numbers.resize(padded + BLOCK, 0);
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

    /// Finds the gathered sites whose squared distance from `site` exceeds `above` and is at most
    /// `limit`. The site in `place` and its images are left out. Needs a measure from the same site.
    ///
    /// Which sites are near is what a processor cannot foresee: all is written, and what is not wanted
    /// overwritten.
    pub(crate) fn find(
        &mut self,
        index: &SiteIndex,
        (place, site): (usize, &Point3<f64>),
        (above, limit): (f64, f64),
        found: &mut Found,
    ) {
        found.count = 0;
        if limit < 0.0 {
            return;
        }
        let count = self.list_near(above, limit);
        let numbers = &self.numbers[..count];
        if found.room.len() <= count {
            found.room.resize(2 * count + 1, Candidate::default());
        }
        for &number in numbers {
            // Lanes beyond the last site hold none. They are infinitely far, but so may the limit be.
            let Some(&(other, shift)) = self.places.get(usize::from(number)) else {
                continue;
            };
            let by = &index.shifts()[shift as usize].by;
            let candidate = Candidate::new(index, site, (other as usize, shift), by);
            let square = candidate.distance_squared;
            found.room[found.count] = candidate;
            let is_wanted = (other as usize != place) & (above < square) & (square <= limit);
            found.count += usize::from(is_wanted);
        }
    }

    /// Lists the numbers of the gathered sites that are, as far as single precision can tell, neither
    /// nearer nor farther than this; returns how many these are.
    fn list_near(&mut self, above: f64, limit: f64) -> usize {
        let reach = limit.sqrt() / self.unit + ROUNDING;
        let most = f32x8::splat((reach * reach * (1.0 + ROUNDING)) as f32);
        let seen = (above.max(0.0).sqrt() / self.unit - ROUNDING).max(0.0);
        let least = f32x8::splat((seen * seen * (1.0 - ROUNDING)) as f32);
        let (blocks, _) = self.squares.as_chunks::<BLOCK>();
        let mut count = 0;
        for (block, squares) in blocks.iter().enumerate() {
            let squares = f32x8::new(*squares);
            let [far, seen] = [most - squares, squares - least].map(f32x8::to_bitmask);
            let lanes = &LANES[(far | seen) as usize & 0xff];
            let Some(room) = self.numbers[count..].first_chunk_mut::<BLOCK>() else {
                break;
            };
            *room = (u16x8::splat((block * BLOCK) as u16) + u16x8::new(*lanes)).to_array();
            count += BLOCK - (far | seen).count_ones() as usize;
        }
        count
    }
}

/// What has been found around a site.
#[derive(Clone, Debug, Default)]
pub(crate) struct Found {
    /// The candidates, and room beyond them.
    room: Vec<Candidate>,
    count: usize,
}

impl Found {
    /// The candidates.
    pub(crate) fn candidates(&self) -> &[Candidate] {
        &self.room[..self.count]
    }
}

/// Per set of lanes, as bits: the lanes that are not in it, in ascending order.
static LANES: [[u16; BLOCK]; 1 << BLOCK] = lanes_table();

const fn lanes_table() -> [[u16; BLOCK]; 1 << BLOCK] {
    let mut table = [[0; BLOCK]; 1 << BLOCK];
    let mut set = 0;
    while set < table.len() {
        let (mut lane, mut count) = (0, 0);
        while lane < BLOCK {
            if set >> lane & 1 == 0 {
                table[set][count] = lane as u16;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
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
