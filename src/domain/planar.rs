//! Domains of the plane: rectangles, periodic along any axes, and polygons of any shape, with holes.
//!
//! A convex domain is one counter-clockwise polygon; any other is a set of convex pieces within its
//! bounding box ([`trapezoids`]). Sides are labelled as walls
//! ([`FacetKind::Wall`]): wall k of a rectangle is bottom, right, top, left for k = 0…3, of corners
//! the side that joins corner k to the next one of its loop, counted through all loops, of half-planes
//! the half-plane k.

use nalgebra::{Point2, Vector2};

use crate::arrays::MapEach;
use crate::domain::error::FARTHEST;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar_density::PlaneDensity;
use crate::domain::planar_error::PlaneDomainError;
use crate::domain::trapezoids::{Trapezoids, refuse_crossings, trapezoids};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::{ConvexPolygon, PolygonEdge};
use crate::integrals::polynomial::Polynomial;

/// How far, relative to the domain's largest extent, a corner may lie on the wrong side of a
/// wall, or a point outside the domain, and still count as on it: a thousand roundings.
const ON_WALL: f64 = 1e-12;

/// Half sides of the squares that half-planes are cut from one after the other, in units of the largest
/// distance from the origin to a bounding line, until one holds the whole polygon; what reaches farther
/// than the last counts as unbounded.
const REACHES: [f64; 3] = [2.0, 1e4, 1e8];

/// A rectangle or a polygon, the domain of sites in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneDomain {
    /// What cells are cut from: the domain, or the box around one that is not convex.
    hull: ConvexPolygon,
    /// Convex pieces that fill a domain that is not convex; none of one that is.
    pieces: Vec<ConvexPolygon>,
    /// The sides, the domain on their left.
    sides: Vec<PolygonEdge>,
    bounds: Bounds<2>,
    area: f64,
    periods: [Option<f64>; 2],
    density: Option<PlaneDensity>,
    has_linf_cells: bool,
}

impl PlaneDomain {
    /// The rectangle `bounds`.
    ///
    /// # Errors
    /// If a coordinate is not finite or an extent is not positive.
    pub fn rectangle(bounds: &Bounds<2>) -> Result<Self, PlaneDomainError> {
        check_finite([&bounds.min, &bounds.max])?;
        let extent = bounds.extent();
        if extent.min() <= 0.0 {
            return Err(PlaneDomainError::no_area(&extent));
        }
        Self::of(ConvexPolygon::rectangle(bounds, std::array::from_fn(wall)))
    }

    /// The same rectangle, repeated along the axes that are `periodic`.
    #[must_use]
    pub fn repeated(mut self, periodic: [bool; 2]) -> Self {
        let extent = self.bounds.extent();
        self.periods = [0, 1].map_each(|axis| periodic[axis].then_some(extent[axis]));
        self
    }

    /// The polygon with the given corners, in either orientation.
    ///
    /// # Errors
    /// If there are fewer than three corners, one is not finite, they enclose no area, or two sides
    /// cross. Corners on a straight side are allowed.
    pub fn from_corners(corners: &[Point2<f64>]) -> Result<Self, PlaneDomainError> {
        Self::from_loops(std::slice::from_ref(&corners.to_vec()))
    }

    /// The points that an odd number of loops go around: a loop within another one is a hole. Loops
    /// run in either direction and may touch in points.
    ///
    /// # Errors
    /// As [`from_corners`](Self::from_corners).
    pub fn from_loops(loops: &[Vec<Point2<f64>>]) -> Result<Self, PlaneDomainError> {
        let fewest = loops.iter().map(Vec::len).min().unwrap_or_default();
        if fewest < 3 {
            return Err(PlaneDomainError::TooFew {
                what: "corners",
                count: fewest,
            });
        }
        check_finite(loops.iter().flatten())?;
        if let [corners] = loops {
            let polygon = counter_clockwise(corners);
            if is_convex(&polygon) {
                return Self::of(polygon);
            }
        }
        refuse_crossings(loops)?;
        Self::of_parts(Bounds::of(loops.iter().flatten()), trapezoids(loops)).checked()
    }

    /// The domain of these parts.
    fn of_parts(bounds: Bounds<2>, parts: Trapezoids) -> Self {
        let middle = bounds.center();
        let twice = |side: &PolygonEdge| (side.start - middle).perp(&(side.end - middle));
        Self {
            area: 0.5 * parts.sides.iter().map(twice).sum::<f64>(),
            hull: ConvexPolygon::rectangle(&bounds, [FacetKind::Inner.label(); 4]),
            pieces: parts.pieces,
            sides: parts.sides,
            bounds,
            periods: [None; 2],
            density: None,
            has_linf_cells: false,
        }
    }

