//! The spatial index: a uniform grid of bins over the sites.
//!
//! Bins are near-cubic and hold three sites on average over the sites' own bounding
//! box (over the whole period along periodic axes), however flat that box is. Sites are stored in
//! bin order, so that a walk over the index is a walk through memory.

use std::ops::{Range, RangeInclusive};

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::voronoi::bins::bin_counts;

/// How much of a bin's width the promised reach is drawn in, against rounding at bin borders.
const BORDER: f64 = 1e-9;

/// A site, or a periodic image of one, near a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// Squared distance from the query's site (L²).
    pub distance_squared: f64,
    /// Its place in the index.
    pub place: u32,
    /// By how many periods it is moved along each axis.
    pub image: [i8; 3],
}

/// A uniform grid of bins over sites.
#[derive(Clone, Debug)]
pub struct SiteIndex {
    origin: [f64; 3],
    widths: [f64; 3],
    counts: [usize; 3],
    periods: [Option<f64>; 3],
    starts: Vec<u32>,
    sites: Vec<u32>,
    positions: [Vec<f64>; 3],
}

/// Whose surroundings are collected, and how far.
struct Query {
    place: usize,
    here: [f64; 3],
    limit: f64,
}

impl SiteIndex {
    /// Sorts `sites`, all within `bounds` along the periodic axes, into bins.
    #[must_use]
    pub fn new(sites: &[Point3<f64>], bounds: &Bounds<3>, periods: [Option<f64>; 3]) -> Self {
        let mut around = Bounds::of(sites);
        for axis in 0..3 {
            if periods[axis].is_some() || sites.is_empty() {
                around.min[axis] = bounds.min[axis];
                around.max[axis] = bounds.max[axis];
            }
        }
        let extent = around.extent();
        let counts = bin_counts(extent, sites.len());
        let mut index = Self {
            origin: around.min.into(),
            widths: [0, 1, 2].map(|axis| extent[axis] / counts[axis] as f64),
            counts,
            periods,
            starts: Vec::new(),
            sites: Vec::new(),
            positions: Default::default(),
        };
        index.fill(sites);
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

    /// The index in the caller's order of the site in `place`.
    #[must_use]
    pub fn site(&self, place: usize) -> u32 {
        self.sites[place]
    }

    /// The position of the site in `place`.
    #[must_use]
    pub fn position(&self, place: usize) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|axis| self.positions[axis][place]))
    }

    /// The displacement from the site in place `from` to `candidate`.
    #[must_use]
    pub fn displacement(&self, from: usize, candidate: &Candidate) -> Vector3<f64> {
        Vector3::from([0, 1, 2].map(|axis| {
            let coordinates = &self.positions[axis];
            let plain = coordinates[candidate.place as usize] - coordinates[from];
            plain + self.shift(axis, candidate.image[axis])
        }))
    }

    /// The bin of the site in `place`.
    #[must_use]
    pub fn bin(&self, place: usize) -> [usize; 3] {
        self.bin_at(&self.position(place))
    }

    /// Appends the sites and images nearer than the square root of `limit` in the bins at Chebyshev
    /// distance `ring` from `bin`, and returns whether there are any bins that far out. Ring 1 is
    /// the whole block of bins around, and there is no ring 0. The site in `place` itself and its
    /// images are left out.
    pub fn collect_ring(
        &self,
        place: usize,
        bin: [usize; 3],
        ring: usize,
        limit: f64,
        candidates: &mut Vec<Candidate>,
    ) -> bool {
        let ring = ring as isize;
        let [columns, rows, layers] = [0, 1, 2].map(|axis| self.span(axis, bin[axis], ring));
        let query = Query {
            place,
            here: self.position(place).into(),
            limit,
        };
        let middle = bin.map(|b| b as isize);
        let any = [&columns, &rows, &layers]
            .iter()
            .zip(middle)
            .any(|(span, b)| span.contains(&(b - ring)) || span.contains(&(b + ring)));
        for z in layers {
            let far_z = self.gap_squared(&query, 2, z);
            for y in rows.clone() {
                let far = far_z + self.gap_squared(&query, 1, y);
                if far > limit {
                    continue;
                }
                let on_shell = (y - middle[1]).abs() == ring || (z - middle[2]).abs() == ring;
                if ring == 1 || on_shell {
                    self.collect_row(&query, columns.clone(), y, z, candidates);
                    continue;
                }
                for x in [middle[0] - ring, middle[0] + ring] {
                    if columns.contains(&x) && far + self.gap_squared(&query, 0, x) <= limit {
                        self.collect_row(&query, x..=x, y, z, candidates);
                    }
                }
            }
        }
        any
    }

    /// The distance within which every site and image has been collected once the rings 0…`ring`
    /// around the bin of the site in `place` have been (L).
    #[must_use]
    pub fn reach(&self, place: usize, bin: [usize; 3], ring: usize) -> f64 {
        let mut reach = f64::INFINITY;
        for axis in 0..3 {
            let span = self.span(axis, bin[axis], ring as isize);
            let full = self.span(axis, bin[axis], isize::MAX / 4);
            let inside = self.positions[axis][place] - self.origin[axis];
            let width = self.widths[axis];
            if span.start() > full.start() {
                reach = reach.min(inside - width * (*span.start() as f64 + BORDER));
            }
            if span.end() < full.end() {
                reach = reach.min(width * ((*span.end() + 1) as f64 - BORDER) - inside);
            }
        }
        reach
    }

    /// The bins within `ring` of `bin` along an axis: within the grid, or within one period of it.
    fn span(&self, axis: usize, bin: usize, ring: isize) -> RangeInclusive<isize> {
        let count = self.counts[axis] as isize;
        let bin = bin as isize;
        let (first, last) = match self.periods[axis] {
            Some(_) => (-count, 2 * count - 1),
            None => (0, count - 1),
        };
        (bin - ring).max(first)..=(bin + ring).min(last)
    }

    /// Appends the candidates in a row of bins along x, which may reach over periodic ends.
    fn collect_row(
        &self,
        query: &Query,
        columns: RangeInclusive<isize>,
        y: isize,
        z: isize,
        candidates: &mut Vec<Candidate>,
    ) {
        let [count_x, count_y, count_z] = self.counts.map(|count| count as isize);
        let mut first = *columns.start();
        while first <= *columns.end() {
            let image_x = first.div_euclid(count_x);
            let last = (*columns.end()).min((image_x + 1) * count_x - 1);
            let image = [image_x, y.div_euclid(count_y), z.div_euclid(count_z)].map(|n| n as i8);
            let row = (z.rem_euclid(count_z) * count_y + y.rem_euclid(count_y)) * count_x;
            let [start, end] = [first, last + 1]
                .map(|x| self.starts[(row + x - image_x * count_x) as usize] as usize);
            self.collect_run(query, start..end, image, candidates);
            first = last + 1;
        }
    }

    /// Appends the candidates in consecutive places, all of the same image.
    fn collect_run(
        &self,
        query: &Query,
        places: Range<usize>,
        image: [i8; 3],
        candidates: &mut Vec<Candidate>,
    ) {
        let shift = [0, 1, 2].map(|axis| self.shift(axis, image[axis]));
        let [xs, ys, zs] = [0, 1, 2].map(|axis| &self.positions[axis][places.clone()]);
        for (((x, y), z), place) in xs.iter().zip(ys).zip(zs).zip(places) {
            let x = x - query.here[0] + shift[0];
            let y = y - query.here[1] + shift[1];
            let z = z - query.here[2] + shift[2];
            let distance_squared = x * x + y * y + z * z;
            if distance_squared <= query.limit && place != query.place {
                candidates.push(Candidate {
                    distance_squared,
                    place: place as u32,
                    image,
                });
            }
        }
    }

    /// The squared distance along an axis from the query's site to the slab of bins `bin` (L²),
    /// drawn in a little against rounding at bin borders.
    fn gap_squared(&self, query: &Query, axis: usize, bin: isize) -> f64 {
        let width = self.widths[axis];
        let inside = query.here[axis] - self.origin[axis];
        let before = width * bin as f64 - inside;
        let gap = before.max(-before - width) - BORDER * width;
        if gap > 0.0 { gap * gap } else { 0.0 }
    }

    /// By how much an image is moved along an axis (L).
    fn shift(&self, axis: usize, image: i8) -> f64 {
        self.periods[axis].map_or(0.0, |period| f64::from(image) * period)
    }

    fn bin_at(&self, position: &Point3<f64>) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            if self.counts[axis] == 1 {
                return 0;
            }
            let steps = (position[axis] - self.origin[axis]) / self.widths[axis];
            (steps as usize).min(self.counts[axis] - 1)
        })
    }

    fn bin_number(&self, bin: [usize; 3]) -> usize {
        (bin[2] * self.counts[1] + bin[1]) * self.counts[0] + bin[0]
    }

    /// Counting sort by bin; sites of one bin keep their order.
    fn fill(&mut self, sites: &[Point3<f64>]) {
        let bins: Vec<u32> = sites
            .iter()
            .map(|site| self.bin_number(self.bin_at(site)) as u32)
            .collect();
        self.starts = vec![0; self.counts.iter().product::<usize>() + 1];
        for &bin in &bins {
            self.starts[bin as usize + 1] += 1;
        }
        for bin in 1..self.starts.len() {
            self.starts[bin] += self.starts[bin - 1];
        }
        let mut free = self.starts.clone();
        self.sites = vec![0; sites.len()];
        for (site, &bin) in bins.iter().enumerate() {
            let place = &mut free[bin as usize];
            self.sites[*place as usize] = site as u32;
            *place += 1;
        }
        let order = &self.sites;
        let column = |axis: usize| {
            order
                .iter()
                .map(|&site| sites[site as usize][axis])
                .collect()
        };
        self.positions = [column(0), column(1), column(2)];
    }
}
