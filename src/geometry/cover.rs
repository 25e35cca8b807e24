//! Boxes that cover a solid given by its boundary, for drawing points in it where its bounding box is
//! nearly empty.
//!
//! The boxes are parallel to the boundary's principal axes: a straight thin rod or plate fills its own
//! box wherever it points. Boxes that meet the boundary are halved along their longest side, those
//! that lose it are kept whole or dropped by their center, until the cover is a few times the solid.
//! Whatever meets the boundary is kept, so that points drawn uniformly from the boxes, by volume, and
//! refused outside the solid are uniform over the solid.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::random::Random;

/// Halving stops when the boxes' volume is so many times the solid's.
const FULL: f64 = 8.0;

/// Halving stops before there are more boxes than this.
const BOXES: usize = 1 << 17;

/// By so much of the whole box a triangle may miss a box and still count as meeting it: a thousand
/// roundings of the turned coordinates.
const SLACK: f64 = 1e3 * f64::EPSILON;

/// Boxes whose union holds a solid.
#[derive(Clone, Debug)]
pub(crate) struct Cover {
    /// From the boxes' coordinates to the solid's.
    turn: Rotation3<f64>,
    center: Point3<f64>,
    boxes: Vec<Bounds<3>>,
    /// The volume of each box and all before it.
    volumes: Vec<f64>,
}

/// A box that meets the boundary, and the triangles in it.
struct Mixed {
    bounds: Bounds<3>,
    triangles: Vec<u32>,
}

impl Cover {
    /// A cover of the solid of this volume within `triangles`, of which `contains` tells the inside.
    /// `None` if there are no triangles.
    pub(crate) fn new(
        triangles: &[[Point3<f64>; 3]],
        volume: f64,
        contains: impl Fn(&Point3<f64>) -> bool,
    ) -> Option<Self> {
        let center = Bounds::of(triangles.iter().flatten()).center();
        let turn = principal_axes(triangles, &center)?;
        let turned: Vec<[Point3<f64>; 3]> = triangles
            .iter()
            .map(|corners| corners.map_each(|corner| (turn.inverse() * (corner - center)).into()))
            .collect();
        let whole = Bounds::of(turned.iter().flatten());
        let slack = Vector3::repeat(SLACK * whole.extent().amax());
        let mut cover = Self {
            turn,
            center,
            boxes: Vec::new(),
            volumes: Vec::new(),
        };
        let mut mixed = vec![Mixed {
            bounds: whole.grown(&slack),
            triangles: (0..turned.len() as u32).collect(),
        }];
        while is_loose(&mixed, volume) && 2 * mixed.len() + cover.boxes.len() <= BOXES {
            mixed = mixed
                .iter()
                .flat_map(|one| cover.halve(one, &turned, &slack, &contains))
                .collect();
        }
        cover.boxes.extend(mixed.iter().map(|one| one.bounds));
        let mut sum = 0.0;
        for one in &cover.boxes {
            sum += one.volume();
            cover.volumes.push(sum);
        }
        Some(cover)
    }

    /// A point uniform over the boxes.
    pub(crate) fn point(&self, random: &mut Random) -> Point3<f64> {
        let share = random.uniform() * self.volumes.last().copied().unwrap_or(0.0);
        let at = self.volumes.partition_point(|&sum| sum <= share);
        let at = at.min(self.boxes.len() - 1);
        self.center + self.turn * random.point(&self.boxes[at]).coords
    }

    /// The halves of a box that meet the boundary; a half that does not is kept if it lies inside.
    fn halve(
        &mut self,
        one: &Mixed,
        triangles: &[[Point3<f64>; 3]],
        slack: &Vector3<f64>,
        contains: &impl Fn(&Point3<f64>) -> bool,
    ) -> Vec<Mixed> {
        let axis = one.bounds.extent().imax();
        let (mut low, mut high) = (one.bounds, one.bounds);
        low.max[axis] = one.bounds.center()[axis];
        high.min[axis] = low.max[axis];
        let mut mixed = Vec::with_capacity(2);
        for bounds in [low, high] {
            let near = bounds.grown(slack);
            let meets = |&triangle: &u32| near.meets_triangle(&triangles[triangle as usize]);
            let triangles: Vec<u32> = one.triangles.iter().copied().filter(meets).collect();
            if !triangles.is_empty() {
                mixed.push(Mixed { bounds, triangles });
            } else if contains(&(self.center + self.turn * bounds.center().coords)) {
                self.boxes.push(bounds);
            }
        }
        mixed
    }
}

