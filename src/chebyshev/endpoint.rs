//! Where segments on interfaces begin and end.

use wide::f64x4;

use crate::chebyshev::interface::{Interface, PAIRS};
use crate::chebyshev::sector::{FourSectors, Sector};

/// An interface, and what a point of it is to a segment with the interface's first sector on its
/// left: the interface's number for the segment's start, [`Interface::SLOTS`] more for its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Endpoint(u8);

impl Endpoint {
    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 2 * Interface::SLOTS;

    /// Where a walk around a facet passes from one sector to one of another axis. From the facet
    /// on the other side of the edge it is the way back.
    #[inline]
    pub(crate) fn passing(from: Sector, to: Sector) -> Self {
        PASSING[from.number() + Sector::SLOTS * to.number()]
    }

    /// [`Endpoint::passing`] for the sectors in the last bits of a float.
    #[inline(always)]
    pub(crate) fn of_passing_code(code: f64) -> Self {
        PASSING[code.to_bits() as usize % PASSING.len()]
    }

    /// The second of these sectors.
    #[inline(always)]
    pub(crate) fn end_of_passing_code(code: f64) -> Sector {
        Sector::of_number(code.to_bits() as usize / Sector::SLOTS % Sector::SLOTS)
    }

    /// Four pairs of sectors in the last bits of floats.
    #[inline(always)]
    pub(crate) fn passing_codes([from, to]: &[FourSectors; 2]) -> f64x4 {
        from.codes(0) | to.codes(Sector::SLOTS.trailing_zeros() as usize)
    }

    /// The one at the start or the end of an interface's segment.
    #[inline]
    pub(crate) fn of(interface: Interface, ends: bool) -> Self {
        Self(interface.number() as u8 + if ends { Interface::SLOTS as u8 } else { 0 })
    }

    /// Its place among all.
    #[inline]
    pub(crate) const fn number(self) -> usize {
        self.0 as usize % Self::SLOTS
    }

    /// Its bit in a set of endpoints.
    #[inline]
    pub(crate) fn bit(self) -> u32 {
        1 << self.number()
    }

    /// The first endpoint of a set that has one.
    #[inline]
    pub(crate) fn lowest(set: u32) -> Self {
        Self(set.trailing_zeros() as u8)
    }

    /// The other end of a segment.
    #[inline]
    pub(crate) fn opposite(self) -> Self {
        Self(self.0 ^ Interface::SLOTS as u8)
    }

    /// The interface.
    #[inline]
    pub(crate) fn interface(self) -> Interface {
        Interface::of_number(self.number() % Interface::SLOTS)
    }

    /// A number, with the other sign for an end.
    #[inline]
    pub(crate) fn signed(self, number: f64) -> f64 {
        let is_end = u64::from(self.0) / Interface::SLOTS as u64;
        f64::from_bits(number.to_bits() ^ is_end << 63)
    }

    /// Whether it is a start.
    #[inline]
    pub(crate) fn is_start(self) -> bool {
        self.number() < Interface::SLOTS
    }

    /// The endpoints at the diagonal, for a facet seen from outside with the center inside or beyond
    /// it.
    #[inline]
    pub(crate) fn at_diagonal(diagonal: u8, seen_from_inside: bool) -> &'static AtDiagonal {
        &AT_DIAGONAL[usize::from(seen_from_inside)][usize::from(diagonal & 7)]
    }
}

/// What ends where a diagonal pierces a facet.
#[derive(Clone, Copy)]
pub(crate) struct AtDiagonal {
    /// Three endpoints, each with the sign of the diagonal along the interface's third axis.
    pub(crate) endpoints: [(Endpoint, f64); 3],
    /// The same endpoints as a set of bits.
    pub(crate) bits: u32,
}

/// [`Endpoint::passing`]; meaningless between sectors of one axis.
static PASSING: [Endpoint; Sector::SLOTS * Sector::SLOTS] = passing_table();

const fn passing_table() -> [Endpoint; Sector::SLOTS * Sector::SLOTS] {
    let mut table = [Endpoint(0); Sector::SLOTS * Sector::SLOTS];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let (i, j) = PAIRS[interface >> 2];
        let low = i + Sector::OPPOSITE * (interface >> 1 & 1);
        let high = j + Sector::OPPOSITE * (interface & 1);
        table[low + Sector::SLOTS * high] = Endpoint(interface as u8);
        table[high + Sector::SLOTS * low] = Endpoint((interface + Interface::SLOTS) as u8);
        interface += 1;
    }
    table
}

pub(crate) static AT_DIAGONAL: [[AtDiagonal; 8]; 2] = [diagonal_table(false), diagonal_table(true)];

const fn diagonal_table(seen_from_inside: bool) -> [AtDiagonal; 8] {
    let none = AtDiagonal {
        endpoints: [(Endpoint(0), 0.0); 3],
        bits: 0,
    };
    let mut table = [none; 8];
    let mut entry = 0;
    while entry < 24 {
        let (diagonal, pair) = (entry / 3, entry % 3);
        let (i, j) = PAIRS[pair];
        let interface = 4 * pair + 2 * (diagonal >> i & 1) + (diagonal >> j & 1);
        // Around (1, 1, 1) the sectors run x, y, z counter-clockwise; a mirror turns that round.
        let is_mirrored = diagonal.count_ones() & 1 == 1;
        let ends = ((pair == 1) == is_mirrored) == seen_from_inside;
        let number = interface + if ends { Interface::SLOTS } else { 0 };
        let is_negative = diagonal >> (2 - pair) & 1 == 1;
        let sign = if is_negative { -1.0 } else { 1.0 };
        table[diagonal].endpoints[pair] = (Endpoint(number as u8), sign);
        table[diagonal].bits |= 1 << number;
        entry += 1;
    }
    table
}
