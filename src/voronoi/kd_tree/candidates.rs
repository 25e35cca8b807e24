//! Candidate neighbors of a site, and the buffers that hold and filter them.
//!
//! Gathered sites are kept by component in single precision, eight to a register, so that a site
//! selects the near ones without a branch; those are measured again in double precision.

use std::cmp::Ordering;

use nalgebra::{Point3, Vector3};
use wide::{f32x8, u16x8};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::label::Label;
use crate::voronoi::kd_tree::tree::KdTree;

/// A site, or a periodic image of one, near another.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Candidate {
    /// The displacement to it (L).
    pub(crate) displacement: Vector3<f64>,
    /// The squared distance (L²).
    pub(crate) distance_squared: f64,
    /// Its place in the tree.
    pub(crate) place: u32,
    /// The number of its image among the tree's images.
    pub(crate) shift: u32,
}

/// A subtree of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subtree {
    /// The squared distance of its box from the site or neighborhood that searches (L²).
    pub(crate) gap_squared: f64,
    /// Its node.
    pub(crate) node: u32,
    /// The number of its image among the tree's images.
    pub(crate) shift: u32,
}

impl Subtree {
    /// All sites, in the image of a number.
    #[inline]
    pub(crate) fn whole(shift: usize) -> Self {
        Self {
            gap_squared: 0.0,
            node: 1,
            shift: shift as u32,
        }
    }

    /// The children, the nearer one first.
    #[inline]
    pub(crate) fn children(&self, tree: &KdTree, here: &Point3<f64>) -> [Self; 2] {
        let gaps = tree.gaps_squared(self.node, here);
        let child = |side: u32| Self {
            gap_squared: gaps[side as usize],
            node: 2 * self.node + side,
            shift: self.shift,
        };
        let far = u32::from(gaps[0] <= gaps[1]);
        [child(1 - far), child(far)]
    }
}

impl Candidate {
    /// The image of the site in `place`, displaced by `by`, relative to `here`.
    #[inline]
    #[must_use]
    pub(crate) fn new(
        tree: &KdTree,
        here: &Point3<f64>,
        (place, shift): (usize, u32),
        by: &Vector3<f64>,
    ) -> Self {
        let displacement = tree.position(place) - here + by;
        Self {
            displacement,
            distance_squared: displacement.norm_squared(),
            place: place as u32,
            shift,
        }
    }

    /// The nearer one first; at one distance by index and image, whatever their places.
    #[inline]
    pub(crate) fn compare(&self, other: &Self, tree: &KdTree) -> Ordering {
        let by_distance = self.distance_squared.total_cmp(&other.distance_squared);
        by_distance.then_with(|| {
            let name = |candidate: &Self| (tree.site(candidate.place as usize), candidate.shift);
            name(self).cmp(&name(other))
        })
    }

    /// The label of a facet towards it.
    pub(crate) fn label(&self, tree: &KdTree) -> Label {
        let beyond = FacetKind::Neighbor {
            site: tree.site(self.place as usize),
            image: tree.images()[self.shift as usize].image,
        };
        beyond.label()
    }
}

/// Lanes of a register: sites handled together.
const BLOCK: usize = 8;

/// A bound of the error of a distance in single precision, in units: coordinates of at most a few
/// units are good to 2⁻²².
pub(crate) const ROUNDING: f64 = 1e-5;

/// Gathered sites by component, and their distances from one site.
#[derive(Clone, Debug, Default)]
pub(crate) struct CandidateSoa {
    /// Coordinates in units, in whole blocks once closed, and capacity beyond them.
    positions: [Vec<f32>; 3],
    /// Places and numbers of images, and capacity beyond them.
    places: Vec<(u32, u32)>,
    count: usize,
    /// Squared distances from the site that queries, in units.
    squares: Vec<f32>,
    /// The numbers of those selected, and capacity for a block beyond them.
    numbers: Vec<u16>,
}

impl CandidateSoa {
    /// Removes all sites.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// How many sites there are.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Reserves capacity for more sites.
    pub(crate) fn reserve(&mut self, more: usize) {
        let padded = (self.count + more).next_multiple_of(BLOCK);
        if self.places.len() < padded {
            let capacity = 2 * padded;
            self.places.resize(capacity, (0, 0));
            (self.positions.iter_mut()).for_each(|coordinates| coordinates.resize(capacity, 0.0));
        }
    }

