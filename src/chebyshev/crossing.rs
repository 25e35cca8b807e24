//! Where an edge passes from one sector to another.

use wide::f64x2;

use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::mark::Mark;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::{Sight, VertexSight};
use crate::chebyshev::visit::Corner;

/// Where an edge passes into another sector.
#[derive(Clone, Copy)]
pub(crate) struct Passage {
    /// That sector.
    pub(crate) to: Sector,
    /// The share of the edge that lies behind.
    pub(crate) share: f64,
    /// What the point is for the facet on the left.
    pub(crate) endpoint: Endpoint,
    /// Where the point is.
    pub(crate) found: Found,
    /// Whether rounding alone makes the passage, so that nobody can tell how it slides.
    pub(crate) is_rounded: bool,
}

impl Passage {
    /// Where it is, for a share.
    #[inline]
    pub(crate) fn corner(&self) -> Corner {
        let Found { mark, .. } = &self.found;
        Corner {
            distance: mark.distance,
            point: self.endpoint.interface().point(mark),
        }
    }

    /// The passage from the sector of `a` to that of `b`, if it is the only one and can be told.
    #[inline(always)]
    pub(crate) fn only(a: &VertexSight, b: &VertexSight) -> Option<Self> {
        let (from, to) = (a.sector(), b.sector());
        let ends = [a.sight(), b.sight()];
        let crossing = Crossing::new(ends, [from, to]);
        let is_only = crossing.is_undisturbed() && from.axis() != to.axis();
        is_only.then(|| crossing.passage(ends, to)).flatten()
    }

    /// All passages on the way to the sector of `b`, step by step.
    pub(crate) fn all(a: &VertexSight, b: &VertexSight) -> impl Iterator<Item = Self> {
        let (mut sector, goal) = (a.sector(), b.sector());
        let (a, b) = (a.sight(), b.sight());
        let mut start = 0.0;
        std::iter::from_fn(move || {
            if sector == goal {
                return None;
            }
            let (share, to) = next_sector([a, b], sector, goal, start);
            let endpoint = Endpoint::passing(sector, to);
            let mark = mark_on([a, b], sector, endpoint.interface().third_axis(), share);
            let gain = b.distance(to) - a.distance(to) - b.distance(sector) + a.distance(sector);
            let drift = drift_of([a, b], endpoint, 1.0 / gain);
            (sector, start) = (to, share);
            Some(Self {
                to,
                share,
                endpoint,
                found: Found { mark, drift },
                is_rounded: gain <= 0.0,
            })
        })
    }
}

/// Where two sectors' distances agree along an edge, times what the one gains on the other along all
/// of it: what decides need not wait for a quotient.
struct Crossing {
    endpoint: Endpoint,
    /// By how much the one behind is ahead at the edge's start (L).
    fall: f64,
    /// By how much it is behind at the edge's end (L).
    rise: f64,
    /// The point's distance, and its coordinate along the third axis (L²).
    point: f64x2,
}

