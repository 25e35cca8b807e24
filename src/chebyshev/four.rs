//! Four edges of a piece side by side, as seen from a center, for a processor to work on together.
//!
//! Every facet f is fanned from its *anchor*, the foot q of the perpendicular from the center. The
//! triangle (q, a, b) of a directed edge has twice the area σ = n·(a×b), n the unit normal, a and b
//! displacements from the center; its tetrahedron with the center has six times the volume σ H with
//! H = d − n·c, the signed height of the center below the facet. No polygon is cut for an integral: an
//! edge that runs through several sectors splits its σ in proportion.
//!
//! # Where edges pass from one sector to another
//!
//! The sectors of an edge's ends have equal distances at one point of the edge. If no third distance is
//! larger there, no other sector comes between: the Chebyshev distance is convex, so a sector that has it
//! at two points has it all between. Such a passage is *told* here, with four at once, as `crossing`
//! tells it alone; what is neither told nor *whole*, within one sector, is left to `crossing`.

use wide::f64x4;

use crate::chebyshev::crossing::Passage;
use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::endpoints::Found;
use crate::chebyshev::sector::FourSectors;
use crate::chebyshev::seen::Seen;
use crate::geometry::brep::Edge;
use crate::geometry::simd::{cross, dot};
use crate::geometry::small_polyhedron::BLOCK;

/// Four edges.
#[derive(Debug)]
pub(crate) struct FourEdges<'a> {
    pub(crate) edges: &'a [Edge; BLOCK],
    /// The displacements of their ends, by axis.
    pub(crate) ends: [[f64x4; 3]; 2],
    /// The sectors of their ends.
    pub(crate) sectors: [FourSectors; 2],
    /// Which begin and end in different sectors.
    pub(crate) are_parted: f64x4,
    pub(crate) are_told: f64x4,
    pub(crate) passages: FourPassages,
}

/// A facet beside each edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FourSides {
    /// The unit normals, by axis.
    pub(crate) normals: [f64x4; 3],
    /// The heights of the center below the facets.
    pub(crate) heights: f64x4,
    /// Twice the signed areas of the triangles of the anchors and the edges.
    pub(crate) areas: f64x4,
}

/// Where edges pass from one sector to another, if no third comes between.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FourPassages {
    /// Where none does: both distances are the largest.
    pub(crate) are_undisturbed: f64x4,
    /// Where the sectors are of two axes, and the one ahead gains.
    pub(crate) are_sound: f64x4,
    /// By how much the one behind is ahead at the edges' starts, and behind at their ends (L).
    pub(crate) leads: [f64x4; 2],
    /// The shares of the edges that lie behind.
    pub(crate) shares: f64x4,
    /// The Chebyshev distances, the coordinates along the third axes, and how both slide.
    pub(crate) found: [f64x4; 4],
}

impl<'a> FourEdges<'a> {
    /// Four edges as seen from a center.
    #[inline(always)]
    pub(crate) fn new(seen: &Seen<'_>, edges: &'a [Edge; BLOCK]) -> Self {
        let a = seen.four_vertices(edges.map(|edge| edge.from));
        let b = seen.four_vertices(edges.map(|edge| edge.to));
        let sectors = [FourSectors::of(&a), FourSectors::of(&b)];
        let [from, to] = &sectors;
        let own = [from.own_distance(), to.own_distance()];
        let passages = FourPassages::new([&a, &b], [from, to], own);
        let are_parted = from.differ(to);
        let are_told = are_parted & passages.are_sound & passages.are_undisturbed;
        Self {
            edges,
            ends: [a, b],
            sectors,
            are_parted,
            are_told,
            passages,
        }
    }

    /// The facets left of them, and right.
    #[inline(always)]
    pub(crate) fn sides(&self, seen: &Seen<'_>) -> [FourSides; 2] {
        let [a, b] = &self.ends;
        let fan = cross(a, b);
        let side = |facets: [u32; BLOCK]| {
            let (normals, heights) = seen.four_facets(facets);
            FourSides {
                areas: dot(&normals, &fan),
                normals,
                heights,
            }
        };
        let left = side(self.edges.map(|edge| edge.left));
        let mut right = side(self.edges.map(|edge| edge.right));
        // From the right the edge runs the other way.
        right.areas = -right.areas;
        [left, right]
    }

    /// Which are whole or told.
    #[inline(always)]
    pub(crate) fn are_known(&self) -> f64x4 {
        self.are_told | !self.are_parted
    }

    /// Which are told, and which are neither told nor whole, as sets of bits.
    #[inline(always)]
    pub(crate) fn told_and_far(&self) -> [u64; 2] {
        let [parted, told] = [self.are_parted, self.are_told].map(f64x4::to_bitmask);
        [told, parted & !told].map(u64::from)
    }
}

impl FourSides {
    /// Six times the volumes of the tetrahedra that the center and the anchors make with the edges.
    #[inline(always)]
    pub(crate) fn six_volumes(&self) -> f64x4 {
        self.heights * self.areas
    }
}

impl FourPassages {
    /// Those on the edges between four starts and ends, where the sectors' distances are `own`: that of
    /// the one behind at the starts, and of the one ahead at the ends.
    #[inline(always)]
    pub(crate) fn new(
        [a, b]: [&[f64x4; 3]; 2],
        [from, to]: [&FourSectors; 2],
        own: [f64x4; 2],
    ) -> Self {
        let third = from.third_axes(to);
        let [a_from, a_to, a_third] = [own[0], to.distance(a), third.along(a)];
        let [b_from, b_to, b_third] = [from.distance(b), own[1], third.along(b)];
        // Times what the sector ahead gains, so that what decides need not wait for a quotient.
        let (fall, rise) = (a_from - a_to, b_to - b_from);
        let distance = a_from * rise + b_from * fall;
        let along = a_third * rise + b_third * fall;
        let scale = f64x4::ONE / (fall + rise);
        let is_finite = scale.abs().simd_le(f64x4::splat(f64::MAX));
        let slide = third.is_start.select(b_from - a_from, b_to - a_to);
        let signed = third.is_start.select(scale, -scale);
        Self {
            are_undisturbed: along.abs().simd_le(distance),
            are_sound: third.are_sound & is_finite,
            leads: [fall, rise],
            shares: fall * scale,
            found: [
                distance * scale,
                along * scale,
                slide * signed,
                (b_third - a_third) * signed,
            ],
        }
    }

    /// One by one, those between these sectors; meaningless where they cannot be told.
    #[inline(always)]
    pub(crate) fn alone(&self, sectors: &[FourSectors; 2]) -> [Passage; BLOCK] {
        let (found, shares) = (self.rows(), self.shares.to_array());
        let codes = Endpoint::passing_codes(sectors).to_array();
        [0, 1, 2, 3].map(|lane: usize| Passage {
            to: Endpoint::end_of_passing_code(codes[lane]),
            share: shares[lane],
            endpoint: Endpoint::of_passing_code(codes[lane]),
            found: Found::of_lanes(found[lane]),
            is_rounded: false,
        })
    }

    /// The places of the passages, for the facets on the left: see [`Found::lanes`].
    #[inline(always)]
    pub(crate) fn rows(&self) -> [f64x4; BLOCK] {
        f64x4::transpose(self.found)
    }
}
