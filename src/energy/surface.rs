//! Sums over the surface of a piece, subdivided into sectors: the loop over its edges.
//!
//! A facet's part in sector S is a polygon. Its boundary consists of parts of the facet's edges
//! and of segments of interfaces. Fanned from the facet's anchor q, each directed boundary part
//! (a, b) is a signed triangle (q, a, b), and the sum over all of them is the polygon. So
//! [`sum_over_surface`] passes two things to [`SurfaceSums`]:
//! - *parts* of edges within one sector, for either facet beside the edge;
//! - *segments*: parts of interfaces on a facet.

use nalgebra::Vector3;
use wide::f64x4;

use crate::arrays::MapEach;
use crate::energy::edge_crossings::edge_crossings;
use crate::energy::edge_crossings_simd::{
    DoubleCrossings, EdgeQuad, PartQuad, PointQuad, QuadSectors, SideQuad, crossing_codes,
};
use crate::energy::prepared::{
    Bits, CHUNK, CenteredPiece, FacetView, NO_EDGE, PreparedPiece, array_chunks,
};
use crate::energy::sector::{Interface, InterfaceEnd, InterfacePoint, Sector, SegmentEnd};
use crate::energy::segments::{Segment, SegmentEnds};
use crate::geometry::brep::Edge;
use crate::geometry::small_polyhedron::BLOCK;

/// Takes the parts of a subdivided surface. Points are displacements from the center.
pub(crate) trait SurfaceSums {
    /// Adds parts of four edges, which have the same shares in the triangles on both sides.
    fn add_parts<const N: usize>(&mut self, sides: &[SideQuad; 2], parts: &[PartQuad; N]);

    /// Adds four segments, some of which may be [`Segment::NONE`].
    fn add_segments(&mut self, view: &CenteredPiece<'_>, segments: &[Segment; BLOCK]);
}

/// The memory of [`sum_over_surface`], to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct SurfaceScratch {
    /// Those of the last piece.
    pub(crate) ends: SegmentEnds,
    crossings: ChunkCrossings,
}

/// The crossings of a chunk of edges: meaningless for those that are not resolved.
#[derive(Clone, Debug)]
struct ChunkCrossings {
    at: [[f64x4; BLOCK]; CHUNK / BLOCK],
    /// The [`crossing_codes`].
    codes: [[f64; BLOCK]; CHUNK / BLOCK],
}

impl Default for ChunkCrossings {
    fn default() -> Self {
        Self {
            at: [[f64x4::ZERO; BLOCK]; CHUNK / BLOCK],
            codes: [[0.0; BLOCK]; CHUNK / BLOCK],
        }
    }
}

/// Passes the parts of the surface of `piece`, subdivided about `center` (in the piece's coordinates), to
/// `sums`.
#[inline]
pub(crate) fn sum_over_surface(
    piece: &PreparedPiece,
    center: &Vector3<f64>,
    scratch: &mut SurfaceScratch,
    sums: &mut impl SurfaceSums,
) {
    let SurfaceScratch { ends, crossings } = scratch;
    ends.reset(piece.facets.len());
    let view = CenteredPiece { piece, center };
    for blocks in piece.edges.blocks().chunks(CHUNK / BLOCK) {
        let [resolved, unresolved] = add_edges(&view, blocks, crossings, sums);
        let edges = blocks.as_flattened();
        for number in resolved {
            let (block, lane) = (number / BLOCK, number % BLOCK);
            let end = InterfaceEnd::of_code(crossings.codes[block][lane]);
            let at = SegmentEnd(crossings.at[block][lane]);
            add_crossing(&edges[number], end, at, ends);
        }
        for four in array_chunks(unresolved.map(|number| edges[number]), NO_EDGE) {
            add_double_crossings(&view, &four, ends, sums);
        }
    }
    ends.add_diagonals(&view);
    ends.pair();
    for four in array_chunks(ends.paired(), (0, Interface::NONE)) {
        let segments = four.map_each(
            #[inline(always)]
            |key| ends.segment(key),
        );
        sums.add_segments(&view, &segments);
    }
    while let Some(segment) = ends.next_unpaired() {
        sums.add_segments(
            &view,
            &[segment, Segment::NONE, Segment::NONE, Segment::NONE],
        );
    }
}

