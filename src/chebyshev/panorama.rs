//! A piece as it is seen from the center: where its vertices and facets stand.

use std::ops::{Add, Mul, Sub};

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
    center: Vector3<f64>,
    vertices: Vec<VertexSight>,
    /// The sectors of the vertices, see [`Sector::of_code`].
    codes: Vec<f64x4>,
    facets: Vec<FacetSight>,
}

impl VertexSight {
    /// A vertex at `displacement` from the center.
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
        self.center = *center;
        let center: [f64; 3] = (*center).into();
        let center = center.map(f64x4::splat);
        let blocks = piece.vertices.blocks();
        let sights = rows(&mut self.vertices, blocks.len());
        if self.codes.len() < blocks.len() {
            self.codes.resize(blocks.len(), f64x4::ZERO);
        }
        for ((sights, block), codes) in sights.iter_mut().zip(blocks).zip(&mut self.codes) {
            let away = away(block, &center);
            *codes = Sector::codes_of_four(&away);
            *sights = Sight::four(away, [*codes, f64x4::ZERO]).map(VertexSight);
        }
        let sights = rows(&mut self.facets, piece.facets.len().div_ceil(BLOCK));
        for (sights, facets) in sights.iter_mut().zip(piece.facets.chunks(BLOCK)) {
            *sights = facets_from(facets, center);
        }
    }

    /// From where the piece was looked at.
    #[inline]
    pub(crate) fn center(&self) -> &Vector3<f64> {
        &self.center
    }

    /// The sectors of the vertices, in blocks.
    #[inline]
    pub(crate) fn codes(&self, piece: &Integrand) -> &[f64x4] {
        &self.codes[..piece.vertices.blocks().len()]
    }

    /// Whether all vertices are in the same sectors as seen from another center.
    #[inline]
    pub(crate) fn do_vertices_stay(&self, piece: &Integrand, center: &Vector3<f64>) -> bool {
        let count = piece.vertices.len();
        let blocks = piece.vertices.blocks().iter().zip(&self.codes);
        let moved = blocks
            .enumerate()
            .fold(0, |moved, (block, (points, codes))| {
                let elsewhere = codes_from(points, center).simd_ne(*codes).to_bitmask();
                // What the last block has beyond the last vertex does not count.
                moved | elsewhere & ((1 << (count - block * BLOCK).min(BLOCK)) - 1)
            });
        moved == 0
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

/// The sectors of four vertices as seen from a center.
#[inline]
pub(crate) fn codes_from(block: &[[f64; BLOCK]; 3], center: &Vector3<f64>) -> f64x4 {
    let center: [f64; 3] = (*center).into();
    Sector::codes_of_four(&away(block, &center.map(f64x4::splat)))
}

/// Four vertices as seen from the center.
#[inline(always)]
fn away(block: &[[f64; BLOCK]; 3], center: &[f64x4; 3]) -> [f64x4; 3] {
    [0, 1, 2].map(|axis| f64x4::new(block[axis]) - center[axis])
}

/// At most four facets as seen from the center.
#[inline(always)]
fn facets_from(facets: &[HalfSpace], center: [f64x4; 3]) -> [FacetSight; BLOCK] {
    let [x, y, z, offset] = lanes(facets);
    let height = height_below([x, y, z], offset, center);
    let foot = [x, y, z].map(|along| along * offset);
    let anchor = [0, 1, 2].map(|axis| foot[axis] - center[axis]);
    Sight::four(anchor, [height, f64x4::ONE / height]).map(FacetSight)
}

/// The height of `center` below a plane, in one lane or in four.
#[inline(always)]
pub(crate) fn height_below<T>([x, y, z]: [T; 3], offset: T, center: [T; 3]) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    offset - (x * center[0] + y * center[1] + z * center[2])
}

/// The coordinates of at most four normals, and the offsets. Lanes beyond the last facet repeat the
/// first.
#[inline(always)]
pub(crate) fn lanes(facets: &[HalfSpace]) -> [f64x4; 4] {
    let number = |lane: usize| if lane < facets.len() { lane } else { 0 };
    HalfSpace::lanes([0, 1, 2, 3].map(|lane| &facets[number(lane)]))
}
