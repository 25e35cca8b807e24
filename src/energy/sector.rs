//! The subdivision of space about a center into sectors, interfaces and diagonals, as tables.
//!
//! Six *sectors* ±x, ±y, ±z, the cones in which one signed coordinate difference is the largest, cut
//! the fragments of \[BL\] section 3.5 (Fig. 12) out of a cell. They meet pairwise in twelve
//! *interfaces* (plane cones on |y_i| = |y_j|), and those in threes in eight *diagonals* (rays along
//! (±1, ±1, ±1)). As a map on the sphere this is the octahedron: sectors its vertices, interfaces its
//! edges, diagonals its faces.
//!
//! The boundary of a facet passes through sectors; the interfaces it crosses, counted modulo two,
//! determine which diagonals pierce the facet ([`pierced_diagonals`]). So a cell's integrals are
//! summed over a consistent subdivision even where rounding alone decides the sector of a vertex, as
//! it does at every corner of a cube about its center.

use crate::arrays::MapEach;
use nalgebra::Vector3;
use wide::f64x4;

/// One of the six cones in which a coordinate difference of one sign is the largest: the axis, plus
/// four for the negative side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Sector(u8);

impl Sector {
    /// All six: +x, −x, +y, −y, +z, −z.
    pub(crate) const ALL: [Self; 6] = [Self(0), Self(4), Self(1), Self(5), Self(2), Self(6)];

    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 8;

    /// How far apart the numbers of an axis's two sectors are.
    pub(crate) const OPPOSITE: usize = 4;

    /// The sector in which `displacement` from the center lies; on ties the first of its kind.
    #[must_use]
    #[inline]
    pub(crate) fn of(displacement: &Vector3<f64>) -> Self {
        // Numbers without sign are ordered as their bits are, and those are compared faster.
        const SIGN: u64 = 1 << 63;
        let [x, y, z] = [displacement.x, displacement.y, displacement.z].map_each(f64::to_bits);
        let number = |axis: u64, along: u64| axis | (along >> 63) << 2;
        let (mut sector, mut largest) = (number(0, x), x & !SIGN);
        if y & !SIGN > largest {
            (sector, largest) = (number(1, y), y & !SIGN);
        }
        if z & !SIGN > largest {
            sector = number(2, z);
        }
        Self(sector as u8)
    }

    /// The sector of a number.
    #[inline]
    pub(crate) const fn of_number(number: usize) -> Self {
        Self(number as u8)
    }

    /// The axis, plus four for the negative side.
    #[must_use]
    #[inline]
    pub(crate) fn number(self) -> usize {
        usize::from(self.0) % Self::SLOTS
    }

    /// The four sectors of the other axes, which have an interface with this one.
    #[must_use]
    #[inline]
    pub(crate) fn adjacent(self) -> [Self; 4] {
        const ADJACENT: [[Sector; 4]; 3] = [
            [Sector(1), Sector(5), Sector(2), Sector(6)],
            [Sector(0), Sector(4), Sector(2), Sector(6)],
            [Sector(0), Sector(4), Sector(1), Sector(5)],
        ];
        ADJACENT[self.axis()]
    }

    /// 0, 1, 2 for x, y, z.
    #[must_use]
    #[inline]
    pub(crate) fn axis(self) -> usize {
        usize::from(self.0) % Self::OPPOSITE
    }

    /// +1 or −1.
    #[must_use]
    #[inline]
    pub(crate) fn sign(self) -> f64 {
        if self.is_negative() { -1.0 } else { 1.0 }
    }

    /// The linear function that is the Chebyshev distance within the sector (L).
    #[must_use]
    #[inline]
    pub(crate) fn distance(self, displacement: &Vector3<f64>) -> f64 {
        let coordinate = match self.axis() {
            0 => displacement.x,
            1 => displacement.y,
            _ => displacement.z,
        };
        if self.is_negative() {
            -coordinate
        } else {
            coordinate
        }
    }

    fn is_negative(self) -> bool {
        usize::from(self.0) >= Self::OPPOSITE
    }
}

/// By axis: ∫ in the negative sector minus ∫ in the positive one, of integrals by sector.
pub(crate) fn negative_minus_positive(integrals: &[f64; Sector::SLOTS]) -> Vector3<f64> {
    let difference = |axis: usize| integrals[axis + Sector::OPPOSITE] - integrals[axis];
    Vector3::from([0, 1, 2].map_each(difference))
}

/// Where two sectors of different axes meet: four times the number of the pair of axes (xy, xz, yz),
/// plus two and one for the negative sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interface(u8);

