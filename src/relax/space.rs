//! Relaxation in space: the L2 or L∞ cells of a domain's sites, each with its own axes of distance.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use crate::arrays::MapEach;
use crate::domain::{
    convex::ConvexPolyhedron,
    density::Density,
    domain::Domain,
    shape::{PieceScratch, displacement},
};
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::shell::Shell;
use crate::relax::cell_check::{CellFigures, CellsError, DomainTotals, EnergyKind};
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::frames::Frames;
use crate::relax::linf::{LinfCells, turned};
use crate::relax::metrics::{BothTessellations, CellMetrics};
use crate::relax::objective::{ObjectiveScratch, sum_of};
use crate::relax::optimum::{EnergyOptimum, EnergyReference};
use crate::relax::relaxation_space::{
    CellCrowding, CellResult, EnergySpec, Minimizer, Norm, ObjectiveValue, REMEMBERED_STEPS,
    RelaxationError, RelaxationSpace,
};
use crate::voronoi::cell::{Cell, CellBuilder};
use crate::voronoi::diagram::{Diagram, DiagramError, StopFlag};

/// Why sites have no cells in a [`Space`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SpaceError {
    /// They have no diagram.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
    /// They have cells that cannot be, or whose energies are no numbers.
    #[error(transparent)]
    Cells(#[from] CellsError),
    /// Not every site has a frame.
    #[error("there are {frames} frames for {sites} sites")]
    Frames {
        /// How many frames there are.
        frames: usize,
        /// How many sites there are.
        sites: usize,
    },
}

/// A domain in which sites have cells.
#[derive(Debug)]
pub struct Space {
    domain: Box<dyn Domain>,
    frames: Frames,
    /// The distance in which a cell's points are nearest to its site.
    cells: Norm,
    /// The domain in the frame of L∞ cells, if they have one.
    turned: Option<ConvexPolyhedron>,
    pub(crate) stop: StopFlag,
}

impl Space {
    /// The space of `domain`.
    #[must_use]
    pub fn new(domain: Box<dyn Domain>) -> Self {
        Self::with_frames(domain, Frames::Axes)
    }

    /// The space of `domain` whose cells measure the Chebyshev distance in these frames.
    #[must_use]
    pub fn with_frames(domain: Box<dyn Domain>, frames: Frames) -> Self {
        Self {
            domain,
            frames,
            cells: Norm::L2,
            turned: None,
            stop: None,
        }
    }

    /// The same space, in which work ends in an error soon after `flag` is raised.
    #[must_use]
    pub fn stop_by(self, flag: &Arc<AtomicBool>) -> Self {
        let stop = Some(flag.clone());
        Self { stop, ..self }
    }

    /// The same space with these frames.
    #[must_use]
    pub fn framed(self, frames: Frames) -> Self {
        Self { frames, ..self }.with_turned_domain()
    }

    /// The same space with cells of this distance. L∞ cells want the axes of space, or in a convex domain
    /// without periods and density one frame.
    #[must_use]
    pub fn with_cells(self, cells: Norm) -> Self {
        Self { cells, ..self }.with_turned_domain()
    }

    fn with_turned_domain(self) -> Self {
        let turned = match (&self.frames, self.cells) {
            (Frames::One(frame), Norm::Linf) => turned(self.domain(), frame),
            _ => None,
        };
        Self { turned, ..self }
    }

    /// The distance in which a cell's points are nearest to its site.
    #[must_use]
    pub fn cells(&self) -> Norm {
        self.cells
    }

