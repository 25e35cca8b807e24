//! Lower bounds of the distance to a surface, on a grid of cubes.
//!
//! The bounding box is cut into equal cubes. Those that a triangle may touch are marked, and every
//! other is given its Chebyshev distance to the nearest marked one. A cell that reaches less far than
//! that does not touch the surface, and costs as much as in a box.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::mesh::surface::SurfaceMesh;

/// Cubes along the longest axis: some hundred thousand bytes in all, filled in milliseconds, and
/// as fine as the cells of ten thousand sites.
const FINEST: f64 = 64.0;

/// Rounding of coordinates against the cubes' walls, in sides: more than any place far from zero has.
const ROUNDING: f64 = 1e-3;

/// Lower bounds of the distance to a surface.
#[derive(Clone, Debug)]
pub(crate) struct DistanceGrid {
    origin: Point3<f64>,
    side: f64,
    counts: [usize; 3],
    /// In cubes; 0 where a triangle may be. The last axis runs fastest.
    steps: Vec<u8>,
}

impl DistanceGrid {
    /// The distances to the triangles of `surface`.
    pub(crate) fn new(surface: &SurfaceMesh) -> Self {
        let bounds = surface.bounds();
        let side = (bounds.extent().max() / FINEST).max(f64::MIN_POSITIVE);
        let counts = [0, 1, 2].map_each(|axis| (bounds.extent()[axis] / side) as usize + 1);
        let mut grid = Self {
            origin: bounds.min,
            side,
            counts,
            steps: vec![u8::MAX; counts.iter().product()],
        };
        for corners in surface.all_corners() {
            grid.mark(&corners);
        }
        grid.propagate();
        grid
    }

    /// No triangle is nearer to `place`, a point of the bounding box, along all axes (L).
    pub(crate) fn at(&self, place: &Point3<f64>) -> f64 {
        let steps = self.steps[self.number(self.cube(place))];
        (f64::from(steps) - 1.0 - ROUNDING) * self.side
    }

    fn cube(&self, place: &Point3<f64>) -> [usize; 3] {
        [0, 1, 2].map_each(|axis| {
            let steps = (place[axis] - self.origin[axis]) / self.side;
            (steps as usize).min(self.counts[axis] - 1)
        })
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.counts[1] + y) * self.counts[2] + z
    }

    /// The inverse of [`DistanceGrid::number`].
    fn indices(&self, number: usize) -> [usize; 3] {
        let [_, rows, columns] = self.counts;
        let (row, column) = (number / columns, number % columns);
        [row / rows, row % rows, column]
    }

    /// Marks the cubes that the triangle's bounds and its plane both touch.
    fn mark(&mut self, corners: &[Point3<f64>; 3]) {
        let bounds = Bounds::of(corners);
        let slack = Vector3::repeat(ROUNDING * self.side);
        let [low, high] =
            [bounds.min - slack, bounds.max + slack].map_each(|place| self.cube(&place));
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let reach = normal.abs().sum() * self.side * (0.5 + ROUNDING);
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let steps = Vector3::new(x as f64, y as f64, z as f64).add_scalar(0.5);
                    let middle = self.origin + steps * self.side;
                    if normal.dot(&(middle - corners[0])).abs() <= reach {
                        let number = self.number([x, y, z]);
                        self.steps[number] = 0;
                    }
                }
            }
        }
    }

    /// Gives every cube its distance: one more than the least of its neighbors', which a sweep
    /// forward and one backward find.
    fn propagate(&mut self) {
        let count = self.steps.len();
        for number in 0..count {
            self.update_from_neighbors(number);
        }
        for number in (0..count).rev() {
            self.update_from_neighbors(number);
        }
    }

    fn update_from_neighbors(&mut self, number: usize) {
        let here = self.steps[number];
        if here == 0 {
            return;
        }
        let at = self.indices(number);
        let span =
            |axis: usize| at[axis].saturating_sub(1)..=(at[axis] + 1).min(self.counts[axis] - 1);
        let mut least = u8::MAX;
        for x in span(0) {
            for y in span(1) {
                for z in span(2) {
                    least = least.min(self.steps[self.number([x, y, z])]);
                }
            }
        }
        self.steps[number] = here.min(least.saturating_add(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::trefoil;

    #[test]
    fn no_vertex_is_nearer_than_the_bound() {
        let surface = trefoil(0.4, 64, 8);
        let grid = DistanceGrid::new(&surface);
        let bounds = surface.bounds();
        let mut is_somewhere_free = false;
        for k in 0..1000_u32 {
            let share = |k: u32| f64::from(k % 10) / 9.0;
            let share = Vector3::new(share(k), share(k / 10), share(k / 100));
            let place = bounds.min + bounds.extent().component_mul(&share);
            let bound = grid.at(&place);
            let vertices = surface.vertices.iter();
            let nearest = vertices.fold(f64::INFINITY, |near: f64, v| near.min((v - place).amax()));
            assert!(bound < nearest, "{place}: {bound} {nearest}");
            is_somewhere_free |= bound > 0.5 * nearest;
        }
        assert!(is_somewhere_free);
    }
}
