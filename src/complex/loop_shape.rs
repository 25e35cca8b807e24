//! Measures of faces and cells that a mesh under change remembers.

use nalgebra::{Point3, Vector3};

/// Center, area and flatness of a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceShape {
    /// Its center.
    pub(crate) center: Point3<f64>,
    /// Its area times its normal (L²), outward of the owner.
    pub(crate) area: Vector3<f64>,
    /// The ratio of its area to the sum of its triangles' areas.
    pub(crate) flatness: f64,
}

/// Center and volume of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellShape {
    /// Its center of mass.
    pub(crate) center: Point3<f64>,
    /// Its volume (L³).
    pub(crate) volume: f64,
}
