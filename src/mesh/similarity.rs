//! Uniform scaling and shifting, to bring a mesh into a wanted box.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;

/// The map `y ↦ scale · (y − from) + to`: no shear, no rotation, orientation kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// The factor on lengths, positive.
    pub scale: f64,
    /// The point that is mapped to [`Similarity::to`].
    pub from: Point3<f64>,
    /// Where [`Similarity::from`] goes.
    pub to: Point3<f64>,
}

impl Similarity {
    /// The largest uniform scaling of `bounds` into `target`, centers on each other. A box
    /// without extent is only shifted.
    #[must_use]
    pub fn into_box(bounds: &Bounds<3>, target: &Bounds<3>) -> Self {
        let ratios = target.extent().component_div(&bounds.extent());
        let least = ratios.iter().copied().filter(|ratio| ratio.is_finite());
        let scale = least.fold(f64::INFINITY, f64::min);
        Self {
            scale: if scale.is_finite() { scale } else { 1.0 },
            from: bounds.center(),
            to: target.center(),
        }
    }

    /// The largest uniform scaling of `bounds` into the unit cube, centered there.
    #[must_use]
    pub fn into_unit_cube(bounds: &Bounds<3>) -> Self {
        let (min, max) = (Point3::origin(), Point3::new(1.0, 1.0, 1.0));
        Self::into_box(bounds, &Bounds { min, max })
    }

    /// Extent 1 along `axis` (0, 1 or 2), least coordinates at the origin: \[BL\] Table 3's
    /// unit height. A box without extent along `axis` is only shifted.
    #[must_use]
    pub fn to_unit_height(bounds: &Bounds<3>, axis: usize) -> Self {
        let height = bounds.extent()[axis];
        Self {
            scale: if height > 0.0 { 1.0 / height } else { 1.0 },
            from: bounds.min,
            to: Point3::origin(),
        }
    }

    /// The image of `point`.
    #[must_use]
    pub fn apply(&self, point: &Point3<f64>) -> Point3<f64> {
        let offset: Vector3<f64> = point - self.from;
        self.to + offset * self.scale
    }

    /// Moves every one of `points` to its image.
    pub fn move_all(&self, points: &mut [Point3<f64>]) {
        for point in points {
            *point = self.apply(point);
        }
    }
}
