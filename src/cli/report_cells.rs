//! The cells of a run's sites as a page shows them: surfaces and values, of many only those at a plane.

use nalgebra::{Point, Point2, Point3};

use crate::cli::cell_files::Colors;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::relax::metrics::CellMetrics;
use crate::relax::optimum::optimal_side;
use crate::relax::planar::Plane;
use crate::relax::relaxation_space::RelaxationSpace;
use crate::relax::space::{Space, shells};
use crate::report::cells::{BrightEnd, ShownCell, ShownCells, ValueColumn};
use crate::scene::description::Scene;
use crate::scene::run::{RunSpace, energy_spec};
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram};

/// How far from the middle of the domain its cells are cut, in sides of a mean cell, as in `cells.svg`: the
/// middle itself is a wall of cells for every lattice of an even number of layers.
const OFF_MIDDLE: f64 = 0.25;

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisPlane {
    /// Its axis: 0, 1 or 2.
    pub(crate) axis: usize,
    /// Its place on the axis (L); left out, a little off the middle.
    pub(crate) place: Option<f64>,
}

/// Which cells of a run are shown.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellChoice {
    /// All of up to so many.
    pub(crate) most: usize,
    /// Of more, those that touch this plane; left out, one across the domain's shortest side.
    pub(crate) plane: Option<AxisPlane>,
}

/// A space whose cells a page can show.
pub(crate) trait ShowCells<const D: usize>: RunSpace<D> {
    /// The surfaces of the cells that are shown, in site order.
    fn surfaces(
        &self,
        sites: &[Point<f64, D>],
        shown: &(impl Fn(&Shell) -> bool + Sync),
    ) -> Result<Vec<ShownCell>, String>;
}

impl ShowCells<2> for Plane {
    fn surfaces(
        &self,
        sites: &[Point<f64, 2>],
        shown: &(impl Fn(&Shell) -> bool + Sync),
    ) -> Result<Vec<ShownCell>, String> {
        let diagram = PlaneDiagram::new(&self.domain, sites).map_err(|error| error.to_string())?;
        let cells = (0..).zip(&diagram.cells);
        let cells = cells.map(|(site, cell)| in_plane(site, cell));
        Ok(cells.filter(|cell| shown(&cell.shell)).collect())
    }
}

/// A cell of the plane: its pieces, and the edges between them.
fn in_plane(site: u32, cell: &PlaneCell) -> ShownCell {
    let lift = |point: &Point2<f64>| Point3::new(point.x, point.y, 0.0);
    let (mut vertices, mut facets, mut seams) = (Vec::new(), Vec::new(), Vec::new());
    for piece in cell.pieces() {
        let piece = piece.translated(&cell.site.coords);
        let first = vertices.len() as u32;
        vertices.extend(piece.vertices().iter().map(lift));
        facets.push(first..vertices.len() as u32);
        let inner = piece.edges();
        let inner = inner.filter(|edge| FacetKind::of(edge.label) == FacetKind::Inner);
        seams.extend(inner.map(|edge| [lift(&edge.start), lift(&edge.end)]));
    }
    ShownCell {
        site,
        position: lift(&cell.site),
        // The facets name these vertices only.
        shell: Shell::new(&vertices, facets).unwrap_or_default(),
        seams,
    }
}

impl ShowCells<3> for Space {
    fn surfaces(
        &self,
        sites: &[Point3<f64>],
        shown: &(impl Fn(&Shell) -> bool + Sync),
    ) -> Result<Vec<ShownCell>, String> {
        let mut cells = Vec::new();
        let take = |site: usize, shell: Option<Shell>| {
            cells.extend(shell.map(|shell| ShownCell {
                site: site as u32,
                position: self.wrap(&sites[site]),
                shell,
                seams: Vec::new(),
            }));
            Ok(())
        };
        stream_shells(self, sites, shown, take).map_err(|error| error.to_string())?;
        Ok(cells)
    }
}

