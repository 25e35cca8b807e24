//! L2 Voronoi cells of the plane, clipped to a rectangle or convex polygon.
//!
//! The crate `voronator` finds which sites are neighbors; every cell is then the domain's polygon
//! cut by the bisectors with these neighbors, so each edge is labelled with its neighbor. A neighbor
//! that `voronator` misses can only make cells too large, never too small: their areas add up
//! to the domain's if and only if none was missed. That sum is checked, and when it fails
//! (or `voronator` does, or there are too few sites for it) all cells are cut by the bisectors of
//! ever farther sites of a grid instead, until none can matter: beyond twice the distance to the
//! cell's farthest vertex, the security radius of \[RSL\].
//!
//! Cells are kept relative to their sites: bisectors and cuts are then as exact for a small domain
//! far from the origin as for one around it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::Point2;
use rayon::prelude::*;
use thiserror::Error;
use voronator::VoronoiDiagram;
use voronator::delaunator::Point;
use voronator::polygon::Polygon;

use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::polygon::ConvexPolygon;
use crate::voronoi::planar::grid::PlaneGrid;

/// How closely the areas of the cells must add up to the domain's, relative to it.
const AREA_AGREES: f64 = 1e-13;

/// Why sites have no diagram.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlaneDiagramError {
    /// There is no site.
    #[error("there are no sites: a diagram needs at least one")]
    NoSites,
    /// A coordinate is NaN or infinite.
    #[error("site {site} is not finite: ({x}, {y})")]
    NotFinite {
        /// Which site, from zero.
        site: usize,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
    },
    /// A site lies outside the domain.
    #[error("site {site} lies outside the domain: ({x}, {y})")]
    Outside {
        /// Which site, from zero.
        site: usize,
        /// Its x (L).
        x: f64,
        /// Its y (L).
        y: f64,
    },
    /// Two sites coincide.
    #[error("sites {first} and {second} are the same point ({x}, {y}): remove one")]
    Duplicate {
        /// The lesser index, from zero.
        first: usize,
        /// The greater index.
        second: usize,
        /// Their x (L).
        x: f64,
        /// Their y (L).
        y: f64,
    },
}

/// One cell of a diagram.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneCell {
    /// The site.
    pub site: Point2<f64>,
    /// The cell with the site as origin. [`FacetKind`] reads the labels of its edges.
    pub polygon: ConvexPolygon,
}

impl PlaneCell {
    /// The cell's vertices in the domain's coordinates, counter-clockwise.
    pub(crate) fn outline(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        let origin = self.site.coords;
        self.polygon.vertices().iter().map(move |v| v + origin)
    }
}

/// The Voronoi diagram of sites in a domain of the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneDiagram {
    /// The cells, in site order.
    pub cells: Vec<PlaneCell>,
}

impl PlaneDiagram {
    /// Builds the diagram. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// If there are no sites, or one is not finite, outside the domain or the same as another.
    pub(crate) fn new(
        domain: &PlaneDomain,
        sites: &[Point2<f64>],
    ) -> Result<Self, PlaneDiagramError> {
        check(domain, sites)?;
        let through_voronator = delaunay_neighbors(domain, sites)
            .map(|neighbors| cut_by_neighbors(domain, sites, &neighbors))
            .filter(|diagram| diagram.fills(domain));
        Ok(through_voronator.unwrap_or_else(|| cut_by_rings(domain, sites)))
    }

    /// Builds the diagram without `voronator`, by the bisectors of ever farther sites alone.
    ///
    /// # Errors
    /// As [`PlaneDiagram::new`].
    #[cfg(test)]
    pub(crate) fn by_bisectors(
        domain: &PlaneDomain,
        sites: &[Point2<f64>],
    ) -> Result<Self, PlaneDiagramError> {
        check(domain, sites)?;
        Ok(cut_by_rings(domain, sites))
    }

    /// The sum of the cells' areas (L²), which is the domain's up to rounding.
    #[must_use]
    pub(crate) fn area(&self) -> f64 {
        compensated_sum(self.cells.iter().map(|cell| cell.polygon.area()))
    }

    fn fills(&self, domain: &PlaneDomain) -> bool {
        (self.area() - domain.area()).abs() <= AREA_AGREES * domain.area()
    }
}

