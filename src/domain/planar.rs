//! Domains of the plane: rectangles and convex polygons.
//!
//! A domain is kept as one counter-clockwise convex polygon. Its edges are labelled as walls
//! ([`FacetKind::Wall`]): wall k of a rectangle is bottom, right, top, left for k = 0…3, of corners
//! the side that joins corner k to the next one, of half-planes the half-plane k.

use nalgebra::{Point2, Vector2};
use thiserror::Error;

use crate::domain::error::FARTHEST;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::{ConvexPolygon, PolygonEdge};

/// How far, relative to the domain's largest extent, a corner may lie on the wrong side of a
/// wall, or a point outside the domain, and still count as on it: a thousand roundings.
const ON_WALL: f64 = 1e-12;

/// Half sides of the squares that half-planes are cut from one after the other, in units of the largest
/// distance from the origin to a bounding line, until one holds the whole polygon; what reaches farther
/// than the last counts as unbounded.
const REACHES: [f64; 3] = [2.0, 1e4, 1e8];

/// Why a rectangle, corners or half-planes are not a domain.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlaneDomainError {
    /// A coordinate, normal or offset is NaN or infinite.
    #[error("{what} {index} of the domain is not finite")]
    NotFinite {
        /// What was given: a corner or a half-plane.
        what: &'static str,
        /// Which one, from zero.
        index: usize,
    },
    /// Fewer than three corners or half-planes.
    #[error("a domain in the plane needs at least 3 {what}, {count} were given")]
    TooFew {
        /// What was given: corners or half-planes.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// The domain lies so far from the origin that its coordinates have too few digits left.
    #[error(
        "the domain reaches from {min} to {max} along {}: so far from the origin too few digits are left for \
         sites; shift it towards the origin",
        ["x", "y"][*axis]
    )]
    FarAway {
        /// 0, 1 for x, y.
        axis: usize,
        /// Where it begins.
        min: f64,
        /// Where it ends.
        max: f64,
    },
    /// The domain has no area.
    #[error("the domain has no area (its extent is {width} by {height})")]
    NoArea {
        /// Extent along x (L).
        width: f64,
        /// Extent along y (L).
        height: f64,
    },
    /// The corners do not go once around a convex polygon.
    #[error(
        "the domain is not convex: corner {corner} lies on the wrong side of the side that begins at corner {side}"
    )]
    NotConvex {
        /// The corner at fault.
        corner: usize,
        /// The corner at which the side begins.
        side: usize,
    },
    /// A half-plane whose normal is zero.
    #[error("half-plane {index} of the domain has the normal (0, 0)")]
    ZeroNormal {
        /// Which one, from zero.
        index: usize,
    },
    /// The half-planes leave a direction open.
    #[error("the half-planes do not bound the domain: add one that closes the side left open")]
    Unbounded,
}

/// A rectangle or convex polygon, the domain of sites in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneDomain {
    polygon: ConvexPolygon,
    bounds: Bounds<2>,
    area: f64,
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
            return Err(no_area(&extent));
        }
        Self::of(ConvexPolygon::rectangle(bounds, std::array::from_fn(wall)))
    }

    /// The convex polygon with the given corners, in either orientation.
    ///
    /// # Errors
    /// If there are fewer than three corners, one is not finite, they enclose no area, or they do
    /// not go once around a convex polygon. Corners on a straight side are allowed.
    pub fn from_corners(corners: &[Point2<f64>]) -> Result<Self, PlaneDomainError> {
        if corners.len() < 3 {
            return Err(PlaneDomainError::TooFew {
                what: "corners",
                count: corners.len(),
            });
        }
        check_finite(corners)?;
        let polygon = counter_clockwise(corners);
        if let Some((beyond, start)) = beyond_a_side(&polygon) {
            let given = |point| corners.iter().position(|c| c == point).unwrap_or_default();
            return Err(PlaneDomainError::NotConvex {
                corner: given(beyond),
                side: given(start),
            });
        }
        Self::of(polygon)
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
        let mut rough = ConvexPolygon::default();
        for reach in REACHES {
            rough = cut(reach);
            if !rough.is_empty() && !is_open(&rough) {
                break;
            }
        }
        if is_open(&rough) {
            return Err(PlaneDomainError::Unbounded);
        }
        // The first cut met corners far away and lost digits; the second starts close by.
        let bounds = rough.bounds();
        if rough.is_empty() {
            return Err(no_area(&Vector2::zeros()));
        }
        let close = square(&bounds.center(), bounds.extent().amax());
        Self::of(intersect(&unit, &close))
    }

    /// The domain as a polygon, its edges labelled as walls.
    #[must_use]
    pub fn polygon(&self) -> &ConvexPolygon {
        &self.polygon
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
        self.polygon
            .edges()
            .all(|edge| distance_beyond(&edge, point, slack) <= slack)
    }

    fn of(polygon: ConvexPolygon) -> Result<Self, PlaneDomainError> {
        let bounds = polygon.bounds();
        for axis in 0..2 {
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            if min.abs().max(max.abs()) > FARTHEST * (max - min) {
                return Err(PlaneDomainError::FarAway { axis, min, max });
            }
        }
        let area = polygon.area();
        let least = ON_WALL * bounds.extent().norm_squared();
        if polygon.is_empty() || area.is_nan() || area <= least {
            return Err(no_area(&bounds.extent()));
        }
        Ok(Self {
            polygon,
            bounds,
            area,
        })
    }
}

fn wall(index: usize) -> Label {
    FacetKind::Wall(index as u32).label()
}

fn no_area(extent: &Vector2<f64>) -> PlaneDomainError {
    PlaneDomainError::NoArea {
        width: extent.x,
        height: extent.y,
    }
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

/// A corner to the right of a side, and where that side starts. There is none if and only if the
/// corners go once around a convex polygon: those that go around twice fail as well.
fn beyond_a_side(polygon: &ConvexPolygon) -> Option<(&Point2<f64>, &Point2<f64>)> {
    let slack = ON_WALL * polygon.bounds().extent().amax();
    let corners = polygon.vertices();
    polygon.edges().zip(corners).find_map(|(edge, start)| {
        let beyond = |corner: &&Point2<f64>| distance_beyond(&edge, corner, slack) > slack;
        corners.iter().find(beyond).map(|corner| (corner, start))
    })
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
