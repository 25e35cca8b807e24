//! Half-planes, by which convex polygons are clipped.

use nalgebra::{Point2, Vector2};

/// The points y of the plane with n·y ≤ d; the normal n points outward and need not be unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    /// The outward normal n.
    pub normal: Vector2<f64>,
    /// The offset d (L · |n|).
    pub offset: f64,
}

impl HalfPlane {
    /// The half-plane to the left of the directed line from `start` to `end`.
    #[must_use]
    pub fn left_of(start: &Point2<f64>, end: &Point2<f64>) -> Self {
        let along = end - start;
        let normal = Vector2::new(along.y, -along.x);
        Self {
            normal,
            offset: normal.dot(&start.coords),
        }
    }

    /// The points nearer to the origin than to `displacement`: the bisector of a site and a
    /// neighbor, in coordinates relative to the site.
    ///
    /// For the neighbor's cell the normal and the offset are exactly these with the normal's sign
    /// flipped, so the two cells agree on their edge. The normal is scaled to largest component
    /// 1, lest its square underflow for sites next to each other.
    #[must_use]
    pub fn nearer_to_origin(displacement: &Vector2<f64>) -> Self {
        let normal = displacement / displacement.amax();
        Self {
            normal,
            offset: 0.5 * normal.dot(displacement),
        }
    }

    /// n·y − d: the signed distance (L · |n|), positive outside.
    #[must_use]
    pub fn height(&self, point: &Point2<f64>) -> f64 {
        self.normal.dot(&point.coords) - self.offset
    }
}