    /// The points that lie in all `half_planes`; superfluous ones do no harm.
    ///
    /// # Errors
    /// If there are fewer than three half-planes, one is not finite or has no normal, or if their
    /// intersection is unbounded or without area.
    pub fn from_half_planes(half_planes: &[HalfPlane]) -> Result<Self, PlaneDomainError> {
        let unit = normalized(half_planes)?;
        let farthest = unit.iter().map(|p| p.offset.abs()).fold(0.0, f64::max);
        let farthest = if farthest > 0.0 { farthest } else { 1.0 };
        let is_open = |it: &ConvexPolygon| it.edges().any(|edge| edge.label == Label::MAX);
        let cut = |reach: f64| intersect(&unit, &square(&Point2::origin(), reach * farthest));
        let cuts = REACHES.map(cut);
        let bounded = cuts.iter().find(|it| !it.is_empty() && !is_open(it));
        let rough = bounded.unwrap_or(&cuts[REACHES.len() - 1]);
        if is_open(rough) {
            return Err(PlaneDomainError::Unbounded);
        }
        if rough.is_empty() {
            return Err(PlaneDomainError::no_area(&Vector2::zeros()));
        }
        // The first cut met corners far away and lost digits; the second starts close by.
        let bounds = rough.bounds();
        let close = square(&bounds.center(), bounds.extent().amax());
        Self::of(intersect(&unit, &close))
    }

    /// The same domain with a density, a polynomial in x and y.
    ///
    /// # Errors
    /// If it is negative somewhere, depends on z, or changes along a periodic axis.
    pub fn weighted(mut self, density: &Polynomial) -> Result<Self, PlaneDomainError> {
        self.density = Some(PlaneDensity::new(
            self.pieces(),
            self.bounds,
            self.periods,
            density,
        )?);
        Ok(self)
    }

    /// The same domain; its sites have the points nearest to them in the Chebyshev distance for cells
    /// if it is said to have L∞ cells.
    #[must_use]
    pub(crate) fn with_linf_cells(self, has_linf_cells: bool) -> Self {
        Self {
            has_linf_cells,
            ..self
        }
    }

    /// Whether cells hold the points nearest in the Chebyshev distance, not in the Euclidean one.
    #[must_use]
    pub(crate) fn has_linf_cells(&self) -> bool {
        self.has_linf_cells
    }

    /// The density; none is 1 everywhere.
    #[must_use]
    pub(crate) fn density(&self) -> Option<&PlaneDensity> {
        self.density.as_ref()
    }

    /// What the cell of `site` is cut from, relative to it: all of a convex domain, the box around
    /// any other; along a periodic axis one period about the site, whose ends border on its images.
    #[must_use]
    pub(crate) fn start(&self, site: &Point2<f64>, index: u32) -> ConvexPolygon {
        if !self.is_periodic() {
            return self.hull.translated(&-site.coords);
        }
        let mut bounds = self.bounds.translated(&-site.coords);
        let mut labels: [Label; 4] = std::array::from_fn(wall);
        for axis in 0..2 {
            let Some(period) = self.periods[axis] else {
                continue;
            };
            (bounds.min[axis], bounds.max[axis]) = (-0.5 * period, 0.5 * period);
            // Bottom, right, top, left.
            for (side, step) in [([3, 0][axis], -1), ([1, 2][axis], 1)] {
                let mut image = [0; 3];
                image[axis] = step;
                labels[side] = FacetKind::Neighbor { site: index, image }.label();
            }
        }
        ConvexPolygon::rectangle(&bounds, labels)
    }

    /// The part of `cell` in a domain that is not convex, as convex polygons relative to the cell's
    /// `site`; none where the domain is convex or holds the whole cell. `cuts` are the half-planes that
    /// made the cell from [`start`](Self::start).
    #[must_use]
    pub(crate) fn parts(
        &self,
        site: &Point2<f64>,
        cell: &ConvexPolygon,
        cuts: &[(HalfPlane, Label)],
    ) -> Option<Vec<ConvexPolygon>> {
        if self.is_convex() {
            return None;
        }
        let around = cell.bounds().translated(&site.coords);
        let meets = |side: &PolygonEdge| Bounds::of([&side.start, &side.end]).overlaps(&around);
        if !self.sides.iter().any(meets) {
            return if self.contains(&around.center()) {
                None
            } else {
                Some(Vec::new())
            };
        }
        let near = self
            .pieces
            .iter()
            .filter(|it| it.bounds().overlaps(&around));
        let cut = |piece: &ConvexPolygon| {
            let mut part = piece.translated(&-site.coords);
            for (plane, label) in cuts {
                part.clip(plane, *label);
            }
            part
        };
        Some(near.map(cut).filter(|part| !part.is_empty()).collect())
    }

