//! Where a scene's sites live, in the plane or in space: what a command asks of either.

use std::error::Error;

use nalgebra::Point;

use chebloyd::export::run::directory::RunDirectory;
use chebloyd::relax::metrics::CellFigures;
use chebloyd::relax::planar::Plane;
use chebloyd::relax::relaxation_space::{EnergySpec, RelaxationSpace};
use chebloyd::relax::space::Space;
use chebloyd::scene::description::Scene;
use chebloyd::scene::place::place;
use chebloyd::scene::region::Region;

use crate::cli::failure::Failure;

/// A tessellation that can be filled from a scene, measured and drawn.
pub(crate) trait Ground<const D: usize>: RelaxationSpace<D> {
    /// The domain as sites see it.
    fn region(&self) -> Region<'_, D>;

    /// The figures of every cell, in the question's norm.
    fn cells(
        &self,
        sites: &[Point<f64, D>],
        question: EnergySpec,
    ) -> Result<Vec<CellFigures<D>>, Self::Error>;

    /// Writes `cells.vtu`, `cells.svg` and `cells.png`, given the figures of every cell.
    fn draw_cells(
        &self,
        sites: &[Point<f64, D>],
        cells: &[CellFigures<D>],
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>>;

    /// The scene's sites.
    fn place(&self, scene: &Scene) -> Result<Vec<Point<f64, D>>, Failure> {
        place(&scene.sites, &self.region(), scene.drop_outside).map_err(Failure::input)
    }
}

/// The ground of a scene in the plane.
pub(crate) fn plane(scene: &Scene) -> Result<Plane, Failure> {
    let domain = scene.domain.plane().map_err(Failure::input)?;
    Ok(Plane { domain })
}

/// The ground of a scene in space. What was repaired in its mesh is told on stderr.
pub(crate) fn space(scene: &Scene) -> Result<Space, Failure> {
    let (domain, notes) = scene.solid().map_err(Failure::input)?;
    for note in notes {
        eprintln!("note: {note}");
    }
    let space = Space::new(domain);
    let Some(choice) = &scene.frames else {
        return Ok(space);
    };
    // Frames belong to the sites of the start, also where a run goes on from later ones.
    let sites = space.place(scene)?;
    let frames = choice.frames(space.domain(), &sites);
    Ok(space.framed(frames.map_err(Failure::input)?))
}
