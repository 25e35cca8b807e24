//! The fragments of cells on their way to pictures and files.

use crate::export::vtu::FragmentTets;
use crate::geometry::shell::Shell;
use crate::relax::relaxation_space::EnergySpec;

/// A fragment of a cell within the domain.
#[derive(Clone, Debug, Default)]
pub(crate) struct FragmentPart {
    pub(crate) shell: Shell,
    /// Its volume (L³).
    pub(crate) volume: f64,
    /// Its share of the cell's energy at the site, in the scene's norm, order and density.
    pub(crate) energy: f64,
    /// Tetrahedra that fill it, if they were asked for.
    pub(crate) tets: Vec<FragmentTets>,
}

/// What of which cells is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// None for all cells.
    pub(crate) site: Option<usize>,
    pub(crate) spec: EnergySpec,
    /// Whether as tetrahedra.
    pub(crate) tets: bool,
}