    /// Convex polygons that fill the domain.
    #[must_use]
    pub(crate) fn pieces(&self) -> &[ConvexPolygon] {
        if self.is_convex() {
            std::slice::from_ref(&self.hull)
        } else {
            &self.pieces
        }
    }

    /// Whether the domain is convex.
    #[must_use]
    pub(crate) fn is_convex(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Whether the walls are those of the domain's box.
    #[must_use]
    pub(crate) fn is_box(&self) -> bool {
        let is_upright = |side: &PolygonEdge| (side.end - side.start).abs().min() <= 0.0;
        self.sides.len() == 4 && self.sides.iter().all(is_upright)
    }

    /// The length of the period along each axis that has one.
    #[must_use]
    pub(crate) fn periods(&self) -> [Option<f64>; 2] {
        self.periods
    }

    /// Whether the domain repeats itself.
    #[must_use]
    pub(crate) fn is_periodic(&self) -> bool {
        self.periods.iter().any(Option::is_some)
    }

    /// The point of the domain that is `point` but for whole periods.
    #[must_use]
    pub(crate) fn wrap(&self, point: &Point2<f64>) -> Point2<f64> {
        let mut wrapped = *point;
        for axis in 0..2 {
            if let Some(period) = self.periods[axis] {
                let min = self.bounds.min[axis];
                let inside = min + (point[axis] - min).rem_euclid(period);
                // A point a trifle below the lower wall is rounded onto the upper one.
                wrapped[axis] = if inside < self.bounds.max[axis] {
                    inside
                } else {
                    min
                };
            }
        }
        wrapped
    }

    /// The least box that holds the domain.
    #[must_use]
    pub fn bounds(&self) -> Bounds<2> {
        self.bounds
    }

    /// The domain's area (L²).
    #[must_use]
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Whether `point` lies in the closed domain, up to 1e-12 of the domain's extent.
    #[must_use]
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        let slack = ON_WALL * self.bounds.extent().amax();
        if self.is_convex() {
            let mut sides = self.sides.iter();
            return sides.all(|side| distance_beyond(side, point, slack) <= slack);
        }
        let is_passed = |side: &&PolygonEdge| {
            let (start, end) = (side.start, side.end);
            (start.y > point.y) != (end.y > point.y)
                && ((end - start).perp(&(point - start)) > 0.0) == (end.y > start.y)
        };
        self.sides.iter().filter(is_passed).count() % 2 == 1
            || self.sides.iter().any(|side| distance(side, point) <= slack)
    }

    /// The first wall that the straight way from `site` along `step` meets from within, as the share of
    /// the step before it, and its outward unit normal.
    #[must_use]
    pub(crate) fn wall_ahead(
        &self,
        site: &Point2<f64>,
        step: &Vector2<f64>,
    ) -> Option<(f64, Vector2<f64>)> {
        let slack = ON_WALL * self.bounds.extent().amax();
        let ahead = self.sides.iter().filter_map(|side| {
            let along = side.end - side.start;
            let normal = Vector2::new(along.y, -along.x).try_normalize(0.0)?;
            let (climb, room) = (normal.dot(step), normal.dot(&(side.start - site)));
            let room = Some(room).filter(|room| *room > -slack)?.max(0.0);
            let share = room / climb;
            let place = (site + step * share - side.start).dot(&along) / along.norm_squared();
            // A side of a convex domain is a wall along all of its line.
            let passes = self.is_convex() || (-ON_WALL..=1.0 + ON_WALL).contains(&place);
            (climb > room && passes).then_some((share, normal))
        });
        ahead.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn of(polygon: ConvexPolygon) -> Result<Self, PlaneDomainError> {
        Self {
            bounds: polygon.bounds(),
            area: polygon.area(),
            sides: polygon.edges().collect(),
            hull: polygon,
            pieces: Vec::new(),
            periods: [None; 2],
            density: None,
            has_linf_cells: false,
        }
        .checked()
    }

    /// The domain itself if it has an area and digits are left for sites.
    fn checked(self) -> Result<Self, PlaneDomainError> {
        let bounds = self.bounds;
        for axis in 0..2 {
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            if min.abs().max(max.abs()) > FARTHEST * (max - min) {
                return Err(PlaneDomainError::FarAway { axis, min, max });
            }
        }
        let least = ON_WALL * bounds.extent().norm_squared();
        if self.hull.is_empty() || self.area.is_nan() || self.area <= least {
            return Err(PlaneDomainError::no_area(&bounds.extent()));
        }
        Ok(self)
    }
}

fn wall(index: usize) -> Label {
    FacetKind::Wall(index as u32).label()
}

fn check_finite<'a>(
    corners: impl IntoIterator<Item = &'a Point2<f64>>,
) -> Result<(), PlaneDomainError> {
    let mut corners = corners.into_iter();
    match corners.position(|corner| !corner.iter().all(|c| c.is_finite())) {
        Some(index) => Err(PlaneDomainError::NotFinite {
            what: "corner",
            index,
        }),
        None => Ok(()),
    }
}

