//! Interfaces four at a time.

use crate::chebyshev::endpoint::AT_DIAGONAL;
use crate::chebyshev::interface::{Interface, PAIRS, TURNS};

/// The four interfaces between the sectors of two axes, side by side.
#[derive(Clone, Copy)]
pub(crate) struct Family {
    /// The axes of their first and of their second sectors, and the third axis.
    pub(crate) axes: [usize; 3],
    /// The signs of their first and of their second sectors.
    pub(crate) signs: [[f64; 4]; 2],
    /// See [`Interface::determinant`].
    pub(crate) turns: [f64; 4],
    /// The diagonals at the start and at the end of their segments on a surface about the center.
    pub(crate) diagonals: [[usize; 4]; 2],
    /// The signs of these along the third axis.
    pub(crate) along: [[f64; 4]; 2],
}

impl Family {
    /// How many interfaces it has.
    pub(crate) const SIZE: usize = 4;

    /// All of them, by the number of their first interface.
    #[inline]
    pub(crate) fn all() -> impl Iterator<Item = (usize, &'static Self)> {
        (0..).step_by(Self::SIZE).zip(&FAMILIES)
    }
}

static FAMILIES: [Family; PAIRS.len()] = families_table();

const fn families_table() -> [Family; PAIRS.len()] {
    let none = Family {
        axes: [0; 3],
        signs: [[0.0; 4]; 2],
        turns: [0.0; 4],
        diagonals: [[0; 4]; 2],
        along: [[0.0; 4]; 2],
    };
    let mut table = [none; PAIRS.len()];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let (family, place) = (interface / Family::SIZE, interface % Family::SIZE);
        let (i, j) = PAIRS[family];
        table[family].axes = [i, j, 3 - i - j];
        table[family].signs[0][place] = 1.0 - 2.0 * (place >> 1) as f64;
        table[family].signs[1][place] = 1.0 - 2.0 * (place & 1) as f64;
        table[family].turns[place] = TURNS[interface];
        interface += 1;
    }
    let mut entry = 0;
    while entry < 24 {
        let (endpoint, sign) = AT_DIAGONAL[1][entry / 3].endpoints[entry % 3];
        let interface = endpoint.number() % Interface::SLOTS;
        let (family, place) = (interface / Family::SIZE, interface % Family::SIZE);
        let end = endpoint.number() / Interface::SLOTS;
        table[family].diagonals[end][place] = entry / 3;
        table[family].along[end][place] = sign;
        entry += 1;
    }
    table
}
