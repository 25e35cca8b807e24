//! The plane as a space to relax in: diagrams from `voronoi`, worth from `chebyshev`.

use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

use crate::domain::planar::PlaneDomain;
use crate::energy::center::{BOUNDARY_FRACTION, Center, Search};
use crate::energy::planar::{energy, energy_with_derivatives};
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon::ConvexPolygon;
use crate::relax::tessellation::{Assessment, Norm, Question, Tessellation};
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram, PlaneDiagramError};

/// A reach above this means that the center lies inside or on the border.
const ON_BORDER: f64 = 1.0 - 1e-12;

/// A rectangle or convex polygon in which sites relax.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Where the sites live.
    pub domain: PlaneDomain,
}

impl Tessellation<2> for Plane {
    type Error = PlaneDiagramError;

    fn volume(&self) -> f64 {
        self.domain.area()
    }

    fn bounds(&self) -> Bounds<2> {
        self.domain.bounds()
    }

    fn beyond(&self, site: &Point2<f64>, target: &Point2<f64>, factor: f64) -> Point2<f64> {
        let far = site + (target - site) * factor;
        if self.domain.contains(&far) {
            far
        } else {
            *target
        }
    }

    fn energy(&self, sites: &[Point2<f64>], question: Question) -> Result<f64, PlaneDiagramError> {
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let energies = diagram.cells.iter().map(|cell| match question.norm {
            Norm::Linf => energy_at_site(&cell.polygon, question.order),
            Norm::L2 => cell.polygon.second_moment(&Point2::origin()),
        });
        Ok(energies.sum())
    }

    fn assess(
        &self,
        sites: &[Point2<f64>],
        question: Question,
    ) -> Result<Vec<Assessment<2>>, PlaneDiagramError> {
        let diagram = PlaneDiagram::new(&self.domain, sites)?;
        let bounds = self.bounds();
        Ok(diagram
            .cells
            .par_iter()
            .map(|cell| match question.norm {
                Norm::Linf => toward_center(cell, &bounds, question),
                Norm::L2 => toward_centroid(cell, &bounds),
            })
            .collect())
    }
}

/// The minimum of the cell's energy over its own bounding box, in coordinates relative to the
/// site; none for a cell that rounding has left without area.
pub(crate) fn relative_center(cell: &PlaneCell, question: Question) -> Option<Center<2>> {
    let polygon = &cell.polygon;
    (polygon.area() > 0.0).then(|| {
        let search = Search {
            minimizer: question.minimizer,
            order: question.order,
            volume: polygon.area(),
            mass: polygon.area(),
            bounds: polygon.bounds(),
        };
        search.center(|c| energy_with_derivatives(polygon, &Point2::from(*c), question.order))
    })
}

fn toward_center(cell: &PlaneCell, bounds: &Bounds<2>, question: Question) -> Assessment<2> {
    let polygon = &cell.polygon;
    let minimum = relative_center(cell, question);
    let step = minimum.map(|m| step_inside(polygon, &Point2::from(m.point)));
    Assessment {
        energy: energy_at_site(polygon, question.order),
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

fn toward_centroid(cell: &PlaneCell, bounds: &Bounds<2>) -> Assessment<2> {
    let polygon = &cell.polygon;
    Assessment {
        energy: polygon.second_moment(&Point2::origin()),
        chebyshev: energy_at_site(polygon, 1),
        target: bounds.clamp(&(cell.site + polygon.centroid().coords)),
        evaluations: 1,
    }
}

fn energy_at_site(polygon: &ConvexPolygon, order: u32) -> f64 {
    energy(polygon, &Point2::origin(), order)
}
