//! L2 Voronoi cells of the plane, clipped to a rectangle, perhaps periodic, or a polygon.
//!
//! The crate `voronator` finds which sites are neighbors; every cell is then the domain's polygon
//! cut by the bisectors with these neighbors, so each edge is labelled with its neighbor. A neighbor
//! that `voronator` misses can only make cells too large, never too small: their areas add up
//! to the domain's if and only if none was missed. That sum is checked, and when it fails
//! (or `voronator` does, or there are too few sites for it) all cells are cut by the bisectors of
//! ever farther sites of a grid instead, until none can matter: beyond twice the distance to the
//! cell's farthest vertex, the security radius of \[RSL\]. In periodic rectangles all cells are cut so,
//! by sites and by their images one period away: no image farther than that is the nearest one of its
//! site anywhere in a cell, which is cut from one period about its site.
//!
//! In a domain that is not convex cells are cut from the box around it, and the convex pieces of the
//! domain are then cut by the bisectors that made a cell ([`PlaneCell::pieces`]).
//!
//! Cells are kept relative to their sites: bisectors and cuts are then as exact for a small domain
//! far from the origin as for one around it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use nalgebra::{Point2, Point3, Vector2};
use thiserror::Error;
use voronator::VoronoiDiagram;
use voronator::delaunator::Point;
use voronator::polygon::Polygon;

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::parallel::map;
use crate::voronoi::linf::cone::exact_displacement;
use crate::voronoi::planar::grid::PlaneGrid;
use crate::voronoi::planar::linf::{PlaneLinfCell, box_about, within};

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
    /// A site was chosen that is not there.
    #[error("there is no site {site} among {count}; the first is 0")]
    NoSuchSite {
        /// Its index, from zero.
        site: usize,
        /// How many sites there are.
        count: usize,
    },
}

/// One cell of a diagram.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlaneCell {
    /// The site.
    pub site: Point2<f64>,
    /// The cell with the site as origin; where the domain is not convex, that in the box around it. Of
    /// L∞ cells it is the star-shaped outline in that box. [`FacetKind`] reads the labels of its edges.
    pub polygon: ConvexPolygon,
    /// The cell's part in a domain that is not convex, unless that is all of it, and every L∞ cell.
    parts: Option<Vec<ConvexPolygon>>,
}

impl PlaneCell {
    /// Convex polygons that fill the cell's part in the domain, with the site as origin.
    pub(crate) fn pieces(&self) -> &[ConvexPolygon] {
        match &self.parts {
            Some(parts) => parts,
            None => std::slice::from_ref(&self.polygon),
        }
    }

    /// The corners of the pieces in the domain's coordinates, counter-clockwise.
    pub(crate) fn outlines(&self) -> impl Iterator<Item = Vec<Point2<f64>>> + '_ {
        let place = |corner: &Point2<f64>| corner + self.site.coords;
        let pieces = self.pieces().iter();
        pieces.map(move |piece| piece.vertices().iter().map(place).collect())
    }

    /// The area of the cell's part in the domain (L²) and its centroid relative to the site (L).
    pub(crate) fn centroid(&self) -> (f64, Vector2<f64>) {
        let (mut area, mut first) = (0.0, Vector2::zeros());
        for edge in self.pieces().iter().flat_map(ConvexPolygon::edges) {
            let (start, end) = (edge.start.coords, edge.end.coords);
            let half = 0.5 * start.perp(&end);
            area += half;
            first += (start + end) * (half / 3.0);
        }
        (area, first / area)
    }

    /// The area of the cell's part in the domain (L²).
    pub(crate) fn area(&self) -> f64 {
        self.pieces().iter().map(ConvexPolygon::area).sum()
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
        if domain.has_linf_cells() {
            return Ok(linf_diagram(domain, sites, false));
        }
        let through_voronator = delaunay_neighbors(domain, sites)
            .map(|neighbors| cut_by_neighbors(domain, sites, &neighbors))
            .filter(|diagram| diagram.fills(domain));
        Ok(through_voronator.unwrap_or_else(|| cut_by_rings(domain, sites)))
    }

    /// The L∞ cells without what is equidistant to several sites.
    ///
    /// # Errors
    /// As [`PlaneDiagram::new`].
    pub(crate) fn untied(
        domain: &PlaneDomain,
        sites: &[Point2<f64>],
    ) -> Result<Self, PlaneDiagramError> {
        check(domain, sites)?;
        Ok(linf_diagram(domain, sites, true))
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
        compensated_sum(self.cells.iter().map(PlaneCell::area))
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
    let cell = |index: usize| {
        let mut cell = Cutting::new(domain, sites, index);
        for &other in &neighbors[index] {
            cell.cut(other, [0; 3]);
        }
        cell.finish()
    };
    PlaneDiagram {
        cells: map(sites.len(), &cell),
    }
}

fn cut_by_rings(domain: &PlaneDomain, sites: &[Point2<f64>]) -> PlaneDiagram {
    let images = images(domain, sites);
    let positions: Vec<_> = images.iter().map(|image| image.position).collect();
    let grid = PlaneGrid::new(&positions);
    let cell = |index: usize| cell_by_rings(domain, sites, (&grid, &images), index);
    PlaneDiagram {
        cells: map(sites.len(), &cell),
    }
}

