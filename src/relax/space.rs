//! Diagrams in space: how cells in a domain answer the loops.

use nalgebra::{Point3, Vector3};

use crate::domain::domain::Domain;
use crate::domain::shape::displacement;
use crate::geometry::bounds::Bounds;
use crate::relax::cell_memory::CellMemory;
use crate::relax::figures::CellFigures;
use crate::relax::frames::Frames;
use crate::relax::noise::displaced;
use crate::relax::tessellation::{Assessment, Question, Tessellation};
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A domain in which sites have cells.
#[derive(Debug)]
pub struct Space {
    domain: Box<dyn Domain>,
    frames: Frames,
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
        Self { domain, frames }
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

    /// As [`Diagram::map`].
    pub(crate) fn map<Memory: Default, Answer: Send>(
        &self,
        sites: &[Point3<f64>],
        ask: impl Fn(&mut Memory, Cell<'_>) -> Answer + Sync,
    ) -> Result<Vec<Answer>, DiagramError> {
        Diagram::borrowed(self.domain(), sites)?.map(ask)
    }

    /// Prepares a cell in its own frame.
    fn load(&self, memory: &mut CellMemory, cell: &Cell<'_>) {
        memory.load_in_frame(self.domain(), cell, self.frames.of(cell.site));
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
        self.map(sites, |memory: &mut CellMemory, cell| {
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
        let energies = self.map(sites, |memory: &mut CellMemory, cell| {
            self.load(memory, &cell);
            memory.energy_at_site(question)
        })?;
        Ok(energies.iter().sum())
    }

    fn assess(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<Assessment<3>>, DiagramError> {
        self.map(sites, |memory: &mut CellMemory, cell| {
            self.load(memory, &cell);
            memory.assess(self.domain(), &cell, question)
        })
    }
}
