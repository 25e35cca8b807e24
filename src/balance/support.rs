//! Conditions on the center of mass of a body that stands: it must not tip over.
//!
//! On ground across `up`, at the height h of the lowest vertex, the support is the convex hull of what touches
//! the ground, edges n·y ≤ c with n outward. With a margin μ, and standing on ground tilted by θ in any
//! direction, the center C obeys (n + tan θ up)·C ≤ c − μ + tan θ h for every edge: linear in the density.

use nalgebra::{Matrix2x3, Point2, Point3, Unit, Vector2, Vector3};

use crate::arrays::MapEach;
use crate::balance::conditions::Condition;
use crate::balance::dual::Relation;

/// The ground: across up, with two coordinates on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// Away from the ground.
    pub(crate) up: Unit<Vector3<f64>>,
    /// The directions of the two coordinates on the ground: of the axes across `up` if it is an axis.
    pub(crate) across: [Vector3<f64>; 2],
    /// up·y of the ground.
    pub(crate) height: f64,
}

/// What must be met for a body to stand.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Support {
    /// The center is above a convex polygon, its corners counter-clockwise in ground coordinates.
    Polygon(Vec<Point2<f64>>),
    /// The center is above the line between two points of the ground.
    Segment([Point2<f64>; 2]),
    /// The center is above a point of the ground.
    Point(Point2<f64>),
    /// The center has these coordinates; none is free.
    Target([Option<f64>; 3]),
}

/// Why a body cannot be asked to stand.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum SupportError {
    /// A direction without length.
    #[error("up is ({}, {}, {}), which has no length", up.x, up.y, up.z)]
    Up {
        /// The direction.
        up: Vector3<f64>,
    },
    /// Nothing in contact.
    #[error("no vertex touches the ground: give a contact share of at least 0, at most 1")]
    NoContact,
    /// A margin that leaves nothing.
    #[error(
        "a margin of {margin} leaves nothing of the support polygon, which has room for {room}; \
         give a smaller margin"
    )]
    Margin {
        /// The margin.
        margin: f64,
        /// The radius of the largest circle in the polygon.
        room: f64,
    },
    /// A point or a line with a margin or a tilt.
    #[error(
        "the body touches the ground in {what} only, which leaves no room for a margin or a tilt; \
         name a support with an area by --polygon, or take more of the body for touching by --contact"
    )]
    NoRoom {
        /// `a point` or `a line`.
        what: &'static str,
    },
    /// A margin or tilt for a point or target that was asked for.
    #[error("a center that is to be at one place has no room for a margin or a tilt")]
    Place,
    /// A target that asks nothing.
    #[error("the target frees every coordinate; give at least one number")]
    NoTarget,
}

/// Points of the ground nearer to a line than this share of their extent lie on it.
const FLAT: f64 = 1e-12;

impl Ground {
    /// Ground across a direction under the lowest of `vertices`.
    pub(crate) fn below<'a>(
        up: &Vector3<f64>,
        vertices: impl Iterator<Item = &'a Point3<f64>>,
    ) -> Result<Self, SupportError> {
        let faulty = SupportError::Up { up: *up };
        let up = Unit::try_new(up / up.amax(), 0.5).ok_or(faulty)?;
        let height = vertices.map(|vertex| up.dot(&vertex.coords));
        Ok(Self {
            across: across(&up),
            height: height.fold(f64::INFINITY, f64::min),
            up,
        })
    }

    /// The ground coordinates of a point.
    pub(crate) fn shadow(&self, point: &Point3<f64>) -> Point2<f64> {
        Point2::from(self.across.map_each(|axis| axis.dot(&point.coords)))
    }

    /// The point of the ground at coordinates.
    pub(crate) fn at(&self, place: &Point2<f64>) -> Point3<f64> {
        let [first, second] = self.across;
        Point3::from(first * place.x + second * place.y + self.up.as_ref() * self.height)
    }

    /// Up along a coordinate axis, either way.
    pub(crate) fn is_along_axis(&self) -> bool {
        self.up.iter().filter(|part| **part != 0.0).count() == 1
    }

    /// The height of a point above the ground.
    pub(crate) fn height_of(&self, point: &Point3<f64>) -> f64 {
        self.up.dot(&point.coords) - self.height
    }

    /// The hull of the vertices up to a share of the body's height above the ground.
    pub(crate) fn contact<'a>(
        &self,
        vertices: impl Iterator<Item = &'a Point3<f64>> + Clone,
        share: f64,
    ) -> Result<Support, SupportError> {
        let heights = vertices.clone().map(|vertex| self.height_of(vertex));
        let highest = heights.fold(0.0, f64::max);
        let touches = |vertex: &&Point3<f64>| self.height_of(vertex) <= share * highest;
        let points = vertices.filter(touches).map(|vertex| self.shadow(vertex));
        Support::hull(points.collect())
    }
}

