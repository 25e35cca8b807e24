//! The six cones of a site, and what a neighbor is nearer to in each.
//!
//! In the cone ±k a point is described by its height h = ±(y − x)_k and, across,
//! (u, v) = ((y − x)_{k+1}, (y − x)_{k+2}), axes counted modulo 3. With D, a, b the displacement to
//! site j along ±k, k+1 and k+2, site j is nearer exactly where h exceeds D/2 (and D > 0),
//! u > a − h if a > 0, u < a + h if a < 0, and likewise with b and v.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::voronoi::linf::quadrant::{ConeWalls, Quadrant};

/// How many cones a site has.
pub(crate) const CONES: usize = 6;

/// One of the six cones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Cone {
    /// The axis k.
    pub(crate) axis: usize,
    /// Whether it opens towards −k.
    pub(crate) is_negative: bool,
}

impl Cone {
    /// The cones +x, −x, +y, −y, +z, −z.
    pub(crate) fn all() -> [Self; CONES] {
        std::array::from_fn(|number| Self {
            axis: number / 2,
            is_negative: number % 2 == 1,
        })
    }

    /// The two axes across.
    #[inline]
    pub(crate) fn transverse(self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    /// The number of the plane through the site at the side u (or v, with `along` 1) of 1, or of −1: it
    /// is the same for both cones that meet there.
    pub(crate) fn side(self, along: usize, is_low: bool) -> usize {
        let other = self.transverse()[along];
        let (low, high) = (self.axis.min(other), self.axis.max(other));
        let is_mirrored = self.is_negative != is_low;
        2 * (3 * low + high) + usize::from(is_mirrored)
    }

    /// A displacement along the axis and the two others.
    #[inline]
    pub(crate) fn coordinates(self, displacement: &Vector3<f64>) -> [f64; 3] {
        let [first, second] = self.transverse();
        let along = displacement[self.axis];
        let ahead = if self.is_negative { -along } else { along };
        [ahead, displacement[first], displacement[second]]
    }

    /// The displacement from the site of a place (h, u, v) in the cone.
    pub(crate) fn displacement(self, [height, u, v]: [f64; 3]) -> Vector3<f64> {
        let [first, second] = self.transverse();
        let mut displacement = Vector3::zeros();
        displacement[self.axis] = if self.is_negative { -height } else { height };
        displacement[first] = u;
        displacement[second] = v;
        displacement
    }

    /// What a neighbor at `displacement` is nearer to, between walls; nothing where it is not ahead. One
    /// whose coordinate along the axis is the site's own counts if it `wins_ties`.
    #[inline]
    pub(crate) fn quadrant(
        self,
        displacement: &Vector3<f64>,
        wins_ties: bool,
        walls: &ConeWalls,
        source: u32,
    ) -> Option<Quadrant> {
        let [ahead, along_u, along_v] = self.coordinates(displacement);
        if ahead < 0.0 || ahead == 0.0 && !wins_ties {
            return None;
        }
        let (half, is_low) = (0.5 * ahead, [along_u < 0.0, along_v < 0.0]);
        let across = [along_u.abs(), along_v.abs()];
        // Before that it is outside the section.
        let entry = [0, 1].map_each(|along| {
            let wall = walls.across[along][usize::from(!is_low[along])].0;
            (0.5 * across[along]).max(across[along] - wall)
        });
        let start = half.max(entry[0]).max(entry[1]);
        Some(Quadrant {
            start,
            across,
            is_low,
            is_ahead: half >= start,
            source,
        })
    }

    /// The cone's part of walls along the axes: distances (L) and sources, low and high.
    pub(crate) fn walls(self, walls: &[[(f64, u32); 2]; 3]) -> ConeWalls {
        ConeWalls {
            across: self.transverse().map(|axis| walls[axis]),
            ahead: walls[self.axis][usize::from(!self.is_negative)],
        }
    }
}

/// The displacement from one site to another moved by whole periods, along each axis with the exact
/// sign, zero only where coordinates are equal, and opposite to that in the other direction.
///
/// The difference s + e is exact (Knuth's two-sum), and so is its sum with the period, t + f + e. Where t
/// cancels, f is zero (Sterbenz), and t + e is rounded once; elsewhere t is far larger than both.
#[inline]
pub(crate) fn exact_displacement(
    from: &Point3<f64>,
    to: &Point3<f64>,
    by: &Vector3<f64>,
) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        let (difference, error) = two_sum(to[axis], -from[axis]);
        let (total, more) = two_sum(difference, by[axis]);
        total + (error + more)
    })
}

/// The rounded sum of two numbers, and what is missing to the exact one.
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_have_the_exact_sign_and_opposite_ones_agree() {
        let period = 1.0;
        for (a, b) in [
            (0.1, 1.1 - 1.0),
            (1e-17, 1.0),
            (0.3, 0.1 + 0.2),
            (1.0 - 1e-16, 1e-300),
        ] {
            let points = [a, b].map(|x| Point3::new(x, 0.0, 0.0));
            for shift in [-period, 0.0, period] {
                let by = Vector3::new(shift, 0.0, 0.0);
                let there = exact_displacement(&points[0], &points[1], &by).x;
                let back = exact_displacement(&points[1], &points[0], &-by).x;
                assert_eq!(there.abs().to_bits(), back.abs().to_bits());
                assert!(there * back <= 0.0);
                let is_equal = (b - a).abs() <= 0.0 && shift == 0.0;
                assert_eq!(there == 0.0, is_equal, "{a} {b} {shift}");
            }
        }
        // 1 − (1e-17 + 1) is −1e-17, which rounds to zero in two steps.
        let [low, high] = [1e-17, 1.0].map(|x| Point3::new(x, 0.0, 0.0));
        let by = Vector3::new(-1.0, 0.0, 0.0);
        let between = exact_displacement(&low, &high, &by).x;
        assert_eq!(between.to_bits(), (-1e-17_f64).to_bits());
    }
}
