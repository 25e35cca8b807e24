//! Convex polygons with labelled edges, and their clipping by half-planes.
//!
//! Conventions: vertices run counter-clockwise; edge k goes from vertex k to vertex k + 1 and
//! carries label k. A polygon of fewer than three vertices is empty.
//!
//! Tolerance: none. A vertex is kept if and only if n·y − d ≤ 0 as computed, so the kept part and
//! the part beyond always add up to the whole; where many cuts meet in one point, edges of a few
//! ulps may remain, so edges are to be counted by length. Coordinates should be relative to
//! something near (a cell's are relative to its site): errors are ulps of the coordinates.

use nalgebra::{Point2, Vector2};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;

/// A convex polygon with a label per edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ConvexPolygon {
    vertices: Vec<Point2<f64>>,
    labels: Vec<Label>,
}

/// An edge of a polygon, directed counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PolygonEdge {
    /// Where the edge begins.
    pub start: Point2<f64>,
    /// Where the edge ends.
    pub end: Point2<f64>,
    /// The mark it carries.
    pub label: Label,
}

impl PolygonEdge {
    /// The edge's length (L).
    #[must_use]
    pub(crate) fn length(&self) -> f64 {
        (self.end - self.start).norm()
    }
}

impl ConvexPolygon {
    /// The polygon with the given corners, which must be convex and
    /// counter-clockwise; the edge that leaves corner k carries label k of `labels`.
    pub(crate) fn from_corners(
        corners: impl IntoIterator<Item = Point2<f64>>,
        labels: impl IntoIterator<Item = Label>,
    ) -> Self {
        let (vertices, labels) = corners.into_iter().zip(labels).unzip();
        Self { vertices, labels }
    }

    /// The rectangle `bounds`, its edges labelled bottom, right, top, left.
    #[must_use]
    pub(crate) fn rectangle(bounds: &Bounds<2>, labels: [Label; 4]) -> Self {
        let Bounds { min, max } = bounds;
        let corners = [
            *min,
            Point2::new(max.x, min.y),
            *max,
            Point2::new(min.x, max.y),
        ];
        Self::from_corners(corners, labels)
    }

    /// The vertices, counter-clockwise.
    #[must_use]
    pub(crate) fn vertices(&self) -> &[Point2<f64>] {
        &self.vertices
    }

    /// Whether nothing is left: fewer than three vertices.
    #[must_use]
    pub(crate) fn is_empty(&self) -> bool {
        self.vertices.len() < 3
    }

