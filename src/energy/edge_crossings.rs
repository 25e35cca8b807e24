//! Crossings of one edge with the boundaries between sectors, by the upper envelope of six linear functions.
//!
//! Along an edge the Chebyshev distance is the largest of six linear functions: convex and piecewise
//! linear, so that sectors follow each other with growing slopes. `edge_crossings_simd` finds most
//! crossings of four edges at once.

use nalgebra::Vector3;
use wide::f64x4;

use crate::arrays::MapEach;
use crate::energy::sector::{InterfaceEnd, Sector, SegmentEnd};

/// Where an edge crosses into another sector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeCrossing {
    /// That sector.
    pub(crate) to: Sector,
    /// The share of the edge before the crossing.
    pub(crate) share: f64,
    /// The segment that ends there on the facet left of the edge.
    pub(crate) end: InterfaceEnd,
    /// The point, and how it moves along the edge.
    pub(crate) at: SegmentEnd,
    /// Whether rounding alone makes the crossing, so that its edge velocity is meaningless.
    pub(crate) is_rounded: bool,
}

/// A displacement as x, y, z, −x, −y, −z, so that a sector's number indexes its distance.
#[derive(Clone, Copy, Debug)]
struct SignedCoordinates([f64; Sector::SLOTS]);

impl SignedCoordinates {
    #[inline]
    fn of(displacement: &Vector3<f64>) -> Self {
        let [x, y, z] = (*displacement).into();
        Self([x, y, z, 0.0, -x, -y, -z, 0.0])
    }

    /// The value of the sector's distance function (L).
    #[inline]
    fn distance(&self, sector: Sector) -> f64 {
        self.0[sector.number()]
    }

    /// The coordinates of an interface: the distance in a sector of it, and along its third axis (L).
    #[inline]
    fn on_interface(&self, sector: Sector, third: usize) -> [f64; 2] {
        [self.distance(sector), self.0[third % Sector::SLOTS]]
    }
}

/// All crossings of the edge between two displacements from the center, in order.
pub(crate) fn edge_crossings(ends: [&Vector3<f64>; 2]) -> impl Iterator<Item = EdgeCrossing> {
    let [mut sector, goal] = ends.map_each(Sector::of);
    let [a, b] = ends.map_each(SignedCoordinates::of);
    let mut start = 0.0;
    std::iter::from_fn(move || {
        if sector == goal {
            return None;
        }
        let (share, to) = next_sector([&a, &b], sector, goal, start);
        let crossing = EdgeCrossing::new([&a, &b], [sector, to], share);
        (sector, start) = (to, share);
        Some(crossing)
    })
}

impl EdgeCrossing {
    /// The crossing between two sectors on the edge from `a` to `b`.
    #[inline]
    fn new([a, b]: [&SignedCoordinates; 2], [sector, to]: [Sector; 2], share: f64) -> Self {
        let end = InterfaceEnd::crossing(sector, to);
        let (interface, is_start) = (end.interface(), end.is_start());
        let (left, third) = (interface.sectors().0, interface.third_axis());
        let [from, until] = [a, b].map_each(|end| end.on_interface(sector, third));
        let gain = b.distance(to) - a.distance(to) - b.distance(sector) + a.distance(sector);
        let scale = if is_start { 1.0 } else { -1.0 } / gain;
        let [one, other] = [a, b].map_each(|end| end.on_interface(left, third));
        let at = [
            from[0] + share * (until[0] - from[0]),
            from[1] + share * (until[1] - from[1]),
            (other[0] - one[0]) * scale,
            (other[1] - one[1]) * scale,
        ];
        Self {
            to,
            share,
            end,
            at: SegmentEnd(f64x4::new(at)),
            is_rounded: gain <= 0.0,
        }
    }
}

/// Where along the edge from `a` to `b`, not before `start`, `sector` ends, and which sector
/// follows it on the way to `goal`.
///
/// Slopes grow from sector to sector, so at most five steps are made. Where rounding has put the
/// goal beyond the end of the edge, it is reached there by way of sectors that touch.
fn next_sector(
    [a, b]: [&SignedCoordinates; 2],
    sector: Sector,
    goal: Sector,
    start: f64,
) -> (f64, Sector) {
    let value = a.distance(sector);
    let slope = b.distance(sector) - value;
    let others = sector.adjacent();
    // Which one comes first cannot be predicted by a processor: so it is selected without a branch.
    let meets = others.map_each(|other| {
        let other_value = a.distance(other);
        let gain = b.distance(other) - other_value - slope;
        let meet = (value - other_value) / gain;
        if gain > 0.0 { meet } else { f64::INFINITY }
    });
    let one = usize::from(meets[1] < meets[0]);
    let other = 2 + usize::from(meets[3] < meets[2]);
    let first = [one, other][usize::from(meets[other] < meets[one])];
    if meets[first] < 1.0 {
        (meets[first].max(start), others[first])
    } else if goal.axis() != sector.axis() {
        (1.0, goal)
    } else {
        // The opposite sector is the goal: go through the first one of another axis.
        (1.0, others[0])
    }
}
