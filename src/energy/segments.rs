//! Segments: the parts of interfaces on facets, between crossings with edges and points on diagonals.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are ends of segments;
//! paired up interface by interface they make the subdivision of the facet into sectors.

use wide::{f64x4, u32x8};

use crate::arrays::MapEach;
use crate::energy::prepared::{Bits, CHUNK, CenteredPiece, FacetView, Rows};
use crate::energy::sector::{
    DiagonalEnds, Interface, InterfaceEnd, InterfacePoint, SegmentEnd, diagonal_ray,
    pierced_diagonals,
};

/// The ends that are starts.
const STARTS: u32 = (1 << Interface::SLOTS) - 1;

/// Facets the sets of whose interfaces share a word.
const FACETS: usize = CHUNK / Interface::SLOTS;

/// The bits of the diagonals.
const DIAGONALS: u32x8 = u32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);

/// A directed part of an interface on a facet, to be counted for the sector on its left and, backwards,
/// for the one on its right.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Segment {
    pub(crate) facet: u32,
    pub(crate) interface: Interface,
    pub(crate) ends: [SegmentEnd; 2],
}

impl Segment {
    /// In place of one where there is none: its sums are zero.
    pub(crate) const NONE: Self = Self {
        facet: 0,
        interface: Interface::NONE,
        ends: [SegmentEnd(f64x4::ZERO); 2],
    };
}

/// The points in which diagonals pierce facets.
#[derive(Clone, Debug, Default)]
pub(crate) struct DiagonalHits {
    /// The facets.
    pub(crate) facets: [u32; 8],
    /// The coordinates along all axes, but for their signs (L).
    pub(crate) reaches: [f64; 8],
}

/// A second start or end on an interface of a facet. A convex facet has none but by rounding.
#[derive(Clone, Copy, Debug)]
struct Unpaired {
    facet: usize,
    end: InterfaceEnd,
    point: InterfacePoint,
}

/// The ends of segments by facet: at most one per interface and kind, and the unpaired ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct SegmentEnds {
    /// The ends there are, as sets of bits.
    present: Vec<u32>,
    /// Meaningless where none is present.
    ends: Vec<[SegmentEnd; InterfaceEnd::SLOTS]>,
    unpaired: Vec<Unpaired>,
    /// Where diagonals pierce facets, each one facet and from inside; meaningless without `has_hits`.
    hits: DiagonalHits,
    has_hits: bool,
    /// Whether rounding alone has made some, so that edge velocities are meaningless.
    pub(crate) are_rounded: bool,
    /// The interfaces with a segment, by facet as sets of bits, those of [`FACETS`] facets in one word.
    words: Vec<u64>,
}

impl SegmentEnds {
    /// Removes all ends and reserves memory for those of `count` facets.
    pub(crate) fn reset(&mut self, count: usize) {
        self.present.clear();
        self.present.resize(count, 0);
        if self.ends.len() < count {
            (self.ends).resize(count, [SegmentEnd::default(); InterfaceEnd::SLOTS]);
        }
        self.unpaired.clear();
        self.has_hits = false;
        self.are_rounded = false;
    }

    /// Adds an end on a facet, or an unpaired one where its place is taken.
    #[inline]
    pub(crate) fn add(&mut self, facet: usize, end: InterfaceEnd, at: SegmentEnd) {
        let present = &mut self.present[facet];
        if *present & end.bit() == 0 {
            *present |= end.bit();
            self.ends[facet][end.number()] = at;
        } else {
            let point = at.point();
            self.unpaired.push(Unpaired { facet, end, point });
            self.are_rounded = true;
        }
    }

    /// Adds the ends at a diagonal that pierces the facet `reach` along every axis.
    #[inline(always)]
    fn add_hit(&mut self, facet: usize, diagonal: &DiagonalEnds, reach: f64) {
        let at = |sign: f64| SegmentEnd(f64x4::new([reach, sign * reach, 0.0, 0.0]));
        let present = &mut self.present[facet];
        if *present & diagonal.bits != 0 {
            for (end, sign) in &diagonal.ends {
                self.add(facet, *end, at(*sign));
            }
            return;
        }
        *present |= diagonal.bits;
        let ends = &mut self.ends[facet];
        for (end, sign) in &diagonal.ends {
            ends[end.number()] = at(*sign);
        }
    }