impl Crossing {
    #[inline(always)]
    fn new([a, b]: [&Sight; 2], [from, to]: [Sector; 2]) -> Self {
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
    fn is_undisturbed(&self) -> bool {
        let [distance, along] = self.point.to_array();
        along.abs() <= distance
    }

    /// The passage, if it can be told.
    #[inline(always)]
    fn passage(&self, ends: [&Sight; 2], to: Sector) -> Option<Passage> {
        let scale = 1.0 / (self.fall + self.rise);
        let mark = Mark::of(self.point * f64x2::splat(scale));
        let drift = drift_of(ends, self.endpoint, scale);
        scale.is_finite().then_some(Passage {
            to,
            share: self.fall * scale,
            endpoint: self.endpoint,
            found: Found { mark, drift },
            is_rounded: false,
        })
    }
}

/// How the crossing slides along the edge from `a` to `b`, for `scale` the inverse of how much the
/// distance of the sector ahead gains, along the whole edge, on that of the one behind.
#[inline]
fn drift_of([a, b]: [&Sight; 2], endpoint: Endpoint, scale: f64) -> Mark {
    let interface = endpoint.interface();
    let (left, third) = (interface.sectors().0, interface.third_axis());
    let slide = b.mark(left, third) - a.mark(left, third);
    Mark::of(slide * f64x2::splat(endpoint.signed(scale)))
}

/// The point at `end` along the edge from `a` to `b`, on an interface of `sector`.
#[inline]
fn mark_on([a, b]: [&Sight; 2], sector: Sector, third: usize, end: f64) -> Mark {
    let [a, b] = [a, b].map(|end| end.mark(sector, third));
    Mark::of(a + f64x2::splat(end) * (b - a))
}

/// Where along the edge from `a` to `b`, not before `start`, `sector` ends, and which sector
/// follows it on the way to `goal`.
///
/// Slopes grow from sector to sector, so at most five steps are made. Where rounding has put the
/// goal beyond the end of the edge, it is reached there by way of sectors that touch.
fn next_sector([a, b]: [&Sight; 2], sector: Sector, goal: Sector, start: f64) -> (f64, Sector) {
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
    use crate::chebyshev::chunks::Bits;
    use crate::chebyshev::detours::Detours;
    use crate::chebyshev::four::FourEdges;
    use crate::chebyshev::integrand::Integrand;
    use crate::chebyshev::seen::Seen;
    use crate::geometry::brep::Edge;
    use crate::geometry::small_polyhedron::BLOCK;

    /// What a walk step by step finds, and what is told, agree.
    fn compare(ends: &[Vector3<f64>; 2], told: &[Passage]) {
        let [a, b] = ends.each_ref().map(VertexSight::of);
        let all: Vec<_> = Passage::all(&a, &b).collect();
        assert_eq!(told.len(), all.len(), "{ends:?}");
        for (one, other) in told.iter().zip(&all) {
            let are_same = (one.to, one.endpoint) == (other.to, other.endpoint);
            assert!(are_same, "{ends:?}");
            assert!((one.share - other.share).abs() < 1e-14, "{ends:?}");
            let point = one.endpoint.interface().point(&one.found.mark);
            let there = ends[0].lerp(&ends[1], one.share);
            assert!((there - point).amax() < 1e-14, "{ends:?}");
            let [drift, other] = [one, other].map(|passage| passage.found.drift);
            assert!((drift.distance - other.distance).abs() < 1e-9 * (1.0 + other.distance.abs()));
            assert!((drift.third - other.third).abs() < 1e-9 * (1.0 + other.third.abs()));
        }
    }

    #[test]
    fn passages_told_four_at_a_time_are_those_of_a_walk() {
        let (mut known, mut far) = ([0; 3], 0);
        for number in 0..500 {
            let point =
                |turn: f64| Vector3::new(turn.sin(), (1.7 * turn).cos(), (2.3 * turn).sin());
            let ends = [0, 1, 2, 3].map(|lane| {
                let turn = f64::from(BLOCK as u32 * number + lane);
                [turn, turn * 1.37 + 1.0].map(point)
            });
            let mut piece = Integrand::default();
            piece
                .vertices
                .assign(ends.as_flattened().iter().map(|&end| end.into()));
            let edges = [0, 2, 4, 6].map(|from| Edge {
                from,
                to: from + 1,
                left: 0,
                right: 0,
            });
            let seen = Seen {
                piece: &piece,
                center: &Vector3::zeros(),
            };
            let four = FourEdges::new(&seen, &edges);
            let [told, others] = four.told_and_far();
            let one = four.passages.alone(&four.sectors);
            for lane in Bits::of(told) {
                compare(&ends[lane], &[one[lane]]);
                known[1] += 1;
            }
            let detours = Detours::new(&four);
            let by_way = u64::from(detours.are_told.to_bitmask());
            let sectors = detours.sectors(&four);
            let [into, out] = [0, 1].map(|k: usize| detours.passages[k].alone(&sectors[k]));
            for lane in Bits::of(others & by_way) {
                compare(&ends[lane], &[into[lane], out[lane]]);
                known[2] += 1;
            }
            for lane in Bits::of(!(told | others) & 0b1111) {
                compare(&ends[lane], &[]);
                known[0] += 1;
            }
            far += (others & !by_way).count_ones();
        }
        assert!(
            known[0] > 100 && known[1] > 500 && known[2] > 200,
            "{known:?}"
        );
        assert!(far > 0, "opposite sectors are left to a walk");
    }

    #[test]
    fn a_passage_told_alone_is_that_of_a_walk() {
        let mut known = 0;
        for number in 0..1000 {
            let point =
                |turn: f64| Vector3::new(turn.sin(), (1.7 * turn).cos(), (2.3 * turn).sin());
            let ends = [f64::from(number), f64::from(number) * 1.37 + 1.0].map(point);
            let [a, b] = ends.each_ref().map(VertexSight::of);
            if let Some(passage) = Passage::only(&a, &b).filter(|_| a.sector() != b.sector()) {
                compare(&ends, &[passage]);
                known += 1;
            }
        }
        assert!(known > 200, "{known}");
    }
}
