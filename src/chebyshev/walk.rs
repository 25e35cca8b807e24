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
use crate::chebyshev::crossing::Passage;
use crate::chebyshev::endpoints::Endpoints;
use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::chebyshev::interface::{Endpoint, Interface};
use crate::chebyshev::mark::Mark;
use crate::chebyshev::panorama::Panorama;
use crate::chebyshev::passings::Passings;
use crate::chebyshev::segments::{Segments, report_segments};
use crate::chebyshev::visit::{Corner, Visit};
use crate::chebyshev::weighted::Places;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    pub(crate) panorama: Panorama,
    pub(crate) endpoints: Endpoints,
    pub(crate) segments: Segments,
    /// Of the walk for the energy of order 1, see `quartic`.
    pub(crate) slides: [f64; Interface::SLOTS],
    /// What passes on the way of a center from there.
    pub(crate) passings: Passings,
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
        passings,
        ..
    } = scratch;
    passings.reset();
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

/// Reports an edge that runs through several sectors.
#[inline(always)]
fn report_parted(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    endpoints: &mut Endpoints,
    visitor: &mut impl Visit,
) {
    let [a, b] = panorama.ends(edge);
    if let Some(passage) = Passage::only(a, b) {
        report_passages(piece, edge, panorama, [passage], (endpoints, visitor));
    } else {
        report_far_parted(piece, edge, panorama, (endpoints, visitor));
    }
}

/// As [`report_parted`], where more than two sectors may be on the way.
#[inline(never)]
fn report_far_parted(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    to: (&mut Endpoints, &mut impl Visit),
) {
    let [a, b] = panorama.ends(edge);
    if let Some(passages) = Passage::two(a, b) {
        report_passages(piece, edge, panorama, passages, to);
    } else {
        report_passages(piece, edge, panorama, Passage::all(a, b), to);
    }
}

/// Reports an edge's shares sector by sector and notes its crossings at both facets.
#[inline(always)]
fn report_passages(
    piece: &Integrand,
    edge: &EdgeConstants,
    panorama: &Panorama,
    passages: impl IntoIterator<Item = Passage>,
    (endpoints, visitor): (&mut Endpoints, &mut impl Visit),
) {
    let [a, b] = panorama.ends(edge);
    let sides = panorama.sides(piece, edge);
    let [first, end] = [a, b].map(|end| Corner::new(end.sight(), end.sector()));
    let (mut sector, mut start, mut last) = (a.sector(), 0.0, first);
    for passage in passages {
        let next = corner(passage.endpoint, &passage.found.mark);
        visitor.share(&sides, sector, passage.share - start, [&last, &next]);
        note(edge, &passage, endpoints);
        (sector, start, last) = (passage.to, passage.share, next);
    }
    visitor.share(&sides, sector, 1.0 - start, [&last, &end]);
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
fn note(edge: &EdgeConstants, passage: &Passage, endpoints: &mut Endpoints) {
    let Passage {
        endpoint, found, ..
    } = *passage;
    endpoints.enter(edge.left as usize, endpoint, found);
    // Seen from the right it is the way back.
    endpoints.enter(edge.right as usize, endpoint.opposite(), found);
    endpoints.are_rounded |= passage.is_rounded;
}
