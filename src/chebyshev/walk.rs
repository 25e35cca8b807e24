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

use crate::chebyshev::integrand::{EdgeConstants, FacetConstants, Integrand};
use crate::chebyshev::sector::{Interface, Sector};
use crate::chebyshev::segments::{Endpoints, Role, report_segments};
use crate::chebyshev::visit::{FacetView, Visit};
use crate::chebyshev::weighted::Places;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    vertices: Vec<(Vector3<f64>, Sector)>,
    facets: Vec<FacetView>,
    /// Per facet, its last entry: twice the crossing's place, plus one for the right side, plus one;
    /// zero for none.
    last: Vec<u32>,
    crossings: Vec<Crossing>,
    endpoints: Endpoints,
    /// For pieces with a density.
    pub(crate) places: Option<Places>,
}

/// Where an edge crosses an interface, for both facets beside it.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    point: Vector3<f64>,
    interface: Interface,
    /// What it is on the left facet; on the right one it is the opposite.
    is_start: bool,
    /// The facets' entries before this one, as in `last`.
    before: [u32; 2],
}

/// Walks the surface of a piece as seen from `center` (in the piece's coordinates).
#[inline]
pub(crate) fn walk(
    piece: &Integrand,
    center: &Vector3<f64>,
    scratch: &mut WalkScratch,
    visitor: &mut impl Visit,
) {
    prepare(piece, center, scratch);
    for edge in &piece.edges {
        let (a, from) = scratch.vertices[edge.from as usize];
        let (b, to) = scratch.vertices[edge.to as usize];
        if from == to {
            // The distance is convex along the edge, so no other sector comes between.
            let left = &scratch.facets[edge.left as usize];
            visitor.share(left, from, edge.left_area, &a, &b);
            let right = &scratch.facets[edge.right as usize];
            visitor.share(right, from, edge.right_area, &b, &a);
        } else {
            split_edge(edge, scratch, visitor);
        }
    }
    for facet in 0..piece.facets.len() {
        if scratch.last[facet] != 0 {
            join_segments(&piece.facets[facet], facet, scratch, visitor);
        }
    }
}

fn prepare(piece: &Integrand, center: &Vector3<f64>, scratch: &mut WalkScratch) {
    scratch.vertices.clear();
    scratch.vertices.extend(piece.vertices.iter().map(|vertex| {
        let displacement = vertex - center;
        (displacement, Sector::of(&displacement))
    }));
    scratch.facets.clear();
    for (number, facet) in piece.facets.iter().enumerate() {
        // Planes that have lost all their vertices have no anchor and are never asked for.
        let anchor = scratch.vertices.get(facet.anchor as usize);
        scratch.facets.push(FacetView {
            number: number as u32,
            anchor: anchor.map_or_else(Vector3::zeros, |(anchor, _)| *anchor),
            height: facet.offset - facet.normal.dot(center),
        });
    }
    scratch.last.clear();
    scratch.last.resize(piece.facets.len(), 0);
    scratch.crossings.clear();
}

/// Reports an edge's shares sector by sector and notes its crossings at both facets.
fn split_edge(edge: &EdgeConstants, scratch: &mut WalkScratch, visitor: &mut impl Visit) {
    let (a, mut sector) = scratch.vertices[edge.from as usize];
    let (b, goal) = scratch.vertices[edge.to as usize];
    let along = b - a;
    let [left, right] = [edge.left, edge.right].map(|facet| scratch.facets[facet as usize]);
    let (mut start, mut point) = (0.0, a);
    loop {
        let (end, following) = if sector == goal {
            (1.0, None)
        } else {
            let (end, following) = next_sector(&a, &along, sector, goal, start);
            (end, Some(following))
        };
        let next_point = if end < 1.0 { a + along * end } else { b };
        let part = end - start;
        visitor.share(&left, sector, part * edge.left_area, &point, &next_point);
        visitor.share(&right, sector, part * edge.right_area, &next_point, &point);
        let Some(following) = following else { break };
        let interface = Interface::between(sector, following);
        let is_start = sector == interface.sectors().0;
        note(edge, interface, is_start, next_point, scratch);
        (start, point, sector) = (end, next_point, following);
    }
}

/// Where along the edge a + t·along, t ≥ start, `sector` ends, and which sector follows it on the
/// way to `goal`.
///
/// Slopes grow from sector to sector, so at most five steps are made. Where rounding has put the
/// goal beyond the end of the edge, it is reached at t = 1 by way of sectors that touch.
fn next_sector(
    a: &Vector3<f64>,
    along: &Vector3<f64>,
    sector: Sector,
    goal: Sector,
    start: f64,
) -> (f64, Sector) {
    let (value, slope) = (sector.distance(a), sector.distance(along));
    let mut best = None;
    let mut least = 1.0;
    for other in sector.beside() {
        let gain = other.distance(along) - slope;
        let t = (value - other.distance(a)) / gain;
        if gain > 0.0 && t < least {
            (best, least) = (Some(other), t);
        }
    }
    match best {
        Some(other) => (least.max(start), other),
        None if goal.axis() != sector.axis() => (1.0, goal),
        // The opposite sector is the goal: go through the first one of another axis.
        None => (1.0, sector.beside()[0]),
    }
}

fn note(
    edge: &EdgeConstants,
    interface: Interface,
    is_start: bool,
    point: Vector3<f64>,
    scratch: &mut WalkScratch,
) {
    let entry = 2 * scratch.crossings.len() as u32 + 1;
    let before = [(edge.left, entry), (edge.right, entry + 1)]
        .map(|(facet, entry)| std::mem::replace(&mut scratch.last[facet as usize], entry));
    scratch.crossings.push(Crossing {
        point,
        interface,
        is_start,
        before,
    });
}

/// Gathers a facet's crossings and reports its segments.
fn join_segments(
    constants: &FacetConstants,
    facet: usize,
    scratch: &mut WalkScratch,
    visitor: &mut impl Visit,
) {
    let WalkScratch {
        facets,
        last,
        crossings,
        endpoints,
        ..
    } = scratch;
    endpoints.clear();
    let mut entry = last[facet];
    while entry != 0 {
        let (place, side) = ((entry - 1) / 2, (entry - 1) % 2);
        let crossing = &crossings[place as usize];
        let role = Role::start_if(crossing.is_start == (side == 0));
        endpoints.add(crossing.interface, role, crossing.point);
        entry = crossing.before[side as usize];
    }
    report_segments(constants, &facets[facet], endpoints, visitor);
}
