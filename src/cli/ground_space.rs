//! Space as a ground.

use std::error::Error;

use nalgebra::Point3;

use chebloyd::domain::space::PieceScratch;
use chebloyd::export::run::directory::RunDirectory;
use chebloyd::export::vtu::VtuWriter;
use chebloyd::geometry::bounds::Bounds;
use chebloyd::plot::cut::Cut;
use chebloyd::plot::cutaway::{CutawayPicture, Removed};
use chebloyd::plot::patches::picture;
use chebloyd::relax::metrics::CellFigures;
use chebloyd::relax::record::optimal_side;
use chebloyd::relax::relaxation_space::{EnergySpec, RelaxationSpace};
use chebloyd::relax::space::{Space, shell};
use chebloyd::scene::region::Region;
use chebloyd::voronoi::diagram::Diagram;

use crate::cli::cell_files::{Colors, geometry, save_png, save_svg};
use crate::cli::ground::Ground;

/// How far above the middle of the domain its cells are cut, in sides of a mean cell: the middle
/// itself is a wall of cells for every lattice of an even number of layers.
const OFF_MIDDLE: f64 = 0.25;

impl Ground<3> for Space {
    fn region(&self) -> Region<'_, 3> {
        Region::<3>::of_solid(self.domain())
    }

    fn cells(
        &self,
        sites: &[Point3<f64>],
        question: EnergySpec,
    ) -> Result<Vec<CellFigures<3>>, Self::Error> {
        Self::figures(self, sites, question)
    }

    fn draw_cells(
        &self,
        sites: &[Point3<f64>],
        cells: &[CellFigures<3>],
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        let colors = Colors::of(cells);
        let mut file = VtuWriter::new(&directory.file("cells.vtu"));
        let height = cut_height(&self.bounds(), self.volume(), sites.len());
        let cut = Cut::horizontal(height);
        let mut patches = Vec::new();
        let removed = Removed::enough_of(&self.bounds(), sites);
        let (scale, title) = (colors.scale().clone(), removed.title());
        let mut cutaway = CutawayPicture::new(&self.bounds(), removed, scale, title)?;
        Diagram::new(self.domain(), sites)?.stream(
            |scratch: &mut PieceScratch, cell| shell(self.domain(), &cell, scratch),
            |site, shell| {
                let value = Colors::value(&cells[site]);
                patches.extend(cut.patch(&shell, value));
                cutaway.push(&shell, &sites[site], value);
                file.push(&geometry(site, shell, &cells[site]))?;
                Ok::<(), Box<dyn Error>>(())
            },
        )?;
        file.finish()?;
        let title = format!("Cells cut at z = {height:.4}");
        let figure = picture(&patches, colors.scale(), &title);
        save_svg(&figure, patches.len(), directory)?;
        save_png(&cutaway.finish()?, directory)
    }
}

fn cut_height(bounds: &Bounds<3>, volume: f64, count: usize) -> f64 {
    let side = optimal_side::<3>(volume, count).min(bounds.extent().z);
    bounds.center().z + OFF_MIDDLE * side
}