/// The pairs of axes i < j between which interfaces lie.
pub(crate) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Per interface: +1 where its two sectors' directions and the third axis are right-handed, else −1.
pub(crate) const ORIENTATION: [f64; Interface::SLOTS] = [
    1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
];

/// A point of an interface in its two coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct InterfacePoint {
    /// Its Chebyshev distance from the center: that along either axis of the interface (L).
    pub(crate) distance: f64,
    /// Its coordinate along the third axis (L).
    pub(crate) third: f64,
}

/// An end of a segment of an interface as four lanes: the two coordinates of its point, and those of its
/// *edge velocity* g, which is zero at a diagonal. A center that moves by δ, of which δ_l and δ_r are the
/// parts along the directions of the interface's sectors and δ_t that along the third axis, takes the
/// interface with it, and the coordinates change by −(δ_l, δ_t) − (δ_l − δ_r) g.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SegmentEnd(pub(crate) f64x4);

impl SegmentEnd {
    /// An end that does not lie on an edge.
    #[inline(always)]
    pub(crate) fn off_edges(point: &InterfacePoint) -> Self {
        Self(f64x4::new([point.distance, point.third, 0.0, 0.0]))
    }

    /// Its point.
    #[inline]
    pub(crate) fn point(self) -> InterfacePoint {
        let [distance, third, ..] = self.0.to_array();
        InterfacePoint { distance, third }
    }
}

impl Interface {
    /// How many there are.
    pub(crate) const COUNT: usize = 12;

    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 16;

    /// In place of one where there is none: all determinants are zero.
    pub(crate) const NONE: Self = Self(Self::COUNT as u8);

    /// The two sectors: the one of the smaller axis first. That one is *left* of the interface's
    /// segments, from outside the facet on which they lie.
    #[inline]
    pub(crate) fn sectors(self) -> (Sector, Sector) {
        SECTORS[self.number()]
    }

    /// The axis of neither sector.
    #[inline]
    pub(crate) fn third_axis(self) -> usize {
        2 - (self.0 >> 2) as usize
    }

    /// The displacement of a point of the interface from the center.
    #[inline]
    pub(crate) fn displacement(self, point: &InterfacePoint) -> Vector3<f64> {
        let (left, right) = self.sectors();
        let mut displacement = Vector3::zeros();
        displacement[left.axis()] = left.sign() * point.distance;
        displacement[right.axis()] = right.sign() * point.distance;
        displacement[self.third_axis()] = point.third;
        displacement
    }

    /// The interface's coordinates of a displacement near it.
    pub(crate) fn coordinates(self, displacement: &Vector3<f64>) -> InterfacePoint {
        InterfacePoint {
            distance: self.sectors().0.distance(displacement),
            third: displacement[self.third_axis()],
        }
    }

    /// D, for which u × v of two points of the interface is D (left − right), left and right the
    /// gradients of its sectors' distances. The triangle of u and v with the center has the area
    /// D/√2, and six times the volume of its tetrahedron with q is D (left(q) − right(q)).
    #[inline]
    pub(crate) fn determinant(self, u: &InterfacePoint, v: &InterfacePoint) -> f64 {
        ORIENTATION[self.number()] * (u.distance * v.third - u.third * v.distance)
    }

    /// For four interfaces the signs of their first and of their second sectors, their orientations,
    /// and the numbers of their pairs of axes.
    #[inline(always)]
    pub(crate) fn lanes(quad: [Self; 4]) -> [f64x4; 4] {
        f64x4::transpose(quad.map_each(|interface| f64x4::new(LANES[interface.number()])))
    }

    /// Its place in tables.
    #[inline]
    pub(crate) fn number(self) -> usize {
        usize::from(self.0) % Self::SLOTS
    }

    /// The interface of a number.
    #[inline]
    pub(crate) fn of_number(number: usize) -> Self {
        Self(number as u8)
    }
}

/// The table of [`Interface::lanes`].
static LANES: [[f64; 4]; Interface::SLOTS] = lanes_table();

const fn lanes_table() -> [[f64; 4]; Interface::SLOTS] {
    let mut table = [[0.0; 4]; Interface::SLOTS];
    let mut interface = 0;
    while interface < Interface::COUNT {
        table[interface] = [
            1.0 - 2.0 * (interface >> 1 & 1) as f64,
            1.0 - 2.0 * (interface & 1) as f64,
            ORIENTATION[interface],
            (interface >> 2) as f64,
        ];
        interface += 1;
    }
    table
}

static SECTORS: [(Sector, Sector); Interface::SLOTS] = sectors_table();

