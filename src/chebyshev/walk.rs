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

use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::chebyshev::interface::{Endpoint, Mark};
use crate::chebyshev::sector::Sector;
use crate::chebyshev::segments::{Endpoints, Spare, report_segments};
use crate::chebyshev::sight::Sight;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::chebyshev::weighted::Places;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    vertices: Vec<VertexSight>,
    facets: Vec<FacetSight>,
    endpoints: Vec<Endpoints>,
    spare: Vec<Spare>,
    /// For pieces with a density.
    pub(crate) places: Option<Places>,
}

/// A vertex as seen from the center.
#[derive(Clone, Copy, Debug)]
struct VertexSight {
    sight: Sight,
    sector: Sector,
}

/// A facet as seen from the center.
#[derive(Clone, Copy, Debug)]
struct FacetSight {
    height: f64,
    anchor: Sight,
}

/// Walks the surface of a piece as seen from `center` (in the piece's coordinates).
#[inline]
pub(crate) fn walk(
    piece: &Integrand,
    center: &Vector3<f64>,
    scratch: &mut WalkScratch,
    visitor: &mut impl Visit,
) {
    prepare(piece, center, &Sight::of(center), scratch);
    for edge in &piece.edges {
        let a = &scratch.vertices[edge.from as usize];
        let b = &scratch.vertices[edge.to as usize];
        let (from, to) = (a.sector, b.sector);
        if from == to {
            // The distance is convex along the edge, so no other sector comes between.
            let sides = sides(piece, edge, &scratch.facets);
            let ends = [&Corner::new(&a.sight, from), &Corner::new(&b.sight, from)];
            visitor.share(&sides, from, 1.0, ends);
        } else if let Some((end, mark)) = only_crossing(a, b) {
            let sides = sides(piece, edge, &scratch.facets);
            let between = corner(Endpoint::passing(from, to), &mark);
            visitor.share(&sides, from, end, [&Corner::new(&a.sight, from), &between]);
            visitor.share(
                &sides,
                to,
                1.0 - end,
                [&between, &Corner::new(&b.sight, to)],
            );
            note(
                edge,
                (from, to),
                mark,
                &mut scratch.endpoints,
                &mut scratch.spare,
            );
        } else {
            split_edge(piece, edge, scratch, visitor);
        }
    }
    let endpoints = &mut scratch.endpoints[..piece.facets.len()];
    for (number, endpoints) in endpoints.iter_mut().enumerate() {
        if !endpoints.is_empty() {
            let view = view(piece, number, &scratch.facets);
            report_segments(&view, endpoints, &mut scratch.spare, visitor);
        }
    }
}

/// Looks at the piece from the center. Out of line, lest the compiler finds out how the lanes of
/// `from` hang together and takes them one by one.
#[inline(never)]
fn prepare(piece: &Integrand, center: &Vector3<f64>, from: &Sight, scratch: &mut WalkScratch) {
    scratch.vertices.clear();
    scratch.vertices.extend(piece.vertices.iter().map(|vertex| {
        let sight = vertex.from(from);
        let sector = sight.sector();
        VertexSight { sight, sector }
    }));
    let count = piece.facets.len();
    if scratch.endpoints.len() < count {
        scratch.endpoints.resize(count, Endpoints::default());
    }
    for endpoints in &mut scratch.endpoints[..count] {
        endpoints.clear();
    }
    scratch.facets.clear();
    scratch
        .facets
        .extend(piece.facets.iter().map(|facet| FacetSight {
            height: facet.offset - facet.normal.dot(center),
            anchor: facet.foot.from(from),
        }));
    scratch.spare.clear();
}

#[inline]
fn view<'a>(piece: &'a Integrand, number: usize, facets: &'a [FacetSight]) -> FacetView<'a> {
    let FacetSight { height, anchor } = &facets[number];
    FacetView {
        number,
        piece,
        anchor,
        height: *height,
        per_height: 1.0 / height,
    }
}

/// The facets beside an edge.
#[inline]
fn sides<'a>(
    piece: &'a Integrand,
    edge: &EdgeConstants,
    facets: &'a [FacetSight],
) -> [Side<'a>; 2] {
    let both = [(edge.left, edge.left_area), (edge.right, edge.right_area)];
    both.map(|(facet, doubled_area)| Side {
        facet: view(piece, facet as usize, facets),
        doubled_area,
    })
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
fn only_crossing(a: &VertexSight, b: &VertexSight) -> Option<(f64, Mark)> {
    let (from, to) = (a.sector, b.sector);
    let (a, b) = (&a.sight, &b.sight);
    let fall = a.distance(from) - a.distance(to);
    let rise = b.distance(to) - b.distance(from);
    let third = Endpoint::passing(from, to).interface().third_axis();
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
    scale.is_finite().then_some((fall * scale, mark))
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
    mark: Mark,
    endpoints: &mut [Endpoints],
    spare: &mut Vec<Spare>,
) {
    for (facet, endpoint) in [
        (edge.left, Endpoint::passing(from, to)),
        (edge.right, Endpoint::passing(to, from)),
    ] {
        let facet = facet as usize;
        if !endpoints[facet].add(endpoint, mark) {
            spare.push(Spare {
                facet,
                endpoint,
                mark,
            });
        }
    }
}

/// Reports an edge's shares sector by sector and notes its crossings at both facets.
#[cold]
fn split_edge(
    piece: &Integrand,
    edge: &EdgeConstants,
    scratch: &mut WalkScratch,
    visitor: &mut impl Visit,
) {
    let [a, b] = [edge.from, edge.to].map(|vertex| scratch.vertices[vertex as usize]);
    let (mut sector, goal) = (a.sector, b.sector);
    let (a, b) = (a.sight, b.sight);
    let sides = sides(piece, edge, &scratch.facets);
    let (mut start, mut last) = (0.0, Corner::new(&a, sector));
    while sector != goal {
        let (end, following) = next_sector([&a, &b], sector, goal, start);
        let endpoint = Endpoint::passing(sector, following);
        let mark = mark_on([&a, &b], sector, endpoint.interface().third_axis(), end);
        let next = corner(endpoint, &mark);
        visitor.share(&sides, sector, end - start, [&last, &next]);
        note(
            edge,
            (sector, following),
            mark,
            &mut scratch.endpoints,
            &mut scratch.spare,
        );
        (start, last, sector) = (end, next, following);
    }
    visitor.share(
        &sides,
        sector,
        1.0 - start,
        [&last, &Corner::new(&b, sector)],
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
    let mut best = None;
    let mut least = 1.0;
    for other in sector.beside() {
        let other_value = a.distance(other);
        let gain = b.distance(other) - other_value - slope;
        let lead = value - other_value;
        if gain > 0.0 && lead < least * gain {
            (best, least) = (Some(other), lead / gain);
        }
    }
    match best {
        Some(other) => (least.max(start), other),
        None if goal.axis() != sector.axis() => (1.0, goal),
        // The opposite sector is the goal: go through the first one of another axis.
        None => (1.0, sector.beside()[0]),
    }
}
