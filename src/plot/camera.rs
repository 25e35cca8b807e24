//! Parallel projection of points in space to a picture.

use nalgebra::{Point2, Point3, Vector2, Vector3};

use crate::geometry::bounds::Bounds;

/// From the picture's middle toward the viewer: a little from the right, more from the front (−y)
/// and from above, so that three walls of a box are visible and differ in shape.
pub(crate) const TOWARD: Vector3<f64> = Vector3::new(0.50, -0.72, 0.48);

/// A viewer at infinity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    right: Vector3<f64>,
    up: Vector3<f64>,
    toward: Vector3<f64>,
    /// The point projected to the picture's middle.
    origin: Point3<f64>,
    middle: Point2<f64>,
    /// Pixels per unit of length.
    factor: f64,
}

impl Camera {
    /// The camera whose view direction is −[`TOWARD`], +z upward, and shows all `points` as large as
    /// possible in the middle of `frame`, given by its upper left and lower right corner in pixels.
    #[must_use]
    pub(crate) fn fitting(
        points: impl IntoIterator<Item = Point3<f64>>,
        frame: [Point2<f64>; 2],
    ) -> Self {
        let toward = TOWARD.normalize();
        let right = Vector3::z().cross(&toward).normalize();
        let mut camera = Self {
            right,
            up: toward.cross(&right),
            toward,
            origin: Point3::origin(),
            middle: nalgebra::center(&frame[0], &frame[1]),
            factor: 1.0,
        };
        let projected: Vec<Point3<f64>> = points
            .into_iter()
            .map(|point| camera.lengths(&point))
            .collect();
        let bounds = Bounds::of(&projected);
        let extent = bounds.extent();
        let factor = (frame[1] - frame[0]).component_div(&extent.xy()).min();
        if factor.is_finite() && factor > 0.0 {
            camera.origin = camera.at_lengths(&bounds.center());
            camera.factor = factor;
        }
        camera
    }

    /// The width and height, in lengths, of what shows all `points`.
    #[must_use]
    pub(crate) fn extent(points: impl IntoIterator<Item = Point3<f64>>) -> Vector2<f64> {
        let camera = Self::fitting([], [Point2::origin(); 2]);
        let projected = points.into_iter().map(|point| camera.lengths(&point));
        Bounds::of(&projected.collect::<Vec<_>>()).extent().xy()
    }

    /// The image of a point: pixels to the right and downward from the upper left corner, and the
    /// distance toward the viewer (L).
    #[must_use]
    pub(crate) fn project(&self, point: &Point3<f64>) -> Point3<f64> {
        let arm = point - self.origin;
        Point3::new(
            self.middle.x + self.factor * arm.dot(&self.right),
            self.middle.y - self.factor * arm.dot(&self.up),
            arm.dot(&self.toward),
        )
    }

    /// The inverse of [`Camera::project`].
    #[must_use]
    pub(crate) fn unproject(&self, image: &Point3<f64>) -> Point3<f64> {
        let x = (image.x - self.middle.x) / self.factor;
        let y = (self.middle.y - image.y) / self.factor;
        self.origin + x * self.right + y * self.up + image.z * self.toward
    }

    /// How the depth of a facet with this unit normal grows per pixel to the right and downward;
    /// `None` for a facet that shows its back or its edge.
    #[must_use]
    pub(crate) fn slopes(&self, normal: &Vector3<f64>) -> Option<[f64; 2]> {
        let facing = normal.dot(&self.toward);
        let slope = |direction: &Vector3<f64>| normal.dot(direction) / (facing * self.factor);
        (facing > EDGE_ON).then(|| [-slope(&self.right), slope(&self.up)])
    }

    fn lengths(&self, point: &Point3<f64>) -> Point3<f64> {
        let part = |direction: &Vector3<f64>| direction.dot(&point.coords);
        Point3::new(part(&self.right), part(&self.up), part(&self.toward))
    }

    fn at_lengths(&self, lengths: &Point3<f64>) -> Point3<f64> {
        Point3::from(lengths.x * self.right + lengths.y * self.up + lengths.z * self.toward)
    }
}

/// Facets whose normal is so nearly perpendicular to the view cover no pixels.
const EDGE_ON: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fitted_box_touches_the_picture_and_comes_back() {
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|bits: u32| {
            Point3::new(
                f64::from(bits & 1),
                f64::from(bits >> 1 & 1),
                f64::from(bits >> 2),
            )
        });
        let camera = Camera::fitting(corners, [[0.0, 0.0], [300.0, 200.0]].map(Point2::from));
        let images = corners.map(|corner| camera.project(&corner));
        let bounds = Bounds::of(&images);
        let extent = bounds.extent();
        assert!((extent.x - 300.0).abs() < 1e-9 || (extent.y - 200.0).abs() < 1e-9);
        assert!(bounds.min.x > -1e-9 && bounds.max.x < 300.0 + 1e-9 && bounds.min.y > -1e-9);
        for (corner, image) in corners.iter().zip(&images) {
            assert!((camera.unproject(image) - corner).norm() < 1e-12);
        }
        // The corner (1, 0, 1) is the nearest to the viewer.
        let depth = |k: usize| images[k].z;
        assert!((0..8).all(|k| depth(k) <= depth(5)));
    }
}
