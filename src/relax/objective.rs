//! The global objective: the energy of all cells as a function of all sites.
//!
//! F(x_1 … x_n) = Σ_i ∫_{C_i} d∞(x_i, y)^p dy, the cells those of the L2 diagram: the functional of
//! \[LL\] with its norm at infinity, integrated exactly. Lloyd's iteration sees only how a cell's
//! energy changes while the cell stands still; this gradient also knows what a site does to its
//! neighbors' cells, and so feels rows of cells that have slid past each other.
//!
//! \[LL\] Lévy & Liu, *Lp Centroidal Voronoi Tessellation and its Applications*, 2010.
//!
//! Every cell is visited once and gives one term per facet to the site beyond it. The terms
//! are added in site order, so the sum does not depend on the number of threads.

use nalgebra::{SVector, Vector3};

use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::energy::evaluation::energy;
use crate::energy::facet_terms::{FacetTermScratch, facet_terms};
use crate::integrals::exact_sum::exact_sums;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::frames::Frames;
use crate::relax::relaxation_space::ObjectiveValue;
use crate::voronoi::cell::Cell;

/// The terms of one cell.
#[derive(Debug)]
pub(crate) struct CellTerms<const D: usize> {
    pub(crate) volume: f64,
    pub(crate) energy: f64,
    pub(crate) chebyshev: f64,
    pub(crate) gradient: SVector<f64, D>,
    /// Terms of the gradients by the neighbors.
    pub(crate) across: Vec<(u32, SVector<f64, D>)>,
}

#[derive(Debug, Default)]
pub(crate) struct ObjectiveScratch {
    cell: CellMemory,
    borders: FacetTermScratch,
}

/// The objective at sites whose cells have these terms, in site order.
pub(crate) fn sum_of<const D: usize>(cells: &[CellTerms<D>]) -> ObjectiveValue<D> {
    let [energy, chebyshev] = exact_sums(cells, |cell| [cell.energy, cell.chebyshev]);
    let mut sum = ObjectiveValue {
        energy: energy.value(),
        chebyshev: chebyshev.value(),
        energy_max: 0.0,
        gradient: vec![SVector::zeros(); cells.len()],
        energies: cells.iter().map(|cell| cell.energy).collect(),
    };
    for (site, cell) in cells.iter().enumerate() {
        sum.energy_max = sum.energy_max.max(cell.energy);
        sum.gradient[site] += cell.gradient;
        for &(neighbor, term) in &cell.across {
            sum.gradient[neighbor as usize] += term;
        }
    }
    sum
}

impl ObjectiveScratch {
    /// The terms of a cell of `domain` for the energy of order `order` ≥ 1.
    pub(crate) fn terms(
        &mut self,
        domain: &dyn Domain,
        frames: &Frames,
        cell: &Cell<'_>,
        order: u32,
    ) -> CellTerms<3> {
        self.cell.load_in_frame(domain, cell, frames.of(cell.site));
        let volume = self.cell.volume();
        let (pieces, walk) = self.cell.pieces();
        let facets = pieces.iter().map(|piece| piece.piece.facets.len());
        let mut across = Vec::with_capacity(facets.sum());
        let mut own = Vector3::zeros();
        let inside = facet_terms(
            pieces,
            order,
            (&mut *walk, &mut self.borders),
            |label| matches!(FacetKind::of(label), FacetKind::Neighbor { .. }),
            |push| {
                if let FacetKind::Neighbor { site, .. } = FacetKind::of(push.label) {
                    own += push.own;
                    across.push((site, push.across));
                }
            },
        );
        let chebyshev = if order == 1 {
            inside.value
        } else {
            energy(pieces, &Vector3::zeros(), 1, walk).value
        };
        for (_, term) in &mut across {
            *term = self.cell.in_space(*term);
        }
        CellTerms {
            volume,
            energy: inside.value,
            chebyshev: chebyshev / domain.mean_density(),
            gradient: self.cell.in_space(inside.gradient + own),
            across,
        }
    }
}