/// Two unit vectors across a unit vector: the other axes in their order if it is an axis.
fn across(up: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let axis = up.iamax();
    if up.iter().filter(|part| **part != 0.0).count() == 1 {
        return [[1, 2], [0, 2], [0, 1]][axis].map_each(|other| Vector3::ith(other, 1.0));
    }
    let first = Vector3::ith(up.iamin(), 1.0).cross(up).normalize();
    [first, up.cross(&first)]
}

impl Support {
    /// The convex hull of points of the ground (Andrew's monotone chain); a segment or a point where they
    /// lie on a line or in one place.
    pub(crate) fn hull(mut points: Vec<Point2<f64>>) -> Result<Self, SupportError> {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        let (Some(&first), Some(&last)) = (points.first(), points.last()) else {
            return Err(SupportError::NoContact);
        };
        let extent = points.iter().map(|point| (point - first).norm());
        let extent = extent.fold(0.0, f64::max);
        if extent == 0.0 {
            return Ok(Self::Point(first));
        }
        let mut hull = half_hull(points.iter());
        let upper = half_hull(points.iter().rev());
        hull.extend(&upper);
        let along = (last - first).normalize();
        let off = |point: &Point2<f64>| turn(&along, &(point - first)).abs();
        let width = hull.iter().map(off).fold(0.0, f64::max);
        if hull.len() < 3 || width <= FLAT * extent {
            return Ok(Self::Segment([first, last]));
        }
        Ok(Self::Polygon(hull))
    }

    /// The edges n·y ≤ c of the polygon or segment, n outward in ground coordinates.
    pub(crate) fn edges(&self) -> Vec<(Vector2<f64>, f64)> {
        let corners = match self {
            Self::Polygon(corners) => &corners[..],
            Self::Segment([from, to]) => {
                let along = (to - from).normalize();
                return vec![
                    (along, along.dot(&to.coords)),
                    (-along, -along.dot(&from.coords)),
                ];
            }
            Self::Point(_) | Self::Target(_) => return Vec::new(),
        };
        let next = |k: usize| corners[(k + 1) % corners.len()];
        let edge = |k: usize| {
            let along = (next(k) - corners[k]).normalize();
            let outward = Vector2::new(along.y, -along.x);
            (outward, outward.dot(&corners[k].coords))
        };
        (0..corners.len()).map(edge).collect()
    }

    /// What the center of mass must obey, with a margin and on ground tilted by an angle whose tangent is
    /// `tilt`: for each the condition, and the horizontal direction along which it is missed.
    pub(crate) fn demands(
        &self,
        ground: &Ground,
        margin: f64,
        tilt: f64,
    ) -> Result<Vec<(Condition, Vector3<f64>)>, SupportError> {
        let has_room = margin > 0.0 || tilt > 0.0;
        let equal = |place: Point3<f64>, axis: Vector3<f64>| {
            (Condition::center_level(&place, &-axis), axis)
        };
        match self {
            Self::Target(coordinates) => {
                if has_room {
                    return Err(SupportError::Place);
                }
                let given = (0..3).filter_map(|k| coordinates[k].map(|value| (k, value)));
                let level = |(k, value): (usize, f64)| {
                    equal(Point3::from(Vector3::ith(k, value)), Vector3::ith(k, 1.0))
                };
                let demands: Vec<_> = given.map(level).collect();
                if demands.is_empty() {
                    return Err(SupportError::NoTarget);
                }
                Ok(demands)
            }
            Self::Point(place) => {
                if has_room {
                    return Err(SupportError::NoRoom { what: "a point" });
                }
                Ok(ground
                    .across
                    .map(|axis| equal(ground.at(place), axis))
                    .into())
            }
            Self::Segment([from, to]) => {
                if has_room {
                    return Err(SupportError::NoRoom { what: "a line" });
                }
                let along = (to - from).normalize();
                let [first, second] = ground.across;
                let across = first * -along.y + second * along.x;
                let mut demands = vec![equal(ground.at(from), across)];
                demands.extend(self.edge_demands(ground, 0.0, 0.0));
                Ok(demands)
            }
            Self::Polygon(_) => {
                let room = self.room();
                if margin >= room {
                    return Err(SupportError::Margin { margin, room });
                }
                Ok(self.edge_demands(ground, margin, tilt))
            }
        }
    }