/// Whether the boxes that meet the boundary are much greater than the solid of this volume.
fn is_loose(mixed: &[Mixed], volume: f64) -> bool {
    let sum: f64 = mixed.iter().map(|one| one.bounds.volume()).sum();
    sum > FULL * volume
}

/// The axes of the corners' spread about `center`; `None` without corners or finite spread.
fn principal_axes(triangles: &[[Point3<f64>; 3]], center: &Point3<f64>) -> Option<Rotation3<f64>> {
    let mut spread = Matrix3::zeros();
    for corner in triangles.iter().flatten() {
        let arm = corner - center;
        spread += arm * arm.transpose();
    }
    // Neither over- nor underflows, whatever the unit of length.
    let size = spread.amax();
    if !size.is_normal() {
        return None;
    }
    let mut axes = (spread / size).symmetric_eigen().eigenvectors;
    if axes.determinant() < 0.0 {
        axes.swap_columns(0, 1);
    }
    Some(Rotation3::from_matrix_unchecked(axes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The surface of a box about the origin, turned.
    fn block(half: [f64; 3], turn: &Rotation3<f64>) -> Vec<[Point3<f64>; 3]> {
        let corner = |bits: usize| {
            let sign = |axis: usize| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
            turn * Point3::new(sign(0) * half[0], sign(1) * half[1], sign(2) * half[2])
        };
        const SIDES: [[usize; 4]; 6] = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let halves = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
        SIDES
            .into_iter()
            .flat_map(halves)
            .map(|corners| corners.map(corner))
            .collect()
    }

    #[test]
    fn a_turned_plate_fills_its_cover_evenly() {
        let turn = Rotation3::from_euler_angles(0.3, 0.7, 1.1);
        let half = [1.0, 0.5, 1e-7];
        let inside = |point: &Point3<f64>| {
            let back = turn.inverse() * point;
            (0..3).all(|axis| back[axis].abs() <= half[axis])
        };
        let cover = Cover::new(&block(half, &turn), 4e-7, inside).unwrap();
        let mut random = Random::new(1);
        let points: Vec<_> = (0..8000).map(|_| cover.point(&mut random)).collect();
        let kept: Vec<_> = points.iter().filter(|point| inside(point)).collect();
        assert!(kept.len() > 800, "{}", kept.len());
        for axis in 0..3 {
            let share = |point: &&Point3<f64>| (turn.inverse() * *point)[axis] / half[axis];
            let mean = kept.iter().map(share).sum::<f64>() / kept.len() as f64;
            // The deviation of the mean of n numbers uniform in [−1, 1] is (3n)^(−1/2).
            assert!(
                mean.abs() < 4.0 / (3.0 * kept.len() as f64).sqrt(),
                "{axis}: {mean}"
            );
        }
    }

    #[test]
    fn a_thin_shell_is_covered_by_small_boxes() {
        let still = Rotation3::identity();
        let (outer, inner) = (1.0, 1.0 - 1e-3);
        let mut triangles = block([outer; 3], &still);
        triangles.extend(
            block([inner; 3], &still)
                .iter()
                .map(|[a, b, c]| [*a, *c, *b]),
        );
        let inside = |point: &Point3<f64>| (inner..=outer).contains(&point.coords.amax());
        let volume = 8.0 * (1.0 - inner.powi(3));
        let cover = Cover::new(&triangles, volume, inside).unwrap();
        let mut random = Random::new(2);
        let points: Vec<_> = (0..20_000).map(|_| cover.point(&mut random)).collect();
        let kept = points.iter().filter(|point| inside(point)).count();
        assert!(kept > 200, "{kept}");
        // Every octant has its eighth.
        let octant = |point: &&Point3<f64>| inside(point) && point.iter().all(|x| *x > 0.0);
        let here = points.iter().filter(octant).count() as f64;
        let (expected, kept) = (kept as f64 / 8.0, kept as f64);
        assert!(
            (here - expected).abs() < 4.0 * (kept * 7.0 / 64.0).sqrt(),
            "{here} {expected}"
        );
    }

    #[test]
    fn nothing_has_no_cover() {
        assert!(Cover::new(&[], 1.0, |_| true).is_none());
    }
}
