//! Crossings of four edges with the boundaries between sectors, in four SIMD lanes.
//!
//! Every facet f is fanned from its *anchor*, the foot q of the perpendicular from the center. The
//! triangle (q, a, b) of a directed edge has twice the area σ = n·(a×b), n the unit normal, a and b
//! displacements from the center; its tetrahedron with the center (\[BL\] section 3.5) has six times the
//! volume σ H with H = d − n·c, the signed height of the center below the facet. No polygon is cut for an
//! integral: an edge that crosses several sectors splits its σ in proportion.
//!
//! # Crossings
//!
//! The sectors of an edge's ends have equal distances at one point of the edge. If no third distance is
//! larger there, no other sector comes between: the Chebyshev distance is convex, so a sector that has it
//! at two points has it all between. Such a crossing is *resolved* here, as is one that is split by one
//! sector of the third axis. What is neither that nor within one sector is left to `edge_crossings`.

use wide::f64x4;

use crate::arrays::MapEach;
use crate::energy::prepared::CenteredPiece;
use crate::energy::sector::Sector;
use crate::geometry::brep::Edge;
use crate::geometry::simd::{cross, dot};
use crate::geometry::small_polyhedron::BLOCK;

/// The sectors of four displacements.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadSectors {
    /// Whether y is the axis unless z is.
    is_y: f64x4,
    is_z: f64x4,
    is_negative: f64x4,
    distance: f64x4,
}

impl QuadSectors {
    /// [`Sector::of`] of four displacements, by axis.
    #[inline(always)]
    pub(crate) fn of(displacements: &[f64x4; 3]) -> Self {
        let [x, y, z] = displacements.each_ref().map_each(|all| all.abs());
        let is_y = y.simd_gt(x);
        let is_z = z.simd_gt(x.fast_max(y));
        let coordinate = is_z.select(
            displacements[2],
            is_y.select(displacements[1], displacements[0]),
        );
        Self {
            is_y,
            is_z,
            is_negative: coordinate.simd_lt(f64x4::ZERO),
            distance: coordinate.abs(),
        }
    }

    /// Of three numbers the one of the sector's axis.
    #[inline(always)]
    pub(crate) fn of_axis(&self, [x, y, z]: [f64x4; 3]) -> f64x4 {
        self.is_z.select(z, self.is_y.select(y, x))
    }

    /// The values of the sectors' distance functions at other displacements (L).
    #[inline(always)]
    pub(crate) fn distance(&self, displacements: &[f64x4; 3]) -> f64x4 {
        self.signed(self.of_axis(*displacements))
    }

    /// The distances of the four displacements themselves.
    #[inline(always)]
    pub(crate) fn own_distance(&self) -> f64x4 {
        self.distance
    }

    /// Numbers, with the other sign for negative sectors.
    #[inline(always)]
    pub(crate) fn signed(&self, numbers: f64x4) -> f64x4 {
        numbers ^ self.is_negative & f64x4::splat(-0.0)
    }

    /// Numbers where the axis is x, where y and where z.
    #[inline(always)]
    pub(crate) fn by_axis(&self, numbers: f64x4) -> [f64x4; 3] {
        let z = self.is_z & numbers;
        let rest = numbers ^ z;
        let y = self.is_y & rest;
        [rest ^ y, y, z]
    }

    /// The axes that belong neither to these sectors nor to others.
    #[inline(always)]
    pub(crate) fn third_axes(&self, others: &Self) -> ThirdAxes {
        let [y, other_y] = [self, others].map_each(|four| four.is_y ^ four.is_y & four.is_z);
        let (z, other_z) = (self.is_z, others.is_z);
        ThirdAxes {
            is_y_taken: y | other_y,
            is_z_taken: z | other_z,
            are_two: y ^ other_y | z ^ other_z,
            is_start: other_z | (other_y ^ other_y & z),
        }
    }

    /// Where these differ from others.
    #[inline(always)]
    pub(crate) fn differ(&self, others: &Self) -> f64x4 {
        self.third_axes(others).are_two | self.is_negative ^ others.is_negative
    }