const fn sectors_table() -> [(Sector, Sector); Interface::SLOTS] {
    let mut table = [(Sector::ALL[0], Sector::ALL[0]); Interface::SLOTS];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let (i, j) = PAIRS[interface >> 2];
        let low = Sector::ALL[2 * i + (interface >> 1 & 1)];
        let high = Sector::ALL[2 * j + (interface & 1)];
        table[interface] = (low, high);
        interface += 1;
    }
    table
}

/// The ray of a diagonal: bit k of its number is set where coordinate k is negative.
#[inline]
pub(crate) fn diagonal_ray(diagonal: u8) -> &'static Vector3<f64> {
    &RAYS[usize::from(diagonal & 7)]
}

static RAYS: [Vector3<f64>; 8] = [
    Vector3::new(1.0, 1.0, 1.0),
    Vector3::new(-1.0, 1.0, 1.0),
    Vector3::new(1.0, -1.0, 1.0),
    Vector3::new(-1.0, -1.0, 1.0),
    Vector3::new(1.0, 1.0, -1.0),
    Vector3::new(-1.0, 1.0, -1.0),
    Vector3::new(1.0, -1.0, -1.0),
    Vector3::new(-1.0, -1.0, -1.0),
];

/// The diagonals, as a set of bits, inside a closed curve that crosses the interfaces of the set
/// `crossed` an odd number of times. Where a set of four and its complement both fit, the one
/// that holds diagonal 0 is returned.
#[inline]
pub(crate) fn pierced_diagonals(crossed: u32) -> u8 {
    PIERCED[crossed as usize & ((1 << Interface::COUNT) - 1)]
}

static PIERCED: [u8; 1 << Interface::COUNT] = pierced_table();

/// The three interfaces that meet in a diagonal, as a set of bits.
const fn interfaces_at(diagonal: usize) -> usize {
    let (x, y, z) = (diagonal & 1, diagonal >> 1 & 1, diagonal >> 2 & 1);
    1 << (x << 1 | y) | 1 << (4 | x << 1 | z) | 1 << (8 | y << 1 | z)
}

const fn pierced_table() -> [u8; 1 << Interface::COUNT] {
    let mut table = [0; 1 << Interface::COUNT];
    let mut inside: usize = 0;
    while inside < 256 {
        let mut crossed = 0;
        let mut diagonal = 0;
        while diagonal < 8 {
            if inside >> diagonal & 1 == 1 {
                crossed ^= interfaces_at(diagonal);
            }
            diagonal += 1;
        }
        let size = (inside as u8).count_ones();
        if size < 4 || (size == 4 && inside & 1 == 1) {
            table[crossed] = inside as u8;
        }
        inside += 1;
    }
    table
}

/// Start or end of an interface's segments, which have the interface's first sector on their left: the
/// interface's number for the start, [`Interface::SLOTS`] more for the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InterfaceEnd(u8);

impl InterfaceEnd {
    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 2 * Interface::SLOTS;

    /// Where the boundary of a facet, counter-clockwise, crosses from one sector to one of another
    /// axis. For the facet on the other side of the edge it is the opposite one.
    #[inline]
    pub(crate) fn crossing(from: Sector, to: Sector) -> Self {
        CROSSING[from.number() + Sector::SLOTS * to.number()]
    }

    /// [`InterfaceEnd::crossing`] for the numbers of two sectors in the last bits of a float.
    #[inline(always)]
    pub(crate) fn of_code(code: f64) -> Self {
        CROSSING[code.to_bits() as usize % CROSSING.len()]
    }

    /// The start or the end of an interface's segment.
    #[inline]
    pub(crate) fn of(interface: Interface, is_end: bool) -> Self {
        Self(interface.number() as u8 + if is_end { Interface::SLOTS as u8 } else { 0 })
    }

    /// Its place in tables.
    #[inline]
    pub(crate) const fn number(self) -> usize {
        self.0 as usize % Self::SLOTS
    }

    /// Its bit in a set.
    #[inline]
    pub(crate) fn bit(self) -> u32 {
        1 << self.number()
    }

    /// The first one of a set that has one.
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

    /// Whether it is a start.
    #[inline]
    pub(crate) fn is_start(self) -> bool {
        self.number() < Interface::SLOTS
    }
}

/// [`InterfaceEnd::crossing`]; meaningless between sectors of one axis.
static CROSSING: [InterfaceEnd; Sector::SLOTS * Sector::SLOTS] = crossing_table();

const fn crossing_table() -> [InterfaceEnd; Sector::SLOTS * Sector::SLOTS] {
    let mut table = [InterfaceEnd(0); Sector::SLOTS * Sector::SLOTS];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let (i, j) = PAIRS[interface >> 2];
        let low = i + Sector::OPPOSITE * (interface >> 1 & 1);
        let high = j + Sector::OPPOSITE * (interface & 1);
        table[low + Sector::SLOTS * high] = InterfaceEnd(interface as u8);
        table[high + Sector::SLOTS * low] = InterfaceEnd((interface + Interface::SLOTS) as u8);
        interface += 1;
    }
    table
}

