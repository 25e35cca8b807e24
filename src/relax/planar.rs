//! Relaxation in the plane: the cells of a planar domain's sites.

use nalgebra::{Point2, Vector2};
use thiserror::Error;

use crate::arrays::MapEach;
use crate::domain::planar::PlaneDomain;
use crate::domain::planar_density::PlaneDensity;
use crate::domain::shape::displacement;
use crate::geometry::bounds::Bounds;
use crate::parallel::map;
use crate::relax::cell_check::{CellFigures, CellsError, DomainTotals, EnergyKind};
use crate::relax::metrics::{BothTessellations, CellMetrics};
use crate::relax::objective::sum_of;
use crate::relax::optimum::{EnergyOptimum, EnergyReference};
use crate::relax::planar_cell::CellInPlane;
use crate::relax::relaxation_space::{
    CellCrowding, CellResult, EnergySpec, Minimizer, Norm, ObjectiveValue, RelaxationError,
    RelaxationSpace,
};
use crate::voronoi::planar::diagram::{PlaneDiagram, PlaneDiagramError};

/// Why sites have no cells in a [`Plane`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlaneError {
    /// They have no diagram.
    #[error(transparent)]
    Diagram(#[from] PlaneDiagramError),
    /// They have cells that cannot be, or whose energies are no numbers.
    #[error(transparent)]
    Cells(#[from] CellsError),
}

/// A rectangle or polygon in which sites relax.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Where the sites live.
    pub domain: PlaneDomain,
}