/// Passes the surface of every cell, if it is shown, to `take` in site order.
fn stream_shells(
    space: &Space,
    sites: &[Point3<f64>],
    shown: &(impl Fn(&Shell) -> bool + Sync),
    take: impl FnMut(usize, Option<Shell>) -> Result<(), DiagramError>,
) -> Result<(), DiagramError> {
    let kept = |shell: Shell| shown(&shell).then_some(shell);
    if let Some(cells) = space.linf(sites) {
        return cells.stream_shells(|_, _| false, |[shell, _]| kept(shell), take);
    }
    let of_cell = |scratch: &mut PieceScratch, cell: Cell<'_>| {
        let [shell, _] = shells(space.domain(), &cell, scratch, |_| false);
        kept(shell)
    };
    Diagram::borrowed(space.domain(), sites)?.stream(of_cell, take)
}

/// The cells of `sites` with their values, as `choice` says.
///
/// # Errors
/// When the sites have no cells.
pub(crate) fn shown_cells<const D: usize, S: ShowCells<D>>(
    space: &S,
    scene: &Scene,
    sites: &[Point<f64, D>],
    choice: CellChoice,
) -> Result<ShownCells, String> {
    let figures = space
        .cells(sites, energy_spec(scene))
        .map_err(|error| error.to_string())?;
    let (cells, selection) = selected(space, sites, choice)?;
    Ok(ShownCells {
        dimension: D,
        bounds: in_space(&space.bounds()),
        total: sites.len(),
        selection,
        columns: columns(space, sites, &cells, &figures),
        cells,
    })
}

/// The cells that are shown and, if these are not all, which they are.
fn selected<const D: usize, S: ShowCells<D>>(
    space: &S,
    sites: &[Point<f64, D>],
    choice: CellChoice,
) -> Result<(Vec<ShownCell>, Option<String>), String> {
    if sites.len() <= choice.most {
        return Ok((space.surfaces(sites, &|_| true)?, None));
    }
    let side = optimal_side::<D>(space.volume(), sites.len());
    let (axis, place) = cut(&in_space(&space.bounds()), side, choice.plane);
    let cells = space.surfaces(sites, &|shell| touches(shell, axis, place))?;
    let name = ["x", "y", "z"][axis];
    Ok((cells, Some(format!("those that touch {name} = {place}"))))
}

/// The box of a domain in space: one of the plane lies at z = 0.
fn in_space<const D: usize>(bounds: &Bounds<D>) -> Bounds<3> {
    let corner = |point: &Point<f64, D>| {
        let along = |axis: usize| point.iter().nth(axis).copied().unwrap_or(0.0);
        Point3::new(along(0), along(1), along(2))
    };
    Bounds {
        min: corner(&bounds.min),
        max: corner(&bounds.max),
    }
}

/// The plane that is asked for, else the one across the shortest side, of equal ones the last.
fn cut(bounds: &Bounds<3>, side: f64, plane: Option<AxisPlane>) -> (usize, f64) {
    let extent = bounds.extent();
    let is_flat = extent.z <= 0.0;
    let axes = if is_flat { 0..2 } else { 0..3 };
    let shortest = axes.rev().min_by(|&a, &b| extent[a].total_cmp(&extent[b]));
    let axis = plane.map_or(shortest.unwrap_or(2), |plane| plane.axis);
    let off_middle = OFF_MIDDLE * side.min(extent[axis]);
    let place = bounds.center()[axis] + off_middle;
    let rounded = format!("{place:.6e}").parse().unwrap_or(place);
    (axis, plane.and_then(|plane| plane.place).unwrap_or(rounded))
}

fn touches(shell: &Shell, axis: usize, place: f64) -> bool {
    let along = || shell.vertices().iter().map(|vertex| vertex[axis]);
    along().any(|x| x <= place) && along().any(|x| x >= place)
}