/// The segments that end where a diagonal pierces a facet.
#[derive(Clone, Copy)]
pub(crate) struct DiagonalEnds {
    /// Three ends, each with the sign of the diagonal along the interface's third axis.
    pub(crate) ends: [(InterfaceEnd, f64); 3],
    /// The same ends as a set of bits.
    pub(crate) bits: u32,
}

impl DiagonalEnds {
    /// An entry of a table under construction.
    const NONE: Self = Self {
        ends: [(InterfaceEnd(0), 0.0); 3],
        bits: 0,
    };

    /// Those at a diagonal, for a facet with the center below it (*inside*) or beyond it.
    #[inline]
    pub(crate) fn of(diagonal: u8, is_inside: bool) -> &'static Self {
        &DIAGONAL_ENDS[usize::from(is_inside)][usize::from(diagonal & 7)]
    }
}

/// The table of [`DiagonalEnds::of`].
pub(crate) static DIAGONAL_ENDS: [[DiagonalEnds; 8]; 2] =
    [diagonal_table(false), diagonal_table(true)];

const fn diagonal_table(is_inside: bool) -> [DiagonalEnds; 8] {
    let mut table = [DiagonalEnds::NONE; 8];
    let mut entry = 0;
    while entry < 24 {
        let (diagonal, pair) = (entry / 3, entry % 3);
        let (i, j) = PAIRS[pair];
        let interface = 4 * pair + 2 * (diagonal >> i & 1) + (diagonal >> j & 1);
        // Around (1, 1, 1) the sectors run x, y, z counter-clockwise; a mirror reverses that.
        let is_mirrored = diagonal.count_ones() & 1 == 1;
        let is_end = ((pair == 1) == is_mirrored) == is_inside;
        let number = interface + if is_end { Interface::SLOTS } else { 0 };
        let is_negative = diagonal >> (2 - pair) & 1 == 1;
        let sign = if is_negative { -1.0 } else { 1.0 };
        table[diagonal].ends[pair] = (InterfaceEnd(number as u8), sign);
        table[diagonal].bits |= 1 << number;
        entry += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sector_holds_the_largest_difference() {
        assert_eq!(Sector::of(&Vector3::new(1.0, -1.0, 1.0)), Sector::ALL[0]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, 1.0)), Sector::ALL[3]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, -1.5)), Sector::ALL[5]);
    }

    #[test]
    fn crossings_to_and_fro_are_the_two_ends_of_one_interface() {
        for one in Sector::ALL {
            for other in Sector::ALL.into_iter().filter(|s| s.axis() > one.axis()) {
                let start = InterfaceEnd::crossing(one, other);
                assert!(start.is_start());
                assert_eq!(start.interface().sectors(), (one, other));
                assert_eq!(InterfaceEnd::crossing(other, one), start.opposite());
            }
        }
    }

    #[test]
    fn a_curve_around_one_diagonal_holds_it() {
        for diagonal in 0..8 {
            let ends = &DiagonalEnds::of(diagonal, true).ends;
            let crossed =
                (ends.iter()).fold(0, |set, (end, _)| set ^ 1 << end.interface().number());
            assert_eq!(pierced_diagonals(crossed), 1 << diagonal);
        }
    }

    #[test]
    fn interface_coordinates_and_displacements_are_inverse() {
        for diagonal in 0..8 {
            for (end, sign) in &DiagonalEnds::of(diagonal, false).ends {
                let (distance, third) = (2.0, 2.0 * sign);
                let displacement =
                    (end.interface()).displacement(&InterfacePoint { distance, third });
                assert_eq!(displacement, 2.0 * diagonal_ray(diagonal));
                let point = end.interface().coordinates(&displacement);
                assert_eq!((point.distance, point.third), (distance, third));
            }
        }
    }

    #[test]
    fn determinants_measure_the_cross_product() {
        for number in 0..Interface::COUNT {
            let interface = Interface::of_number(number);
            let [u, v] = [(1.0, 0.25), (3.0, -2.0)]
                .map(|(distance, third)| InterfacePoint { distance, third });
            let cross = (interface.displacement(&u)).cross(&interface.displacement(&v));
            let (left, right) = interface.sectors();
            let gradient = |sector: Sector| Vector3::ith(sector.axis(), sector.sign());
            let expected = (gradient(left) - gradient(right)) * interface.determinant(&u, &v);
            assert_eq!(cross, expected);
        }
    }
}