/// Adds the edges with at most one crossing and stores that; returns the numbers of those with one, and
/// of those that are unresolved.
#[inline(always)]
fn add_edges(
    view: &CenteredPiece<'_>,
    blocks: &[[Edge; BLOCK]],
    crossings: &mut ChunkCrossings,
    sums: &mut impl SurfaceSums,
) -> [Bits; 2] {
    let [mut resolved, mut unresolved] = [0, 0];
    let places = crossings.at.iter_mut().zip(&mut crossings.codes);
    for (block, (edges, (at, codes))) in blocks.iter().zip(places).enumerate() {
        let quad = EdgeQuad::new(view, edges);
        *at = quad.crossings.rows();
        *codes = crossing_codes(&quad.sectors).to_array();
        sums.add_parts(&quad.sides(view), &quad.parts());
        let [parted, one] = [quad.are_parted, quad.are_resolved].map_each(f64x4::to_bitmask);
        resolved |= u64::from(one) << (block * BLOCK);
        unresolved |= u64::from(parted & !one) << (block * BLOCK);
    }
    [Bits(resolved), Bits(unresolved)]
}

/// Adds edges with more than one crossing.
#[inline(never)]
fn add_double_crossings(
    view: &CenteredPiece<'_>,
    edges: &[Edge; BLOCK],
    ends: &mut SegmentEnds,
    sums: &mut impl SurfaceSums,
) {
    let quad = EdgeQuad::new(view, edges);
    let double = DoubleCrossings::new(&quad);
    sums.add_parts(&quad.sides(view), &double.parts(&quad));
    let resolved = double.are_resolved.to_bitmask();
    for (crossings, sectors) in double.crossings.iter().zip(double.sectors(&quad)) {
        let (at, codes) = (crossings.rows(), crossing_codes(&sectors).to_array());
        for lane in Bits(u64::from(resolved)).map(|lane| lane % BLOCK) {
            let end = InterfaceEnd::of_code(codes[lane]);
            add_crossing(&edges[lane], end, SegmentEnd(at[lane]), ends);
        }
    }
    let unresolved = quad.are_parted.to_bitmask() & !resolved;
    for lane in Bits(u64::from(unresolved)).map(|lane| lane % BLOCK) {
        add_edge(view, &edges[lane], ends, sums);
    }
}

/// Adds an edge, crossing by crossing.
fn add_edge(
    view: &CenteredPiece<'_>,
    edge: &Edge,
    ends: &mut SegmentEnds,
    sums: &mut impl SurfaceSums,
) {
    let edges = [*edge; BLOCK];
    let sides = EdgeQuad::new(view, &edges).sides(view);
    let [from, to] = [edge.from, edge.to].map_each(|vertex| view.vertex(vertex));
    let point = |at: Vector3<f64>, sector: Sector| PointQuad {
        at: [at.x, at.y, at.z].map_each(f64x4::splat),
        distances: f64x4::splat(sector.distance(&at)),
    };
    let mut sector = Sector::of(&from);
    let (mut start, mut last) = (0.0, point(from, sector));
    let mut add_part = |sector: Sector, share: f64, ends: [PointQuad; 2]| {
        let direction = Vector3::ith(sector.axis(), sector.sign());
        let part = PartQuad {
            sectors: QuadSectors::of(
                &[direction.x, direction.y, direction.z].map_each(f64x4::splat),
            ),
            shares: f64x4::new([share, 0.0, 0.0, 0.0]),
            ends,
        };
        sums.add_parts(&sides, &[part]);
    };
    for crossing in edge_crossings([&from, &to]) {
        let at = crossing.end.interface().displacement(&crossing.at.point());
        let next = point(at, sector);
        add_part(sector, crossing.share - start, [last, next]);
        add_crossing(edge, crossing.end, crossing.at, ends);
        ends.are_rounded |= crossing.is_rounded;
        (sector, start, last) = (crossing.to, crossing.share, next);
    }
    add_part(sector, 1.0 - start, [last, point(to, sector)]);
}

/// Adds a crossing to the ends of segments on both facets of the edge.
#[inline(always)]
fn add_crossing(edge: &Edge, end: InterfaceEnd, at: SegmentEnd, ends: &mut SegmentEnds) {
    ends.add(edge.left as usize, end, at);
    ends.add(edge.right as usize, end.opposite(), at);
}

