//! The cells of a run as files: `cells.vtu`, and pictures of them.

use std::error::Error;
use std::io::Write;

use nalgebra::{Point, Point2, Point3};

use crate::cli::failure::{print_note, write_file};
use crate::complex::assemble::assemble_whole;
use crate::complex::linf_mesh::linf_mesh;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::export::compress::compress;
use crate::export::mesh_vtu::{CellColumn, write_mesh};
use crate::export::run::directory::RunDirectory;
use crate::export::vtu::{CellGeometry, VtuWriter};
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::geometry::shell::Shell;
use crate::mesh::poly_mesh::PolyMesh;
use crate::plot::color::ColorScale;
use crate::plot::cutaway::{CutawayPicture, Removed};
use crate::plot::figure::Figure;
use crate::plot::patches::PlaneCut;
use crate::plot::patches::{Patch, picture};
use crate::plot::png::png;
use crate::plot::svg::svg;
use crate::relax::linf::LinfCells;
use crate::relax::metrics::CellMetrics;
use crate::relax::optimum::{optimal_energy, optimal_side};
use crate::relax::planar::Plane;
use crate::relax::relaxation_space::RelaxationSpace;
use crate::relax::space::Space;
use crate::relax::space::shells;
use crate::scene::description::Output;
use crate::scene::run::RunSpace;
use crate::voronoi::diagram::Diagram;
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram};

/// Pixels per unit of an SVG: text stays sharp on fine screens.
pub(crate) const PNG_SCALE: f64 = 2.0;

/// More cells than this make an SVG that no viewer opens; the PNG is there all the same.
const MOST_PATCHES: usize = 100_000;

/// Up to so many cells share their points in `cells.vtu`: about 0.5 GB while they are paired.
const MOST_SHARED: usize = 100_000;

/// Up to so many L∞ cells share theirs, which have several times as many: about 1 GB, and 0.8 ms a cell.
const MOST_SHARED_LINF: usize = 50_000;

/// How far above the middle of the domain its cells are cut, in sides of a mean cell: the middle
/// itself is a wall of cells for every lattice of an even number of layers.
const OFF_MIDDLE: f64 = 0.25;

