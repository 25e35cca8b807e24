//! Where an edge passes from one sector to another.

use wide::f64x2;

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::interface::Endpoint;
use crate::chebyshev::mark::{Drift, Mark};
use crate::chebyshev::panorama::VertexSight;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::Sight;

/// Where an edge passes from one sector's distance to another's, times what the one gains on the
/// other along the whole edge: what decides need not wait for a quotient.
pub(crate) struct Crossing {
    pub(crate) endpoint: Endpoint,
    /// By how much the one behind is ahead at the edge's start (L).
    fall: f64,
    /// By how much it is behind at the edge's end (L).
    rise: f64,
    /// The point's distance, and its coordinate along the third axis (L²).
    point: f64x2,
}

impl Crossing {
    #[inline(always)]
    pub(crate) fn new([a, b]: [&Sight; 2], [from, to]: [Sector; 2]) -> Self {
        let fall = a.distance(from) - a.distance(to);
        let rise = b.distance(to) - b.distance(from);
        let endpoint = Endpoint::passing(from, to);
        let third = endpoint.interface().third_axis();
        let [a, b] = [a, b].map(|end| end.mark(from, third));
        Self {
            endpoint,
            fall,
            rise,
            point: a * f64x2::splat(rise) + b * f64x2::splat(fall),
        }
    }

    /// Whether both distances are the largest where they agree. Then no third sector comes between:
    /// the Chebyshev distance is convex, so a sector that has it at two points has it all between.
    #[inline]
    pub(crate) fn is_undisturbed(&self) -> bool {
        let [distance, along] = self.point.to_array();
        along.abs() <= distance
    }

    /// Which share of the edge lies behind, and the point; if that can be told.
    #[inline(always)]
    pub(crate) fn found(&self, ends: [&Sight; 2]) -> Option<(f64, Found)> {
        let scale = 1.0 / (self.fall + self.rise);
        let mark = Mark::of(self.point * f64x2::splat(scale));
        let drift = drift_of(ends, self.endpoint, scale);
        scale
            .is_finite()
            .then_some((self.fall * scale, Found { mark, drift }))
    }
}

/// The sector between those of `a` and `b`, and where it begins and ends, if there is just one and
/// that can be told.
///
/// Where the distances of the sectors at the ends agree, one of the third axis is larger: so its
/// sector comes between. With convexity, no other does unless that distance is negative.
#[inline]
pub(crate) fn two_crossings(
    a: &VertexSight,
    b: &VertexSight,
) -> Option<(Sector, [(f64, Found); 2])> {
    let (from, to) = (a.sector(), b.sector());
    let ends = [a.sight(), b.sight()];
    if from.axis() == to.axis() {
        return None;
    }
    let direct = Crossing::new(ends, [from, to]);
    let [distance, along] = direct.point.to_array();
    if direct.is_undisturbed() || distance < 0.0 {
        return None;
    }
    let axis = direct.endpoint.interface().third_axis();
    let third = Sector::ALL[2 * axis + usize::from(along < 0.0)];
    let [one, other] = [[from, third], [third, to]].map(|pair| Crossing::new(ends, pair));
    let are_sound = one.rise >= 0.0 && other.fall >= 0.0;
    let (one, other) = (one.found(ends)?, other.found(ends)?);
    (are_sound && one.0 <= other.0).then_some((third, [one, other]))
}

/// How the crossing slides along the edge from `a` to `b`, for `scale` the inverse of how much the
/// distance of the sector ahead gains, along the whole edge, on that of the one behind.
#[inline]
pub(crate) fn drift_of([a, b]: [&Sight; 2], endpoint: Endpoint, scale: f64) -> Drift {
    let interface = endpoint.interface();
    let (left, third) = (interface.sectors().0, interface.third_axis());
    let slide = b.mark(left, third) - a.mark(left, third);
    let [distance, third] = (slide * f64x2::splat(endpoint.signed(scale))).to_array();
    Drift { distance, third }
}

/// The point at `end` along the edge from `a` to `b`, on an interface of `sector`.
#[inline]
pub(crate) fn mark_on([a, b]: [&Sight; 2], sector: Sector, third: usize, end: f64) -> Mark {
    let [a, b] = [a, b].map(|end| end.mark(sector, third));
    Mark::of(a + f64x2::splat(end) * (b - a))
}

/// Where along the edge from `a` to `b`, not before `start`, `sector` ends, and which sector
/// follows it on the way to `goal`.
///
/// Slopes grow from sector to sector, so at most five steps are made. Where rounding has put the
/// goal beyond the end of the edge, it is reached there by way of sectors that touch.
pub(crate) fn next_sector(
    [a, b]: [&Sight; 2],
    sector: Sector,
    goal: Sector,
    start: f64,
) -> (f64, Sector) {
    let value = a.distance(sector);
    let slope = b.distance(sector) - value;
    let others = sector.beside();
    // Which one comes first is what a processor cannot foresee: it is looked up.
    let meets = others.map(|other| {
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

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// The sectors along an edge, and where they end.
    fn walked([a, b]: [&Sight; 2], from: Sector, to: Sector) -> Vec<(f64, Sector)> {
        let (mut all, mut end, mut sector) = (Vec::new(), 0.0, from);
        while sector != to {
            let (next, following) = next_sector([a, b], sector, to, end);
            all.push((next, sector));
            (end, sector) = (next, following);
        }
        all
    }

    #[test]
    fn one_or_two_crossings_are_those_of_a_walk() {
        let mut known = [0, 0];
        for number in 0..2000 {
            let point =
                |turn: f64| Vector3::new(turn.sin(), (1.7 * turn).cos(), (2.3 * turn).sin());
            let ends = [f64::from(number), f64::from(number) * 1.37 + 1.0].map(point);
            let [from, to] = ends.each_ref().map(Sector::of);
            if from == to {
                continue;
            }
            let sights = ends.each_ref().map(Sight::of);
            let walked = walked(sights.each_ref(), from, to);
            let direct = Crossing::new(sights.each_ref(), [from, to]);
            let [a, b] = ends.each_ref().map(VertexSight::of);
            if from.axis() != to.axis() && direct.is_undisturbed() {
                let (end, found) = direct.found([a.sight(), b.sight()]).expect("it is sound");
                let point = direct.endpoint.interface().point(&found.mark);
                assert_eq!(walked.len(), 1, "{number}");
                assert!((walked[0].0 - end).abs() < 1e-14, "{number}");
                assert!(
                    (ends[0].lerp(&ends[1], end) - point).amax() < 1e-14,
                    "{number}"
                );
                known[0] += 1;
            } else if let Some((third, [one, other])) = two_crossings(&a, &b) {
                assert_eq!([walked[0].1, walked[1].1], [from, third], "{number}");
                assert_eq!(walked.len(), 2, "{number}");
                assert!((walked[0].0 - one.0).abs() < 1e-14, "{number}");
                assert!((walked[1].0 - other.0).abs() < 1e-14, "{number}");
                known[1] += 1;
            } else {
                assert!(walked.len() > 2 || from.axis() == to.axis(), "{number}");
            }
        }
        assert!(known[0] > 500 && known[1] > 200, "{known:?}");
    }
}