    /// The sectors' numbers as floats, from bit `shift` of each on.
    #[inline(always)]
    pub(crate) fn codes(&self, shift: usize) -> f64x4 {
        let bits = |number: usize| f64x4::splat(f64::from_bits((number as u64) << shift));
        let axes = self.of_axis([0, 1, 2].map_each(bits));
        axes | self.is_negative & bits(Sector::OPPOSITE)
    }
}

/// The axes that belong to neither of two sectors, of four pairs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ThirdAxes {
    is_y_taken: f64x4,
    is_z_taken: f64x4,
    /// Where the sectors are of two axes.
    pub(crate) are_two: f64x4,
    /// Where the axis of the first sector comes before that of the second.
    pub(crate) is_start: f64x4,
}

impl ThirdAxes {
    /// The sectors of these axes on the sides of displacements with these coordinates.
    #[inline(always)]
    pub(crate) fn sectors(&self, coordinate: f64x4) -> QuadSectors {
        QuadSectors {
            is_y: !self.is_y_taken,
            is_z: !self.is_z_taken,
            is_negative: coordinate.simd_lt(f64x4::ZERO),
            distance: coordinate.abs(),
        }
    }

    /// The coordinates of displacements along them.
    #[inline(always)]
    pub(crate) fn coordinate(&self, [x, y, z]: &[f64x4; 3]) -> f64x4 {
        let rest = self.is_y_taken.select(*x, *y);
        self.is_z_taken.select(rest, *z)
    }
}

/// The numbers of four pairs of sectors in the last bits of floats: see
/// [`crate::energy::sector::InterfaceEnd::of_code`].
#[inline(always)]
pub(crate) fn crossing_codes([from, to]: &[QuadSectors; 2]) -> f64x4 {
    from.codes(0) | to.codes(Sector::SLOTS.trailing_zeros() as usize)
}

/// Four edges about a center.
#[derive(Debug)]
pub(crate) struct EdgeQuad<'a> {
    edges: &'a [Edge; BLOCK],
    ends: [PointQuad; 2],
    /// The sectors of their ends.
    pub(crate) sectors: [QuadSectors; 2],
    /// Which begin and end in different sectors.
    pub(crate) are_parted: f64x4,
    /// Which of these have one crossing.
    pub(crate) are_resolved: f64x4,
    pub(crate) crossings: QuadCrossings,
}

/// A point of each of four edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointQuad {
    /// The displacements, by axis.
    pub(crate) at: [f64x4; 3],
    /// The Chebyshev distances (L).
    pub(crate) distances: f64x4,
}

/// A part of each of four edges, within one sector.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartQuad {
    pub(crate) sectors: QuadSectors,
    /// The shares of the edges, zero where there is no such part.
    pub(crate) shares: f64x4,
    pub(crate) ends: [PointQuad; 2],
}

/// A facet beside each of four edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideQuad {
    /// Their numbers.
    pub(crate) facets: [u32; BLOCK],
    /// The unit normals, by axis.
    pub(crate) normals: [f64x4; 3],
    /// The heights of the center below the facets (L).
    pub(crate) heights: f64x4,
    /// σ: twice the signed areas of the triangles of the anchors and the edges (L²).
    pub(crate) doubled_areas: f64x4,
}

/// One crossing of each of four edges between two sectors, if no third comes between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadCrossings {
    /// Where none does: both distances are the largest.
    are_undisturbed: f64x4,
    /// Where the sectors are of two axes, and the second one gains on the first.
    are_valid: f64x4,
    /// By how much the first sector's distance is larger at the edges' starts, and smaller at their
    /// ends (L).
    leads: [f64x4; 2],
    /// The shares of the edges before the crossings.
    shares: f64x4,
    /// Distances, third coordinates and the edge velocities of both.
    at: [f64x4; 4],
}

