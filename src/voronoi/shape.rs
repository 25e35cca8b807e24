//! What a cell is cut from: a polyhedron in fixed slots, or one of any size.

use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::{Full, SmallClipScratch};
use crate::voronoi::far::FarVertices;

/// A polyhedron about the origin that is being cut.
pub(crate) trait Shape {
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full>;

    fn radius_squared(&self) -> f64;

    /// Lists the vertices farther from the origin than the root of `square`.
    fn list_beyond(&self, square: f64, far: &mut FarVertices);
}

impl Shape for (&mut SmallPolyhedron, &mut SmallClipScratch) {
    #[inline]
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full> {
        self.0.clip(half_space, label, self.1)
    }

    #[inline]
    fn radius_squared(&self) -> f64 {
        self.0.radius_squared()
    }

    fn list_beyond(&self, square: f64, far: &mut FarVertices) {
        far.clear();
        let compact = &self.0;
        for slot in compact.beyond(square) {
            far.push([
                compact.x[slot],
                compact.y[slot],
                compact.z[slot],
                compact.square[slot],
            ]);
        }
    }
}

impl Shape for (&mut Polyhedron, &mut ClipScratch) {
    fn cut(&mut self, half_space: &HalfSpace, label: impl FnOnce() -> Label) -> Result<Clip, Full> {
        Ok(clip(self.0, half_space, label(), self.1))
    }

    fn radius_squared(&self) -> f64 {
        self.0.radius_squared()
    }

    fn list_beyond(&self, square: f64, far: &mut FarVertices) {
        far.clear();
        for vertex in self.0.vertices() {
            let distance = vertex.coords.norm_squared();
            if distance > square {
                far.push([vertex.x, vertex.y, vertex.z, distance]);
            }
        }
    }
}