fn cut_by_neighbors(
    domain: &PlaneDomain,
    sites: &[Point2<f64>],
    neighbors: &[Vec<usize>],
) -> PlaneDiagram {
    let cells = sites.par_iter().zip(neighbors).map(|(site, around)| {
        let mut cell = uncut(domain, site);
        for &other in around {
            cut(&mut cell, sites, other);
        }
        cell
    });
    PlaneDiagram {
        cells: cells.collect(),
    }
}

fn cut_by_rings(domain: &PlaneDomain, sites: &[Point2<f64>]) -> PlaneDiagram {
    let grid = PlaneGrid::new(sites);
    let cells = (0..sites.len())
        .into_par_iter()
        .map(|index| cell_by_rings(domain, sites, &grid, index));
    PlaneDiagram {
        cells: cells.collect(),
    }
}

fn cell_by_rings(
    domain: &PlaneDomain,
    sites: &[Point2<f64>],
    grid: &PlaneGrid,
    index: usize,
) -> PlaneCell {
    let mut cell = uncut(domain, &sites[index]);
    for ring in 0..=grid.rings() {
        if grid.distance(ring) > security_radius(&cell.polygon) {
            break;
        }
        for other in grid.ring(&sites[index], ring) {
            if other != index {
                cut(&mut cell, sites, other);
            }
        }
    }
    cell
}

fn uncut(domain: &PlaneDomain, site: &Point2<f64>) -> PlaneCell {
    PlaneCell {
        site: *site,
        polygon: domain.polygon().translated(&-site.coords),
    }
}

fn cut(cell: &mut PlaneCell, sites: &[Point2<f64>], other: usize) {
    let bisector = HalfPlane::nearer_to_origin(&(sites[other] - cell.site));
    let neighbor = FacetKind::Neighbor {
        site: other as u32,
        image: [0; 3],
    };
    cell.polygon.clip(&bisector, neighbor.label());
}

/// No site farther than this from a cell's own can cut the cell.
fn security_radius(polygon: &ConvexPolygon) -> f64 {
    let farthest = polygon.vertices().iter().map(|v| v.coords.norm_squared());
    2.0 * farthest.fold(0.0, f64::max).sqrt()
}

/// Neumaier, *Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen*, 1974.
fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut lost) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        lost += if sum.abs() >= term.abs() {
            (sum - next) + term
        } else {
            (term - next) + sum
        };
        sum = next;
    }
    sum + lost
}

/// Whether `sites` have a diagram in `domain`; of several flaws the first is named.
pub(crate) fn check(domain: &PlaneDomain, sites: &[Point2<f64>]) -> Result<(), PlaneDiagramError> {
    if sites.is_empty() {
        return Err(PlaneDiagramError::NoSites);
    }
    for (site, point) in sites.iter().enumerate() {
        let Point2 { coords } = point;
        let (x, y) = (coords.x, coords.y);
        if !(x.is_finite() && y.is_finite()) {
            return Err(PlaneDiagramError::NotFinite { site, x, y });
        }
        if !domain.contains(point) {
            return Err(PlaneDiagramError::Outside { site, x, y });
        }
    }
    check_distinct(sites)
}

fn check_distinct(sites: &[Point2<f64>]) -> Result<(), PlaneDiagramError> {
    // Adding zero makes −0 and 0 equal in the total order as well.
    let key = |&site: &usize| (sites[site].x + 0.0, sites[site].y + 0.0);
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|a, b| {
        let ((ax, ay), (bx, by)) = (key(a), key(b));
        ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(a.cmp(b))
    });
    let pair = order
        .windows(2)
        .filter(|pair| sites[pair[0]] == sites[pair[1]])
        .min();
    match pair {
        Some(pair) => Err(PlaneDiagramError::Duplicate {
            first: pair[0],
            second: pair[1],
            x: sites[pair[0]].x,
            y: sites[pair[0]].y,
        }),
        None => Ok(()),
    }
}

/// The half side of `voronator`'s bounding square, in units of the domain's largest extent. Its
/// auxiliary sites lie three times as far out: no point of the domain is nearer to one than to a site.
const BOUNDING_SQUARE: f64 = 5.0;

/// The fewest sites for which `voronator` is correct.
const FEWEST_SITES: usize = 3;

/// The neighbors of every site in the Delaunay triangulation, auxiliary sites left out; `None` if
/// `voronator` fails.
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
    // `voronator` panics where its convex hull fails: that counts as a failure like any other.
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