/// Two crossings of each of four edges, into a sector of the third axis and out of it.
#[derive(Debug)]
pub(crate) struct DoubleCrossings {
    between: QuadSectors,
    pub(crate) crossings: [QuadCrossings; 2],
    /// Where these are all crossings of the edge.
    pub(crate) are_resolved: f64x4,
}

impl<'a> EdgeQuad<'a> {
    #[inline(always)]
    pub(crate) fn new(view: &CenteredPiece<'_>, edges: &'a [Edge; BLOCK]) -> Self {
        let a = view.quad_vertices(edges.map_each(|edge| edge.from));
        let b = view.quad_vertices(edges.map_each(|edge| edge.to));
        let sectors = [QuadSectors::of(&a), QuadSectors::of(&b)];
        let [from, to] = &sectors;
        let own = [from.own_distance(), to.own_distance()];
        let crossings = QuadCrossings::new([&a, &b], [from, to], own);
        let are_parted = from.differ(to);
        Self {
            edges,
            ends: [(a, own[0]), (b, own[1])]
                .map_each(|(at, distances)| PointQuad { at, distances }),
            sectors,
            are_parted,
            are_resolved: are_parted & crossings.are_valid & crossings.are_undisturbed,
            crossings,
        }
    }

    /// The facets left of the edges, and right.
    #[inline(always)]
    pub(crate) fn sides(&self, view: &CenteredPiece<'_>) -> [SideQuad; 2] {
        let [a, b] = &self.ends;
        let fan = cross(&a.at, &b.at);
        let side = |facets: [u32; BLOCK]| {
            let (normals, heights) = view.quad_facets(facets);
            SideQuad {
                facets,
                doubled_areas: dot(&normals, &fan),
                normals,
                heights,
            }
        };
        let left = side(self.edges.map_each(|edge| edge.left));
        let mut right = side(self.edges.map_each(|edge| edge.right));
        // From the right the edge runs the other way.
        right.doubled_areas = -right.doubled_areas;
        [left, right]
    }

    /// The parts of the edges that have at most one crossing; a whole edge is its own first part.
    #[inline(always)]
    pub(crate) fn parts(&self) -> [PartQuad; 2] {
        let [start, end] = self.ends;
        let are_known = self.are_resolved | !self.are_parted;
        let (middle, share) = self.crossings.points(&self.ends, self.are_resolved);
        let part = |sectors, shares: f64x4, ends| PartQuad {
            sectors,
            shares: shares & are_known,
            ends,
        };
        [
            part(self.sectors[0], share, [start, middle]),
            part(self.sectors[1], f64x4::ONE - share, [middle, end]),
        ]
    }
}

impl SideQuad {
    /// Six times the volumes of the tetrahedra that the center and the anchors make with the edges.
    #[inline(always)]
    pub(crate) fn six_volumes(&self) -> f64x4 {
        self.heights * self.doubled_areas
    }
}

impl QuadCrossings {
    /// Those of the edges from `a` to `b`, where the sectors' distances are `own`: that of the first
    /// sector at the starts, and of the second one at the ends.
    #[inline(always)]
    fn new([a, b]: [&[f64x4; 3]; 2], [from, to]: [&QuadSectors; 2], own: [f64x4; 2]) -> Self {
        let third = from.third_axes(to);
        let [a_from, a_to, a_third] = [own[0], to.distance(a), third.coordinate(a)];
        let [b_from, b_to, b_third] = [from.distance(b), own[1], third.coordinate(b)];
        // Times what the second sector gains, so that what decides need not wait for a quotient.
        let (fall, rise) = (a_from - a_to, b_to - b_from);
        let distance = a_from * rise + b_from * fall;
        let along = a_third * rise + b_third * fall;
        let scale = f64x4::ONE / (fall + rise);
        let is_finite = scale.abs().simd_le(f64x4::splat(f64::MAX));
        let velocity = third.is_start.select(b_from - a_from, b_to - a_to);
        let signed = third.is_start.select(scale, -scale);
        Self {
            are_undisturbed: along.abs().simd_le(distance),
            are_valid: third.are_two & is_finite,
            leads: [fall, rise],
            shares: fall * scale,
            at: [
                distance * scale,
                along * scale,
                velocity * signed,
                (b_third - a_third) * signed,
            ],
        }
    }

