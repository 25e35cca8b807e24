//! The six cones of a site, and what a neighbor or a wall demands of each.
//!
//! In the cone ±k a point is described by its height h = ±(y − x)_k and the direction
//! (u, v) = ((y − x)_{k+1}, (y − x)_{k+2}) / h, axes counted modulo 3. With D, a, b the displacement to
//! site j along ±k, k+1 and k+2, site j is nearer exactly where h exceeds D/2 (and D > 0),
//! a/(1 + u) if a > 0, −a/(1 − u) if a < 0, and likewise b and v. In g = 1/h these are linear.

use nalgebra::{Point3, Vector3};

use crate::geometry::half_space::HalfSpace;
use crate::voronoi::linf::envelope::{Demand, Gauge};

/// How many cones a site has.
pub(crate) const CONES: usize = 6;

/// A wall that the site touches, or lies beyond by rounding, counts as this near, relative to its
/// normal, and a difference of coordinates as at least this large (L): any other length is
/// infinitely longer.
const TOUCHING: f64 = 1e-290;

/// The forms of a neighbor's demand: facets with normals ±k, ±k ± (k+1) and ±k ± (k+2).
pub(crate) const AHEAD: u8 = 0;
const ALONG_U: u8 = 1;
const ALONG_V: u8 = 2;
/// The form of a wall's demand.
const WALL: u8 = 3;

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

    #[inline]
    fn transverse(self) -> [usize; 2] {
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

    /// The displacement from the site of a direction with a gauge.
    pub(crate) fn displacement(self, [u, v, gauge]: [f64; 3]) -> Vector3<f64> {
        let (height, [first, second]) = (1.0 / gauge, self.transverse());
        let mut displacement = Vector3::zeros();
        displacement[self.axis] = if self.is_negative { -height } else { height };
        displacement[first] = u * height;
        displacement[second] = v * height;
        displacement
    }

    /// What a neighbor at `displacement` demands; nothing where it is not ahead. One whose coordinate
    /// along the axis is the site's own counts if it `wins_ties`.
    #[inline]
    pub(crate) fn of_neighbor(self, displacement: &Vector3<f64>, wins_ties: bool) -> Demand {
        let [ahead, along_u, along_v] = self.coordinates(displacement);
        let mut demand = Demand::default();
        if ahead > 0.0 {
            let constant = 2.0 / ahead.max(TOUCHING);
            demand.push(
                AHEAD,
                Gauge {
                    constant,
                    by_u: 0.0,
                    by_v: 0.0,
                },
            );
        } else if ahead < 0.0 || !wins_ties {
            return demand;
        }
        if along_u != 0.0 {
            let constant = 1.0 / along_u.abs().max(TOUCHING);
            let by_u = constant.copysign(along_u);
            demand.push(
                ALONG_U,
                Gauge {
                    constant,
                    by_u,
                    by_v: 0.0,
                },
            );
        }
        if along_v != 0.0 {
            let constant = 1.0 / along_v.abs().max(TOUCHING);
            let by_v = constant.copysign(along_v);
            demand.push(
                ALONG_V,
                Gauge {
                    constant,
                    by_u: 0.0,
                    by_v,
                },
            );
        }
        demand
    }

    /// What a half-space about the site demands.
    pub(crate) fn of_wall(self, wall: &HalfSpace) -> Demand {
        let scale = 1.0 / wall.offset.max(TOUCHING * wall.normal.amax());
        let [constant, by_u, by_v] = self.coordinates(&wall.normal).map(|part| part * scale);
        Demand::single(
            WALL,
            Gauge {
                constant,
                by_u,
                by_v,
            },
        )
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
