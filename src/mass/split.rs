//! Splitting of a tetrahedron by a plane into tetrahedra (\[BL\] Appendix B, Fig. 16).
//!
//! By the number of corners on either side, and on the plane, there are four cases:
//!
//! ```text
//! 1|3       a │ bcd      one tetrahedron and a prism          1 + 3
//! 2|2      ab │ cd       two prisms                           3 + 3
//! 1|(1)|2   a │(z)│ cd   one tetrahedron and a pyramid        1 + 2
//! 1|(2)|1   a │(yz)│ d   two tetrahedra                       1 + 1
//! ```
//!
//! Prisms and pyramids fall into tetrahedra along diagonals of their four-sided faces. Where
//! such a face lies in a face of the tetrahedron, the diagonal starts at its corner of the lower
//! id: a neighbor that shares the face makes the same choice, so a mesh stays conforming.
//!
//! Only the combinatorics are computed here: pieces are given by corners and cut edges, so the same split
//! serves positions, densities and whole meshes. Every piece is oriented as the tetrahedron is;
//! the orders of corners below were fixed by their determinants in barycentric coordinates.

use crate::arrays::MapEach;

/// Where a corner lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// At a negative distance.
    Below,
    /// On the plane exactly.
    On,
    /// At a positive distance.
    Above,
}

impl Side {
    /// By the sign of a signed distance; −0 is on the plane.
    #[must_use]
    pub fn of(distance: f64) -> Self {
        if distance < 0.0 {
            Self::Below
        } else if distance > 0.0 {
            Self::Above
        } else {
            Self::On
        }
    }

    fn opposite(self) -> Self {
        match self {
            Self::Below => Self::Above,
            Self::On => Self::On,
            Self::Above => Self::Below,
        }
    }
}

/// A corner of a piece: `[i, i]` the tetrahedron's corner i, `[i, j]` with i ≠ j the point where
/// the plane cuts its edge, the corner of lower id first.
pub type Node = [usize; 2];

/// A piece: its side and its corners.
pub type TetPiece = (Side, [Node; 4]);

/// Splits a tetrahedron whose corners lie on these `sides` and have these distinct `ids`; `None`
/// if the plane does not pass through its interior.
#[must_use]
pub fn split(sides: [Side; 4], ids: [u32; 4]) -> Option<Vec<TetPiece>> {
    let count = |wanted: Side| sides.iter().filter(|&&side| side == wanted).count();
    // The smaller side comes first, then the plane's corners, then the larger side.
    let small = smaller(count(Side::Below), count(Side::Above))?;
    let large = small.opposite();
    let mut order = [0, 1, 2, 3];
    let rank = |side: Side| [small, Side::On, large].iter().position(|&s| s == side);
    order.sort_by_key(|&corner| (rank(sides[corner]), ids[corner]));
    let pieces = match (count(small), count(Side::On)) {
        (1, 0) => one_against_three(small, large),
        (2, _) => two_against_two(small, large),
        (_, 1) => one_on_plane(small, large),
        _ => two_on_plane(small, large),
    };
    let odd = is_odd(order);
    let pieces = pieces.into_iter();
    Some(
        pieces
            .map(|piece| renamed(piece, order, odd, ids))
            .collect(),
    )
}

/// The side with fewer corners, if both have some.
fn smaller(below: usize, above: usize) -> Option<Side> {
    match (below, above) {
        (0, _) | (_, 0) => None,
        _ if below <= above => Some(Side::Below),
        _ => Some(Side::Above),
    }
}

/// a │ b c d, in terms of the sorted corners 0 │ 1 2 3.
fn one_against_three(small: Side, large: Side) -> Vec<TetPiece> {
    let [a, b, c, d] = CORNERS;
    let [ab, ac, ad] = [[0, 1], [0, 2], [0, 3]];
    vec![
        (small, [a, ab, ac, ad]),
        (large, [ab, ac, ad, b]),
        (large, [b, ac, ad, c]),
        (large, [b, c, ad, d]),
    ]
}

/// a b │ c d. The cut's own quadrilateral is split along ac-bd on both sides.
fn two_against_two(small: Side, large: Side) -> Vec<TetPiece> {
    let [a, b, c, d] = CORNERS;
    let [ac, ad, bc, bd] = [[0, 2], [0, 3], [1, 2], [1, 3]];
    vec![
        (small, [a, ac, ad, bd]),
        (small, [a, ac, bd, bc]),
        (small, [a, b, bc, bd]),
        (large, [c, ad, ac, bd]),
        (large, [c, bd, ac, bc]),
        (large, [c, d, ad, bd]),
    ]
}

/// a │ (z) │ c d.
fn one_on_plane(small: Side, large: Side) -> Vec<TetPiece> {
    let [a, z, c, d] = CORNERS;
    let [ac, ad] = [[0, 2], [0, 3]];
    vec![
        (small, [a, z, ac, ad]),
        (large, [c, z, d, ad]),
        (large, [c, z, ad, ac]),
    ]
}

/// a │ (y z) │ d.
fn two_on_plane(small: Side, large: Side) -> Vec<TetPiece> {
    let [a, y, z, d] = CORNERS;
    let ad = [0, 3];
    vec![(small, [a, y, z, ad]), (large, [ad, y, z, d])]
}

const CORNERS: [Node; 4] = [[0, 0], [1, 1], [2, 2], [3, 3]];

/// A piece in terms of the tetrahedron's own corners, oriented as it is.
fn renamed((side, mut nodes): TetPiece, order: [usize; 4], odd: bool, ids: [u32; 4]) -> TetPiece {
    for node in &mut nodes {
        *node = node.map_each(|corner| order[corner]);
        node.sort_by_key(|&corner| ids[corner]);
    }
    if odd {
        nodes.swap(0, 1);
    }
    (side, nodes)
}

fn is_odd(order: [usize; 4]) -> bool {
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    pairs.iter().filter(|&&(i, j)| order[i] > order[j]).count() % 2 == 1
}
