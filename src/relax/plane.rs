//! The plane as a space to relax in: diagrams from `voronoi`, worth from `chebyshev`.

use nalgebra::Point2;
use rayon::prelude::*;

use crate::chebyshev::plane::energy;
use crate::chebyshev::plane_center::{center, step_inside};
use crate::domain::plane::PlaneDomain;
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::problem::Minimum;
use crate::relax::tessellation::{Assessment, Norm, Question, Tessellation};
use crate::voronoi::plane::{PlaneCell, PlaneDiagram, PlaneDiagramError};

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
pub(crate) fn relative_center(cell: &PlaneCell, question: Question) -> Option<Minimum<2>> {
    let polygon = &cell.polygon;
    (polygon.area() > 0.0).then(|| {
        center(
            polygon,
            &Point2::origin(),
            &polygon.bounds(),
            question.order,
        )
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
