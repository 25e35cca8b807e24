//! Volume and moments of prepared pieces, and mass moments of pieces whose density is a polynomial.

use nalgebra::Vector3;
use wide::f64x4;

use crate::energy::edge_crossings_simd::{EdgeQuad, SideQuad};
use crate::energy::prepared::{CenteredPiece, PreparedPiece};
use crate::geometry::faceted::Piece;
use crate::geometry::lanes::sum;
use crate::geometry::moments::Moments;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Monomials, weight};

impl PreparedPiece {
    /// The volume (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        let (piece, center) = (self, &Vector3::zeros());
        let view = CenteredPiece { piece, center };
        let volumes = self.edges.blocks().iter().map(|edges| {
            let sides = EdgeQuad::new(&view, edges).sides(&view);
            let [left, right] = sides.each_ref().map(SideQuad::six_volumes);
            left + right
        });
        sum(volumes.fold(f64x4::ZERO, |all, some| all + some)) / 6.0
    }

    /// Volume and moments about the origin, by the tetrahedra (origin, q, a, b) of all edges.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let (piece, center) = (self, &Vector3::zeros());
        let view = CenteredPiece { piece, center };
        let mut moments = Moments::default();
        for edge in self.edges.blocks().as_flattened() {
            let [a, b] = [edge.from, edge.to].map(|vertex| self.vertices.vector(vertex as usize));
            let (sum, squares) = (a + b, a.norm_squared() + b.norm_squared());
            for (facet, fan) in [(edge.left, a.cross(&b)), (edge.right, b.cross(&a))] {
                let facet = view.facet(facet as usize);
                let foot = facet.anchor();
                let volume = facet.normal.dot(&fan) * facet.height / 6.0;
                let all = sum + foot;
                moments.volume += volume;
                moments.first += all * (volume / 4.0);
                let squares = squares + foot.norm_squared() + all.norm_squared();
                moments.second += volume / 20.0 * squares;
            }
        }
        moments
    }
}

/// ∫ ρ, ∫ ρ y and ∫ ρ |y|² over the piece, `density` and y about the origin of its coordinates.
/// `volume` of the answer is the mass.
#[must_use]
pub fn mass_moments(piece: Piece<'_>, density: &Polynomial) -> Moments {
    let monomials = Monomials::up_to(density.degree() + 2);
    let mut sums = vec![0.0; monomials.exponents().len()];
    let mut table = Vec::new();
    piece.visit_fans(|anchor, a, b| {
        let volume = anchor.dot(&a.cross(&b)) / 6.0;
        let corners = [anchor, a, b].map(<[f64; 3]>::from);
        monomials.coefficients(&corners, &mut table);
        for (sum, coefficient) in sums.iter_mut().zip(&table) {
            *sum += volume * coefficient;
        }
    });
    let integral = |powers: [u32; 3]| {
        let terms = density.terms().map(|(term, value)| {
            let exponents = [0, 1, 2].map(|axis| term[axis] + powers[axis]);
            let place = monomials.place(exponents);
            value * place.map_or(0.0, |place| weight(3, exponents) * sums[place])
        });
        terms.sum::<f64>()
    };
    Moments {
        volume: integral([0; 3]),
        first: Vector3::new(
            integral([1, 0, 0]),
            integral([0, 1, 0]),
            integral([0, 0, 1]),
        ),
        second: integral([2, 0, 0]) + integral([0, 2, 0]) + integral([0, 0, 2]),
    }
}
