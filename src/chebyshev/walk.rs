//! The subdivision of a piece's surface into sectors, walked edge by edge.
//!
//! A facet's part in sector S is a polygon. Its boundary consists of parts of the facet's edges
//! and of segments on interfaces. Fanned from the facet's anchor q, each directed boundary part
//! (a, b) is a signed triangle (q, a, b), and the sum over all of them is the polygon. So the walk
//! reports two things:
//! - a *share*: part of an edge within one sector, once for either facet beside it;
//! - a *segment*: part of an interface on a facet, to be counted for the sector on its left and,
//!   backwards, for the one on its right.
//!
//! Along an edge the Chebyshev distance is a convex, piecewise linear function, so the sectors
//! follow each other with growing slopes. Segments join what is found on a facet's boundary with
//! the points in which diagonals pierce the facet.

use nalgebra::Vector3;

use crate::chebyshev::chunks::{CHUNK, chosen};
use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::chebyshev::interface::{Drift, Endpoint, Mark};
use crate::chebyshev::panorama::{Panorama, VertexSight};
use crate::chebyshev::sector::Sector;
use crate::chebyshev::segments::{Endpoints, Segments, Spare, enter, report_segments};
use crate::chebyshev::sight::Sight;
use crate::chebyshev::visit::{Corner, Visit};
use crate::chebyshev::weighted::Places;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    pub(crate) panorama: Panorama,
    pub(crate) endpoints: Vec<Endpoints>,
    pub(crate) segments: Segments,
    spare: Vec<Spare>,
    /// Per facet, by which share a step of the center has last lowered the height below it.
    pub(crate) lowerings: Vec<f64>,
    /// For pieces with a density.
    pub(crate) places: Option<Places>,
}

/// Walks the surface of a piece as seen from `center` (in the piece's coordinates).
#[inline]
pub(crate) fn walk(
    piece: &Integrand,
    center: &Vector3<f64>,
    scratch: &mut WalkScratch,
    visitor: &mut impl Visit,
) {
    let WalkScratch {
        panorama,
        endpoints,
        segments,
        spare,
        ..
    } = scratch;
    panorama.take(piece, center, &Sight::of(center));
    clear(endpoints, piece.facets.len());
    let endpoints = &mut endpoints[..piece.facets.len()];
    spare.clear();
    for edges in piece.edges.chunks(CHUNK) {
        let parted = chosen(edges, |_, edge| {
            let [a, b] = panorama.ends(edge);
            a.sector != b.sector
        });
        for number in parted.others(edges.len()) {
            report_whole(piece, &edges[number], panorama, visitor);
        }
        for number in parted {
            report_parted(piece, &edges[number], panorama, (endpoints, spare), visitor);
        }
    }
    let view = |number| panorama.facet(piece, number);
    report_segments(view, endpoints, (segments, spare), visitor);
}

/// Reports an edge within one sector. The Chebyshev distance is convex along the edge, so that no other
/// sector comes between ends in the same one.
#[inline(always)]
fn report_whole(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let ends = [a, b].map(|end| Corner::new(&end.sight, a.sector));
    let sides = panorama.sides(piece, edge);
    visitor.share(&sides, a.sector, 1.0, ends.each_ref());
}

/// Reports the shares of an edge that runs through several sectors, and notes its crossings at both
/// facets.
#[inline(always)]
fn report_parted(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    (endpoints, spare): (&mut [Endpoints], &mut Vec<Spare>),
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let (from, to) = (a.sector, b.sector);
    let Some((end, mark, drift)) = only_crossing(a, b) else {
        return split_edge(piece, edge, panorama, (endpoints, spare), visitor);
    };
    let sides = panorama.sides(piece, edge);
    let between = corner(Endpoint::passing(from, to), &mark);
    let [a, b] = [a, b].map(|end| Corner::new(&end.sight, end.sector));
    visitor.share(&sides, from, end, [&a, &between]);
    visitor.share(&sides, to, 1.0 - end, [&between, &b]);
    note(edge, (from, to), (mark, drift), endpoints, spare);
}

/// Forgets the endpoints of `count` facets.
fn clear(endpoints: &mut Vec<Endpoints>, count: usize) {
    if endpoints.len() < count {
        endpoints.resize(count, Endpoints::default());
    }
    for endpoints in &mut endpoints[..count] {
        endpoints.clear();
    }
}

