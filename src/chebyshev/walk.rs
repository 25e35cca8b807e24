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
use crate::chebyshev::crossing::{Crossing, drift_of, mark_on, next_sector, two_crossings};
use crate::chebyshev::endpoints::{Endpoints, Found};
use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::chebyshev::interface::Endpoint;
use crate::chebyshev::mark::Mark;
use crate::chebyshev::panorama::Panorama;
use crate::chebyshev::segments::{Segments, report_segments};
use crate::chebyshev::visit::{Corner, Visit};
use crate::chebyshev::weighted::Places;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    pub(crate) panorama: Panorama,
    pub(crate) endpoints: Endpoints,
    pub(crate) segments: Segments,
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
        ..
    } = scratch;
    panorama.take(piece, center);
    endpoints.reset(piece.facets.len());
    for edges in piece.edges.chunks(CHUNK) {
        let parted = chosen(edges, |_, edge| {
            let [a, b] = panorama.ends(edge);
            a.sector() != b.sector()
        });
        for number in parted.others(edges.len()) {
            report_whole(piece, &edges[number], panorama, visitor);
        }
        for number in parted {
            report_parted(piece, &edges[number], panorama, endpoints, visitor);
        }
    }
    let view = |number| panorama.facet(piece, number);
    report_segments(view, endpoints, segments, visitor);
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
    let ends = [a, b].map(|end| Corner::new(end.sight(), a.sector()));
    let sides = panorama.sides(piece, edge);
    visitor.share(&sides, a.sector(), 1.0, ends.each_ref());
}

/// Reports the shares of an edge that runs through several sectors, and notes its crossings at both
/// facets.
#[inline(always)]
fn report_parted(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    endpoints: &mut Endpoints,
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let (from, to) = (a.sector(), b.sector());
    let (a, b) = (a.sight(), b.sight());
    let crossing = Crossing::new([a, b], [from, to]);
    let is_only = crossing.is_undisturbed() && from.axis() != to.axis();
    let Some((end, found)) = is_only.then(|| crossing.found([a, b])).flatten() else {
        return report_far_parted(piece, edge, panorama, endpoints, visitor);
    };
    let sides = panorama.sides(piece, edge);
    let between = corner(crossing.endpoint, &found.mark);
    let [a, b] = [(a, from), (b, to)].map(|(end, sector)| Corner::new(end, sector));
    visitor.share(&sides, from, end, [&a, &between]);
    visitor.share(&sides, to, 1.0 - end, [&between, &b]);
    note(edge, crossing.endpoint, found, endpoints);
}

/// As [`report_parted`], where more than two sectors may be on the way.
#[inline(never)]
fn report_far_parted(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    endpoints: &mut Endpoints,
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let Some((third, [one, other])) = two_crossings(a, b) else {
        return split_edge(piece, edge, panorama, endpoints, visitor);
    };
    let (from, to) = (a.sector(), b.sector());
    let sides = panorama.sides(piece, edge);
    let [a, b] = [a, b].map(|end| Corner::new(end.sight(), end.sector()));
    let crossings = [(from, third, one), (third, to, other)];
    let [first, second] = crossings.map(|(from, to, (_, found))| {
        let endpoint = Endpoint::passing(from, to);
        note(edge, endpoint, found, endpoints);
        corner(endpoint, &found.mark)
    });
    visitor.share(&sides, from, one.0, [&a, &first]);
    visitor.share(&sides, third, other.0 - one.0, [&first, &second]);
    visitor.share(&sides, to, 1.0 - other.0, [&second, &b]);
}

#[inline]
fn corner(endpoint: Endpoint, mark: &Mark) -> Corner {
    Corner {
        distance: mark.distance,
        point: endpoint.interface().point(mark),
    }
}

/// Enters a crossing at both facets of the edge.
#[inline(always)]
fn note(edge: &EdgeConstants, endpoint: Endpoint, found: Found, endpoints: &mut Endpoints) {
    endpoints.enter(edge.left as usize, endpoint, found);
    // Seen from the right it is the way back.
    endpoints.enter(edge.right as usize, endpoint.opposite(), found);
}

/// Reports an edge's shares sector by sector and notes its crossings at both facets.
#[cold]
fn split_edge(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    endpoints: &mut Endpoints,
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    let (mut sector, goal) = (a.sector(), b.sector());
    let (a, b) = (a.sight(), b.sight());
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
        let drift = drift_of([a, b], endpoint, 1.0 / gain);
        note(edge, endpoint, Found { mark, drift }, endpoints);
        endpoints.are_rounded |= gain <= 0.0;
        (start, last, sector) = (end, next, following);
    }
    visitor.share(
        &sides,
        sector,
        1.0 - start,
        [&last, &Corner::new(b, sector)],
    );
}
