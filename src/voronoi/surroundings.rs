//! What lies around a site: the near sites in order, and where to look for the others.

use nalgebra::Point3;
use wide::i32x8;

use crate::voronoi::candidate::{Candidate, Subtree};
use crate::voronoi::crowd::{Crowd, DRAWN_IN};
use crate::voronoi::index::SiteIndex;
use crate::voronoi::layer::Found;

/// Near sites at most. More would take longer to sort than they are worth: the look is then too far.
const MOST: usize = 256;

/// The bits of a sorting key that number a candidate: as many as [`MOST`] takes.
const NUMBER: i32 = 0xff;

/// A near site may come after one that is farther by this factor, squared: keys hold the distance to
/// 2⁻¹² only.
pub(crate) const DISORDER: f64 = 1.001;

/// Up to so many near sites are ranked by comparing all with all: there is no branch in that.
const RANKED: usize = 64;

/// Keys compared together, eight at a time.
const BLOCK: usize = 16;

/// What has been found around a site.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    crowd: Crowd,
    /// The sites within the first look.
    near: Found,
    /// Their sorting keys.
    keys: Vec<i32>,
    /// Their numbers, nearest first.
    order: Vec<u8>,
    /// Sites beyond the first look.
    others: Found,
}

impl Surroundings {
    /// Looks around the site in `place` as far as the root of `limit`, or less far where that is too
    /// much, and returns the square within which all sites are found. What is gathered depends on
    /// `usual` alone, the limit that neighboring sites have in common.
    pub(crate) fn look(
        &mut self,
        index: &SiteIndex,
        place: usize,
        (limit, usual): (f64, f64),
    ) -> f64 {
        self.crowd.gather(index, place, usual);
        let site = index.position(place);
        self.crowd.measure(&site);
        let mut limit = limit.min(self.crowd.near_squared());
        for _ in 0..DRAWN_IN {
            if self.look_within(index, place, &site, limit) {
                self.sort();
                return limit;
            }
            limit *= 0.25;
        }
        self.give_up()
    }

    /// Finds nothing.
    fn give_up(&mut self) -> f64 {
        self.near.clear();
        self.order.clear();
        -1.0
    }

    /// The sites within the first look, nearest first but for [`DISORDER`].
    pub(crate) fn near(&self) -> impl Iterator<Item = &Candidate> {
        let order = self.order.iter();
        let candidates = self.near.candidates();
        order.map(|&number| &candidates[usize::from(number)])
    }

    /// Orders the candidates by their keys, no two of which agree.
    fn sort(&mut self) {
        let count = self.keys.len();
        self.order.clear();
        if count > RANKED {
            self.keys.sort_unstable();
            let numbers = self.keys.iter().map(|key| (key & NUMBER) as u8);
            self.order.extend(numbers);
            return;
        }
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

    /// The gathered sites farther than the root of `seen` and within that of `needed`, in no order.
    pub(crate) fn gathered(
        &mut self,
        index: &SiteIndex,
        place: usize,
        (seen, needed): (f64, f64),
    ) -> &[Candidate] {
        let site = index.position(place);
        let from = (place, &site);
        self.crowd
            .find_all(index, from, (seen, needed), &mut self.others);
        self.others.candidates()
    }

    /// What has not been gathered and may be nearer to the neighborhood than the root of `needed`,
    /// nearest first; the gaps are those to the neighborhood.
    pub(crate) fn beyond(&mut self, needed: f64) -> &[Subtree] {
        self.crowd.beyond(needed)
    }

    fn look_within(
        &mut self,
        index: &SiteIndex,
        place: usize,
        site: &Point3<f64>,
        limit: f64,
    ) -> bool {
        self.crowd.find(index, (place, site), limit, &mut self.near);
        self.list_keys()
    }

    /// Lists the keys of the near sites, if these are not too many.
    fn list_keys(&mut self) -> bool {
        let near = self.near.candidates();
        if near.len() > MOST {
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
