//! Moments of any density over cones of triangles, by a pair of rules of different degree.
//!
//! A cone from the apex a over a triangle is y = a + τ (c − a), c on the triangle and 0 ≤ τ ≤ 1, with
//! the volume element τ² dτ · det. Its pieces are cut off by two values of τ and halved along τ or across
//! the triangle's longest edge, where they are longer.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::{
    AdaptivePiece, Estimate, add_mass, gauss_legendre, halved, longest_edge,
};

/// The part of a cone between two values of τ; signed as its corners turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConePiece {
    apex: Point3<f64>,
    corners: [Point3<f64>; 3],
    range: [f64; 2],
    /// The number of its triangle or tetrahedron.
    pub(crate) number: u32,
}

/// A piece is halved along τ where it is so many times as long as its triangle: the rule along τ has the
/// higher degree.
const SLENDER: f64 = 1.5;

impl ConePiece {
    /// A whole cone.
    pub(crate) fn new(apex: Point3<f64>, corners: [Point3<f64>; 3], number: u32) -> Self {
        let range = [0.0, 1.0];
        Self {
            apex,
            corners,
            range,
            number,
        }
    }
}

impl AdaptivePiece for ConePiece {
    fn halves(&self) -> [Self; 2] {
        let [low, high] = self.range;
        let arms = self.corners.map_each(|corner| corner - self.apex);
        let length = (high - low) * (arms[0] + arms[1] + arms[2]).norm() / 3.0;
        let width = high * longest_edge(&self.corners).1.sqrt();
        if length > SLENDER * width {
            let middle = 0.5 * (low + high);
            return [[low, middle], [middle, high]].map_each(|range| Self { range, ..*self });
        }
        halved(&self.corners).map(|corners| Self { corners, ..*self })
    }
}

/// Barycentric coordinates in groups of equal ones, and the group's weight: all three orders of (a, b, b).
type Orbit = (f64, f64);

/// Six points of degree 4 (Dunavant, *High degree efficient symmetrical Gaussian quadrature rules for the
/// triangle*, 1985): b and weight.
const DEGREE_4: [Orbit; 2] = [
    (0.445_948_490_915_964_9, 0.223_381_589_678_011_47),
    (0.091_576_213_509_770_74, 0.109_951_743_655_321_87),
];

/// Seven points of degree 5 (Radon, 1948), beside the middle of weight 9/40.
const DEGREE_5: [Orbit; 2] = [
    (0.470_142_064_105_115_1, 0.132_394_152_788_506_2),
    (0.101_286_507_323_456_34, 0.125_939_180_544_827_15),
];

/// Nodes of a rule on the triangle and along τ.
#[derive(Clone, Debug)]
struct ConeRule {
    triangle: Vec<([f64; 3], f64)>,
    along: Vec<(f64, f64)>,
}

impl ConeRule {
    fn new(orbits: &[Orbit], middle: f64, along: usize) -> Self {
        let mut triangle = Vec::new();
        if middle > 0.0 {
            triangle.push(([1.0 / 3.0; 3], middle));
        }
        for &(b, weight) in orbits {
            for k in 0..3 {
                let mut shares = [b; 3];
                shares[k] = 1.0 - 2.0 * b;
                triangle.push((shares, weight));
            }
        }
        Self {
            triangle,
            along: gauss_legendre(along),
        }
    }

    /// The moments from `origin` of a piece.
    fn moments(
        &self,
        piece: &ConePiece,
        origin: &Point3<f64>,
        density: &mut impl FnMut(&Point3<f64>) -> f64,
    ) -> Moments {
        let arms = piece.corners.map_each(|corner| corner - piece.apex);
        let double_area = arms[0].dot(&arms[1].cross(&arms[2]));
        let [low, high] = piece.range;
        let mut moments = Moments::default();
        for ([a, b, c], share) in &self.triangle {
            let ray = arms[0] * *a + arms[1] * *b + arms[2] * *c;
            for (node, weight) in &self.along {
                let tau = low + (high - low) * node;
                let place = piece.apex + ray * tau;
                let volume = 0.5 * double_area * share * (high - low) * weight * tau * tau;
                add_mass(&mut moments, volume * density(&place), &(place - origin));
            }
        }
        moments
    }
}

/// The pair of rules: degree 5 on the triangle with 6 nodes along τ, and degree 4 with 5.
#[derive(Clone, Debug)]
pub(crate) struct ConeRules {
    rules: [ConeRule; 2],
}

impl ConeRules {
    pub(crate) fn new() -> Self {
        Self {
            rules: [
                ConeRule::new(&DEGREE_5, 9.0 / 40.0, 6),
                ConeRule::new(&DEGREE_4, 0.0, 5),
            ],
        }
    }

    /// The moments of a piece from `origin`, and their difference from those of the lower rule.
    pub(crate) fn estimate(
        &self,
        piece: &ConePiece,
        origin: &Point3<f64>,
        mut density: impl FnMut(&Point3<f64>) -> f64,
    ) -> Estimate {
        let both = (self.rules.each_ref()).map(|rule| rule.moments(piece, origin, &mut density));
        Estimate::of_pair(both[0], &both[1])
    }

    /// The first node of a piece at which the density is no finite number, and the density there.
    pub(crate) fn fault(
        &self,
        piece: &ConePiece,
        density: impl Fn(&Point3<f64>) -> f64,
    ) -> Option<(Point3<f64>, f64)> {
        let mut found = None;
        let mut look = |place: &Point3<f64>| {
            let value = density(place);
            if !value.is_finite() {
                found.get_or_insert((*place, value));
            }
            value
        };
        for rule in &self.rules {
            rule.moments(piece, &Point3::origin(), &mut look);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone() -> ConePiece {
        let corners = [[1.0, 0.1, 0.0], [0.2, 1.3, 0.1], [-0.2, 0.3, 0.9]].map(Point3::from);
        ConePiece::new(Point3::new(0.1, -0.2, -0.3), corners, 0)
    }

    #[test]
    fn both_rules_are_exact_for_constant_densities_and_pieces_add_up() {
        let rules = ConeRules::new();
        let origin = Point3::new(0.3, 0.2, 0.1);
        let whole = rules.estimate(&cone(), &origin, |_| 2.0);
        let mut expected = Moments::default();
        expected.add_cone(cone().corners.map(|corner| corner - cone().apex));
        let expected = expected.translated(&(cone().apex - origin)) * 2.0;
        let close = |one: &Moments, other: &Moments| {
            let pairs = one.ten().into_iter().zip(other.ten());
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-14
        };
        assert!(close(&whole.moments, &expected), "{whole:?}");
        assert!(whole.errors.mass < 1e-15 && whole.errors.inertia < 1e-14);
        let mut sum = Moments::default();
        for half in cone().halves() {
            for quarter in half.halves() {
                sum += rules.estimate(&quarter, &origin, |_| 2.0).moments;
            }
        }
        assert!(close(&sum, &expected), "{sum:?}");
    }
}
