//! The spatial index: a uniform grid of bins over the sites.
//!
//! Bins are near-cubic and hold three sites on average over the sites' own bounding
//! box (over the whole period along periodic axes), however flat that box is. Sites are stored in
//! bin order, so that a walk over the index is a walk through memory.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;

/// Three sites a bin: the 3×3×3 block around a site then holds about 81, of which a typical cell
/// needs the nearest 30.
const SITES_PER_BIN: f64 = 3.0;

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
            match self.periods[axis] {
                Some(period) => plain + f64::from(candidate.image[axis]) * period,
                None => plain,
            }
        }))
    }

    /// The bin of the site in `place`.
    #[must_use]
    pub fn bin(&self, place: usize) -> [usize; 3] {
        self.bin_at(&self.position(place))
    }

    /// Appends the sites and images in the bins at Chebyshev distance `ring` from `bin`, and
    /// returns whether there are any bins that far out. The site in `place` itself and its images
    /// are left out.
    pub fn collect_ring(
        &self,
        place: usize,
        bin: [usize; 3],
        ring: usize,
        candidates: &mut Vec<Candidate>,
    ) -> bool {
        let ring = ring as isize;
        let spans = [0, 1, 2].map(|axis| self.span(axis, bin[axis], ring));
        let mut any = false;
        for z in spans[2].clone() {
            for y in spans[1].clone() {
                let on_shell = [(y, 1), (z, 2)]
                    .iter()
                    .any(|&(b, axis)| (b - bin[axis] as isize).abs() == ring);
                let middle = bin[0] as isize;
                if on_shell {
                    any |= !spans[0].is_empty();
                    for x in spans[0].clone() {
                        self.collect_bin(place, [x, y, z], candidates);
                    }
                } else {
                    for x in [middle - ring, middle + ring] {
                        if spans[0].contains(&x) {
                            any = true;
                            self.collect_bin(place, [x, y, z], candidates);
                        }
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
    fn span(&self, axis: usize, bin: usize, ring: isize) -> std::ops::RangeInclusive<isize> {
        let count = self.counts[axis] as isize;
        let bin = bin as isize;
        let (first, last) = match self.periods[axis] {
            Some(_) => (-count, 2 * count - 1),
            None => (0, count - 1),
        };
        (bin - ring).max(first)..=(bin + ring).min(last)
    }

    fn collect_bin(&self, place: usize, bin: [isize; 3], candidates: &mut Vec<Candidate>) {
        let image = [0, 1, 2].map(|axis| bin[axis].div_euclid(self.counts[axis] as isize) as i8);
        let wrapped = [0, 1, 2].map(|axis| bin[axis].rem_euclid(self.counts[axis] as isize));
        let number = self.bin_number(wrapped.map(|b| b as usize));
        let [first, last] = [self.starts[number], self.starts[number + 1]];
        for other in first..last {
            if other as usize == place {
                continue;
            }
            let mut candidate = Candidate {
                distance_squared: 0.0,
                place: other,
                image,
            };
            candidate.distance_squared = self.displacement(place, &candidate).norm_squared();
            candidates.push(candidate);
        }
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

/// Bins per axis: near-cubic ones along the axes that are longer than a bin, one along the others.
fn bin_counts(extent: Vector3<f64>, sites: usize) -> [usize; 3] {
    let bins = (sites as f64 / SITES_PER_BIN).max(1.0);
    let mut long = [0, 1, 2].map(|axis| extent[axis] > 0.0);
    loop {
        let lengths: Vec<f64> = (0..3).filter(|&k| long[k]).map(|k| extent[k]).collect();
        if lengths.is_empty() {
            return [1; 3];
        }
        // The geometric mean by logarithms: the product of three extents may underflow.
        let sum: f64 = lengths.iter().map(|length| length.ln()).sum();
        let width = ((sum - bins.ln()) / lengths.len() as f64).exp();
        let short = (0..3).find(|&axis| long[axis] && extent[axis] < width);
        match short {
            Some(axis) if lengths.len() > 1 => long[axis] = false,
            _ => {
                let count = |axis: usize| (extent[axis] / width).round().max(1.0) as usize;
                return [0, 1, 2].map(|axis| if long[axis] { count(axis) } else { 1 });
            }
        }
    }
}
