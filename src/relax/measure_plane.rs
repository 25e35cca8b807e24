//! The figures of every cell of a diagram in the plane, and its outline for pictures.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use crate::chebyshev::plane::energy_with_derivatives;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::relax::plane::relative_center;
use crate::relax::tessellation::Question;
use crate::voronoi::plane::{PlaneCell, PlaneDiagram};

/// Edges longer than this share of √area count as facets.
const FACET_SHARE: f64 = 0.05;

/// An edge counts as axis-aligned if a component of its unit normal is at least this.
const ALIGNED: f64 = 0.985;

/// The figures of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneCellFigures {
    /// The site.
    pub site: Point2<f64>,
    /// The vertices, counter-clockwise: what a picture draws.
    pub outline: Vec<Point2<f64>>,
    /// The area (L²).
    pub area: f64,
    /// The mass center.
    pub centroid: Point2<f64>,
    /// The Chebyshev energy of the asked order at the site (L^(2+p)).
    pub energy: f64,
    /// Its gradient at the site (L^(1+p)).
    pub gradient: Vector2<f64>,
    /// The p = 1 Chebyshev energy at the site (L³).
    pub chebyshev: f64,
    /// The minimizer of the energy over the cell's bounding box.
    pub center: Point2<f64>,
    /// The energy there (L^(2+p)).
    pub center_energy: f64,
    /// How many edges are longer than 5 % of √area.
    pub facets: usize,
    /// |C ∩ Q| / |C ∪ Q|, Q the axis-aligned square of the cell's area about its site.
    pub cubeness: f64,
    /// The share of the perimeter whose unit normal has a component of at least 0.985.
    pub axis_aligned: f64,
}

/// The figures of all cells, in site order.
#[must_use]
pub fn measure(diagram: &PlaneDiagram, question: Question) -> Vec<PlaneCellFigures> {
    diagram
        .cells
        .par_iter()
        .map(|cell| figures(cell, question))
        .collect()
}

fn figures(cell: &PlaneCell, question: Question) -> PlaneCellFigures {
    let polygon = &cell.polygon;
    let origin = Point2::origin();
    let at_site = energy_with_derivatives(polygon, &origin, question.order);
    let minimum = relative_center(cell, question);
    PlaneCellFigures {
        site: cell.site,
        outline: cell.outline().collect(),
        area: polygon.area(),
        centroid: cell.site + polygon.centroid().coords,
        energy: at_site.value,
        gradient: at_site.gradient,
        chebyshev: energy_with_derivatives(polygon, &origin, 1).value,
        center: cell.site + minimum.map(|m| m.point).unwrap_or_default(),
        center_energy: minimum.map_or(at_site.value, |m| m.energy),
        facets: facets(polygon),
        cubeness: cubeness(polygon),
        axis_aligned: axis_aligned(polygon),
    }
}

fn facets(polygon: &ConvexPolygon) -> usize {
    let least = FACET_SHARE * polygon.area().max(0.0).sqrt();
    polygon.edges().filter(|edge| edge.length() > least).count()
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
        common.clip(&HalfPlane { normal, offset }, Label::MAX);
    }
    let overlap = common.area();
    overlap / (2.0 * area - overlap)
}

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
