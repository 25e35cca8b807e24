//! A piece as it is seen from the center: where its vertices and facets stand.

use nalgebra::Vector3;

use crate::chebyshev::integrand::{EdgeConstants, FacetConstants, Integrand};
use crate::chebyshev::sector::Sector;
use crate::chebyshev::sight::Sight;
use crate::chebyshev::visit::{FacetView, Side};

/// A vertex as seen from the center.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexSight {
    pub(crate) sight: Sight,
    pub(crate) sector: Sector,
}

/// A facet as seen from the center.
#[derive(Clone, Copy, Debug)]
struct FacetSight {
    height: f64,
    per_height: f64,
    anchor: Sight,
}

/// A piece as seen from a center, in memory to be reused from one center to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panorama {
    vertices: Vec<VertexSight>,
    facets: Vec<FacetSight>,
}

impl Panorama {
    /// Looks at the piece from `center`, which is `from`. Out of line, lest the compiler finds out
    /// how the lanes of `from` hang together and takes them one by one.
    #[inline(never)]
    pub(crate) fn take(&mut self, piece: &Integrand, center: &Vector3<f64>, from: &Sight) {
        self.vertices.clear();
        self.vertices.extend(piece.vertices.iter().map(|vertex| {
            let sight = vertex.from(from);
            let sector = sight.sector();
            VertexSight { sight, sector }
        }));
        self.facets.clear();
        self.facets.extend(piece.facets.iter().map(|facet| {
            let height = facet.offset - facet.normal.dot(center);
            FacetSight {
                height,
                per_height: 1.0 / height,
                anchor: facet.foot.from(from),
            }
        }));
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
        let mut vertices = self.vertices.iter();
        if !vertices.all(|vertex| vertex.sight.stays_in(vertex.sector, from)) {
            return false;
        }
        lowerings.clear();
        lowerings.extend(self.facets.iter().zip(&piece.facets).map(
            |(sight, facet): (&FacetSight, &FacetConstants)| {
                sight.per_height * facet.normal.dot(step)
            },
        ));
        lowerings.iter().all(|&lowering| lowering < 1.0)
    }

    /// The vertices at the ends of an edge.
    #[inline]
    pub(crate) fn ends(&self, edge: &EdgeConstants) -> [&VertexSight; 2] {
        [edge.from, edge.to].map(|vertex| &self.vertices[vertex as usize])
    }

    /// A facet of the piece that was looked at.
    #[inline]
    pub(crate) fn facet<'a>(&'a self, piece: &'a Integrand, number: usize) -> FacetView<'a> {
        let sight = &self.facets[number];
        FacetView {
            number,
            piece,
            anchor: &sight.anchor,
            height: sight.height,
            per_height: sight.per_height,
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
