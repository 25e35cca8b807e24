//! Triangulated surfaces: corners, bounds, volume, area.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::geometry::double_double::six_volume;

/// A triangulated surface as it was read: perhaps open, perhaps badly oriented. What bounds a
/// solid is a [`crate::mesh::validate::ValidSurface`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Vertex positions (L).
    pub vertices: Vec<Point3<f64>>,
    /// Zero-based vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// Adds the triangles of another surface.
    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        let moved = other.triangles.iter();
        self.triangles
            .extend(moved.map(|triangle| triangle.map(|vertex| vertex + first)));
    }

    /// The corners of a triangle.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// All triangles' corners.
    pub fn all_corners(&self) -> impl ExactSizeIterator<Item = [Point3<f64>; 3]> + '_ {
        (0..self.triangles.len()).map(|triangle| self.corners(triangle))
    }

    /// The least box that holds all triangles; vertices no triangle uses do not count.
    #[must_use]
    pub fn bounds(&self) -> Bounds<3> {
        Bounds::of(
            self.triangles
                .iter()
                .flatten()
                .map(|&v| &self.vertices[v as usize]),
        )
    }

    /// The enclosed volume (L³) by the divergence theorem: the signed volumes of the cones
    /// from the box's center, each to full precision, so that thin solids far from the origin keep
    /// their digits. Independent of the apex only if the surface is closed.
    #[must_use]
    pub fn volume(&self) -> f64 {
        let apex = self.bounds().center();
        let cones = self
            .all_corners()
            .map(|corners| six_volume(&apex, corners.each_ref()));
        cones.sum::<f64>() / 6.0
    }

    /// The sum of the triangles' areas (L²).
    #[must_use]
    pub fn area(&self) -> f64 {
        self.all_corners()
            .map(|corners| triangle_area(&corners))
            .sum()
    }
}

/// The area of a triangle.
#[must_use]
pub fn triangle_area([a, b, c]: &[Point3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}