/// A value's short name, its name with unit, and which end of its range is bright.
type ValueName = (&'static str, &'static str, BrightEnd);

/// The values of cells in space, in the order of [`value`].
const IN_SPACE: [ValueName; 8] = [
    (
        "energy",
        "energy (% of a cube of the cell’s volume)",
        BrightEnd::Low,
    ),
    ("volume", "volume (L³)", BrightEnd::Low),
    (
        "cubeness",
        "cubeness (overlap / union with a cube)",
        BrightEnd::High,
    ),
    (
        "aligned area",
        "share of the area within 10° of the axes",
        BrightEnd::High,
    ),
    (
        "way to center",
        "site to center (% of the cell’s diagonal)",
        BrightEnd::Low,
    ),
    (
        "energy as in the scene",
        "energy in the scene’s norm and order",
        BrightEnd::Low,
    ),
    ("density", "mean density (1 = the domain’s)", BrightEnd::Low),
    ("facets", "facets above 5 % of volume^⅔", BrightEnd::Low),
];

/// The same in the plane.
const IN_PLANE: [ValueName; 8] = [
    (
        "energy",
        "energy (% of a square of the cell’s area)",
        BrightEnd::Low,
    ),
    ("area", "area (L²)", BrightEnd::Low),
    (
        "squareness",
        "squareness (overlap / union with a square)",
        BrightEnd::High,
    ),
    (
        "aligned sides",
        "share of the sides within 10° of the axes",
        BrightEnd::High,
    ),
    (
        "way to center",
        "site to center (% of the cell’s diagonal)",
        BrightEnd::Low,
    ),
    (
        "energy as in the scene",
        "energy in the scene’s norm and order",
        BrightEnd::Low,
    ),
    ("density", "mean density (1 = the domain’s)", BrightEnd::Low),
    ("sides", "sides above 5 % of √area", BrightEnd::Low),
];

/// The last one, in space and in the plane.
const SITE: ValueName = ("site", "number of the site", BrightEnd::Low);

/// The places of values that are whole numbers, and of those that domains without density do without.
const FACETS: usize = 7;
const DENSITY: usize = 6;

/// A value of a cell, `way` being that from its site to its center (L).
fn value<const D: usize>(cell: &CellMetrics<D>, way: f64, place: usize) -> f64 {
    match place {
        0 => Colors::value(cell),
        1 => cell.volume,
        2 => cell.cubeness,
        3 => cell.axis_aligned,
        4 => 100.0 * way / (optimal_side::<D>(cell.volume, 1) * (D as f64).sqrt()),
        5 => cell.energy,
        DENSITY => cell.relative_density,
        _ => f64::from(cell.facets),
    }
}

/// The values of the cells by which they can be colored.
fn columns<const D: usize, S: ShowCells<D>>(
    space: &S,
    sites: &[Point<f64, D>],
    shown: &[ShownCell],
    figures: &[CellMetrics<D>],
) -> Vec<ValueColumn> {
    let names = if D == 2 { IN_PLANE } else { IN_SPACE };
    let has_density = space.varying_density().is_some();
    let of_cell = |cell: &ShownCell, place: usize| {
        let figures = &figures[cell.site as usize];
        let way = space.displacement(&sites[cell.site as usize], &figures.center);
        value(figures, way.norm(), place)
    };
    let wanted = (0..).zip(names);
    let wanted = wanted.filter(|&(place, _)| has_density || place != DENSITY);
    let of_cells = wanted.map(|(place, name)| {
        let values = shown.iter().map(|cell| of_cell(cell, place)).collect();
        column(name, place == FACETS, values)
    });
    let sites = shown.iter().map(|cell| f64::from(cell.site)).collect();
    of_cells.chain([column(SITE, true, sites)]).collect()
}

fn column((name, label, bright): ValueName, is_whole: bool, values: Vec<f64>) -> ValueColumn {
    ValueColumn {
        name,
        label,
        bright,
        is_whole,
        values,
    }
}
