//! The figures of cells in the plane: squares for cubes, edges for facets.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use crate::domain::facet_kind::FacetKind;
use crate::energy::planar::{energy, energy_with_derivatives};
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::problem::Evaluation;
use crate::relax::figures::{ALIGNED, CellFigures, FACET_SHARE};
use crate::relax::plane::{Plane, relative_center};
use crate::relax::tessellation::{Norm, Question};
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram, PlaneDiagramError};

impl Plane {
    /// The figures of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn figures(
        &self,
        sites: &[Point2<f64>],
        question: Question,
    ) -> Result<Vec<CellFigures<2>>, PlaneDiagramError> {
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let cells = diagram.cells.par_iter();
        Ok(cells.map(|cell| figures(cell, question)).collect())
    }
}

fn figures(cell: &PlaneCell, question: Question) -> CellFigures<2> {
    let polygon = &cell.polygon;
    let centroid = polygon.centroid();
    let (at_site, center, center_energy) = match question.norm {
        Norm::Linf => chebyshev_figures(cell, question),
        Norm::L2 => euclidean_figures(polygon, &centroid),
    };
    CellFigures {
        volume: polygon.area(),
        centroid: cell.site + centroid.coords,
        energy: at_site.value,
        gradient: at_site.gradient,
        center: cell.site + center,
        center_energy,
        facets: facets(polygon),
        chebyshev: energy(polygon, &Point2::origin(), 1),
        cubeness: cubeness(polygon),
        axis_aligned: axis_aligned(polygon),
    }
}

/// The energy about the site, the center relative to the site and the energy there.
fn chebyshev_figures(cell: &PlaneCell, question: Question) -> (Evaluation<2>, Vector2<f64>, f64) {
    let polygon = &cell.polygon;
    let at_site = energy_with_derivatives(polygon, &Point2::origin(), question.order);
    match relative_center(cell, question) {
        Some(center) => (at_site, center.point, center.energy),
        None => (at_site, Vector2::zeros(), at_site.value),
    }
}

/// The same for ∫ |y − c|₂², whose center is the centroid: the gradient is 2 A (c − centroid).
fn euclidean_figures(
    polygon: &ConvexPolygon,
    centroid: &Point2<f64>,
) -> (Evaluation<2>, Vector2<f64>, f64) {
    let bend = 2.0 * polygon.area();
    let at_site = Evaluation {
        value: polygon.second_moment(&Point2::origin()),
        gradient: -bend * centroid.coords,
        hessian: nalgebra::Matrix2::from_diagonal_element(bend),
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
