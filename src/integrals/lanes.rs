//! The ten moments of four simplices at a time.
//!
//! The ten moments of a simplex are some hundred multiplications without a branch, so they run as
//! wide as the machine if the data lie by component: a [`Lanes`] holds one number of four
//! simplices. Each lane adds up its own sums, and the four are added at the end in one order;
//! how many lanes an instruction really takes changes no bit, because nothing is contracted or
//! reordered. The coordinates go from the vertices straight into registers: writing them to a
//! buffer first took as long as all the arithmetic. A block that is not full is filled up with
//! simplices shrunk to a point, whose volume is exactly 0.

use nalgebra::Point3;
use wide::f64x4;

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::geometry::simd::{cross, dot, sum};

/// One number of [`WIDTH`] simplices.
pub type Lanes = f64x4;

/// A position of [`WIDTH`] simplices, by component.
pub type LanePoint = [Lanes; 3];

/// Simplices handled together. Eight spill every register of the default x86-64 target.
pub const WIDTH: usize = 4;

/// The factors of mass, first and second moments that [`Sums::add_constant`] leaves out: V, V/4
/// and V/20 in terms of six times the volume V.
pub const CONSTANT: [f64; 3] = [1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0];

/// The factors that [`Sums::add_linear`] leaves out: V/4, V/20 and V/120 in terms of six times
/// the volume V, mass and second moments doubled because they carry a half.
pub const LINEAR: [f64; 3] = [1.0 / 12.0, 1.0 / 120.0, 1.0 / 360.0];

/// Running sums of ∫ρ·{1, x, y, z, x², y², z², xy, yz, zx}, before the constant factors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    ten: [Lanes; 10],
}

impl Sums {
    /// Adds simplices spanned by the origin, of density `apex_density`, and `K` corners. For
    /// tetrahedra that do not have the origin for a corner, K = 4 and the apex density is 0.
    ///
    /// With σ = Σ ρ_i, S = Σ v_i, u_i = (σ/2 + ρ_i) v_i and U = Σ u_i, the integrals of ρ, ρ y
    /// and ρ y yᵀ are proportional to σ, σ S/2 + U and Σ u_i v_iᵀ + (U Sᵀ + S Uᵀ)/2: a product
    /// ρ_i v_j v_kᵀ counts 1, 2 or 6 times as none, two or three of its indices meet.
    #[inline(always)]
    pub fn add_linear<const K: usize>(
        &mut self,
        six_volumes: Lanes,
        corners: &[LanePoint; K],
        densities: &[Lanes; K],
        apex_density: Lanes,
    ) {
        let one_half = Lanes::splat(0.5);
        let total = densities
            .iter()
            .fold(apex_density, |sum, &density| sum + density);
        let half = total * one_half;
        let (mut s, mut u, mut second) = zeros();
        for (corner, &density) in corners.iter().zip(densities) {
            let weight = half + density;
            for axis in 0..3 {
                let weighed = weight * corner[axis];
                s[axis] += corner[axis];
                u[axis] += weighed;
                second[axis] += weighed * corner[axis];
                second[3 + axis] += weighed * corner[(axis + 1) % 3];
            }
        }
        self.ten[0] += six_volumes * half;
        for axis in 0..3 {
            let next = (axis + 1) % 3;
            let mixed = one_half * (u[axis] * s[next] + u[next] * s[axis]);
            self.ten[1 + axis] += six_volumes * (half * s[axis] + u[axis]);
            self.ten[4 + axis] += six_volumes * (second[axis] + u[axis] * s[axis]);
            self.ten[7 + axis] += six_volumes * (second[3 + axis] + mixed);
        }
    }

    /// The same at density 1: 1, Σ v_i and Σ v_i v_iᵀ + Σ v_i (Σ v_i)ᵀ.
    #[inline(always)]
    pub fn add_constant<const K: usize>(&mut self, six_volumes: Lanes, corners: &[LanePoint; K]) {
        let (mut s, _, mut second) = zeros();
        for corner in corners {
            for axis in 0..3 {
                s[axis] += corner[axis];
                second[axis] += corner[axis] * corner[axis];
                second[3 + axis] += corner[axis] * corner[(axis + 1) % 3];
            }
        }
        self.ten[0] += six_volumes;
        for axis in 0..3 {
            let next = (axis + 1) % 3;
            self.ten[1 + axis] += six_volumes * s[axis];
            self.ten[4 + axis] += six_volumes * (second[axis] + s[axis] * s[axis]);
            self.ten[7 + axis] += six_volumes * (second[3 + axis] + s[axis] * s[next]);
        }
    }

    /// The moments, given the factors that the additions left out.
    #[must_use]
    pub fn moments(&self, [mass, first, second]: [f64; 3]) -> Moments {
        let mut ten = self.ten.map(sum);
        ten[0] *= mass;
        for sum in &mut ten[1..4] {
            *sum *= first;
        }
        for sum in &mut ten[4..] {
            *sum *= second;
        }
        Moments::from_ten(ten)
    }
}

/// Corner by corner the vertices that up to [`WIDTH`] simplices name; the missing ones shrink to
/// the first simplex's first vertex. The block must not be empty.
#[inline(always)]
pub fn named<const K: usize>(block: &[[u32; K]]) -> [[usize; WIDTH]; K] {
    let point = [block[0][0]; K];
    let at = |lane: usize| block.get(lane).unwrap_or(&point);
    let lanes = [at(0), at(1), at(2), at(3)];
    std::array::from_fn(|corner| lanes.map_each(|simplex| simplex[corner] as usize))
}

/// The positions of four vertices relative to `origin`, by component.
#[inline(always)]
pub fn gathered(vertices: &[Point3<f64>], named: [usize; WIDTH], origin: &LanePoint) -> LanePoint {
    let [a, b, c, d] = named.map_each(|vertex| &vertices[vertex]);
    [
        Lanes::from([a.x, b.x, c.x, d.x]) - origin[0],
        Lanes::from([a.y, b.y, c.y, d.y]) - origin[1],
        Lanes::from([a.z, b.z, c.z, d.z]) - origin[2],
    ]
}

/// The same point in every lane.
#[must_use]
pub fn splat(point: &Point3<f64>) -> LanePoint {
    [point.x, point.y, point.z].map_each(Lanes::splat)
}

/// Six times the signed volumes of tetrahedra: a · (b × c) with the fourth corner at 0 for `K` = 3;
/// from the edges at the first corner for `K` = 4, so that a small one far from the origin keeps its
/// digits.
#[inline(always)]
#[must_use]
pub fn six_volumes<const K: usize>(corners: &[LanePoint; K]) -> Lanes {
    match corners.as_slice() {
        [a, b, c] => dot(a, &cross(b, c)),
        [a, others @ ..] if others.len() == 3 => {
            let edge = |k: usize| [0, 1, 2].map_each(|axis| others[k][axis] - a[axis]);
            dot(&edge(0), &cross(&edge(1), &edge(2)))
        }
        _ => Lanes::ZERO,
    }
}

fn zeros() -> ([Lanes; 3], [Lanes; 3], [Lanes; 6]) {
    ([Lanes::ZERO; 3], [Lanes::ZERO; 3], [Lanes::ZERO; 6])
}