/// The corners in counter-clockwise order, starting at the same corner.
fn counter_clockwise(corners: &[Point2<f64>]) -> ConvexPolygon {
    let walls = (0..corners.len()).map(wall);
    let given = ConvexPolygon::from_corners(corners.iter().copied(), walls);
    if given.area() >= 0.0 {
        return given;
    }
    let reversed = corners.iter().take(1).chain(corners.iter().skip(1).rev());
    let walls = (0..corners.len()).rev().map(wall);
    ConvexPolygon::from_corners(reversed.copied(), walls)
}

/// Whether no corner lies to the right of a side: that holds if and only if the corners go once around
/// a convex polygon, for those that go around twice fail as well.
fn is_convex(polygon: &ConvexPolygon) -> bool {
    let slack = ON_WALL * polygon.bounds().extent().amax();
    let corners = polygon.vertices();
    polygon.edges().all(|edge| {
        let is_beyond = |corner| distance_beyond(&edge, corner, slack) > slack;
        !corners.iter().any(is_beyond)
    })
}

/// The distance of a point from a segment (L).
fn distance(segment: &PolygonEdge, point: &Point2<f64>) -> f64 {
    let along = segment.end - segment.start;
    let arm = point - segment.start;
    let share = arm.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
    (arm - along * share.clamp(0.0, 1.0)).norm()
}

/// How far `point` lies to the right of `edge` (L). An edge shorter than `slack` has no reliable
/// direction, and nothing counts as beyond it.
fn distance_beyond(edge: &PolygonEdge, point: &Point2<f64>, slack: f64) -> f64 {
    let along = edge.end - edge.start;
    let length = along.norm();
    if length <= slack {
        return f64::NEG_INFINITY;
    }
    (point - edge.start).perp(&along) / length
}

/// The half-planes with unit normals.
fn normalized(half_planes: &[HalfPlane]) -> Result<Vec<HalfPlane>, PlaneDomainError> {
    if half_planes.len() < 3 {
        return Err(PlaneDomainError::TooFew {
            what: "half-planes",
            count: half_planes.len(),
        });
    }
    let planes = half_planes.iter().enumerate();
    planes.map(|(index, plane)| unit(index, plane)).collect()
}

fn unit(index: usize, plane: &HalfPlane) -> Result<HalfPlane, PlaneDomainError> {
    let length = plane.normal.norm();
    if !length.is_finite() || !plane.offset.is_finite() {
        return Err(PlaneDomainError::NotFinite {
            what: "half-plane",
            index,
        });
    }
    if length <= 0.0 {
        return Err(PlaneDomainError::ZeroNormal { index });
    }
    Ok(HalfPlane {
        normal: plane.normal / length,
        offset: plane.offset / length,
    })
}

fn square(center: &Point2<f64>, half_side: f64) -> ConvexPolygon {
    let diagonal = Vector2::repeat(half_side);
    let bounds = Bounds {
        min: center - diagonal,
        max: center + diagonal,
    };
    ConvexPolygon::rectangle(&bounds, [Label::MAX; 4])
}

fn intersect(half_planes: &[HalfPlane], start: &ConvexPolygon) -> ConvexPolygon {
    let mut polygon = start.clone();
    for (index, plane) in half_planes.iter().enumerate() {
        polygon.clip(plane, wall(index));
    }
    polygon
}