    /// The points of the crossings that are resolved, or else the ends, and their shares of the edges.
    #[inline(always)]
    fn points(&self, [start, end]: &[PointQuad; 2], are_resolved: f64x4) -> (PointQuad, f64x4) {
        let shares = are_resolved.select(self.shares, f64x4::ONE);
        let between = |axis: usize| start.at[axis] + shares * (end.at[axis] - start.at[axis]);
        let point = PointQuad {
            at: [0, 1, 2].map_each(between),
            distances: are_resolved.select(self.at[0], end.distances),
        };
        (point, shares)
    }

    /// The crossings one by one as lanes of [`crate::energy::sector::SegmentEnd`], for the facets on the
    /// left.
    #[inline(always)]
    pub(crate) fn rows(&self) -> [f64x4; BLOCK] {
        f64x4::transpose(self.at)
    }
}

impl DoubleCrossings {
    /// Those of edges that begin and end in different sectors.
    ///
    /// Where the distances of these agree, that of the third axis may be larger: then its sector comes
    /// between. With convexity, no other does unless that distance is negative.
    #[inline(always)]
    pub(crate) fn new(quad: &EdgeQuad<'_>) -> Self {
        let EdgeQuad {
            ends: [PointQuad { at: a, .. }, PointQuad { at: b, .. }],
            sectors: [from, to],
            crossings: direct,
            ..
        } = quad;
        let [distance, third, ..] = direct.at;
        let between = from.third_axes(to).sectors(third);
        let [a_between, b_between] = [a, b].map_each(|end| between.distance(end));
        let into = QuadCrossings::new([a, b], [from, &between], [from.own_distance(), b_between]);
        let out = QuadCrossings::new([a, b], [&between, to], [a_between, to.own_distance()]);
        let is_positive = |number: f64x4| number.simd_ge(f64x4::ZERO);
        let are_resolved = quad.are_parted
            & direct.are_valid
            & is_positive(distance)
            & into.are_valid
            & is_positive(into.leads[1])
            & out.are_valid
            & is_positive(out.leads[0])
            & into.shares.simd_le(out.shares);
        Self {
            between,
            crossings: [into, out],
            are_resolved,
        }
    }

    /// The sectors before and after either crossing.
    #[inline(always)]
    pub(crate) fn sectors(&self, quad: &EdgeQuad<'_>) -> [[QuadSectors; 2]; 2] {
        let [from, to] = quad.sectors;
        [[from, self.between], [self.between, to]]
    }

