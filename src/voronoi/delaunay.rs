//! The crate `voronator` as a finder of neighbors in the plane.
//!
//! What `voronator` 0.2.1 needs to be trusted: no duplicates (it would give one of them an empty
//! cell), coordinates near the unit square (it merges points by absolute distances), and a
//! counter-clockwise bounding rectangle far larger than the domain (its four helper points beyond
//! that rectangle take area from the sites otherwise). Neighbors numbered n and above are these
//! helpers.

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::Point2;
use voronator::VoronoiDiagram;
use voronator::delaunator::Point;
use voronator::polygon::Polygon;

use crate::domain::planar::PlaneDomain;

/// The half side of `voronator`'s bounding square, in units of the domain's largest extent. Its
/// helpers stand three times as far out: no point of the domain is nearer to one than to a site.
const BOUNDING_SQUARE: f64 = 5.0;

/// Fewest sites for which `voronator` is right.
const FEWEST_SITES: usize = 3;

/// The neighbors of every site in the Delaunay triangulation, helpers left out; none if
/// `voronator` cannot say.
pub(crate) fn delaunay_neighbors(
    domain: &PlaneDomain,
    sites: &[Point2<f64>],
) -> Option<Vec<Vec<usize>>> {
    if sites.len() < FEWEST_SITES {
        return None;
    }
    let bounds = domain.bounds();
    let (center, unit) = (bounds.center(), bounds.extent().amax());
    let points: Vec<Point> = sites
        .iter()
        .map(|site| (site - center) / unit)
        .map(|v| Point { x: v.x, y: v.y })
        .collect();
    let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| Point {
            x: BOUNDING_SQUARE * x,
            y: BOUNDING_SQUARE * y,
        })
        .to_vec();
    // `voronator` panics where its hull breaks down; for us that is one more way to fail.
    let diagram = catch_unwind(AssertUnwindSafe(|| {
        VoronoiDiagram::with_bounding_polygon(points, &Polygon::from_points(square))
    }));
    let mut neighbors = diagram.ok()??.neighbors;
    neighbors.truncate(sites.len());
    for around in &mut neighbors {
        around.retain(|&other| other < sites.len());
    }
    Some(neighbors)
}