    /// What the space's L∞ cells, if it has such, do not go with.
    pub(crate) fn refused_cells(&self, norm: Norm) -> Option<&'static str> {
        let refused = [
            (
                matches!(self.frames, Frames::PerSite(_)),
                "frames of single sites",
            ),
            (
                matches!(self.frames, Frames::One(_)) && self.turned.is_none(),
                "frames in a domain that is periodic, not convex or has a density",
            ),
            (norm == Norm::L2, "the Euclidean norm"),
        ];
        let first = refused.into_iter().find(|(is_given, _)| *is_given);
        first
            .filter(|_| self.cells == Norm::Linf)
            .map(|(_, what)| what)
    }

    /// The L∞ cells of `sites`, if the space has such.
    pub(crate) fn linf<'a>(&'a self, sites: &'a [Point3<f64>]) -> Option<LinfCells<'a>> {
        let cells = match (&self.frames, &self.turned) {
            (Frames::One(frame), Some(turned)) => LinfCells::in_frame(turned, sites, *frame),
            _ => LinfCells::new(self.domain(), sites),
        };
        (self.cells == Norm::Linf).then(|| cells.with_stop(&self.stop))
    }

    /// The figures of `sites` in both tessellations, where the cells are L∞ cells.
    ///
    /// # Errors
    /// When the sites have no cells.
    pub(crate) fn both(
        &self,
        sites: &[Point3<f64>],
    ) -> Result<Option<BothTessellations>, SpaceError> {
        let Some(cells) = self.linf(sites) else {
            return Ok(None);
        };
        let spec = EnergySpec {
            norm: Norm::Linf,
            order: 1,
            minimizer: Minimizer::Newton,
        };
        let (count, optimum) = (sites.len(), self.optimum());
        let per_cell = |energy: f64| energy / (count as f64 * self.domain.mean_density());
        let percent = |energy: f64| optimum.percent::<3>(per_cell(energy), count);
        Ok(Some(BothTessellations {
            energy_percent_l2: percent(self.energy_of_l2_cells(sites, spec)?),
            energy_percent_linf: percent(cells.energy(1)?),
            tied_volume: cells.tied_volume()?,
        }))
    }

    fn energy_of_l2_cells(
        &self,
        sites: &[Point3<f64>],
        spec: EnergySpec,
    ) -> Result<f64, SpaceError> {
        let energies = self.map_loaded(sites, |memory, _| memory.energy_at_site(spec))?;
        Ok(energies.iter().sum())
    }

    /// The frames in which cells measure the Chebyshev distance.
    #[must_use]
    pub fn frames(&self) -> &Frames {
        &self.frames
    }

    /// The domain.
    #[must_use]
    pub fn domain(&self) -> &dyn Domain {
        self.domain.as_ref()
    }

    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no cells.
    pub fn metrics(
        &self,
        sites: &[Point3<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<3>>, SpaceError> {
        self.totals().check_scale::<3>(sites.len(), spec.kind())?;
        let cells = match self.linf(sites) {
            Some(cells) => cells.metrics(spec)?,
            None => self.map_loaded(sites, |memory, cell| {
                memory.metrics(self.domain(), cell, spec)
            })?,
        };
        let figures = |site: usize| (cells[site].volume, cells[site].energy);
        self.check(sites, &figures, spec.kind())?;
        let mut numbered = cells.iter().enumerate();
        numbered.try_for_each(|(site, cell)| cell.check(site))?;
        Ok(cells)
    }

    /// What bounds the energies of any cells.
    pub(crate) fn totals(&self) -> DomainTotals {
        let (volume, density) = (self.domain.volume(), self.domain.density());
        DomainTotals {
            volume,
            mass: volume * self.domain.mean_density(),
            density: density.map_or(1.0, Density::upper_bound),
        }
    }

    /// Checks the cells of `sites`; where they are none, by their facets too.
    pub(crate) fn check(
        &self,
        sites: &[Point3<f64>],
        cells: &(dyn Fn(usize) -> CellFigures + Sync),
        kind: EnergyKind,
    ) -> Result<(), CellsError> {
        self.totals().check::<3>(sites.len(), cells, kind, || {
            let diagram = Diagram::borrowed(self.domain(), sites).ok()?;
            Some(diagram.check().err()?.to_string())
        })
    }

    /// What `of_cell` says of the cells of chosen sites, in ascending order, and how far each asks for others (L).
    pub(crate) fn of_chosen<Memory: Default + Send, Answer: Send>(
        &self,
        sites: &[Point3<f64>],
        chosen: &[usize],
        of_cell: impl Fn(&mut Memory, &Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<(Answer, f64)>, SpaceError> {
        let mut is_chosen = vec![false; sites.len()];
        chosen.iter().for_each(|&site| is_chosen[site] = true);
        let diagram = Diagram::borrowed(self.domain(), sites)?.with_stop(&self.stop);
        let tree = diagram.tree()?;
        let of_place = |(builder, memory): &mut (CellBuilder, Memory), place| {
            if !is_chosen[tree.site(place) as usize] {
                return Ok(None);
            }
            let cell = builder.build(self.domain(), tree, place)?;
            Ok(Some((of_cell(memory, &cell), cell.reach())))
        };
        let all = diagram.map_places(of_place)?;
        Ok(all.into_iter().flatten().collect())
    }

    /// As [`Diagram::map`], where every site has a frame.
    fn map<Memory: Default + Send, Answer: Send>(
        &self,
        sites: &[Point3<f64>],
        of_cell: impl Fn(&mut Memory, Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, SpaceError> {
        Ok(self.diagram(sites)?.map(of_cell)?)
    }

    /// Nothing, until the flag of [`Space::stop_by`] is raised.
    ///
    /// # Errors
    /// [`DiagramError::Stopped`].
    pub(crate) fn check_stop(&self) -> Result<(), SpaceError> {
        let stop = self.stop.as_ref();
        match stop.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            true => Err(DiagramError::Stopped.into()),
            false => Ok(()),
        }
    }

    /// The diagram of sites that all have frames.
    fn diagram<'a>(&'a self, sites: &'a [Point3<f64>]) -> Result<Diagram<'a>, SpaceError> {
        self.check_stop()?;
        if let Some(frames) = self.frames.count()
            && frames != sites.len()
        {
            let sites = sites.len();
            return Err(SpaceError::Frames { frames, sites });
        }
        Ok(Diagram::borrowed(self.domain(), sites)?.with_stop(&self.stop))
    }

    /// As [`Diagram::map_copied`] for cells that are prepared in their frames.
    fn map_loaded<Answer: Copy + Send + Sync + 'static>(
        &self,
        sites: &[Point3<f64>],
        of_cell: impl Fn(&mut CellMemory, &Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, SpaceError> {
        let of_cell = |memory: &mut CellMemory, cell: Cell<'_>| {
            memory.load_in_frame(self.domain(), &cell, self.frames.of(cell.site));
            of_cell(memory, &cell)
        };
        Ok(self.diagram(sites)?.map_copied(of_cell)?)
    }
}

impl RelaxationSpace<3> for Space {
    type Error = SpaceError;

    fn volume(&self) -> f64 {
        self.domain.volume()
    }

    /// Objectives of L∞ cells have kinks, behind which old steps mislead: of 216 sites, seeds 1 to 8, three take 74
    /// to 113 evaluations to a gradient of 1e-7 of the first, four 81 to 151, six 72 to 104. Of 10 000 sites 50 moves
    /// end at 100.31, 100.29, 100.29 %.
    fn remembered_steps(&self) -> usize {
        match self.cells {
            Norm::L2 => REMEMBERED_STEPS,
            Norm::Linf => 3,
        }
    }

    fn bounds(&self) -> Bounds<3> {
        self.domain.bounds()
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.domain.contains(point)
    }

    fn periods(&self) -> [Option<f64>; 3] {
        self.domain.periods()
    }

    fn wrap(&self, point: &Point3<f64>) -> Point3<f64> {
        self.domain.wrap(point)
    }

    fn varying_density(&self) -> Option<f64> {
        let density = self.domain.mean_density();
        self.domain.has_density().then_some(density)
    }

    fn optimum(&self) -> EnergyOptimum {
        let Some(density) = self.domain.density() else {
            return EnergyOptimum::of_equal_cubes(self.domain.volume());
        };
        let volume = density.optimal_volume(self.domain.shape());
        EnergyOptimum {
            kind: EnergyReference::AsymptoticOptimum,
            volume: volume.value,
            volume_error: volume.error,
            density: density.mean(),
        }
    }

    fn check_scale(&self, count: usize, spec: EnergySpec) -> Result<(), CellsError> {
        self.totals().check_scale::<3>(count, spec.kind())
    }

    fn displacement(&self, from: &Point3<f64>, to: &Point3<f64>) -> Vector3<f64> {
        displacement(&self.domain.periods(), from, to)
    }

    fn is_box(&self) -> bool {
        self.domain.is_box()
    }

    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        self.domain.wall_ahead(site, step)
    }

    fn energy(&self, sites: &[Point3<f64>], spec: EnergySpec) -> Result<f64, SpaceError> {
        if let Some(cells) = self.linf(sites) {
            return Ok(cells.energy(spec.order)?);
        }
        self.energy_of_l2_cells(sites, spec)
    }

    fn assess(
        &self,
        sites: &[Point3<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellResult<3>>, SpaceError> {
        self.totals().check_scale::<3>(sites.len(), spec.kind())?;
        let cells = match self.linf(sites) {
            Some(linf) => {
                let mut cells = linf.assess(spec)?;
                for cell in cells.iter_mut().filter(|_| self.turned.is_some()) {
                    // Turning rounds.
                    cell.target = self.domain.bounds().clamp(&cell.target);
                }
                cells
            }
            None => self.map_loaded(sites, |memory, cell| {
                memory.assess(self.domain(), cell, spec)
            })?,
        };
        let figures = |site: usize| (cells[site].volume, cells[site].energy);
        self.check(sites, &figures, spec.kind())?;
        Ok(cells)
    }

    fn objective(
        &self,
        sites: &[Point3<f64>],
        order: u32,
    ) -> Result<ObjectiveValue<3>, RelaxationError<SpaceError>> {
        let kind = EnergyKind::Chebyshev(order);
        self.totals().check_scale::<3>(sites.len(), kind)?;
        if let Some(cells) = self.linf(sites) {
            let value = cells.objective(order).map_err(SpaceError::Diagram);
            let (value, volumes) = value.map_err(RelaxationError::Space)?;
            let figures = |site: usize| (volumes[site], value.energies[site]);
            self.check(sites, &figures, kind)?;
            return Ok(value);
        }
        let terms = self.map(sites, |scratch: &mut ObjectiveScratch, cell| {
            scratch.terms(self.domain(), &self.frames, &cell, order)
        });
        let terms = terms.map_err(RelaxationError::Space)?;
        let figures = |site: usize| (terms[site].volume, terms[site].energy);
        self.check(sites, &figures, kind)?;
        Ok(sum_of(&terms))
    }

    fn crowding(
        &self,
        sites: &[Point3<f64>],
    ) -> Result<Vec<CellCrowding<3>>, RelaxationError<SpaceError>> {
        if let Some(cells) = self.linf(sites) {
            let crowding = cells.crowding().map_err(SpaceError::Diagram);
            return crowding.map_err(RelaxationError::Space);
        }
        self.map_loaded(sites, |memory, cell| memory.crowding(self.domain(), cell))
            .map_err(RelaxationError::Space)
    }
}

/// The surface of `cell` within the domain, in the domain's coordinates, for files, and its facets for
/// whose labels `is_seen` holds, for pictures.
pub(crate) fn shells(
    domain: &dyn Domain,
    cell: &Cell<'_>,
    scratch: &mut PieceScratch,
    is_seen: impl Fn(Label) -> bool,
) -> [Shell; 2] {
    let mut shells = [Shell::default(), Shell::default()];
    domain.outline(&cell.position, cell.polyhedron(), scratch, &mut |piece| {
        let all = [Shell::from(piece), Shell::of_facets(piece, &is_seen)];
        shells = all.map_each(|shell| shell.translated(&cell.position.coords));
    });
    shells
}

/// The surface of `cell` within the domain.
#[cfg(test)]
pub(crate) fn shell(domain: &dyn Domain, cell: &Cell<'_>, scratch: &mut PieceScratch) -> Shell {
    let [shell, _] = shells(domain, cell, scratch, |_| true);
    shell
}