impl Plane {
    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn metrics(
        &self,
        sites: &[Point2<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<2>>, PlaneError> {
        self.check_scale(sites.len(), spec)?;
        let cells = self.map(sites, |cell| cell.metrics(spec))?;
        let figures = |site: usize| (cells[site].volume, cells[site].energy);
        self.check(sites, &figures, spec.kind())?;
        let mut numbered = cells.iter().enumerate();
        numbered.try_for_each(|(site, cell)| cell.check(site))?;
        Ok(cells)
    }

    /// The figures of `sites` in both tessellations, where the cells are L∞ cells.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub(crate) fn both(
        &self,
        sites: &[Point2<f64>],
    ) -> Result<Option<BothTessellations>, PlaneError> {
        if !self.domain.has_linf_cells() {
            return Ok(None);
        }
        let spec = EnergySpec {
            norm: Norm::Linf,
            order: 1,
            minimizer: Minimizer::Newton,
        };
        let (count, optimum) = (sites.len(), self.optimum());
        let per_cell = |energy: f64| energy / (count as f64 * optimum.density);
        let percent = |energy: f64| optimum.percent::<2>(per_cell(energy), count);
        let l2 = Self {
            domain: self.domain.clone().with_linf_cells(false),
        };
        let untied = PlaneDiagram::untied(&self.domain, sites)?.area();
        Ok(Some(BothTessellations {
            energy_percent_l2: percent(l2.energy(sites, spec)?),
            energy_percent_linf: percent(self.energy(sites, spec)?),
            tied_volume: (1.0 - untied / self.domain.area()).max(0.0),
        }))
    }

    /// The answers of all cells, in site order.
    fn map<Answer: Send>(
        &self,
        sites: &[Point2<f64>],
        of_cell: impl Fn(CellInPlane<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, PlaneDiagramError> {
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let domain = &self.domain;
        let of_site = |site: usize| {
            let cell = &diagram.cells[site];
            of_cell(CellInPlane { domain, cell })
        };
        Ok(map(diagram.cells.len(), &of_site))
    }

    fn check(
        &self,
        sites: &[Point2<f64>],
        cells: &(dyn Fn(usize) -> CellFigures + Sync),
        kind: EnergyKind,
    ) -> Result<(), CellsError> {
        self.totals().check::<2>(sites.len(), cells, kind, || None)
    }

    /// What bounds the energies of any cells.
    fn totals(&self) -> DomainTotals {
        let (area, density) = (self.domain.area(), self.domain.density());
        DomainTotals {
            volume: area,
            mass: area * density.map_or(1.0, PlaneDensity::mean),
            density: density.map_or(1.0, PlaneDensity::upper_bound),
        }
    }
}

impl RelaxationSpace<2> for Plane {
    type Error = PlaneError;

    fn volume(&self) -> f64 {
        self.domain.area()
    }

    fn bounds(&self) -> Bounds<2> {
        self.domain.bounds()
    }

    fn contains(&self, point: &Point2<f64>) -> bool {
        self.domain.contains(point)
    }

    fn periods(&self) -> [Option<f64>; 2] {
        self.domain.periods()
    }

    fn wrap(&self, point: &Point2<f64>) -> Point2<f64> {
        self.domain.wrap(point)
    }

    fn varying_density(&self) -> Option<f64> {
        self.domain.density().map(PlaneDensity::mean)
    }

    fn optimum(&self) -> EnergyOptimum {
        let Some(density) = self.domain.density() else {
            return EnergyOptimum::of_equal_cubes(self.domain.area());
        };
        let area = density.optimal_area();
        EnergyOptimum {
            kind: EnergyReference::AsymptoticOptimum,
            volume: area.value,
            volume_error: area.error,
            density: density.mean(),
        }
    }

    fn check_scale(&self, count: usize, spec: EnergySpec) -> Result<(), CellsError> {
        self.totals().check_scale::<2>(count, spec.kind())
    }

    fn displacement(&self, from: &Point2<f64>, to: &Point2<f64>) -> Vector2<f64> {
        displacement(&self.domain.periods(), from, to)
    }

    fn beyond(&self, site: &Point2<f64>, target: &Point2<f64>, factor: f64) -> Point2<f64> {
        let step = self.displacement(site, target) * factor;
        let far = self.domain.wrap(&(site + step));
        let is_free = self.domain.is_convex() || self.wall_ahead(site, &step).is_none();
        if is_free && self.domain.contains(&far) {
            far
        } else {
            *target
        }
    }

    fn is_box(&self) -> bool {
        self.domain.is_box()
    }

    fn wall_ahead(&self, site: &Point2<f64>, step: &Vector2<f64>) -> Option<(f64, Vector2<f64>)> {
        self.domain.wall_ahead(site, step)
    }

    fn energy(&self, sites: &[Point2<f64>], spec: EnergySpec) -> Result<f64, PlaneError> {
        let energies = self.map(sites, |cell| cell.energy_at_site(spec))?;
        Ok(energies.iter().sum())
    }

    fn assess(
        &self,
        sites: &[Point2<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellResult<2>>, PlaneError> {
        self.check_scale(sites.len(), spec)?;
        let results = self.map(sites, |cell| cell.assess(spec))?;
        let figures = |site: usize| (results[site].volume, results[site].energy);
        self.check(sites, &figures, spec.kind())?;
        Ok(results)
    }

    fn objective(
        &self,
        sites: &[Point2<f64>],
        order: u32,
    ) -> Result<ObjectiveValue<2>, RelaxationError<PlaneError>> {
        let kind = EnergyKind::Chebyshev(order);
        self.totals().check_scale::<2>(sites.len(), kind)?;
        let periods = self.domain.periods().map(Option::unwrap_or_default);
        let terms = self.map(sites, |cell| {
            let site = cell.cell.site;
            cell.terms(order, |other, image| {
                let moved = [0, 1].map_each(|axis| f64::from(image[axis]) * periods[axis]);
                (sites[other as usize] - site) + Vector2::from(moved)
            })
        });
        let terms = terms.map_err(in_plane)?;
        let figures = |site: usize| (terms[site].volume, terms[site].energy);
        self.check(sites, &figures, kind)?;
        Ok(sum_of(&terms))
    }

    fn crowding(
        &self,
        sites: &[Point2<f64>],
    ) -> Result<Vec<CellCrowding<2>>, RelaxationError<PlaneError>> {
        self.map(sites, |cell| cell.crowding()).map_err(in_plane)
    }
}

fn in_plane(error: PlaneDiagramError) -> RelaxationError<PlaneError> {
    RelaxationError::Space(PlaneError::Diagram(error))
}