#[inline]
fn corner(endpoint: Endpoint, mark: &Mark) -> Corner {
    Corner {
        distance: mark.distance,
        point: endpoint.interface().point(mark),
    }
}

/// Where the edge passes from the sector of `a` to that of `b`, if no third one comes between.
///
/// That is so where both distances agree and are the largest: the Chebyshev distance is convex, so
/// a sector that has it at two points has it everywhere between them.
#[inline]
fn only_crossing(a: &VertexSight, b: &VertexSight) -> Option<(f64, Mark, Drift)> {
    let (from, to) = (a.sector, b.sector);
    let (a, b) = (&a.sight, &b.sight);
    let fall = a.distance(from) - a.distance(to);
    let rise = b.distance(to) - b.distance(from);
    let endpoint = Endpoint::passing(from, to);
    let third = endpoint.interface().third_axis();
    // Both of the mark's numbers times (fall + rise): what decides need not wait for a quotient.
    let distance = a.distance(from) * rise + b.distance(from) * fall;
    let along = a.along(third) * rise + b.along(third) * fall;
    if along.abs() > distance || from.axis() == to.axis() {
        return None;
    }
    let scale = 1.0 / (fall + rise);
    let mark = Mark {
        distance: distance * scale,
        third: along * scale,
    };
    let drift = drift_of([a, b], endpoint, scale);
    scale.is_finite().then_some((fall * scale, mark, drift))
}

/// How the crossing slides along the edge from `a` to `b`, for `scale` the inverse of how much the
/// distance of the sector ahead gains, along the whole edge, on that of the one behind.
#[inline]
fn drift_of([a, b]: [&Sight; 2], endpoint: Endpoint, scale: f64) -> Drift {
    let interface = endpoint.interface();
    let (left, third) = (interface.sectors().0, interface.third_axis());
    let scale = endpoint.signed(scale);
    Drift {
        distance: (b.distance(left) - a.distance(left)) * scale,
        third: (b.along(third) - a.along(third)) * scale,
    }
}

/// The point at `end` along the edge from `a` to `b`, on an interface of `sector`.
#[inline]
fn mark_on([a, b]: [&Sight; 2], sector: Sector, third: usize, end: f64) -> Mark {
    let between = |from: f64, to: f64| from + end * (to - from);
    Mark {
        distance: between(a.distance(sector), b.distance(sector)),
        third: between(a.along(third), b.along(third)),
    }
}

/// Enters a crossing at both facets of the edge.
#[inline(always)]
fn note(
    edge: &EdgeConstants,
    (from, to): (Sector, Sector),
    (mark, drift): (Mark, Drift),
    endpoints: &mut [Endpoints],
    spare: &mut Vec<Spare>,
) {
    let endpoint = Endpoint::passing(from, to);
    // Seen from the right it is the way back.
    for (facet, endpoint) in [(edge.left, endpoint), (edge.right, endpoint.opposite())] {
        let facet = facet as usize;
        endpoints[facet].note_drift(endpoint, drift);
        enter(facet, endpoint, mark, &mut endpoints[facet], spare);
    }
}

/// Reports an edge's shares sector by sector and notes its crossings at both facets.
#[cold]
fn split_edge(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    (endpoints, spare): (&mut [Endpoints], &mut Vec<Spare>),
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let (mut sector, goal) = (a.sector, b.sector);
    let (a, b) = (&a.sight, &b.sight);
    let sides = panorama.sides(piece, edge);
    let (mut start, mut last) = (0.0, Corner::new(a, sector));
    while sector != goal {
        let (end, following) = next_sector([a, b], sector, goal, start);
        let endpoint = Endpoint::passing(sector, following);
        let mark = mark_on([a, b], sector, endpoint.interface().third_axis(), end);
        let next = corner(endpoint, &mark);
        visitor.share(&sides, sector, end - start, [&last, &next]);
        let gain =
            b.distance(following) - a.distance(following) - b.distance(sector) + a.distance(sector);
        // Where rounding alone makes the passage, nobody can tell how it slides.
        let scale = if gain > 0.0 { 1.0 / gain } else { f64::NAN };
        let drift = drift_of([a, b], endpoint, scale);
        note(edge, (sector, following), (mark, drift), endpoints, spare);
        (start, last, sector) = (end, next, following);
    }
    visitor.share(
        &sides,
        sector,
        1.0 - start,
        [&last, &Corner::new(b, sector)],
    );
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
