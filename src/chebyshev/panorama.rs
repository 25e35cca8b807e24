//! A piece as it is seen from the center: where its vertices and facets stand.

use nalgebra::Vector3;
use wide::f64x4;

use crate::chebyshev::integrand::{EdgeConstants, Integrand};
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::Sight;
use crate::chebyshev::visit::{FacetView, Side};
use crate::geometry::compact::BLOCK;
use crate::geometry::half_space::HalfSpace;

/// A vertex as seen from the center. With its displacement goes its sector.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VertexSight(Sight);

/// A facet as seen from the center. With the displacement of its anchor go its height above the
/// center, and one over that.
#[derive(Clone, Copy, Debug, Default)]
struct FacetSight(Sight);

/// A piece as seen from a center, in memory to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panorama {
    vertices: Vec<VertexSight>,
    facets: Vec<FacetSight>,
}

impl VertexSight {
    /// A vertex at `displacement` from the center.
    #[cfg(test)]
    pub(crate) fn of(displacement: &Vector3<f64>) -> Self {
        let displacement: [f64; 3] = (*displacement).into();
        let away = displacement.map(f64x4::splat);
        let [sight, ..] = Sight::four(away, [Sector::codes_of_four(&away), f64x4::ZERO]);
        Self(sight)
    }

    /// Its displacement.
    #[inline]
    pub(crate) fn sight(&self) -> &Sight {
        &self.0
    }

    /// Its sector.
    #[inline]
    pub(crate) fn sector(&self) -> Sector {
        Sector::of_code(self.0.more()[0])
    }
}

impl Panorama {
    /// Looks at the piece from `center`.
    pub(crate) fn take(&mut self, piece: &Integrand, center: &Vector3<f64>) {
        let center: [f64; 3] = (*center).into();
        let center = center.map(f64x4::splat);
        let blocks = piece.vertices.blocks();
        let sights = rows(&mut self.vertices, blocks.len());
        for (sights, block) in sights.iter_mut().zip(blocks) {
            let away = [0, 1, 2].map(|axis| f64x4::new(block[axis]) - center[axis]);
            let sectors = Sector::codes_of_four(&away);
            *sights = Sight::four(away, [sectors, f64x4::ZERO]).map(VertexSight);
        }
        let sights = rows(&mut self.facets, piece.facets.len().div_ceil(BLOCK));
        for (sights, facets) in sights.iter_mut().zip(piece.facets.chunks(BLOCK)) {
            *sights = facets_from(facets, &center);
        }
    }

    /// Whether all vertices stay in their sectors, and the center below or above every facet, where
    /// the center moves by `step`, which is `from`. Sectors are convex: what is so at both ends of the
    /// step is so all along. If they do, `lowerings` are the shares by which the heights below facets
    /// shrink.
    #[inline]
    pub(crate) fn stays(
        &self,
        piece: &Integrand,
        (step, from): (&Vector3<f64>, &Sight),
        lowerings: &mut Vec<f64>,
    ) -> bool {
        // Cheaper than a branch at each.
        let vertices = self.vertices.iter().take(piece.vertices.len());
        let mut stay = vertices.fold(f64x4::splat(f64::from_bits(u64::MAX)), |all, vertex| {
            all & vertex.0.staying_in(vertex.sector(), from)
        });
        let [x, y, z] = (*step).into();
        let step = [x, y, z].map(f64x4::splat);
        let rows = rows(lowerings, piece.facets.len().div_ceil(BLOCK)).iter_mut();
        let sights = self.facets.as_chunks().0.iter();
        for ((lowerings, sights), facets) in rows.zip(sights).zip(piece.facets.chunks(BLOCK)) {
            let [x, y, z, _] = lanes(facets);
            let lowered = x * step[0] + y * step[1] + z * step[2];
            let per_height = sights.each_ref().map(|FacetSight(sight)| sight.more()[1]);
            let lowering = lowered * f64x4::new(per_height);
            stay &= lowering.simd_lt(f64x4::ONE);
            *lowerings = lowering.to_array();
        }
        stay.to_bitmask() == 0b1111
    }

    /// The vertices at the ends of an edge.
    #[inline]
    pub(crate) fn ends(&self, edge: &EdgeConstants) -> [&VertexSight; 2] {
        [edge.from, edge.to].map(|vertex| &self.vertices[vertex as usize])
    }

    /// A facet of the piece that was looked at.
    #[inline]
    pub(crate) fn facet<'a>(&'a self, piece: &'a Integrand, number: usize) -> FacetView<'a> {
        let FacetSight(anchor) = &self.facets[number];
        let [height, per_height] = anchor.more();
        FacetView {
            number,
            piece,
            anchor,
            height,
            per_height,
        }
    }

    /// The facets beside an edge.
    #[inline]
    pub(crate) fn sides<'a>(&'a self, piece: &'a Integrand, edge: &EdgeConstants) -> [Side<'a>; 2] {
        let both = [(edge.left, edge.left_area), (edge.right, edge.right_area)];
        both.map(|(facet, doubled_area)| Side {
            facet: self.facet(piece, facet as usize),
            doubled_area,
        })
    }
}

/// The first rows of a list, which grows to hold them.
fn rows<Item: Clone + Default>(list: &mut Vec<Item>, count: usize) -> &mut [[Item; BLOCK]] {
    if list.len() < count * BLOCK {
        list.resize(count * BLOCK, Item::default());
    }
    &mut list.as_chunks_mut().0[..count]
}

/// At most four facets as seen from the center.
#[inline(always)]
fn facets_from(facets: &[HalfSpace], center: &[f64x4; 3]) -> [FacetSight; BLOCK] {
    let [x, y, z, offset] = lanes(facets);
    let height = offset - (x * center[0] + y * center[1] + z * center[2]);
    let foot = [x, y, z].map(|along| along * offset);
    let anchor = [0, 1, 2].map(|axis| foot[axis] - center[axis]);
    Sight::four(anchor, [height, f64x4::ONE / height]).map(FacetSight)
}

/// The coordinates of at most four normals, and the offsets. Lanes beyond the last facet repeat the
/// first.
#[inline(always)]
fn lanes(facets: &[HalfSpace]) -> [f64x4; 4] {
    let number = |lane: usize| if lane < facets.len() { lane } else { 0 };
    HalfSpace::lanes([0, 1, 2, 3].map(|lane| &facets[number(lane)]))
}