    /// Where diagonals pierce facets, if each pierces one and from inside, all segments have two ends,
    /// and all edge velocities are known.
    #[inline]
    pub(crate) fn hits(&self) -> Option<&DiagonalHits> {
        let sets = self.present.iter();
        let odd = sets.fold(0, |all, one| all | one ^ one >> Interface::SLOTS);
        let is_regular = self.has_hits && odd & STARTS == 0 && !self.are_rounded;
        is_regular.then_some(&self.hits)
    }

    /// An end that is present.
    #[inline]
    pub(crate) fn end(&self, facet: usize, end: InterfaceEnd) -> SegmentEnd {
        self.ends[facet][end.number()]
    }

    /// The diagonals that pierce a facet, as a set of bits.
    #[inline(always)]
    fn diagonals_through(&self, view: &CenteredPiece<'_>, facet: usize) -> u8 {
        let present = self.present[facet];
        let mut crossed = (present ^ present >> Interface::SLOTS) & STARTS;
        if !self.unpaired.is_empty() {
            for one in self.unpaired.iter().filter(|one| one.facet == facet) {
                crossed ^= 1 << one.end.interface().number();
            }
        }
        let inside = pierced_diagonals(crossed);
        if inside.count_ones() == 4 {
            facing_diagonals(inside, &view.facet(facet))
        } else {
            inside
        }
    }

    /// Adds the points in which diagonals pierce facets, each an end on three interfaces.
    ///
    /// Which facets these are cannot be predicted by a processor: so all are tested without a branch.
    #[inline]
    pub(crate) fn add_diagonals(&mut self, view: &CenteredPiece<'_>) {
        let (mut facets, mut all, mut is_once) = (u32x8::ZERO, 0, true);
        for facet in 0..self.present.len() {
            let inside = self.diagonals_through(view, facet);
            is_once &= all & inside == 0;
            all |= inside;
            let are_pierced = (u32x8::splat(u32::from(inside)) & DIAGONALS).simd_eq(DIAGONALS);
            facets |= are_pierced & u32x8::splat(facet as u32);
        }
        let facets = facets.to_array();
        let is_regular = is_once && all == u8::MAX;
        match is_regular.then(|| reaches(view, facets)).flatten() {
            Some(reaches) => {
                for (diagonal, (&facet, reach)) in (0..).zip(facets.iter().zip(reaches)) {
                    self.add_hit(facet as usize, DiagonalEnds::of(diagonal, true), reach);
                }
                (self.hits, self.has_hits) = (DiagonalHits { facets, reaches }, true);
            }
            None => self.add_any_diagonals(view),
        }
    }

    /// As [`SegmentEnds::add_diagonals`], where diagonals may pierce several facets, none, or one from
    /// outside.
    #[inline(never)]
    fn add_any_diagonals(&mut self, view: &CenteredPiece<'_>) {
        let facets = 0..self.present.len();
        let sets: Vec<_> = facets
            .map(|facet| self.diagonals_through(view, facet))
            .collect();
        for (number, inside) in sets.into_iter().enumerate() {
            let facet = view.facet(number);
            for diagonal in Bits(u64::from(inside)) {
                let diagonal = diagonal as u8;
                let ends = DiagonalEnds::of(diagonal, facet.height >= 0.0);
                // Both change sign where the center lies beyond the facet.
                let reach = facet.height / facet.normal.dot(diagonal_ray(diagonal));
                if (0.0..=f64::MAX).contains(&reach) {
                    self.add_hit(number, ends, reach);
                } else {
                    self.add_flat_diagonal(&facet, ends);
                }
            }
        }
    }

    /// Adds a diagonal that pierces the facet by rounding alone, because the center lies in its plane:
    /// triangles with the center have no volume there, and any point serves to close the segments.
    #[cold]
    fn add_flat_diagonal(&mut self, facet: &FacetView, diagonal: &DiagonalEnds) {
        let present = self.present[facet.number];
        let point = if present == 0 {
            facet.anchor()
        } else {
            let end = InterfaceEnd::lowest(present);
            let point = self.end(facet.number, end).point();
            end.interface().displacement(&point)
        };
        for &(end, _) in &diagonal.ends {
            let point = end.interface().coordinates(&point);
            self.add(facet.number, end, SegmentEnd::off_edges(&point));
        }
        self.are_rounded = true;
    }

