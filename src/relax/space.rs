//! Diagrams in space: how cells in a domain answer the loops.

use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::domain::shape::displacement;
use crate::geometry::bounds::Bounds;
use crate::relax::cell_memory::CellMemory;
use crate::relax::figures::CellFigures;
use crate::relax::frames::Frames;
use crate::relax::noise::displaced;
use crate::relax::tessellation::{Assessment, Question, Tessellation};
use crate::voronoi::carried::Carried;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A domain in which sites have cells.
#[derive(Debug)]
pub struct Space {
    domain: Box<dyn Domain>,
    frames: Frames,
    /// What the last diagram leaves to the next. It shows in no answer.
    carried: Mutex<Carried>,
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
            carried: Mutex::default(),
        }
    }

    /// The same space with these frames.
    #[must_use]
    pub fn framed(self, frames: Frames) -> Self {
        Self { frames, ..self }
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

    /// How many cells the last diagram that could carry cells over from another one had to rebuild.
    #[must_use]
    pub fn rebuilt(&self) -> usize {
        self.lock().rebuilt()
    }

    /// As [`Diagram::map`], or for near sites as [`Diagram::map_carried`] with what the last such
    /// diagram has left.
    pub(crate) fn map<Memory: Default, Answer: Send>(
        &self,
        sites: &[Point3<f64>],
        is_near: bool,
        ask: impl Fn(&mut Memory, Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        let diagram = Diagram::new(self.domain(), sites)?;
        if !is_near {
            return diagram.map(ask);
        }
        // Taken out meanwhile: no lock is held while threads are at work.
        let mut carried = std::mem::take(&mut *self.lock());
        let answers = diagram.map_carried(&mut carried, ask);
        *self.lock() = carried;
        answers
    }

    /// Prepares a cell in its own frame.
    fn load(&self, memory: &mut CellMemory, cell: &Cell<'_>) {
        memory.load_in_frame(self.domain(), cell, self.frames.of(cell.site));
    }

    fn assess_all(
        &self,
        sites: &[Point3<f64>],
        question: Question,
        is_near: bool,
    ) -> Result<Vec<Assessment<3>>, DiagramError> {
        self.map(sites, is_near, |memory: &mut CellMemory, cell| {
            self.load(memory, &cell);
            memory.assess(self.domain(), &cell, question)
        })
    }

    fn total_energy(
        &self,
        sites: &[Point3<f64>],
        question: Question,
        is_near: bool,
    ) -> Result<f64, DiagramError> {
        let energies = self.map(sites, is_near, |memory: &mut CellMemory, cell| {
            self.load(memory, &cell);
            memory.energy_at_site(question)
        })?;
        Ok(energies.iter().sum())
    }

    fn lock(&self) -> MutexGuard<'_, Carried> {
        self.carried.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Space {
    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn figures(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<3>>, DiagramError> {
        self.map(sites, false, |memory: &mut CellMemory, cell| {
            self.load(memory, &cell);
            memory.figures(self.domain(), &cell, question)
        })
    }
}

impl Tessellation<3> for Space {
    type Error = DiagramError;

    fn volume(&self) -> f64 {
        self.domain.volume()
    }

    fn bounds(&self) -> Bounds<3> {
        self.domain.bounds()
    }

    fn displacement(&self, from: &Point3<f64>, to: &Point3<f64>) -> Vector3<f64> {
        displacement(&self.domain.periods(), from, to)
    }

    fn beyond(&self, site: &Point3<f64>, target: &Point3<f64>, factor: f64) -> Point3<f64> {
        let moved = displaced(self, site, self.displacement(site, target) * factor);
        if moved == *site { *target } else { moved }
    }

    fn energy(&self, sites: &[Point3<f64>], question: Question) -> Result<f64, DiagramError> {
        self.total_energy(sites, question, false)
    }

    fn energy_near(&self, sites: &[Point3<f64>], question: Question) -> Result<f64, DiagramError> {
        self.total_energy(sites, question, true)
    }

    fn assess(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<Assessment<3>>, DiagramError> {
        self.assess_all(sites, question, false)
    }

    fn assess_near(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<Assessment<3>>, DiagramError> {
        self.assess_all(sites, question, true)
    }
}