/// A space whose cells can be drawn.
pub(crate) trait DrawCells<const D: usize>: RunSpace<D> {
    /// Writes those of `cells.vtu`, `cells.svg` and `cells.png` that are wanted, given the figures of
    /// every cell.
    fn draw_cells(
        &self,
        sites: &[Point<f64, D>],
        cells: &[CellMetrics<D>],
        wanted: Output,
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>>;
}

impl DrawCells<2> for Plane {
    fn draw_cells(
        &self,
        sites: &[Point2<f64>],
        cells: &[CellMetrics<2>],
        wanted: Output,
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        let colors = Colors::of(cells, wanted.range);
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let path = directory.file("cells.vtu");
        let mut file = wanted.cells_file.then(|| VtuWriter::new(&path));
        let mut patches = Vec::with_capacity(sites.len());
        for (site, (cell, figures)) in diagram.cells.iter().zip(cells).enumerate() {
            if let Some(file) = &mut file {
                for corners in cell.outlines() {
                    file.push(&geometry(site, Shell::polygon(&corners), figures))?;
                }
            }
            patches.push(flat_patch(cell, Colors::value(figures)));
        }
        finish(file, wanted, directory)?;
        if !wanted.pictures {
            return Ok(());
        }
        let (title, names) = ("Cells and their sites", ["x", "y"].map(str::to_owned));
        let figure = picture(&patches, colors.scale(), title, &names);
        save_svg(&figure, patches.len(), directory)?;
        save_png(&png(&figure, PNG_SCALE)?, directory)
    }
}

/// A cell of the plane for a picture, with lines along those edges that are not between its pieces.
fn flat_patch(cell: &PlaneCell, value: f64) -> Patch {
    let place = |point: &Point2<f64>| point + cell.site.coords;
    let pieces = cell.pieces().iter();
    let contours = pieces.map(|piece| piece.vertices().iter().map(place).collect());
    let edges = cell.pieces().iter().flat_map(ConvexPolygon::edges);
    let lines = edges.filter(|edge| FacetKind::of(edge.label) != FacetKind::Inner);
    Patch {
        contours: contours.collect(),
        rims: (cell.pieces().len() > 1).then(|| {
            let ends = lines.map(|edge| [place(&edge.start), place(&edge.end)]);
            ends.collect()
        }),
        value,
        site: Some(cell.site),
    }
}

impl DrawCells<3> for Space {
    fn draw_cells(
        &self,
        sites: &[Point3<f64>],
        cells: &[CellMetrics<3>],
        wanted: Output,
        directory: &RunDirectory,
    ) -> Result<(), Box<dyn Error>> {
        let colors = Colors::of(cells, wanted.range);
        let is_written = !wanted.cells_file || self.write_shared(sites, cells, directory)?;
        if is_written && !wanted.pictures {
            return finish(None, wanted, directory);
        }
        let mut file = (!is_written).then(|| VtuWriter::new(&directory.file("cells.vtu")));
        let height = cut_height(&self.bounds(), self.volume(), sites.len());
        let cut = PlaneCut::horizontal(height);
        let mut patches = Vec::new();
        let removed = Removed::enough_of(&self.bounds(), sites);
        let (scale, title) = (colors.scale().clone(), removed.title());
        let around = seen_bounds(self, sites.len());
        let mut cutaway = CutawayPicture::new(&around, removed, scale, title)?;
        let shown: Vec<bool> = sites.iter().map(|site| cutaway.shows(site)).collect();
        let mut add = |site: usize, [shell, seen]: [Shell; 2]| {
            let value = Colors::value(&cells[site]);
            if wanted.pictures {
                patches.extend(cut.patch(&shell, value));
                cutaway.push(&seen, &sites[site], value);
            }
            if let Some(file) = &mut file {
                file.push(&geometry(site, shell, &cells[site]))?;
            }
            Ok::<(), Box<dyn Error>>(())
        };
        if let Some(cells) = self.linf(sites) {
            let is_seen = |site: u32, label| shown[site as usize] && !is_covered(label, &shown);
            cells.stream_shells(is_seen, |shells| shells, &mut add)?;
        } else {
            Diagram::borrowed(self.domain(), sites)?.stream(
                |scratch: &mut PieceScratch, cell| {
                    let is_shown = shown[cell.site as usize];
                    let is_seen = |label| is_shown && !is_covered(label, &shown);
                    shells(self.domain(), &cell, scratch, is_seen)
                },
                &mut add,
            )?;
        }
        finish(file, wanted, directory)?;
        if !wanted.pictures {
            return Ok(());
        }
        let title = format!("Cells cut at z = {height:.4}");
        let figure = picture(&patches, colors.scale(), &title, &cut.axis_names());
        save_svg(&figure, patches.len(), directory)?;
        save_png(&cutaway.finish()?, directory)
    }
}

/// Completes `cells.vtu`, packed if that is wanted.
fn finish(
    file: Option<VtuWriter>,
    wanted: Output,
    directory: &RunDirectory,
) -> Result<(), Box<dyn Error>> {
    file.map_or(Ok(0), VtuWriter::finish)?;
    if wanted.cells_file && wanted.compress {
        let path = directory.file("cells.vtu");
        compress(&path).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(())
}

/// Whether the cell on the other side of a facet is shown too: then nobody sees the facet. Filling it
/// costs as many pixels as it has, for a wall-to-wall slab millions.
fn is_covered(label: Label, shown: &[bool]) -> bool {
    match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => image == [0; 3] && shown[site as usize],
        _ => false,
    }
}

impl Space {
    /// Writes `cells.vtu` with points that cells share, unless they are too many for the memory or do
    /// not fit together; returns whether it is written.
    fn write_shared(
        &self,
        sites: &[Point3<f64>],
        cells: &[CellMetrics<3>],
        directory: &RunDirectory,
    ) -> Result<bool, Box<dyn Error>> {
        if sites.len() > MOST_SHARED {
            print_note(format!(
                "in cells.vtu each of more than {MOST_SHARED} cells has its own points; facets narrower than \
                 1e-10 of a cell are left out"
            ));
            return Ok(false);
        }
        let mesh = match self.linf(sites) {
            None => assemble_whole(&Diagram::borrowed(self.domain(), sites)?).ok(),
            Some(cells) if sites.len() <= MOST_SHARED_LINF => shared_linf_cells(&cells),
            Some(_) => return Ok(false),
        };
        let Some(mesh) = mesh else {
            return Ok(false);
        };
        let reals =
            |of: fn(&CellMetrics<3>) -> f64| CellColumn::Reals(cells.iter().map(of).collect());
        let facets = cells.iter().map(|cell| cell.facets as i64).collect();
        let columns = [
            (
                "site",
                CellColumn::Integers((0..sites.len() as i64).collect()),
            ),
            ("energy", reals(|cell| cell.energy)),
            ("volume", reals(|cell| cell.volume)),
            ("cubeness", reals(|cell| cell.cubeness)),
            ("facets", CellColumn::Integers(facets)),
        ];
        write_mesh(&directory.file("cells.vtu"), &mesh, &columns, false)?;
        Ok(true)
    }
}

/// The mesh of L∞ cells in space, none where they do not fit together.
pub(crate) fn shared_linf_cells(cells: &LinfCells<'_>) -> Option<PolyMesh> {
    let (domain, sites, frame) = cells.placed();
    let mut mesh = linf_mesh(domain.shape(), sites)?;
    if let Some(frame) = frame {
        for point in &mut mesh.points {
            *point = frame * *point;
        }
    }
    Some(mesh)
}

/// The domain's box, longer along periodic axes by what cells of sites at its ends reach beyond it.
fn seen_bounds(space: &Space, count: usize) -> Bounds<3> {
    let side = optimal_side::<3>(space.volume(), count);
    let beyond = |period: Option<f64>| period.map_or(0.0, |period| side.min(0.5 * period));
    space.bounds().grown(&space.periods().map(beyond).into())
}

fn cut_height(bounds: &Bounds<3>, volume: f64, count: usize) -> f64 {
    let side = optimal_side::<3>(volume, count).min(bounds.extent().z);
    bounds.center().z + OFF_MIDDLE * side
}

/// Cells colored by energy, relative to a cube of the cell's own volume and mean density: that shows
/// shapes, where a common measure would show how volumes and densities differ.
pub(crate) struct Colors(ColorScale);

impl Colors {
    /// Colors spread over the energies of `cells`, or over `range`.
    fn of<const D: usize>(cells: &[CellMetrics<D>], range: Option<[f64; 2]>) -> Self {
        let label = if D == 2 {
            "energy (% of a square of the cell’s area)"
        } else {
            "energy (% of a cube of the cell’s volume)"
        };
        if let Some([min, max]) = range {
            let label = label.to_owned();
            return Self(ColorScale { label, min, max });
        }
        let values = cells.iter().map(Self::value);
        Self(ColorScale::fitting(label, values))
    }

    fn scale(&self) -> &ColorScale {
        &self.0
    }

    /// The energy of a cell (%).
    pub(crate) fn value<const D: usize>(cell: &CellMetrics<D>) -> f64 {
        let cube = cell.relative_density * optimal_energy::<D>(cell.volume, 1, 1);
        100.0 * cell.chebyshev / cube
    }
}

/// A cell as `cells.vtu` holds it.
fn geometry<const D: usize>(site: usize, shell: Shell, cell: &CellMetrics<D>) -> CellGeometry {
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
fn save_svg(
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
fn save_png(bytes: &[u8], directory: &RunDirectory) -> Result<(), Box<dyn Error>> {
    save("cells.png", bytes, directory)
}

fn save(name: &str, bytes: &[u8], directory: &RunDirectory) -> Result<(), Box<dyn Error>> {
    write_file(&directory.file(name), |file| file.write_all(bytes))?;
    Ok(())
}
