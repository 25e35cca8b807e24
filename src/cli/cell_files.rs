//! The cells as files: what their pictures and `cells.vtu` have in common.

use std::error::Error;
use std::io::Write;

use chebloyd::export::run::directory::RunDirectory;
use chebloyd::export::vtu::CellGeometry;
use chebloyd::export::whole_file;
use chebloyd::geometry::shell::Shell;
use chebloyd::plot::color::{Best, ColorScale};
use chebloyd::plot::figure::Figure;
use chebloyd::plot::svg::svg;
use chebloyd::relax::figures::CellFigures;
use chebloyd::relax::record::optimal_energy;

/// Pixels per unit of an SVG: text stays sharp on fine screens.
pub(crate) const PNG_SCALE: f64 = 2.0;

/// More cells than this make an SVG that no viewer opens; the PNG is there all the same.
const MOST_PATCHES: usize = 100_000;

/// Cells colored by energy.
pub(crate) struct Colors {
    optimum: f64,
    scale: ColorScale,
}

impl Colors {
    /// Colors spread over the energies of `cells`, in percent of that of a cube of the mean volume.
    pub(crate) fn of<const D: usize>(volume: f64, cells: &[CellFigures<D>]) -> Self {
        let optimum = optimal_energy::<D>(volume, cells.len(), 1);
        let values = cells.iter().map(|cell| percent(cell, optimum));
        let scale = ColorScale::fitting("energy (% of the optimal cell’s)", Best::Low, values);
        Self { optimum, scale }
    }

    pub(crate) fn scale(&self) -> &ColorScale {
        &self.scale
    }

    pub(crate) fn value<const D: usize>(&self, cell: &CellFigures<D>) -> f64 {
        percent(cell, self.optimum)
    }
}

fn percent<const D: usize>(cell: &CellFigures<D>, optimum: f64) -> f64 {
    100.0 * cell.chebyshev / optimum
}

/// What `cells.vtu` tells of a cell.
pub(crate) fn geometry<const D: usize>(
    site: usize,
    shell: Shell,
    cell: &CellFigures<D>,
) -> CellGeometry {
    CellGeometry {
        site,
        shell,
        energy: cell.energy,
        volume: cell.volume,
        cubeness: cell.cubeness,
        facet_count: cell.facets as usize,
    }
}

/// Writes `cells.svg`, unless `patches` are too many for it.
pub(crate) fn save_svg(
    figure: &Figure,
    patches: usize,
    directory: &RunDirectory,
) -> Result<(), Box<dyn Error>> {
    if patches > MOST_PATCHES {
        return Ok(());
    }
    save("cells.svg", svg(figure).as_bytes(), directory)
}

/// Writes `cells.png`.
pub(crate) fn save_png(bytes: &[u8], directory: &RunDirectory) -> Result<(), Box<dyn Error>> {
    save("cells.png", bytes, directory)
}

fn save(name: &str, bytes: &[u8], directory: &RunDirectory) -> Result<(), Box<dyn Error>> {
    let path = directory.file(name);
    whole_file::write(&path, |file| file.write_all(bytes))
        .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
}
