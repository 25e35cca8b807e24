//! Where the sectors about a center meet.
//!
//! The six *sectors* ±x, ±y, ±z (the cones that cut fragments out of a cell) meet pairwise in twelve
//! *interfaces* (plane cones on |y_i| = |y_j|), and those in threes in eight *diagonals* (rays
//! along (±1, ±1, ±1)). As a map on the sphere this is the octahedron: sectors its vertices,
//! interfaces its edges, diagonals its faces.
//!
//! A walk around a convex polygon visits sectors; the interfaces it crosses, counted modulo two,
//! determine which diagonals pierce the polygon. `pierced` looks that up, so that a cell's
//! integrals are put together from a consistent subdivision even where rounding alone decided the
//! sector of a vertex, as it does at every corner of a cube about its center.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::mark::Mark;
use crate::chebyshev::sector::Sector;

/// The place where two sectors of different axes meet: four times the number of the pair of axes
/// (xy, xz, yz), plus two and one for the negative sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Interface(u8);

/// The pairs of axes i < j between which interfaces lie.
pub(crate) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Per interface: +1 where its two axes' directions and the third axis are right-handed, else −1.
pub(crate) const TURNS: [f64; Interface::SLOTS] = [
    1.0, -1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
];

impl Interface {
    /// How many there are.
    pub(crate) const COUNT: usize = 12;

    /// The length of tables by number, which need no check of bounds then.
    pub(crate) const SLOTS: usize = 16;

    /// In place of one where there is none: all determinants are zero.
    pub(crate) const NONE: Self = Self(Self::COUNT as u8);

    /// The two sectors: the one of the smaller axis first. That one is *left* of the interface's
    /// segments, seen from outside the facet on which they lie.
    #[inline]
    pub(crate) fn sectors(self) -> (Sector, Sector) {
        SECTORS[self.number()]
    }

    /// The axis of neither sector.
    #[inline]
    pub(crate) fn third_axis(self) -> usize {
        2 - (self.0 >> 2) as usize
    }

    /// The displacement of a point of the interface.
    #[inline]
    pub(crate) fn point(self, mark: &Mark) -> Vector3<f64> {
        let (left, right) = self.sectors();
        let mut point = Vector3::zeros();
        point[left.axis()] = left.sign() * mark.distance;
        point[right.axis()] = right.sign() * mark.distance;
        point[self.third_axis()] = mark.third;
        point
    }

    /// The mark of a point near the interface.
    pub(crate) fn mark(self, point: &Vector3<f64>) -> Mark {
        Mark {
            distance: self.sectors().0.distance(point),
            third: point[self.third_axis()],
        }
    }

    /// What makes u × v of two points of the interface D (left − right), left and right the
    /// gradients of its sectors' distances. The triangle of u and v with the center has the area
    /// D/√2, and six times the volume of its tetrahedron with q is D (left(q) − right(q)).
    #[inline]
    pub(crate) fn determinant(self, u: &Mark, v: &Mark) -> f64 {
        self.turn() * (u.distance * v.third - u.third * v.distance)
    }

    /// For four interfaces the signs of their first and of their second sectors, their turns, and the
    /// numbers of their pairs of axes.
    #[inline(always)]
    pub(crate) fn lanes(four: [Self; 4]) -> [f64x4; 4] {
        f64x4::transpose(four.map(|interface| f64x4::new(LANES[interface.number()])))
    }

    /// See [`TURNS`].
    #[inline]
    pub(crate) fn turn(self) -> f64 {
        TURNS[self.number()]
    }

    /// Its place among all.
    #[inline]
    pub(crate) fn number(self) -> usize {
        usize::from(self.0) % Self::SLOTS
    }

    /// The one of a number.
    #[inline]
    pub(crate) fn of_number(number: usize) -> Self {
        Self(number as u8)
    }
}

/// See [`Interface::lanes`].
static LANES: [[f64; 4]; Interface::SLOTS] = lanes_table();

const fn lanes_table() -> [[f64; 4]; Interface::SLOTS] {
    let mut table = [[0.0; 4]; Interface::SLOTS];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let signs = [interface >> 1 & 1, interface & 1];
        table[interface] = [
            1.0 - 2.0 * signs[0] as f64,
            1.0 - 2.0 * signs[1] as f64,
            TURNS[interface],
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

/// The diagonals, as a set of bits, inside a closed walk that crosses the interfaces of the set
/// `crossed` an odd number of times. Where a set of four and its complement both fit, the one
/// that holds diagonal 0 is returned.
#[inline]
pub(crate) fn pierced(crossed: u32) -> u8 {
    PIERCED[crossed as usize & ((1 << Interface::COUNT) - 1)]
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
    use crate::chebyshev::endpoint::Endpoint;

    #[test]
    fn a_passage_and_the_way_back_are_the_two_ends_of_one_interface() {
        for one in Sector::ALL {
            for other in Sector::ALL.into_iter().filter(|s| s.axis() > one.axis()) {
                let start = Endpoint::passing(one, other);
                assert!(start.is_start());
                assert_eq!(start.interface().sectors(), (one, other));
                assert_eq!(Endpoint::passing(other, one), start.opposite());
            }
        }
    }

    #[test]
    fn a_walk_around_one_diagonal_pierces_it() {
        for diagonal in 0..8 {
            let endpoints = &Endpoint::at_diagonal(diagonal, true).endpoints;
            let crossed = endpoints.iter().fold(0, |set, (endpoint, _)| {
                set ^ 1 << endpoint.interface().number()
            });
            assert_eq!(pierced(crossed), 1 << diagonal);
        }
    }

    #[test]
    fn marks_and_points_are_two_ways_to_tell_the_same() {
        for diagonal in 0..8 {
            for (endpoint, sign) in &Endpoint::at_diagonal(diagonal, false).endpoints {
                let mark = Mark {
                    distance: 2.0,
                    third: 2.0 * sign,
                };
                let point = endpoint.interface().point(&mark);
                assert_eq!(point, 2.0 * diagonal_ray(diagonal));
                let again = endpoint.interface().mark(&point);
                assert_eq!((again.distance, again.third), (mark.distance, mark.third));
            }
        }
    }

    #[test]
    fn determinants_measure_the_cross_product() {
        for diagonal in 0..8 {
            for (endpoint, _) in &Endpoint::at_diagonal(diagonal, false).endpoints {
                let interface = endpoint.interface();
                let [u, v] =
                    [(1.0, 0.25), (3.0, -2.0)].map(|(distance, third)| Mark { distance, third });
                let cross = interface.point(&u).cross(&interface.point(&v));
                let (left, right) = interface.sectors();
                let normal = |sector: Sector| {
                    Vector3::from([0, 1, 2].map(|k| {
                        if k == sector.axis() {
                            sector.sign()
                        } else {
                            0.0
                        }
                    }))
                };
                let told = (normal(left) - normal(right)) * interface.determinant(&u, &v);
                assert_eq!(cross, told);
            }
        }
    }
}
