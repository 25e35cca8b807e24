//! What can still be cut: a cell's vertices far enough from the site to feel the sites to come.
//!
//! A site p cuts the vertex v exactly if it lies in the ball about v through the origin: |p − v| <
//! |v|. So neither a site farther than 2 |v| can, nor any site in a box that does not meet the ball.
//! The union of all the balls is the cell's flower; what lies outside needs no look. This spares the
//! crowd behind a cell that reaches far out of it.

use nalgebra::{Point3, Vector3};
use wide::f64x4;

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;

/// The vertices of a cell, relative to its site, that sites farther than some distance may cut.
#[derive(Clone, Debug, Default)]
pub(crate) struct FarVertices {
    blocks: Vec<[f64x4; 4]>,
    /// How many vertices there are in the blocks.
    count: usize,
}

impl FarVertices {
    /// Forgets all vertices.
    pub(crate) fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    /// Adds a vertex, the last number being its squared distance.
    #[inline]
    pub(crate) fn push(&mut self, vertex: [f64; 4]) {
        let lane = self.count % 4;
        if lane == 0 {
            // A vertex in the site itself is cut by nothing and has a ball that holds nothing.
            self.blocks.push([f64x4::ZERO; 4]);
        }
        if let Some(block) = self.blocks.last_mut() {
            for (lanes, number) in block.iter_mut().zip(vertex) {
                lanes.as_mut_array()[lane] = number;
            }
        }
        self.count += 1;
    }

    /// Whether one of the vertices lies beyond the half-space, as computed.
    #[inline]
    #[must_use]
    pub(crate) fn exceed(&self, half_space: &HalfSpace) -> bool {
        let [a, b, c] = [0, 1, 2].map(|axis| f64x4::splat(half_space.normal[axis]));
        let offset = f64x4::splat(half_space.offset);
        let mut cut = 0;
        for [x, y, z, _] in &self.blocks {
            cut |= (offset - (a * *x + b * *y + c * *z)).to_bitmask();
        }
        cut != 0
    }

    /// Whether the ball of one of the vertices meets the box, as seen from the site in `here`.
    #[inline]
    #[must_use]
    pub(crate) fn meet(&self, bounds: &Bounds<3>, here: &Point3<f64>) -> bool {
        let [min, max] = [&bounds.min, &bounds.max].map(|end| {
            let end: Vector3<f64> = end - here;
            [0, 1, 2].map(|axis| f64x4::splat(end[axis]))
        });
        for [x, y, z, square] in &self.blocks {
            let mut room = -*square;
            for (axis, along) in [x, y, z].into_iter().enumerate() {
                let outside = (min[axis] - *along).fast_max(*along - max[axis]);
                let gap = outside.fast_max(f64x4::ZERO);
                room += gap * gap;
            }
            if room.to_bitmask() != 0 {
                return true;
            }
        }
        false
    }
}