/// A signed triangle of a facet within one sector, from the facet's anchor to two points.
#[derive(Debug)]
pub(crate) struct Triangle<'a> {
    pub(crate) facet: &'a FacetView,
    pub(crate) sector: Sector,
    /// Twice its signed area (L²).
    pub(crate) doubled_area: f64,
    pub(crate) corners: [Vector3<f64>; 3],
    /// The Chebyshev distances of the corners (L).
    pub(crate) distances: [f64; 3],
}

impl<'a> Triangle<'a> {
    fn new(
        facet: &'a FacetView,
        sector: Sector,
        doubled_area: f64,
        [a, b]: [Vector3<f64>; 2],
        distances: [f64; 2],
    ) -> Self {
        let anchor = facet.anchor();
        Self {
            facet,
            sector,
            doubled_area,
            corners: [anchor, a, b],
            distances: [sector.distance(&anchor), distances[0], distances[1]],
        }
    }

    /// Six times the signed volume of its tetrahedron with the center (L³).
    pub(crate) fn six_volume(&self) -> f64 {
        self.doubled_area * self.facet.height
    }
}

/// One of four vectors given by axis.
fn lane_of(all: &[f64x4; 3], lane: usize) -> Vector3<f64> {
    Vector3::from(all.each_ref().map_each(|along| along.to_array()[lane]))
}

impl SideQuad {
    /// The facet beside one of the four edges.
    fn facet(&self, lane: usize) -> FacetView {
        FacetView {
            number: self.facets[lane] as usize,
            normal: lane_of(&self.normals, lane),
            height: self.heights.to_array()[lane],
        }
    }
}

/// Visits the triangles of parts of four edges one by one.
pub(crate) fn visit_triangles<const N: usize>(
    sides: &[SideQuad; 2],
    parts: &[PartQuad; N],
    mut visit: impl FnMut(&Triangle<'_>),
) {
    for part in parts {
        let (shares, codes) = (part.shares.to_array(), part.sectors.codes(0).to_array());
        for lane in (0..BLOCK).filter(|&lane| shares[lane] != 0.0) {
            let sector = Sector::of_number(codes[lane].to_bits() as usize);
            let points = part.ends.map_each(|end| lane_of(&end.at, lane));
            let distances = part.ends.map_each(|end| end.distances.to_array()[lane]);
            for side in sides {
                let facet = side.facet(lane);
                let area = shares[lane] * side.doubled_areas.to_array()[lane];
                let triangle = Triangle::new(&facet, sector, area, points, distances);
                visit(&triangle);
            }
        }
    }
}

/// Visits segments one by one, with the triangles left and right of each and the points of its ends.
pub(crate) fn visit_segments(
    view: &CenteredPiece<'_>,
    segments: &[Segment; BLOCK],
    mut visit: impl FnMut(&[Triangle<'_>; 2], Interface, &[InterfacePoint; 2]),
) {
    for segment in segments
        .iter()
        .filter(|one| one.interface != Interface::NONE)
    {
        let (facet, interface) = (view.facet(segment.facet as usize), segment.interface);
        let (left, right) = interface.sectors();
        let ends = segment.ends.map_each(SegmentEnd::point);
        let points = ends.each_ref().map_each(|end| interface.displacement(end));
        let distances = ends.each_ref().map_each(|end| end.distance);
        let slope = left.distance(&facet.normal) - right.distance(&facet.normal);
        let doubled_area = interface.determinant(&ends[0], &ends[1]) * slope;
        let triangle =
            |sector, doubled_area| Triangle::new(&facet, sector, doubled_area, points, distances);
        let both = [triangle(left, doubled_area), triangle(right, -doubled_area)];
        visit(&both, interface, &ends);
    }
}

/// ∫ d∞^p y dA and ∫ d∞^p dA over one facet, as four lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FacetIntegrals(pub(crate) f64x4);

impl FacetIntegrals {
    /// Adds to both.
    pub(crate) fn add(&mut self, weight: f64, first: &Vector3<f64>) {
        self.0 += f64x4::new([first.x, first.y, first.z, weight]);
    }

    /// ∫ d∞^p dA (L^(2+p)).
    pub(crate) fn weight(&self) -> f64 {
        self.0.to_array()[3]
    }

    /// ∫ d∞^p y dA (L^(3+p)).
    pub(crate) fn first(&self) -> Vector3<f64> {
        let [x, y, z, _] = self.0.to_array();
        Vector3::new(x, y, z)
    }
}