    /// (n + tan θ up)·C ≤ c − μ + tan θ h for every edge.
    fn edge_demands(
        &self,
        ground: &Ground,
        margin: f64,
        tilt: f64,
    ) -> Vec<(Condition, Vector3<f64>)> {
        let across = Matrix2x3::from_rows(&ground.across.map_each(|axis| axis.transpose()));
        let demand = |(normal, bound): (Vector2<f64>, f64)| {
            let outward = across.transpose() * normal;
            let gradient = outward + ground.up.as_ref() * tilt;
            let about = ground.at(&Point2::from(normal * (bound - margin)));
            let condition = Condition {
                relation: Relation::AtLeast,
                ..Condition::center_level(&about, &-gradient)
            };
            (condition, outward)
        };
        self.edges().into_iter().map(demand).collect()
    }

    /// How far the shadow of a center lies within the support (negative: outside), and the tangent of the
    /// ground's tilt that it stands; none where a target says where it must be.
    pub(crate) fn slack(&self, ground: &Ground, center: &Point3<f64>) -> Option<[f64; 2]> {
        let shadow = ground.shadow(center);
        let within = match self {
            Self::Target(_) => return None,
            Self::Point(place) => -(shadow - place).norm(),
            Self::Segment([from, to]) => {
                let along = (to - from).normalize();
                let ends = self.edges().into_iter();
                let ends = ends.map(|(normal, bound)| bound - normal.dot(&shadow.coords));
                let beside = turn(&along, &(shadow - from)).abs();
                (-beside).min(ends.fold(f64::INFINITY, f64::min))
            }
            Self::Polygon(_) => {
                let edges = self.edges().into_iter();
                let slacks = edges.map(|(normal, bound)| bound - normal.dot(&shadow.coords));
                slacks.fold(f64::INFINITY, f64::min)
            }
        };
        Some([within, within / ground.height_of(center)])
    }

    /// The radius of the largest circle in the polygon, by bisection: each half-plane cut once.
    fn room(&self) -> f64 {
        let Self::Polygon(corners) = self else {
            return 0.0;
        };
        let edges = self.edges();
        let extent = corners.iter().map(|corner| (corner - corners[0]).norm());
        let (mut low, mut high) = (0.0, extent.fold(0.0, f64::max));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let mut rest = corners.clone();
            for (normal, bound) in &edges {
                rest = clipped(&rest, normal, bound - middle);
            }
            *(if rest.is_empty() { &mut high } else { &mut low }) = middle;
        }
        low
    }
}

/// The part of a convex polygon where normal·y ≤ bound.
fn clipped(corners: &[Point2<f64>], normal: &Vector2<f64>, bound: f64) -> Vec<Point2<f64>> {
    let mut part = Vec::new();
    for (k, corner) in corners.iter().enumerate() {
        let next = corners[(k + 1) % corners.len()];
        let [here, there] = [corner, &next].map_each(|point| bound - normal.dot(&point.coords));
        if here >= 0.0 {
            part.push(*corner);
        }
        if (here >= 0.0) != (there >= 0.0) {
            part.push(corner + (next - corner) * (here / (here - there)));
        }
    }
    part
}

/// The cross product of two vectors of the plane.
fn turn(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The lower hull of points that ascend, without its last point.
fn half_hull<'a>(points: impl Iterator<Item = &'a Point2<f64>>) -> Vec<Point2<f64>> {
    let mut hull: Vec<Point2<f64>> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..]
            && turn(&(b - a), &(point - a)) <= 0.0
        {
            hull.pop();
        }
        hull.push(*point);
    }
    hull.pop();
    hull
}
