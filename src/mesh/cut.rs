//! A triangle divided along segments in its plane.
//!
//! A binary partition by the segments in a shuffled order: a convex piece is cut by the whole line of
//! a segment that reaches into it. Paterson & Yao, *Efficient binary space partitions for
//! hidden-surface removal and solid modeling*, 1990: n segments give O(n log n) pieces on average.

use nalgebra::{Point3, Vector3};

/// A segment in the plane of the triangle to be divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    from: Point3<f64>,
    /// Its unit direction and its length.
    along: Vector3<f64>,
    length: f64,
    /// The unit normal of its line in the plane.
    across: Vector3<f64>,
}

impl Cut {
    /// The cut along a segment, given the unit normal of the plane; `None` of a point.
    #[must_use]
    pub(crate) fn along([from, to]: [Point3<f64>; 2], normal: &Vector3<f64>) -> Option<Self> {
        let length = (to - from).norm();
        let along = (to - from).try_normalize(0.0)?;
        let across = along.cross(normal).try_normalize(0.0)?;
        Some(Self {
            from,
            along,
            length,
            across,
        })
    }

    /// The two parts of a convex polygon, if the segment reaches farther into it than `touch` (L).
    fn split(&self, polygon: &[Point3<f64>], touch: f64) -> Option<[Vec<Point3<f64>>; 2]> {
        let height = |point: &Point3<f64>| (point - self.from).dot(&self.across);
        let heights: Vec<f64> = polygon.iter().map(height).collect();
        let has = |sign: f64| heights.iter().any(|height| sign * height > touch);
        if !has(1.0) || !has(-1.0) {
            return None;
        }
        let (mut above, mut below) = (Vec::new(), Vec::new());
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, (corner, &height)) in polygon.iter().zip(&heights).enumerate() {
            let next = (k + 1) % polygon.len();
            if height >= 0.0 {
                above.push(*corner);
            }
            if height <= 0.0 {
                below.push(*corner);
            }
            if height * heights[next] <= 0.0 {
                let span = height - heights[next];
                let share = if span == 0.0 { 0.0 } else { height / span };
                let point = corner + (polygon[next] - corner) * share;
                let along = (point - self.from).dot(&self.along);
                (first, last) = (first.min(along), last.max(along));
                if height * heights[next] < 0.0 {
                    above.push(point);
                    below.push(point);
                }
            }
        }
        (last.min(self.length) - first.max(0.0) > touch).then_some([above, below])
    }
}

/// The convex pieces into which `cuts` divide a convex polygon.
#[must_use]
pub(crate) fn divide(polygon: Vec<Point3<f64>>, cuts: &[Cut], touch: f64) -> Vec<Vec<Point3<f64>>> {
    let mut order: Vec<u32> = (0..cuts.len() as u32).collect();
    order.sort_unstable_by_key(|&cut| shuffled(cut));
    let mut pieces = Vec::new();
    let mut open = vec![(polygon, order)];
    while let Some((polygon, order)) = open.pop() {
        let mut order = order.into_iter();
        let parts = order.find_map(|cut| cuts[cut as usize].split(&polygon, touch));
        let Some(parts) = parts else {
            pieces.push(polygon);
            continue;
        };
        for part in parts {
            let reaches = |&cut: &u32| cuts[cut as usize].split(&part, touch).is_some();
            let left: Vec<u32> = order.clone().filter(reaches).collect();
            open.push((part, left));
        }
    }
    pieces
}

/// A fixed shuffle: multiplication by an odd number near 2³² over the golden ratio.
fn shuffled(number: u32) -> u32 {
    number.wrapping_mul(0x9e37_79b1)
}
