//! Where a scene's sites live, in the plane or in space: what a command asks of either.

use std::error::Error;

use nalgebra::{Point, Point2, Point3};

use chebloyd::export::run::directory::RunDirectory;
use chebloyd::relax::figures::{CellFigures, Figures};
use chebloyd::relax::plane::Plane;
use chebloyd::relax::space::Space;
use chebloyd::relax::tessellation::{Question, Tessellation};
use chebloyd::scene::description::Scene;
use chebloyd::scene::place::place;
use chebloyd::scene::region::Region;

use crate::cli::failure::Failure;

/// A tessellation that can be filled from a scene, measured and drawn.
pub(crate) trait Ground<const D: usize>: Tessellation<D> {
    /// The domain as sites see it.
    fn region(&self) -> Region<'_, D>;

    /// The figures of every cell, in the question's norm.
    fn cells(
        &self,
        sites: &[Point<f64, D>],
        question: Question,
    ) -> Result<Vec<CellFigures<D>>, Self::Error>;

    /// Writes the cells and their picture.
    fn draw_cells(
        &self,
        sites: &[Point<f64, D>],
        question: Question,
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>>;

    /// The scene's sites.
    fn place(&self, scene: &Scene) -> Result<Vec<Point<f64, D>>, Failure> {
        place(&scene.sites, &self.region()).map_err(Failure::input)
    }

    /// The figures of the tessellation.
    fn figures(&self, sites: &[Point<f64, D>], question: Question) -> Result<Figures, Self::Error> {
        Ok(Figures::of(self.volume(), &self.cells(sites, question)?))
    }
}

/// The ground of a scene in the plane.
pub(crate) fn plane(scene: &Scene) -> Result<Plane, Failure> {
    let domain = scene.domain.plane().map_err(Failure::input)?;
    Ok(Plane { domain })
}

/// The ground of a scene in space.
pub(crate) fn space(scene: &Scene) -> Result<Space, Failure> {
    Ok(Space::new(scene.domain.solid().map_err(Failure::input)?))
}

impl Ground<2> for Plane {
    fn region(&self) -> Region<'_, 2> {
        Region::<2>::of_plane(&self.domain)
    }

    fn cells(
        &self,
        sites: &[Point2<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<2>>, Self::Error> {
        Self::figures(self, sites, question)
    }

    fn draw_cells(
        &self,
        _sites: &[Point2<f64>],
        _question: Question,
        _directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        Ok(())
    }
}

impl Ground<3> for Space {
    fn region(&self) -> Region<'_, 3> {
        Region::<3>::of_solid(self.domain())
    }

    fn cells(
        &self,
        sites: &[Point3<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<3>>, Self::Error> {
        Self::figures(self, sites, question)
    }

    fn draw_cells(
        &self,
        _sites: &[Point3<f64>],
        _question: Question,
        _directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        Ok(())
    }
}
