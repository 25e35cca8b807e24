//! Space about a center, split by the largest coordinate difference.
//!
//! Six *sectors* ±x, ±y, ±z (the cones that cut fragments out of a cell) meet pairwise in twelve
//! *interfaces* (plane cones on |y_i| = |y_j|), and those in threes in eight *diagonals* (rays
//! along (±1, ±1, ±1)). As a map on the sphere this is the octahedron: sectors its vertices,
//! interfaces its edges, diagonals its faces.
//!
//! A walk around a convex polygon visits sectors; the interfaces it crosses, counted modulo two,
//! determine which diagonals pierce the polygon. `pierced` looks that up, so that a cell's
//! integrals are put together from a consistent subdivision even where rounding alone decided the
//! sector of a vertex, as it does at every corner of a cube about its center.

use nalgebra::Vector3;

/// One of the six cones in which a coordinate difference of one sign is the largest: twice the
/// axis, plus one for the negative side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sector(u8);

/// The place where two sectors of different axes meet: four times the number of the pair of axes
/// (xy, xz, yz), plus two and one for the negative sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interface(u8);

/// The pairs of axes i < j between which interfaces lie.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl Sector {
    /// All six: +x, −x, +y, −y, +z, −z.
    pub const ALL: [Self; 6] = [Self(0), Self(1), Self(2), Self(3), Self(4), Self(5)];

    /// The sector in which `displacement` from the center lies; on ties the first of its kind.
    #[must_use]
    #[inline]
    pub fn of(displacement: &Vector3<f64>) -> Self {
        let [x, y, z] = [
            displacement.x.abs(),
            displacement.y.abs(),
            displacement.z.abs(),
        ];
        let y_over_x = y > x;
        let (axis, most) = if y_over_x { (1, y) } else { (0, x) };
        let axis = if z > most { 2 } else { axis };
        let along = [displacement.x, displacement.y, displacement.z][axis];
        Self(2 * axis as u8 + u8::from(along < 0.0))
    }

    /// Its place in [`Sector::ALL`].
    #[must_use]
    #[inline]
    pub fn number(self) -> usize {
        self.0 as usize
    }

    /// The four sectors of the other axes, which have an interface with this one.
    #[must_use]
    #[inline]
    pub fn beside(self) -> [Self; 4] {
        const BESIDE: [[Sector; 4]; 3] = [
            [Sector(2), Sector(3), Sector(4), Sector(5)],
            [Sector(0), Sector(1), Sector(4), Sector(5)],
            [Sector(0), Sector(1), Sector(2), Sector(3)],
        ];
        BESIDE[self.axis()]
    }

    /// 0, 1, 2 for x, y, z.
    #[must_use]
    #[inline]
    pub fn axis(self) -> usize {
        (self.0 >> 1) as usize
    }

    /// +1 or −1.
    #[must_use]
    #[inline]
    pub fn sign(self) -> f64 {
        1.0 - 2.0 * f64::from(self.0 & 1)
    }

    /// The linear function that is the Chebyshev distance within the sector (L).
    #[must_use]
    #[inline]
    pub fn distance(self, displacement: &Vector3<f64>) -> f64 {
        let along = match self.axis() {
            0 => displacement.x,
            1 => displacement.y,
            _ => displacement.z,
        };
        if self.0 & 1 == 0 { along } else { -along }
    }
}

impl Interface {
    pub(crate) const COUNT: usize = 12;

    /// The interface between two sectors of different axes.
    #[inline]
    pub(crate) fn between(one: Sector, other: Sector) -> Self {
        let (low, high) = if one.0 < other.0 {
            (one, other)
        } else {
            (other, one)
        };
        // The pairs xy, xz, yz are those whose axes sum to 1, 2, 3.
        let pair = low.axis() + high.axis() - 1;
        Self((4 * pair) as u8 | (low.0 & 1) << 1 | (high.0 & 1))
    }