/// The L∞ cells; `wins_ties` takes from all of them what they share.
fn linf_diagram(domain: &PlaneDomain, sites: &[Point2<f64>], wins_ties: bool) -> PlaneDiagram {
    let images = images(domain, sites);
    let positions: Vec<_> = images.iter().map(|image| image.position).collect();
    let grid = PlaneGrid::new(&positions);
    let cell = |index: usize| {
        let site = sites[index];
        let (bounds, labels) = box_about(domain, &site, index as u32);
        let mut cell = PlaneLinfCell::new(&bounds, labels);
        for ring in 0..=grid.rings() {
            if grid.distance(ring) > 2.0 * cell.reach() {
                break;
            }
            for image in grid.ring(&site, ring).map(|other| &images[other]) {
                if image.site != index {
                    let [from, to] =
                        [site, sites[image.site]].map_each(|p| Point3::new(p.x, p.y, 0.0));
                    let by = shift(domain, image.image).push(0.0);
                    let to_image = exact_displacement(&from, &to, &by).xy();
                    let label = image.label();
                    cell.add(&to_image, label, wins_ties || image.site < index);
                }
            }
        }
        let (polygon, parts) = cell.finish();
        let parts = Some(within(domain, &site, parts));
        PlaneCell {
            site,
            polygon,
            parts,
        }
    };
    PlaneDiagram {
        cells: map(sites.len(), &cell),
    }
}

/// A site, or a copy of one by whole periods.
struct SiteImage {
    position: Point2<f64>,
    site: usize,
    image: [i8; 3],
}

impl SiteImage {
    fn label(&self) -> Label {
        let (site, image) = (self.site as u32, self.image);
        FacetKind::Neighbor { site, image }.label()
    }
}

/// All sites, and their images one period away.
fn images(domain: &PlaneDomain, sites: &[Point2<f64>]) -> Vec<SiteImage> {
    let reach = domain.periods().map(|period| i8::from(period.is_some()));
    let mut images = Vec::new();
    for x in -reach[0]..=reach[0] {
        for y in -reach[1]..=reach[1] {
            let image = [x, y, 0];
            let by = shift(domain, image);
            let moved = sites.iter().enumerate();
            images.extend(moved.map(|(site, position)| SiteImage {
                position: position + by,
                site,
                image,
            }));
        }
    }
    images
}

/// The displacement of an image (L).
fn shift(domain: &PlaneDomain, image: [i8; 3]) -> Vector2<f64> {
    let periods = domain.periods().map(Option::unwrap_or_default);
    Vector2::new(
        f64::from(image[0]) * periods[0],
        f64::from(image[1]) * periods[1],
    )
}

fn cell_by_rings(
    domain: &PlaneDomain,
    sites: &[Point2<f64>],
    (grid, images): (&PlaneGrid, &[SiteImage]),
    index: usize,
) -> PlaneCell {
    let mut cell = Cutting::new(domain, sites, index);
    for ring in 0..=grid.rings() {
        if grid.distance(ring) > security_radius(&cell.polygon) {
            break;
        }
        for other in grid.ring(&sites[index], ring) {
            if images[other].site != index {
                cell.cut(images[other].site, images[other].image);
            }
        }
    }
    cell.finish()
}

/// A cell while it is cut.
struct Cutting<'a> {
    domain: &'a PlaneDomain,
    sites: &'a [Point2<f64>],
    site: Point2<f64>,
    polygon: ConvexPolygon,
    /// The cuts that took something away, where the domain is not convex.
    cuts: Vec<(HalfPlane, Label)>,
}

impl<'a> Cutting<'a> {
    fn new(domain: &'a PlaneDomain, sites: &'a [Point2<f64>], index: usize) -> Self {
        Self {
            domain,
            sites,
            site: sites[index],
            polygon: domain.start(&sites[index], index as u32),
            cuts: Vec::new(),
        }
    }

    /// Cuts by the bisector with another site's image.
    fn cut(&mut self, other: usize, image: [i8; 3]) {
        // This sum is the negative of the other cell's to the last bit.
        let displacement = (self.sites[other] - self.site) + shift(self.domain, image);
        let bisector = HalfPlane::nearer_to_origin(&displacement);
        let site = other as u32;
        let label = FacetKind::Neighbor { site, image }.label();
        if self.polygon.clip(&bisector, label) && !self.domain.is_convex() {
            self.cuts.push((bisector, label));
        }
    }

    fn finish(self) -> PlaneCell {
        PlaneCell {
            parts: self.domain.parts(&self.site, &self.polygon, &self.cuts),
            site: self.site,
            polygon: self.polygon,
        }
    }
}

/// No site farther than this from a cell's own can cut the cell.
pub(crate) fn security_radius(polygon: &ConvexPolygon) -> f64 {
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
    if domain.is_periodic() {
        let wrapped: Vec<_> = sites.iter().map(|site| domain.wrap(site)).collect();
        return check_distinct(&wrapped);
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
    if sites.len() < FEWEST_SITES || domain.is_periodic() {
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
