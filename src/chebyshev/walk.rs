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
use wide::f64x4;

use crate::chebyshev::chunks::{Bits, CHUNK, fours};
use crate::chebyshev::crossing::Passage;
use crate::chebyshev::detours::Detours;
use crate::chebyshev::edges::NONE;
use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::endpoints::Endpoints;
use crate::chebyshev::four::FourEdges;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::passings::Passings;
use crate::chebyshev::seen::Seen;
use crate::chebyshev::segments::{Segments, report_segments};
use crate::chebyshev::visit::Visit;
use crate::chebyshev::weighted::Places;
use crate::geometry::brep::Edge;
use crate::geometry::small_polyhedron::BLOCK;

/// The memory of a walk, to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub struct WalkScratch {
    /// From where the last piece was seen.
    pub(crate) center: Vector3<f64>,
    pub(crate) endpoints: Endpoints,
    pub(crate) segments: Segments,
    crossings: Crossings,
    /// Of the walk for the energy of order 1, see `quartic`.
    pub(crate) slides: [f64; Interface::SLOTS],
    /// And the volume of the pieces walked together (L³).
    pub(crate) volume: Option<f64>,
    /// What passes on the way of a center from there.
    pub(crate) passings: Passings,
    /// For pieces with a density.
    pub(crate) places: Option<Places>,
}

impl WalkScratch {
    /// The volume of the pieces the energy of which was last taken (L³), if that was the one of order 1.
    pub(crate) fn volume(&self) -> Option<f64> {
        self.volume
    }
}

/// The crossings of some edges that are told: meaningless for others.
#[derive(Clone, Debug)]
struct Crossings {
    found: [[f64x4; BLOCK]; CHUNK / BLOCK],
    /// See [`Endpoint::of_passing_code`].
    codes: [[f64; BLOCK]; CHUNK / BLOCK],
}

impl Default for Crossings {
    fn default() -> Self {
        Self {
            found: [[f64x4::ZERO; BLOCK]; CHUNK / BLOCK],
            codes: [[0.0; BLOCK]; CHUNK / BLOCK],
        }
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
    let WalkScratch {
        endpoints,
        segments,
        crossings,
        passings,
        ..
    } = scratch;
    scratch.center = *center;
    passings.reset();
    endpoints.reset(piece.facets.len());
    let seen = Seen { piece, center };
    for blocks in piece.edges.blocks().chunks(CHUNK / BLOCK) {
        let [told, far] = report_edges(&seen, blocks, crossings, visitor);
        let edges = blocks.as_flattened();
        for number in told {
            let (block, lane) = (number / BLOCK, number % BLOCK);
            let endpoint = Endpoint::of_passing_code(crossings.codes[block][lane]);
            note(
                &edges[number],
                endpoint,
                crossings.found[block][lane],
                endpoints,
            );
        }
        for four in fours(far.map(|number| edges[number]), NONE) {
            report_detours(&seen, &four, (endpoints, visitor));
        }
    }
    report_segments(&seen, endpoints, segments, visitor);
}

/// Reports edges that are whole or told, four at a time, and notes their crossings; returns the numbers
/// of those that are told, and of those that are neither told nor whole.
#[inline(always)]
fn report_edges(
    seen: &Seen<'_>,
    blocks: &[[Edge; BLOCK]],
    crossings: &mut Crossings,
    visitor: &mut impl Visit,
) -> [Bits; 2] {
    let [mut told, mut far] = [0, 0];
    let places = crossings.found.iter_mut().zip(&mut crossings.codes);
    for (block, (edges, (found, codes))) in blocks.iter().zip(places).enumerate() {
        let four = FourEdges::new(seen, edges);
        *found = four.passages.rows();
        *codes = Endpoint::passing_codes(&four.sectors).to_array();
        visitor.edges(seen, &four);
        let [more_told, more_far] = four.told_and_far();
        told |= more_told << (block * BLOCK);
        far |= more_far << (block * BLOCK);
    }
    [told, far].map(Bits::of)
}

/// Reports edges on the way of which is more than one sector.
#[inline(never)]
fn report_detours(
    seen: &Seen<'_>,
    edges: &[Edge; BLOCK],
    (endpoints, visitor): (&mut Endpoints, &mut impl Visit),
) {
    let four = FourEdges::new(seen, edges);
    let detours = Detours::new(&four);
    visitor.detours(seen, &four, &detours);
    let told = detours.are_told.to_bitmask();
    for (passages, sectors) in detours.passages.iter().zip(detours.sectors(&four)) {
        let (found, codes) = (
            passages.rows(),
            Endpoint::passing_codes(&sectors).to_array(),
        );
        for lane in Bits::of(u64::from(told)) {
            let endpoint = Endpoint::of_passing_code(codes[lane % BLOCK]);
            note(
                &edges[lane % BLOCK],
                endpoint,
                found[lane % BLOCK],
                endpoints,
            );
        }
    }
    let far = four.are_parted.to_bitmask() & !told;
    for lane in Bits::of(u64::from(far)) {
        report_far(seen, &edges[lane % BLOCK], (endpoints, visitor));
    }
}

/// Reports an edge step by step.
#[cold]
fn report_far(
    seen: &Seen<'_>,
    edge: &Edge,
    (endpoints, visitor): (&mut Endpoints, &mut impl Visit),
) {
    let [a, b] = &seen.ends(edge);
    let note = |passage: &Passage| {
        note(edge, passage.endpoint, passage.found.lanes(), endpoints);
        endpoints.are_rounded |= passage.is_rounded;
    };
    seen.report_passages(edge, Passage::all(a, b), note, visitor);
}

/// Enters a crossing at both facets of the edge.
#[inline(always)]
fn note(edge: &Edge, endpoint: Endpoint, found: f64x4, endpoints: &mut Endpoints) {
    endpoints.enter(edge.left as usize, endpoint, found);
    // Seen from the right it is the way back.
    endpoints.enter(edge.right as usize, endpoint.opposite(), found);
}
