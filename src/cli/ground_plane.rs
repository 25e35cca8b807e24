//! The plane as a ground.

use std::error::Error;

use nalgebra::Point2;

use chebloyd::export::run::directory::RunDirectory;
use chebloyd::export::vtu::VtuWriter;
use chebloyd::geometry::shell::Shell;
use chebloyd::plot::patches::{Patch, picture};
use chebloyd::plot::png::png;
use chebloyd::relax::metrics::CellFigures;
use chebloyd::relax::planar::Plane;
use chebloyd::relax::relaxation_space::EnergySpec;
use chebloyd::scene::region::Region;
use chebloyd::voronoi::plane::PlaneDiagram;

use crate::cli::cell_files::{Colors, PNG_SCALE, geometry, save_png, save_svg};
use crate::cli::ground::Ground;

impl Ground<2> for Plane {
    fn region(&self) -> Region<'_, 2> {
        Region::<2>::of_plane(&self.domain)
    }

    fn cells(
        &self,
        sites: &[Point2<f64>],
        question: EnergySpec,
    ) -> Result<Vec<CellFigures<2>>, Self::Error> {
        Self::figures(self, sites, question)
    }

    fn draw_cells(
        &self,
        sites: &[Point2<f64>],
        cells: &[CellFigures<2>],
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        let colors = Colors::of(cells);
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let mut file = VtuWriter::new(&directory.file("cells.vtu"));
        let mut patches = Vec::with_capacity(sites.len());
        for (site, (cell, figures)) in diagram.cells.iter().zip(cells).enumerate() {
            let outline: Vec<Point2<f64>> = cell.outline().collect();
            file.push(&geometry(site, Shell::polygon(&outline), figures))?;
            patches.push(Patch {
                contours: vec![outline],
                value: Colors::value(figures),
                site: Some(cell.site),
            });
        }
        file.finish()?;
        let figure = picture(&patches, colors.scale(), "Cells and their sites");
        save_svg(&figure, patches.len(), directory)?;
        save_png(&png(&figure, PNG_SCALE)?, directory)
    }
}
