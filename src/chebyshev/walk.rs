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
use crate::chebyshev::sector::{Interface, Sector, diagonal_ray, pierced};

/// A facet as seen from the center of the walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacetView {
    /// The anchor's displacement from the center.
    pub(crate) anchor: Vector3<f64>,
    /// The center's signed height below the facet's plane.
    pub(crate) height: f64,
}

/// Takes what the walk reports. Positions are displacements from the center.
pub(crate) trait Visit {
    /// The part (a, b) of an edge lies in `sector`; the triangle with the anchor has the signed
    /// area `doubled_area / 2`.
    fn share(
        &mut self,
        facet: &FacetView,
        sector: Sector,
        doubled_area: f64,
        a: &Vector3<f64>,
        b: &Vector3<f64>,
    );

    /// The directed part (u, v) of the interface lies on the facet.
    fn segment(
        &mut self,
        facet: &FacetView,
        interface: Interface,
        doubled_area: f64,
        u: &Vector3<f64>,
        v: &Vector3<f64>,
    );
}

/// The memory of [`walk`], to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    vertices: Vec<(Vector3<f64>, Sector)>,
    facets: Vec<FacetView>,
    /// Per facet, one more than the place of its last crossing; zero for none.
    last: Vec<u32>,
    crossings: Vec<Crossing>,
    endpoints: Vec<Endpoint>,
}

/// Where the walk around a facet crosses an interface.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    endpoint: Endpoint,
    /// One more than the place of the facet's crossing before this one; zero for none.
    before: u32,
}

#[derive(Clone, Copy, Debug)]
struct Endpoint {
    interface: Interface,
    role: Role,
    point: Vector3<f64>,
}

/// What an endpoint is to a segment with the interface's first sector on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Start,
    End,
    /// The end of a segment that has been reported.
    Taken,
}

impl Role {
    fn start_if(is_start: bool) -> Self {
        if is_start { Self::Start } else { Self::End }
    }
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
    for facet in &piece.facets {
        // Planes that have lost all their vertices have no anchor and are never asked for.
        let anchor = scratch.vertices.get(facet.anchor as usize);
        scratch.facets.push(FacetView {
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
        let onto_right = sector == interface.sectors().0;
        note(
            scratch,
            edge.left,
            interface,
            Role::start_if(onto_right),
            next_point,
        );
        note(
            scratch,
            edge.right,
            interface,
            Role::start_if(!onto_right),
            next_point,
        );
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
    for other in Sector::ALL {
        let gain = other.distance(along) - slope;
        if other.axis() == sector.axis() || gain <= 0.0 {
            continue;
        }
        let t = (value - other.distance(a)) / gain;
        if t < best.map_or(1.0, |(t, _)| t) {
            best = Some((t, other));
        }
    }
    match best {
        Some((t, other)) => (t.max(start), other),
        None if goal.axis() != sector.axis() => (1.0, goal),
        // The opposite sector is the goal: go through the first one of another axis.
        None => (1.0, Sector::ALL[(2 * sector.axis() + 2) % 6]),
    }
}

fn note(
    scratch: &mut WalkScratch,
    facet: u32,
    interface: Interface,
    role: Role,
    point: Vector3<f64>,
) {
    let last = &mut scratch.last[facet as usize];
    scratch.crossings.push(Crossing {
        endpoint: Endpoint {
            interface,
            role,
            point,
        },
        before: *last,
    });
    *last = scratch.crossings.len() as u32;
}

/// Pairs a facet's crossings and pierced diagonals to segments.
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
    let view = facets[facet];
    endpoints.clear();
    let mut crossed = 0;
    let mut number = last[facet];
    while number != 0 {
        let crossing = crossings[number as usize - 1];
        crossed ^= crossing.endpoint.interface.bit();
        endpoints.push(crossing.endpoint);
        number = crossing.before;
    }
    push_diagonals(constants, &view, crossed, endpoints);
    for start in 0..endpoints.len() {
        let Endpoint {
            interface,
            role: Role::Start,
            point: u,
        } = endpoints[start]
        else {
            continue;
        };
        let end = endpoints
            .iter_mut()
            .find(|end| end.interface == interface && end.role == Role::End);
        if let Some(end) = end {
            end.role = Role::Taken;
            let v = end.point;
            let doubled_area = constants
                .normal
                .dot(&(u - view.anchor).cross(&(v - view.anchor)));
            visitor.segment(&view, interface, doubled_area, &u, &v);
        }
    }
}

/// Adds the points in which diagonals pierce the facet, each an endpoint of three interfaces.
fn push_diagonals(
    constants: &FacetConstants,
    view: &FacetView,
    crossed: u16,
    endpoints: &mut Vec<Endpoint>,
) {
    let mut inside = pierced(crossed);
    let seen_from_inside = view.height >= 0.0;
    let steepness = |diagonal: u8| {
        let dot = constants.normal.dot(&diagonal_ray(diagonal));
        if seen_from_inside { dot } else { -dot }
    };
    if inside.count_ones() == 4 {
        // The facet spans a whole sector: this one or the opposite.
        let balance = |set: u8| -> f64 { members(set).map(steepness).sum() };
        if balance(!inside) > balance(inside) {
            inside = !inside;
        }
    }
    for diagonal in members(inside) {
        let slope = steepness(diagonal);
        let reach = view.height.abs() / slope;
        let point = if slope > 0.0 && reach.is_finite() {
            diagonal_ray(diagonal) * reach
        } else {
            // Rounding alone says that this diagonal pierces: its triangle has no area.
            endpoints.first().map_or(view.anchor, |first| first.point)
        };
        for (interface, ends) in Interface::at_diagonal(diagonal) {
            endpoints.push(Endpoint {
                interface,
                role: Role::start_if(ends != seen_from_inside),
                point,
            });
        }
    }
}

fn members(set: u8) -> impl Iterator<Item = u8> {
    (0..8).filter(move |member| set >> member & 1 == 1)
}
