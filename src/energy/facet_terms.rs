//! The gradient of the global objective: energies of cells, and integrals over their moving facets.
//!
//! F = Σ_i ∫_{C_i} d∞(x_i, y)^p dy changes with a site not only because distances do, but also
//! because the bisectors move (Lévy & Liu, *Lp Centroidal Voronoi Tessellation*, 2010, with their
//! norm at infinity). Under δx_i and δx_j a point y of the facet between C_i and C_j moves outward
//! by [(y − x_i)·δx_i − (y − x_j)·δx_j] / |x_j − x_i|. So a facet f of C_i with the neighbor at r
//! (relative to x_i) adds to the gradient
//! - for its own site (1/|r|) ∫_f d∞^p (y − x_i) dA,
//! - for its neighbor −(1/|r|) ∫_f d∞^p (y − x_i − r) dA.
//!
//! For p = 1 the energy itself is Σ_f H_f/4 ∫_f d∞ dA, H_f the site's height below the facet, since d∞ is
//! homogeneous about the site.

use nalgebra::Vector3;

use crate::energy::evaluation::{EnergyScratch, SignedPiece};
use crate::energy::prepared::PreparedPiece;
use crate::energy::sums_linear::LinearFacetSums;
use crate::energy::sums_polynomial::{PolynomialTerms, polynomial_integrals};
use crate::energy::sums_power::PowerSums;
use crate::energy::surface::{FacetIntegrals, SurfaceScratch, sum_over_surface};
use crate::geometry::label::Label;

/// What one facet adds to the gradients of the sites on its two sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FacetGradient {
    /// The facet's label.
    pub label: Label,
    /// ∂E/∂x_i by the facet's motion (L^(2+p)).
    pub own: Vector3<f64>,
    /// ∂E/∂x_j, x_j the mirror image of the site in the facet's plane (L^(2+p)).
    pub across: Vector3<f64>,
}

/// A cell's energy about its site and the part of its gradient that comes from distances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CellTerm {
    /// ∫ d∞^p (L^(3+p)).
    pub value: f64,
    /// ∂E/∂x_i with the cell held fixed (L^(2+p)).
    pub gradient: Vector3<f64>,
}

/// The memory of [`facet_terms`], to be reused from one cell to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct FacetTermScratch {
    facets: Vec<FacetIntegrals>,
    /// For pieces with a density.
    terms: Option<PolynomialTerms>,
}

/// Computes the energy of order `order` of `pieces` about their site, the origin, and passes to `visit`
/// the terms in the gradients of every facet whose label `is_bisector`.
pub(crate) fn facet_terms<'a>(
    pieces: impl IntoIterator<Item = &'a SignedPiece>,
    order: u32,
    (energy, scratch): (&mut EnergyScratch, &mut FacetTermScratch),
    is_bisector: impl Fn(Label) -> bool,
    mut visit: impl FnMut(FacetGradient),
) -> CellTerm {
    let mut total = CellTerm::default();
    for SignedPiece { sign, piece } in pieces {
        let term = piece_term(piece, order, &mut energy.surface, scratch);
        total.value += sign * term.value;
        total.gradient += term.gradient * *sign;
        let facets = piece.facets.iter().zip(&piece.labels);
        for ((&[x, y, z, offset], &label), sums) in facets.zip(&scratch.facets) {
            let (weight, first) = (sums.weight() * sign, sums.first() * *sign);
            if weight.abs() > 0.0 && is_bisector(label) {
                let distance = 2.0 * offset;
                visit(FacetGradient {
                    label,
                    own: first / distance,
                    across: Vector3::new(x, y, z) * weight - first / distance,
                });
            }
        }
    }
    total
}

/// The energy of a piece and its gradient; the integrals over its facets are left in `scratch`.
fn piece_term(
    piece: &PreparedPiece,
    order: u32,
    surface: &mut SurfaceScratch,
    scratch: &mut FacetTermScratch,
) -> CellTerm {
    let FacetTermScratch { facets, terms } = scratch;
    facets.clear();
    facets.resize(piece.facets.len(), FacetIntegrals::default());
    let origin = &Vector3::zeros();
    let at_site = (origin, order);
    let polynomial = polynomial_integrals(piece, at_site, Some(facets), surface, terms);
    let integrals = if let Some(integrals) = polynomial {
        integrals
    } else if order == 1 {
        let mut sums = LinearFacetSums::new(facets);
        sum_over_surface(piece, origin, surface, &mut sums);
        let gradient = sums.gradient();
        let heights = piece.facets.iter().zip(&*facets);
        let heights = heights.map(|([.., offset], sums)| sums.weight() * offset);
        let value = heights.sum::<f64>() / 4.0;
        return CellTerm { value, gradient };
    } else {
        let mut sums = PowerSums::new(order, Some(facets));
        sum_over_surface(piece, origin, surface, &mut sums);
        sums.integrals
    };
    CellTerm {
        value: integrals.value,
        gradient: integrals.gradient(order),
    }
}
