//! A piece as it is seen from a center.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::crossing::Passage;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::pierced::height_below;
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::VertexSight;
use crate::chebyshev::visit::{Corner, FacetView, Side, Visit};
use crate::geometry::brep::Edge;
use crate::geometry::small_polyhedron::BLOCK;

/// A piece, and the center from which it is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<'a> {
    pub(crate) piece: &'a Integrand,
    pub(crate) center: &'a Vector3<f64>,
}

impl Seen<'_> {
    /// A vertex.
    #[inline]
    pub(crate) fn vertex(&self, number: u32) -> VertexSight {
        VertexSight::of(&(self.piece.vertices.get(number as usize) - self.center))
    }

    /// The vertices at the ends of an edge.
    #[inline]
    pub(crate) fn ends(&self, edge: &Edge) -> [VertexSight; 2] {
        [edge.from, edge.to].map(|vertex| self.vertex(vertex))
    }

    /// A facet.
    #[inline]
    pub(crate) fn facet(&self, number: usize) -> FacetView {
        let plane = self.piece.facets.get(number);
        FacetView {
            number,
            height: plane.offset - plane.normal.dot(self.center),
            normal: plane.normal,
        }
    }

    /// Four vertices' displacements, by axis.
    #[inline(always)]
    pub(crate) fn four_vertices(&self, numbers: [u32; BLOCK]) -> [f64x4; 3] {
        let ([x, y, z], center) = (self.piece.vertices.four(numbers), self.center);
        [
            x - f64x4::splat(center.x),
            y - f64x4::splat(center.y),
            z - f64x4::splat(center.z),
        ]
    }

    /// Four facets' normals, by axis, and the heights of the center below them.
    #[inline(always)]
    pub(crate) fn four_facets(&self, numbers: [u32; BLOCK]) -> ([f64x4; 3], f64x4) {
        let [x, y, z, offset] = self.piece.facets.four(numbers);
        let center = self.center;
        let center = [
            f64x4::splat(center.x),
            f64x4::splat(center.y),
            f64x4::splat(center.z),
        ];
        ([x, y, z], height_below([x, y, z, offset], center))
    }

    /// The sectors of four vertices, see [`Sector::codes_of_four`].
    #[inline]
    pub(crate) fn codes(&self, block: &[f64x4; 3]) -> f64x4 {
        let away = [0, 1, 2].map(|axis| block[axis] - f64x4::splat(self.center[axis]));
        Sector::codes_of_four(&away)
    }

    /// The facets beside an edge between `ends`.
    #[inline]
    fn sides(&self, edge: &Edge, [a, b]: &[VertexSight; 2]) -> [Side; 2] {
        let fan = a.sight().point().cross(&b.sight().point());
        let side = |facet: u32, fan: Vector3<f64>| {
            let facet = self.facet(facet as usize);
            Side {
                doubled_area: facet.normal.dot(&fan),
                facet,
            }
        };
        [side(edge.left, fan), side(edge.right, -fan)]
    }

    /// Reports an edge's shares sector by sector, with the passages between, to `visitor` and each
    /// passage to `note`.
    #[inline(always)]
    pub(crate) fn report_passages(
        &self,
        edge: &Edge,
        passages: impl IntoIterator<Item = Passage>,
        mut note: impl FnMut(&Passage),
        visitor: &mut (impl Visit + ?Sized),
    ) {
        let ends = self.ends(edge);
        let sides = self.sides(edge, &ends);
        let [first, end] = (ends.each_ref()).map(|end| Corner::new(end.sight(), end.sector()));
        let (mut sector, mut start, mut last) = (ends[0].sector(), 0.0, first);
        for passage in passages {
            let next = passage.corner();
            visitor.share(&sides, sector, passage.share - start, [&last, &next]);
            note(&passage);
            (sector, start, last) = (passage.to, passage.share, next);
        }
        visitor.share(&sides, sector, 1.0 - start, [&last, &end]);
    }
}