    /// The parts of the edges that are resolved.
    #[inline(always)]
    pub(crate) fn parts(&self, quad: &EdgeQuad<'_>) -> [PartQuad; 3] {
        let ([start, end], [from, to]) = (quad.ends, quad.sectors);
        let [(into, first), (out, last)] = (self.crossings.each_ref())
            .map(|crossings| crossings.points(&quad.ends, self.are_resolved));
        let part = |sectors, shares: f64x4, ends| PartQuad {
            sectors,
            shares: shares & self.are_resolved,
            ends,
        };
        [
            part(from, first, [start, into]),
            part(self.between, last - first, [into, out]),
            part(to, f64x4::ONE - last, [out, end]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::energy::edge_crossings::{EdgeCrossing, edge_crossings};
    use crate::energy::prepared::{Bits, PreparedPiece};
    use crate::energy::sector::{InterfaceEnd, SegmentEnd};

    #[test]
    fn four_sectors_at_once_are_those_of_each() {
        let values = [-1.0, -0.5, 0.0, 0.5, 1.0];
        for (x, y) in values.iter().flat_map(|&x| values.map(|y| (x, y))) {
            let z = [-1.0, 0.25, 0.5, 1.0];
            let all = [f64x4::splat(x), f64x4::splat(y), f64x4::new(z)];
            let codes = QuadSectors::of(&all).codes(0).to_array();
            for (code, z) in codes.into_iter().zip(z) {
                let number = code.to_bits() as usize % Sector::SLOTS;
                assert_eq!(number, Sector::of(&Vector3::new(x, y, z)).number());
            }
        }
    }

    /// A crossing of one of four edges.
    fn crossing(all: &QuadCrossings, sectors: &[QuadSectors; 2], lane: usize) -> EdgeCrossing {
        let code = crossing_codes(sectors).to_array()[lane];
        EdgeCrossing {
            to: Sector::of_number(code.to_bits() as usize / Sector::SLOTS % Sector::SLOTS),
            share: all.shares.to_array()[lane],
            end: InterfaceEnd::of_code(code),
            at: SegmentEnd(all.rows()[lane]),
            is_rounded: false,
        }
    }

    /// Compares the crossings found side by side with those found one by one.
    fn compare(ends: &[Vector3<f64>; 2], crossings: &[EdgeCrossing]) {
        let all: Vec<_> = edge_crossings(ends.each_ref()).collect();
        assert_eq!(crossings.len(), all.len(), "{ends:?}");
        for (one, other) in crossings.iter().zip(&all) {
            assert_eq!((one.to, one.end), (other.to, other.end), "{ends:?}");
            assert!((one.share - other.share).abs() < 1e-14, "{ends:?}");
            let point = one.end.interface().displacement(&one.at.point());
            let there = ends[0].lerp(&ends[1], one.share);
            assert!((there - point).amax() < 1e-14, "{ends:?}");
            let [[.., g, g_third], [.., h, h_third]] =
                [one, other].map(|each| each.at.0.to_array());
            assert!((g - h).abs() < 1e-9 * (1.0 + h.abs()));
            assert!((g_third - h_third).abs() < 1e-9 * (1.0 + h_third.abs()));
        }
    }

    /// The property is checked on 2000 edges between points on a curve that fills a cube.
    #[test]
    fn crossings_of_four_edges_are_those_of_each() {
        let (mut resolved, mut unresolved) = ([0; 3], 0);
        for number in 0..500 {
            let point =
                |turn: f64| Vector3::new(turn.sin(), (1.7 * turn).cos(), (2.3 * turn).sin());
            let ends = [0, 1, 2, 3].map(|lane| {
                let turn = f64::from(BLOCK as u32 * number + lane);
                [turn, turn * 1.37 + 1.0].map(point)
            });
            let mut piece = PreparedPiece::default();
            let rows = ends.as_flattened().iter();
            (piece.vertices).assign(rows.map(|end| [end.x, end.y, end.z, 0.0]));
            let edges = [0, 2, 4, 6].map(|from| Edge {
                from,
                to: from + 1,
                left: 0,
                right: 0,
            });
            let center = &Vector3::zeros();
            let view = CenteredPiece {
                piece: &piece,
                center,
            };
            let quad = EdgeQuad::new(&view, &edges);
            let double = DoubleCrossings::new(&quad);
            let bits = |mask: f64x4| Bits(u64::from(mask.to_bitmask()));
            for lane in bits(!quad.are_parted) {
                compare(&ends[lane], &[]);
                resolved[0] += 1;
            }
            for lane in bits(quad.are_resolved) {
                let one = crossing(&quad.crossings, &quad.sectors, lane);
                compare(&ends[lane], &[one]);
                resolved[1] += 1;
            }
            let others = quad.are_parted & !quad.are_resolved;
            let sectors = double.sectors(&quad);
            for lane in bits(others & double.are_resolved) {
                let both = [0, 1].map(|k: usize| crossing(&double.crossings[k], &sectors[k], lane));
                compare(&ends[lane], &both);
                resolved[2] += 1;
            }
            unresolved += (others & !double.are_resolved).to_bitmask().count_ones();
        }
        assert!(
            resolved[0] > 100 && resolved[1] > 500 && resolved[2] > 200,
            "{resolved:?}"
        );
        assert!(unresolved > 0, "some edges join opposite sectors");
    }
}
