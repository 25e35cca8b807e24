//! Relaxation in the plane: the energies, minimizers and figures of planar cells. In the figures read
//! square for cube and edge for facet.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use thiserror::Error;

use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::energy::center::{BOUNDARY_FRACTION, Center, CenterSearch};
use crate::energy::planar::{energy, energy_with_derivatives};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::problem::Evaluation;
use crate::relax::cell_check::{CellsError, DomainTotals};
use crate::relax::metrics::{ALIGNED, CellMetrics, FACET_SHARE};
use crate::relax::relaxation_space::{CellResult, EnergySpec, Norm, RelaxationSpace};
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram, PlaneDiagramError};

/// A reach above this means that the center lies inside or on the border.
const ON_BORDER: f64 = 1.0 - 1e-12;

/// Why sites have no cells in a [`Plane`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlaneError {
    /// They have no diagram.
    #[error(transparent)]
    Diagram(#[from] PlaneDiagramError),
    /// They have cells that cannot be, or whose energies are no numbers.
    #[error(transparent)]
    Cells(#[from] CellsError),
}

/// A rectangle or convex polygon in which sites relax.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Where the sites live.
    pub domain: PlaneDomain,
}

impl Plane {
    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn metrics(
        &self,
        sites: &[Point2<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellMetrics<2>>, PlaneError> {
        self.check_scale(sites.len(), spec)?;
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let cells = diagram.cells.par_iter();
        let cells: Vec<_> = cells.map(|cell| metrics(cell, spec)).collect();
        let figures = cells.iter().map(|cell| (cell.volume, cell.energy));
        self.totals().check::<2>(figures, spec.kind(), || None)?;
        let mut numbered = cells.iter().enumerate();
        numbered.try_for_each(|(site, cell)| cell.check(site))?;
        Ok(cells)
    }

    /// What bounds the energies of any cells.
    fn totals(&self) -> DomainTotals {
        let area = self.domain.area();
        DomainTotals {
            volume: area,
            mass: area,
            density: 1.0,
        }
    }
}

impl RelaxationSpace<2> for Plane {
    type Error = PlaneError;

    fn volume(&self) -> f64 {
        self.domain.area()
    }

    fn bounds(&self) -> Bounds<2> {
        self.domain.bounds()
    }

    fn contains(&self, point: &Point2<f64>) -> bool {
        self.domain.contains(point)
    }

    fn beyond(&self, site: &Point2<f64>, target: &Point2<f64>, factor: f64) -> Point2<f64> {
        let far = site + (target - site) * factor;
        if self.domain.contains(&far) {
            far
        } else {
            *target
        }
    }

    fn energy(&self, sites: &[Point2<f64>], spec: EnergySpec) -> Result<f64, PlaneError> {
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let energies = diagram.cells.iter().map(|cell| match spec.norm {
            Norm::Linf => energy_at_site(&cell.polygon, spec.order),
            Norm::L2 => cell.polygon.second_moment(&Point2::origin()),
        });
        Ok(energies.sum())
    }

    fn assess(
        &self,
        sites: &[Point2<f64>],
        spec: EnergySpec,
    ) -> Result<Vec<CellResult<2>>, PlaneError> {
        self.check_scale(sites.len(), spec)?;
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let bounds = self.bounds();
        let results: Vec<_> = diagram
            .cells
            .par_iter()
            .map(|cell| match spec.norm {
                Norm::Linf => toward_center(cell, &bounds, spec),
                Norm::L2 => toward_centroid(cell, &bounds),
            })
            .collect();
        let figures = results.iter().map(|cell| (cell.volume, cell.energy));
        self.totals().check::<2>(figures, spec.kind(), || None)?;
        Ok(results)
    }

    fn check_scale(&self, count: usize, spec: EnergySpec) -> Result<(), CellsError> {
        self.totals().check_scale::<2>(count, spec.kind())
    }
}

/// The minimum of the cell's energy over its own bounding box, in coordinates relative to the
/// site; none for a cell that rounding has left without area.
fn relative_center(cell: &PlaneCell, spec: EnergySpec) -> Option<Center<2>> {
    let polygon = &cell.polygon;
    (polygon.area() > 0.0).then(|| {
        let search = CenterSearch {
            minimizer: spec.minimizer,
            order: spec.order,
            volume: polygon.area(),
            mass: polygon.area(),
            bounds: polygon.bounds(),
        };
        search.center(|c| energy_with_derivatives(polygon, &Point2::from(*c), spec.order))
    })
}

fn toward_center(cell: &PlaneCell, bounds: &Bounds<2>, spec: EnergySpec) -> CellResult<2> {
    let polygon = &cell.polygon;
    let minimum = relative_center(cell, spec);
    let step = minimum.map(|m| step_inside(polygon, &Point2::from(m.point)));
    CellResult {
        volume: polygon.area(),
        energy: energy_at_site(polygon, spec.order),
        chebyshev: energy_at_site(polygon, 1),
        target: bounds.clamp(&(cell.site + step.unwrap_or_default())),
        evaluations: minimum.map_or(0, |m| m.evaluations),
    }
}

/// Where a site moves that wants to go to `center`: all the way if that lies in the cell
/// `polygon` (which has the site as origin), else along the straight line, up to just before the
/// cell's boundary.
fn step_inside(polygon: &ConvexPolygon, center: &Point2<f64>) -> Vector2<f64> {
    let reach = polygon.reach(&Point2::origin(), &center.coords);
    if reach >= ON_BORDER {
        center.coords
    } else {
        center.coords * (reach * BOUNDARY_FRACTION)
    }
}

fn toward_centroid(cell: &PlaneCell, bounds: &Bounds<2>) -> CellResult<2> {
    let polygon = &cell.polygon;
    CellResult {
        volume: polygon.area(),
        energy: polygon.second_moment(&Point2::origin()),
        chebyshev: energy_at_site(polygon, 1),
        target: bounds.clamp(&(cell.site + polygon.centroid().coords)),
        evaluations: 1,
    }
}

fn energy_at_site(polygon: &ConvexPolygon, order: u32) -> f64 {
    energy(polygon, &Point2::origin(), order)
}

fn metrics(cell: &PlaneCell, spec: EnergySpec) -> CellMetrics<2> {
    let polygon = &cell.polygon;
    let centroid = polygon.centroid();
    let (at_site, center, center_energy) = match spec.norm {
        Norm::Linf => chebyshev_metrics(cell, spec),
        Norm::L2 => euclidean_metrics(polygon, &centroid),
    };
    CellMetrics {
        volume: polygon.area(),
        centroid: cell.site + centroid.coords,
        energy: at_site.value,
        gradient: at_site.gradient,
        center: cell.site + center,
        center_energy,
        facets: facets(polygon),
        chebyshev: energy(polygon, &Point2::origin(), 1),
        relative_density: 1.0,
        cubeness: cubeness(polygon),
        axis_aligned: axis_aligned(polygon),
    }
}

/// The energy about the site, the center relative to the site and the energy there.
fn chebyshev_metrics(cell: &PlaneCell, spec: EnergySpec) -> (Evaluation<2>, Vector2<f64>, f64) {
    let polygon = &cell.polygon;
    let at_site = energy_with_derivatives(polygon, &Point2::origin(), spec.order);
    match relative_center(cell, spec) {
        Some(center) => (at_site, center.point, center.energy),
        None => (at_site, Vector2::zeros(), at_site.value),
    }
}

/// The same for ∫ |y − c|₂², whose center is the centroid: the gradient is 2 A (c − centroid).
fn euclidean_metrics(
    polygon: &ConvexPolygon,
    centroid: &Point2<f64>,
) -> (Evaluation<2>, Vector2<f64>, f64) {
    let curvature = 2.0 * polygon.area();
    let at_site = Evaluation {
        value: polygon.second_moment(&Point2::origin()),
        gradient: -curvature * centroid.coords,
        hessian: nalgebra::Matrix2::from_diagonal_element(curvature),
    };
    (at_site, centroid.coords, polygon.second_moment(centroid))
}

fn facets(polygon: &ConvexPolygon) -> u32 {
    let least = FACET_SHARE * polygon.area().max(0.0).sqrt();
    polygon.edges().filter(|edge| edge.length() > least).count() as u32
}

/// The overlap of the polygon with the square of its own area about the origin, over their union.
fn cubeness(polygon: &ConvexPolygon) -> f64 {
    let area = polygon.area();
    if area <= 0.0 {
        return 0.0;
    }
    let offset = 0.5 * area.sqrt();
    let mut common = polygon.clone();
    for normal in [Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()] {
        common.clip(&HalfPlane { normal, offset }, FacetKind::Inner.label());
    }
    let overlap = common.area();
    overlap / (2.0 * area - overlap)
}

/// The share of the perimeter whose unit normal has a component of at least [`ALIGNED`].
fn axis_aligned(polygon: &ConvexPolygon) -> f64 {
    let aligned = polygon
        .edges()
        .filter(|edge| (edge.end - edge.start).amax() >= ALIGNED * edge.length())
        .map(|edge| edge.length())
        .sum::<f64>();
    let perimeter = polygon.perimeter();
    if perimeter > 0.0 {
        aligned / perimeter
    } else {
        0.0
    }
}
