//! Sites side by side, in single precision, to be passed over by many that look.

use nalgebra::{Point3, Vector3};
use wide::{f32x8, u16x8};

use crate::voronoi::candidate::Candidate;
use crate::voronoi::index::SiteIndex;

/// Sites handled together.
const BLOCK: usize = 8;

/// What single precision may do to a distance, in units: coordinates of at most a few units are good
/// to 2⁻²², with room to spare.
pub(crate) const ROUNDING: f64 = 1e-5;

/// Gathered sites, and how far they are from the one that looks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layer {
    /// Coordinates in units, in whole blocks once all are here, and room beyond them.
    positions: [Vec<f32>; 3],
    /// Places and numbers of shifts, and room beyond them.
    places: Vec<(u32, u32)>,
    count: usize,
    /// Squared distances from the site that looks, in units.
    squares: Vec<f32>,
    /// The numbers of those that are near, and room for a block beyond them.
    numbers: Vec<u16>,
}

impl Layer {
    /// Forgets all sites.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// How many sites there are.
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Makes room for some more sites.
    pub(crate) fn reserve(&mut self, more: usize) {
        let needed = (self.count + more).next_multiple_of(BLOCK);
        if self.places.len() < needed {
            let room = 2 * needed;
            self.places.resize(room, (0, 0));
            (self.positions.iter_mut()).for_each(|coordinates| coordinates.resize(room, 0.0));
        }
    }

    /// Adds a site if it is wanted, `place` in the shift of a number, `about` the middle in units.
    /// There has to be room. What is not wanted is overwritten by the next one.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_wanted: bool, place: (u32, u32), about: &Vector3<f64>) {
        let [xs, ys, zs] = &mut self.positions;
        xs[self.count] = about.x as f32;
        ys[self.count] = about.y as f32;
        zs[self.count] = about.z as f32;
        self.places[self.count] = place;
        self.count += usize::from(is_wanted);
    }

    /// Says that all sites are here.
    pub(crate) fn close(&mut self) {
        self.reserve(0);
        let padded = self.count.next_multiple_of(BLOCK);
        for coordinates in &mut self.positions {
            coordinates[self.count..padded].fill(f32::INFINITY);
        }
        self.squares.resize(padded, 0.0);
        self.numbers.resize(padded + BLOCK, 0);
    }

    /// Measures how far all sites are from `here`, in units, for the visits to come.
    pub(crate) fn measure(&mut self, here: &Vector3<f64>) {
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

    /// Adds to `found` the sites whose squared distance from `site` exceeds `above` and is at most
    /// `limit`. The site in `place` and its images are left out. Needs a measure from the same site.
    ///
    /// Which sites are near is what a processor cannot foresee: all is written, and what is not wanted
    /// overwritten.
    pub(crate) fn find(
        &mut self,
        (index, unit): (&SiteIndex, f64),
        (place, site): (usize, &Point3<f64>),
        (above, limit): (f64, f64),
        found: &mut Found,
    ) {
        let count = self.list_near(above.max(0.0).sqrt() / unit, limit.sqrt() / unit);
        found.reserve(count);
        for &number in &self.numbers[..count] {
            // Lanes beyond the last site hold none. They are infinitely far, but so may the limit be.
            let Some(&(other, shift)) = self.places[..self.count].get(usize::from(number)) else {
                continue;
            };
            let by = &index.shifts()[shift as usize].by;
            let candidate = Candidate::new(index, site, (other as usize, shift), by);
            let square = candidate.distance_squared;
            let is_wanted = (other as usize != place) & (above < square) & (square <= limit);
            found.push_if(is_wanted, candidate);
        }
    }

    /// Lists the numbers of the sites that are, as far as single precision can tell, neither nearer
    /// nor farther than this, in units; returns how many these are.
    fn list_near(&mut self, above: f64, limit: f64) -> usize {
        let reach = limit + ROUNDING;
        let most = f32x8::splat((reach * reach * (1.0 + ROUNDING)) as f32);
        let seen = (above - ROUNDING).max(0.0);
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
    /// Forgets all candidates.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    /// Makes room for some more candidates.
    pub(crate) fn reserve(&mut self, more: usize) {
        let most = self.count + more;
        if self.room.len() <= most {
            self.room.resize(2 * most + 1, Candidate::default());
        }
    }

    /// Adds a candidate if it is wanted. There has to be room.
    #[inline(always)]
    pub(crate) fn push_if(&mut self, is_wanted: bool, candidate: Candidate) {
        self.room[self.count] = candidate;
        self.count += usize::from(is_wanted);
    }

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