    /// Adds a site if it is wanted: its place and image, and its position `about` the middle in units.
    /// Capacity must have been reserved. A site that is not wanted is overwritten by the next one.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_wanted: bool, place: (u32, u32), about: &Vector3<f64>) {
        let [xs, ys, zs] = &mut self.positions;
        xs[self.count] = about.x as f32;
        ys[self.count] = about.y as f32;
        zs[self.count] = about.z as f32;
        self.places[self.count] = place;
        self.count += usize::from(is_wanted);
    }

    /// Pads the last block once all sites are added.
    pub(crate) fn close(&mut self) {
        self.reserve(0);
        let padded = self.count.next_multiple_of(BLOCK);
        for coordinates in &mut self.positions {
            coordinates[self.count..padded].fill(f32::INFINITY);
        }
        self.squares.resize(padded, 0.0);
        self.numbers.resize(padded + BLOCK, 0);
    }

    /// Measures how far all sites are from `here`, in units, for the queries that follow.
    pub(crate) fn measure(&mut self, here: &Vector3<f64>) {
        let [x, y, z] = [here.x, here.y, here.z].map_each(|along| f32x8::splat(along as f32));
        let [xs, ys, zs] = self.positions.each_ref().map_each(|all| all.as_chunks().0);
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

    /// Adds to `found` the sites whose squared distance from `site` exceeds `above` and is at most
    /// `limit`. The site in `place` and its images are left out. Needs a measure from the same site.
    ///
    /// All candidates are written and unwanted ones overwritten: a branch would be mispredicted.
    pub(crate) fn find(
        &mut self,
        (tree, unit): (&KdTree, f64),
        (place, site): (usize, &Point3<f64>),
        (above, limit): (f64, f64),
        found: &mut CandidateList,
    ) {
        let count = self.list_near(above.max(0.0).sqrt() / unit, limit.sqrt() / unit);
        found.reserve(count);
        for &number in &self.numbers[..count] {
            // Lanes beyond the last site hold none. They are infinitely far, but so may the limit be.
            let Some(&(other, shift)) = self.places[..self.count].get(usize::from(number)) else {
                continue;
            };
            let by = &tree.images()[shift as usize].by;
            let candidate = Candidate::new(tree, site, (other as usize, shift), by);
            let square = candidate.distance_squared;
            let is_wanted = (other as usize != place) & (above < square) & (square <= limit);
            found.push_if(is_wanted, candidate);
        }
    }

    /// Lists the numbers of the sites that are, up to the error of single precision, neither nearer
    /// nor farther than this, in units; returns how many these are.
    fn list_near(&mut self, above: f64, limit: f64) -> usize {
        let reach = limit + ROUNDING;
        let most = f32x8::splat((reach * reach * (1.0 + ROUNDING)) as f32);
        let inner = (above - ROUNDING).max(0.0);
        let least = f32x8::splat((inner * inner * (1.0 - ROUNDING)) as f32);
        let (blocks, _) = self.squares.as_chunks::<BLOCK>();
        let mut count = 0;
        for (block, squares) in blocks.iter().enumerate() {
            let squares = f32x8::new(*squares);
            let [outside, inside] = [most - squares, squares - least].map_each(f32x8::to_bitmask);
            let lanes = &LANES[(outside | inside) as usize & 0xff];
            let Some(chunk) = self.numbers[count..].first_chunk_mut::<BLOCK>() else {
                break;
            };
            *chunk = (u16x8::splat((block * BLOCK) as u16) + u16x8::new(*lanes)).to_array();
            count += BLOCK - (outside | inside).count_ones() as usize;
        }
        count
    }
}

/// Candidates that have been selected.
#[derive(Clone, Debug, Default)]
pub(crate) struct CandidateList {
    /// The candidates, and capacity beyond them.
    slots: Vec<Candidate>,
    count: usize,
}

impl CandidateList {
    /// Removes all candidates.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Reserves capacity for more candidates.
    pub(crate) fn reserve(&mut self, more: usize) {
        let most = self.count + more;
        if self.slots.len() <= most {
            self.slots.resize(2 * most + 1, Candidate::default());
        }
    }

    /// Adds a candidate if it is wanted. Capacity must have been reserved.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_wanted: bool, candidate: Candidate) {
        self.slots[self.count] = candidate;
        self.count += usize::from(is_wanted);
    }

    /// The candidates.
    pub(crate) fn candidates(&self) -> &[Candidate] {
        &self.slots[..self.count]
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
