//! Volume and moments of prepared pieces.

use nalgebra::Vector3;
use wide::f64x4;

use crate::arrays::MapEach;
use crate::energy::edge_crossings_simd::{EdgeQuad, SideQuad};
use crate::energy::prepared::{CenteredPiece, PreparedPiece};
use crate::geometry::moments::Moments;
use crate::geometry::simd::sum;

impl PreparedPiece {
    /// The volume (L³).
    #[must_use]
    pub(crate) fn volume(&self) -> f64 {
        let (piece, center) = (self, &Vector3::zeros());
        let view = CenteredPiece { piece, center };
        let volumes = self.edges.blocks().iter().map(|edges| {
            let sides = EdgeQuad::new(&view, edges).sides(&view);
            let [left, right] = sides.each_ref().map_each(SideQuad::six_volumes);
            left + right
        });
        sum(volumes.fold(f64x4::ZERO, |all, some| all + some)) / 6.0
    }

    /// Volume and moments about the origin, by the tetrahedra (origin, q, a, b) of all edges.
    #[must_use]
    pub(crate) fn moments(&self) -> Moments {
        let (piece, center) = (self, &Vector3::zeros());
        let view = CenteredPiece { piece, center };
        let mut moments = Moments::default();
        for edge in self.edges.blocks().as_flattened() {
            let [a, b] =
                [edge.from, edge.to].map_each(|vertex| self.vertices.vector(vertex as usize));
            let (sum, squares) = (a + b, a * a.transpose() + b * b.transpose());
            for (facet, fan) in [(edge.left, a.cross(&b)), (edge.right, b.cross(&a))] {
                let facet = view.facet(facet as usize);
                let foot = facet.anchor();
                let volume = facet.normal.dot(&fan) * facet.height / 6.0;
                let all = sum + foot;
                moments.mass += volume;
                moments.first += all * (volume / 4.0);
                let squares = squares + foot * foot.transpose() + all * all.transpose();
                moments.second += squares * (volume / 20.0);
            }
        }
        moments
    }
}