    /// The facets and interfaces that have a segment between a start and an end.
    #[inline]
    pub(crate) fn paired(&self) -> impl Iterator<Item = (u32, Interface)> + '_ {
        let words = self.words.iter().enumerate();
        words.flat_map(|(chunk, &word)| {
            Bits(word).map(move |bit| {
                let facet = chunk * FACETS + bit / Interface::SLOTS;
                (facet as u32, Interface::of_number(bit % Interface::SLOTS))
            })
        })
    }

    /// Finds the pairs of a start and an end, for [`SegmentEnds::paired`].
    #[inline]
    pub(crate) fn pair(&mut self) {
        self.words.clear();
        self.words.extend(self.present.chunks(FACETS).map(|chunk| {
            let sets = chunk.iter().enumerate();
            sets.fold(0, |word, (place, one)| {
                let both = one & one >> Interface::SLOTS & STARTS;
                word | u64::from(both) << (place * Interface::SLOTS)
            })
        }));
    }

    /// The segment of an interface on a facet.
    #[inline(always)]
    pub(crate) fn segment(&self, (facet, interface): (u32, Interface)) -> Segment {
        let ends = &self.ends[facet as usize];
        Segment {
            facet,
            interface,
            ends: [false, true]
                .map_each(|is_end| ends[InterfaceEnd::of(interface, is_end).number()]),
        }
    }

    /// Pairs two of the unpaired ends and removes them. Which of several are paired makes no difference:
    /// they lie on one line, on which signed segments of the same ends add up to the same.
    #[inline]
    pub(crate) fn next_unpaired(&mut self) -> Option<Segment> {
        while let Some(one) = self.unpaired.pop() {
            let is_partner =
                |other: &Unpaired| other.facet == one.facet && other.end == one.end.opposite();
            let Some(place) = self.unpaired.iter().position(is_partner) else {
                continue;
            };
            let other = self.unpaired.swap_remove(place);
            let (start, end) = if one.end.is_start() {
                (one, other)
            } else {
                (other, one)
            };
            return Some(Segment {
                facet: one.facet as u32,
                interface: one.end.interface(),
                ends: [start, end].map_each(|end| SegmentEnd::off_edges(&end.point)),
            });
        }
        None
    }
}

/// How far along the diagonals their facets are pierced, if all are from inside (L).
#[inline]
fn reaches(view: &CenteredPiece<'_>, facets: [u32; 8]) -> Option<[f64; 8]> {
    let center = [view.center.x, view.center.y, view.center.z].map_each(f64x4::splat);
    let reaches = by_diagonal(&view.piece.facets, facets, |[x, y, z, offset], along| {
        let height = offset - (x * center[0] + y * center[1] + z * center[2]);
        let outside = f64x4::splat(-1.0);
        height.simd_ge(f64x4::ZERO).select(height / along, outside)
    });
    let are_inside = reaches.iter().all(|reach| (0.0..=f64::MAX).contains(reach));
    are_inside.then_some(reaches)
}

/// Applies `of` to the facet of each diagonal, four at a time: to the coordinates of the normals and the
/// offsets, and to the normals times the rays.
#[inline(always)]
pub(crate) fn by_diagonal(
    planes: &Rows,
    facets: [u32; 8],
    of: impl Fn([f64x4; 4], f64x4) -> f64x4,
) -> [f64; 8] {
    let [[a, b, c, d], [e, f, g, h]] = [0, 4].map_each(|first| {
        let quad = [0, 1, 2, 3].map_each(|lane| first + lane);
        let lanes = planes.quad(quad.map_each(|diagonal: usize| facets[diagonal]));
        let rays = quad.map_each(|diagonal| diagonal_ray(diagonal as u8));
        let ray = |axis: usize| f64x4::new(rays.map_each(|ray| ray[axis]));
        let along = lanes[0] * ray(0) + lanes[1] * ray(1) + lanes[2] * ray(2);
        of(lanes, along).to_array()
    });
    [a, b, c, d, e, f, g, h]
}

/// The set of four diagonals or its complement, where the facet spans a whole sector: that in the middle
/// of the four, or the opposite one.
fn facing_diagonals(inside: u8, facet: &FacetView) -> u8 {
    let balance = |set: u8| -> f64 {
        let slopes = Bits(u64::from(set)).map(|bit| facet.normal.dot(diagonal_ray(bit as u8)));
        slopes.sum()
    };
    let is_opposite = (balance(!inside) > balance(inside)) == (facet.height >= 0.0);
    if is_opposite { !inside } else { inside }
}
