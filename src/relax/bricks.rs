//! A box divided into bricks, one for every rank, by halving sites across the longest side.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;

/// Bricks that fill a box. Sides on the box's walls are infinitely far, as are all sides along a periodic axis
/// that is not divided: beyond them there is no site of another brick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bricks {
    bricks: Vec<Bounds<3>>,
    periods: [Option<f64>; 3],
}

impl Bricks {
    /// `count` bricks of a domain's box, which hold as many of `sites` each as they can.
    pub(crate) fn new(
        domain: &Bounds<3>,
        periods: [Option<f64>; 3],
        mut sites: Vec<Point3<f64>>,
        count: usize,
    ) -> Self {
        let mut bricks = Vec::with_capacity(count);
        divide(&mut sites, *domain, count, &mut bricks);
        for brick in &mut bricks {
            for axis in 0..3 {
                let (at_min, at_max) = (
                    brick.min[axis] <= domain.min[axis],
                    brick.max[axis] >= domain.max[axis],
                );
                let is_closed = periods[axis].is_none() || at_min && at_max;
                if is_closed && at_min {
                    brick.min[axis] = f64::NEG_INFINITY;
                }
                if is_closed && at_max {
                    brick.max[axis] = f64::INFINITY;
                }
            }
        }
        Self { bricks, periods }
    }

    /// The brick in which a point lies: of two that share a side the upper one, if none the nearest.
    pub(crate) fn owner(&self, point: &Point3<f64>) -> usize {
        let holds = |brick: &Bounds<3>| {
            (0..3).all(|axis| brick.min[axis] <= point[axis] && point[axis] < brick.max[axis])
        };
        self.bricks.iter().position(holds).unwrap_or_else(|| {
            let gaps = (0..self.bricks.len()).map(|number| (self.gap(number, point), number));
            let nearest = gaps.min_by(|one, other| one.0.total_cmp(&other.0));
            nearest.map_or(0, |(_, number)| number)
        })
    }

    /// The distance of a point, or the nearest image of it, from a brick (L).
    pub(crate) fn gap(&self, number: usize, point: &Point3<f64>) -> f64 {
        let brick = &self.bricks[number];
        let along = |axis: usize| {
            let outside = |at: f64| (brick.min[axis] - at).max(at - brick.max[axis]).max(0.0);
            let at = point[axis];
            match self.periods[axis] {
                Some(period) => outside(at)
                    .min(outside(at - period))
                    .min(outside(at + period)),
                None => outside(at),
            }
        };
        let [x, y, z] = [0, 1, 2].map_each(along);
        (x * x + y * y + z * z).sqrt()
    }

    /// The distance of a point of a brick from the brick's nearest side beyond which there are others (L).
    pub(crate) fn depth(&self, number: usize, point: &Point3<f64>) -> f64 {
        let brick = &self.bricks[number];
        let sides =
            (0..3).flat_map(|axis| [point[axis] - brick.min[axis], brick.max[axis] - point[axis]]);
        sides.fold(f64::INFINITY, f64::min)
    }
}

/// Divides a brick with its sites among `count` ranks.
fn divide(sites: &mut [Point3<f64>], brick: Bounds<3>, count: usize, bricks: &mut Vec<Bounds<3>>) {
    if count <= 1 {
        bricks.push(brick);
        return;
    }
    let axis = brick.extent().imax();
    let low = count / 2;
    let half = sites.len() * low / count;
    let share = low as f64 / count as f64;
    let mut middle = brick.min[axis] + share * brick.extent()[axis];
    if half > 0 && half < sites.len() {
        let (_, site, _) = sites.select_nth_unstable_by(half, |a, b| a[axis].total_cmp(&b[axis]));
        let is_inside = brick.min[axis] < site[axis] && site[axis] < brick.max[axis];
        middle = if is_inside { site[axis] } else { middle };
    }
    let (below, above) = sites.split_at_mut(half);
    let (mut lower, mut upper) = (brick, brick);
    (lower.max[axis], upper.min[axis]) = (middle, middle);
    divide(below, lower, low, bricks);
    divide(above, upper, count - low, bricks);
}
