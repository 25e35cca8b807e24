//! Axis-aligned boxes.

use crate::arrays::MapEach;
use nalgebra::{Point, Point3, SVector, Vector3};

/// An axis-aligned box `min ≤ y ≤ max` in `D` dimensions (lengths in L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const D: usize> {
    /// The corner with the least coordinates.
    pub min: Point<f64, D>,
    /// The corner with the greatest coordinates.
    pub max: Point<f64, D>,
}

impl<const D: usize> Bounds<D> {
    /// The box between two opposite corners.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Bounds, Cuboid};
    ///
    /// let bounds = Bounds::from_corners([0.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    /// let cuboid = Cuboid::new(bounds, [true, false, false])?;
    /// # let _ = cuboid;
    /// # Ok::<(), chebloyd::DomainError>(())
    /// ```
    pub fn from_corners(one: impl Into<Point<f64, D>>, other: impl Into<Point<f64, D>>) -> Self {
        Self::of(&[one.into(), other.into()])
    }

    /// The box that holds nothing: `min = +∞`, `max = −∞`.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            min: Point::from(SVector::repeat(f64::INFINITY)),
            max: Point::from(SVector::repeat(f64::NEG_INFINITY)),
        }
    }

    /// The least box that holds all `points`; [`Bounds::empty`] of none.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point<f64, D>>) -> Self {
        let mut bounds = Self::empty();
        for point in points {
            bounds.include(point);
        }
        bounds
    }

    /// Grows the box so that it holds `point`.
    pub fn include(&mut self, point: &Point<f64, D>) {
        // Not f64::min and max: their treatment of NaN costs more than the rest.
        for axis in 0..D {
            let (along, min, max) = (point[axis], self.min[axis], self.max[axis]);
            self.min[axis] = if along < min { along } else { min };
            self.max[axis] = if along > max { along } else { max };
        }
    }

    /// The box moved by `displacement`.
    #[must_use]
    pub fn translated(&self, displacement: &SVector<f64, D>) -> Self {
        Self {
            min: self.min + displacement,
            max: self.max + displacement,
        }
    }

    /// The box with its sides moved outward by `margin` (L), per axis.
    #[must_use]
    pub fn grown(&self, margin: &SVector<f64, D>) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// `max − min` per axis (L).
    #[must_use]
    pub fn extent(&self) -> SVector<f64, D> {
        self.max - self.min
    }

    /// The box's midpoint.
    #[must_use]
    pub fn center(&self) -> Point<f64, D> {
        nalgebra::center(&self.min, &self.max)
    }

    /// The product of the extents (L^D); zero for a box that is empty along an axis.
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.extent().iter().map(|length| length.max(0.0)).product()
    }

    /// Whether `point` lies in the closed box.
    #[must_use]
    pub fn contains(&self, point: &Point<f64, D>) -> bool {
        (0..D).all(|axis| self.min[axis] <= point[axis] && point[axis] <= self.max[axis])
    }

    /// Whether the two closed boxes have a point in common.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..D).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }

    /// The part common to both boxes.
    #[must_use]
    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.sup(&other.min),
            max: self.max.inf(&other.max),
        }
    }

    /// The point of the box nearest to `point`.
    #[must_use]
    pub fn clamp(&self, point: &Point<f64, D>) -> Point<f64, D> {
        point.sup(&self.min).inf(&self.max)
    }
}

impl Bounds<3> {
    /// Whether the closed box and the triangle have a point in common: none of the thirteen axes
    /// that could separate them does (Akenine-Möller, *Fast 3D Triangle-Box Overlap Testing*, 2001).
    #[must_use]
    pub(crate) fn meets_triangle(&self, corners: &[Point3<f64>; 3]) -> bool {
        let (center, half) = (self.center(), self.extent() / 2.0);
        let arms = corners.map_each(|corner| corner - center);
        let reaches = |axis: &Vector3<f64>| {
            let along = arms.map_each(|arm| arm.dot(axis));
            let reach = half.dot(&axis.abs());
            let (least, most) = along
                .iter()
                .fold((f64::INFINITY, -f64::INFINITY), |(a, b), &x| {
                    (a.min(x), b.max(x))
                });
            least <= reach && most >= -reach
        };
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let sides = [0, 1, 2].map_each(|k| arms[(k + 1) % 3] - arms[k]);
        axes.iter().all(&reaches)
            && reaches(&sides[0].cross(&sides[1]))
            && (sides.iter()).all(|side| axes.iter().all(|axis| reaches(&side.cross(axis))))
    }
}