    /// The edges, counter-clockwise.
    pub(crate) fn edges(&self) -> impl Iterator<Item = PolygonEdge> + '_ {
        let ends = self.vertices.iter().cycle().skip(1);
        self.vertices
            .iter()
            .zip(ends)
            .zip(&self.labels)
            .map(|((&start, &end), &label)| PolygonEdge { start, end, label })
    }

    /// The same polygon moved by `displacement`.
    #[must_use]
    pub(crate) fn translated(&self, displacement: &Vector2<f64>) -> Self {
        Self {
            vertices: self.vertices.iter().map(|v| v + displacement).collect(),
            labels: self.labels.clone(),
        }
    }

    /// Keeps the part inside `plane`; the new edge, if any, carries `label`. Returns
    /// whether anything was cut away.
    ///
    /// Sutherland & Hodgman, *Reentrant Polygon Clipping*, 1974, for one plane.
    pub(crate) fn clip(&mut self, plane: &HalfPlane, label: Label) -> bool {
        if self.vertices.iter().all(|v| plane.height(v) <= 0.0) {
            return false;
        }
        let mut kept = Self::with_capacity(self.vertices.len() + 1);
        for edge in self.edges() {
            kept.append_clipped(&edge, plane, label);
        }
        *self = if kept.is_empty() {
            Self::default()
        } else {
            kept
        };
        true
    }

    /// The area (L²).
    #[must_use]
    pub(crate) fn area(&self) -> f64 {
        self.fan().map(|(a, b)| 0.5 * a.perp(&b)).sum()
    }

    /// The least box that holds the polygon.
    #[must_use]
    pub(crate) fn bounds(&self) -> Bounds<2> {
        Bounds::of(&self.vertices)
    }

    /// The share t of `step` from `start`, a point of the polygon, at which the boundary is
    /// reached; 0 if `start` lies beyond it.
    ///
    /// Only edges that the line crosses count, so the direction of an edge of a few ulps,
    /// which is noise, does not matter.
    #[must_use]
    pub(crate) fn reach(&self, start: &Point2<f64>, step: &Vector2<f64>) -> f64 {
        self.edges()
            .filter_map(|edge| {
                let (a, b) = (edge.start - start, edge.end - start);
                let (right, left) = (step.perp(&a), step.perp(&b));
                let crossed = (right < 0.0) != (left < 0.0);
                crossed.then(|| {
                    let exit = a + (b - a) * (right / (right - left));
                    exit.dot(step) / step.norm_squared()
                })
            })
            .fold(0.0, f64::max)
    }

    fn with_capacity(capacity: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(capacity),
            labels: Vec::with_capacity(capacity),
        }
    }

    fn push(&mut self, vertex: Point2<f64>, label: Label) {
        self.vertices.push(vertex);
        self.labels.push(label);
    }

    /// Appends what `plane` leaves of `edge`, without the end point unless it is where the new
    /// edge begins.
    fn append_clipped(&mut self, edge: &PolygonEdge, plane: &HalfPlane, label: Label) {
        let (start, end) = (plane.height(&edge.start), plane.height(&edge.end));
        match (start <= 0.0, end <= 0.0) {
            (true, true) => self.push(edge.start, edge.label),
            (true, false) => {
                self.push(edge.start, edge.label);
                self.push(crossing(&edge.start, start, &edge.end, end), label);
            }
            (false, true) => {
                self.push(crossing(&edge.end, end, &edge.start, start), edge.label);
            }
            (false, false) => {}
        }
    }

    /// The triangles of the fan about the first vertex, as pairs of displacements from it.
    fn fan(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + '_ {
        self.vertices
            .windows(2)
            .skip(1)
            .map(|pair| (pair[0] - self.vertices[0], pair[1] - self.vertices[0]))
    }
}

/// Where the segment from the kept point `inside` (height ≤ 0) to `outside` (height > 0) meets
/// the plane.
fn crossing(
    inside: &Point2<f64>,
    inside_height: f64,
    outside: &Point2<f64>,
    outside_height: f64,
) -> Point2<f64> {
    let share = inside_height / (inside_height - outside_height);
    inside + (outside - inside) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> ConvexPolygon {
        let bounds = Bounds {
            min: Point2::new(-1.0, -1.0),
            max: Point2::new(1.0, 1.0),
        };
        ConvexPolygon::rectangle(&bounds, [1, 2, 3, 4])
    }

    fn half_plane(x: f64, y: f64, offset: f64) -> HalfPlane {
        HalfPlane {
            normal: Vector2::new(x, y),
            offset,
        }
    }

    #[test]
    fn a_cut_through_a_vertex_keeps_the_other_half() {
        let mut polygon = square();
        assert!(polygon.clip(&half_plane(1.0, -1.0, 0.0), 9));
        assert!((polygon.area() - 2.0).abs() < 1e-15);
        let labels: Vec<_> = polygon.edges().map(|edge| edge.label).collect();
        assert!(labels.contains(&9) && labels.contains(&3) && labels.contains(&4));
    }

    #[test]
    fn a_plane_that_only_touches_cuts_nothing_and_one_beyond_takes_all() {
        let mut polygon = square();
        assert!(!polygon.clip(&half_plane(1.0, 0.0, 1.0), 9));
        assert_eq!(polygon, square());
        assert!(polygon.clip(&half_plane(1.0, 0.0, -2.0), 9));
        assert!(polygon.is_empty() && polygon.area().abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn reach_is_the_share_of_the_step_to_the_wall() {
        let reach = square().reach(&Point2::new(0.5, 0.0), &Vector2::new(2.0, 0.0));
        assert!((reach - 0.25).abs() < 1e-15);
    }
}
