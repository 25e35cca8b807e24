//! The global objective: the energy of all cells as a function of all sites.
//!
//! F(x_1 … x_n) = Σ_i ∫_{C_i} d∞(x_i, y)^p dy, the cells those of the L2 diagram: the functional of
//! \[LL\] with its norm at infinity, integrated exactly. Lloyd's iteration sees only how a cell's
//! energy changes while the cell stands still; this gradient also knows what a site does to its
//! neighbors' cells, and so feels rows of cells that have slid past each other.
//!
//! \[LL\] Lévy & Liu, *Lp Centroidal Voronoi Tessellation and its Applications*, 2010.
//!
//! Every cell is visited once and hands out one push per facet to the site beyond it. The pushes
//! are added in site order, so the sum does not depend on the number of threads.

use nalgebra::{Point3, Vector3};

use crate::domain::beyond::Beyond;
use crate::energy::evaluation::energy;
use crate::energy::facet_terms::{FacetTermScratch, facet_terms};
use crate::relax::cell_memory::CellMemory;
use crate::relax::space::Space;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::DiagramError;

/// The global objective of some sites.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Global {
    /// F: the sum of the cells' energies of the asked order (L^(3+p)).
    pub energy: f64,
    /// The sum of the cells' p = 1 Chebyshev energies, per unit of the domain's mean density (L⁴).
    pub chebyshev: f64,
    /// The largest energy of a cell (L^(3+p)).
    pub energy_max: f64,
    /// ∂F/∂x_i for every site (L^(2+p)).
    pub gradient: Vec<Vector3<f64>>,
    /// Every cell's energy (L^(3+p)).
    pub energies: Vec<f64>,
}

/// What one cell adds.
struct Part {
    energy: f64,
    chebyshev: f64,
    gradient: Vector3<f64>,
    pushes: Vec<(u32, Vector3<f64>)>,
}

#[derive(Debug, Default)]
struct Memory {
    cell: CellMemory,
    facets: FacetTermScratch,
}

impl Space {
    /// The global objective of order `order` ≥ 1 at `sites`, with its exact gradient.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn global(&self, sites: &[Point3<f64>], order: u32) -> Result<Global, DiagramError> {
        self.global_of(sites, order, false)
    }

    /// As [`Space::global`] where sites have moved little since they were last asked this way: it
    /// takes less time then. The answers may differ from those by rounding, but depend on nothing
    /// else either.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn global_near(&self, sites: &[Point3<f64>], order: u32) -> Result<Global, DiagramError> {
        self.global_of(sites, order, true)
    }

    fn global_of(
        &self,
        sites: &[Point3<f64>],
        order: u32,
        is_near: bool,
    ) -> Result<Global, DiagramError> {
        let parts = self.map(sites, is_near, |memory: &mut Memory, cell| {
            self.part_of_cell(memory, &cell, order)
        })?;
        let mut global = Global {
            gradient: vec![Vector3::zeros(); sites.len()],
            energies: parts.iter().map(|part| part.energy).collect(),
            ..Global::default()
        };
        for (site, part) in parts.iter().enumerate() {
            global.energy += part.energy;
            global.chebyshev += part.chebyshev;
            global.energy_max = global.energy_max.max(part.energy);
            global.gradient[site] += part.gradient;
            for &(neighbor, push) in &part.pushes {
                global.gradient[neighbor as usize] += push;
            }
        }
        Ok(global)
    }

    fn part_of_cell(&self, memory: &mut Memory, cell: &Cell<'_>, order: u32) -> Part {
        let frame = self.frames().of(cell.site);
        memory.cell.load_in_frame(self.domain(), cell, frame);
        let (pieces, walk) = memory.cell.pieces();
        let facets = pieces.iter().map(|piece| piece.piece.facets.len());
        let mut pushes = Vec::with_capacity(facets.sum());
        let mut own = Vector3::zeros();
        let inside = facet_terms(
            pieces,
            order,
            (&mut *walk, &mut memory.facets),
            |label| matches!(Beyond::of(label), Beyond::Neighbor { .. }),
            |push| {
                if let Beyond::Neighbor { site, .. } = Beyond::of(push.label) {
                    own += push.own;
                    pushes.push((site, push.across));
                }
            },
        );
        let chebyshev = if order == 1 {
            inside.value
        } else {
            energy(pieces, &Vector3::zeros(), 1, walk).value
        };
        for (_, push) in &mut pushes {
            *push = memory.cell.in_space(*push);
        }
        Part {
            energy: inside.value,
            chebyshev: chebyshev / self.domain().mean_density(),
            gradient: memory.cell.in_space(inside.gradient + own),
            pushes,
        }
    }
}