    /// The two sectors: the one of the smaller axis first. That one is *left* of the interface's
    /// segments, seen from outside the facet on which they lie.
    #[inline]
    pub(crate) fn sectors(self) -> (Sector, Sector) {
        let (i, j) = PAIRS[(self.0 >> 2) as usize];
        let low = Sector(2 * i as u8 + (self.0 >> 1 & 1));
        let high = Sector(2 * j as u8 + (self.0 & 1));
        (low, high)
    }

    #[inline]
    pub(crate) fn number(self) -> usize {
        self.0 as usize
    }

    /// The first interface of a set that has one.
    #[inline]
    pub(crate) fn lowest(set: u16) -> Self {
        Self(set.trailing_zeros() as u8)
    }

    /// Its bit in a set of interfaces.
    #[inline]
    pub(crate) fn bit(self) -> u16 {
        1 << self.0
    }

    /// The three interfaces at the diagonal, with whether their segments *end* there, for a facet
    /// seen from outside with the center inside.
    #[inline]
    pub(crate) fn at_diagonal(diagonal: u8) -> [(Self, bool); 3] {
        let sides = [0, 1, 2].map(|axis| diagonal >> axis & 1);
        // Around (1, 1, 1) the sectors run x, y, z counter-clockwise; a mirror turns that round.
        let even = (diagonal.count_ones() & 1) == 0;
        let at = |pair: usize| {
            let (i, j) = PAIRS[pair];
            Self((4 * pair) as u8 | sides[i] << 1 | sides[j])
        };
        [(at(0), even), (at(1), !even), (at(2), even)]
    }
}

/// The ray of a diagonal: bit k of its number is set where coordinate k is negative.
#[inline]
pub(crate) fn diagonal_ray(diagonal: u8) -> Vector3<f64> {
    Vector3::from([0, 1, 2].map(|axis| 1.0 - 2.0 * f64::from(diagonal >> axis & 1)))
}

/// The diagonals, as a set of bits, inside a closed walk that crosses the interfaces of the set
/// `crossed` an odd number of times. Where a set of four and its complement both fit, the one
/// that holds diagonal 0 is returned.
#[inline]
pub(crate) fn pierced(crossed: u16) -> u8 {
    PIERCED[crossed as usize]
}

static PIERCED: [u8; 1 << Interface::COUNT] = pierced_table();

const fn pierced_table() -> [u8; 1 << Interface::COUNT] {
    let mut table = [0; 1 << Interface::COUNT];
    let mut inside: usize = 0;
    while inside < 256 {
        let mut crossed = 0;
        let mut diagonal = 0;
        while diagonal < 8 {
            if inside >> diagonal & 1 == 1 {
                let (x, y, z) = (diagonal & 1, diagonal >> 1 & 1, diagonal >> 2 & 1);
                crossed ^= 1 << (x << 1 | y);
                crossed ^= 1 << (4 | x << 1 | z);
                crossed ^= 1 << (8 | y << 1 | z);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interfaces_name_their_sectors() {
        for one in Sector::ALL {
            for other in Sector::ALL.into_iter().filter(|s| s.axis() > one.axis()) {
                assert_eq!(Interface::between(other, one).sectors(), (one, other));
                assert_eq!(Interface::between(one, other).sectors(), (one, other));
            }
        }
    }

    #[test]
    fn a_walk_around_one_diagonal_pierces_it() {
        for diagonal in 0..8 {
            let interfaces = Interface::at_diagonal(diagonal);
            let crossed = interfaces.iter().fold(0, |set, (i, _)| set ^ i.bit());
            assert_eq!(pierced(crossed), 1 << diagonal);
        }
    }

    #[test]
    fn the_sector_holds_the_largest_difference() {
        assert_eq!(Sector::of(&Vector3::new(1.0, -1.0, 1.0)), Sector::ALL[0]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, 1.0)), Sector::ALL[3]);
        assert_eq!(Sector::of(&Vector3::new(0.5, -1.0, -1.5)), Sector::ALL[5]);
    }
}
