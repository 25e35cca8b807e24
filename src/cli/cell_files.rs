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
use chebloyd::relax::metrics::CellFigures;
use chebloyd::relax::record::optimal_energy;

/// Pixels per unit of an SVG: text stays sharp on fine screens.
pub(crate) const PNG_SCALE: f64 = 2.0;

/// More cells than this make an SVG that no viewer opens; the PNG is there all the same.
const MOST_PATCHES: usize = 100_000;

/// Cells colored by energy, relative to a cube of the cell's own volume: that shows shapes, where
/// a common measure would show how volumes differ.
pub(crate) struct Colors(ColorScale);

impl Colors {
    /// Colors spread over the energies of `cells`.
    pub(crate) fn of<const D: usize>(cells: &[CellFigures<D>]) -> Self {
        let label = if D == 2 {
            "energy (% of a square of the cell’s area)"
        } else {
            "energy (% of a cube of the cell’s volume)"
        };
        let values = cells.iter().map(Self::value);
        Self(ColorScale::fitting(label, Best::Low, values))
    }

    pub(crate) fn scale(&self) -> &ColorScale {
        &self.0
    }

    pub(crate) fn value<const D: usize>(cell: &CellFigures<D>) -> f64 {
        100.0 * cell.chebyshev / optimal_energy::<D>(cell.volume, 1, 1)
    }
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
