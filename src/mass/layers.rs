//! Moments of solids whose density is linear in layers between parallel planes, from their surfaces.
//!
//! A layer is what lies between two planes. Its signed cones have their apex in its lower plane (the layer
//! below all planes: in its upper one), so the cap there has none; the upper cap is summed from the edges
//! that clipping leaves in the upper plane, with a point of that plane. Thin layers lose no digits that
//! way: all cones are as small as the layer and its surface. The density is linear in every cone:
//! ∫ρ, ∫ρ y and ∫ρ y yᵀ follow from its values at the four corners (\[BL\] eq. 1-3).

use std::ops::Range;

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::geometry::double_double::six_volume;
use crate::geometry::moments::Moments;
use crate::integrals::clip::ClippedPolygon;
use crate::integrals::mesh_moments::Precision;
use crate::integrals::pairwise::sum_by_halves;

/// The density between two planes direction · y = s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layer {
    /// s where it begins; −∞ below all planes.
    pub(crate) from: f64,
    /// s where it ends; ∞ above all planes.
    pub(crate) to: f64,
    /// The density where it begins; below all planes, where it ends.
    pub(crate) value: f64,
    /// The density's growth per length.
    pub(crate) slope: f64,
}

/// The ten moments of a solid within a closed surface, measured from `origin`; the layers fill space,
/// `direction` is a unit vector.
pub(crate) fn layered_moments(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    layers: &[Layer],
    direction: &Vector3<f64>,
    origin: &Point3<f64>,
) -> Moments {
    let used = triangles.iter().flatten().map(|&v| &vertices[v as usize]);
    let bounds = Bounds::of(used);
    let middle = bounds.center();
    let along = direction.dot(&middle.coords);
    let reach = direction.abs().dot(&bounds.extent()) * 0.5;
    let precision = Precision::for_solid(vertices, triangles, &middle);
    let mut total = Moments::default();
    for layer in layers {
        if layer.from > along + reach || layer.to < along - reach {
            continue;
        }
        let solid = SolidLayer::new(layer, direction, (&middle, reach), precision);
        let sum = sum_by_halves(triangles.len(), &|range: Range<usize>| {
            let mut sum = Moments::default();
            for triangle in &triangles[range] {
                let corners = triangle.map_each(|v| vertices[v as usize] - solid.apex);
                solid.add(&mut sum, &corners);
            }
            sum
        });
        total += sum.translated(&(solid.apex - origin));
    }
    total
}

/// A layer as its cones see it, all measured from their apex.
struct SolidLayer {
    apex: Point3<f64>,
    direction: Vector3<f64>,
    /// The heights between which it lies.
    low: f64,
    high: f64,
    /// The point of the upper plane over the apex.
    top: Vector3<f64>,
    /// The density at the apex.
    value: f64,
    slope: f64,
    precision: Precision,
}

impl SolidLayer {
    fn new(
        layer: &Layer,
        direction: &Vector3<f64>,
        (middle, reach): (&Point3<f64>, f64),
        precision: Precision,
    ) -> Self {
        let along = direction.dot(&middle.coords);
        // Planes that miss the body's box cut nothing, and may be far away.
        let from = if layer.from > along - reach {
            layer.from
        } else {
            f64::NEG_INFINITY
        };
        let to = if layer.to < along + reach {
            layer.to
        } else {
            f64::INFINITY
        };
        let base = [from, to]
            .into_iter()
            .find(|s| s.is_finite())
            .unwrap_or(along);
        let reference = if layer.from.is_finite() {
            layer.from
        } else {
            layer.to
        };
        Self {
            apex: middle + direction * (base - along),
            direction: *direction,
            low: if from.is_finite() { 0.0 } else { from },
            high: to - base,
            top: direction * (to - base),
            value: layer.value + layer.slope * (base - reference),
            slope: layer.slope,
            precision,
        }
    }

    fn density(&self, corner: &Vector3<f64>) -> f64 {
        self.value + self.slope * self.direction.dot(corner)
    }

    /// Adds the cones of a triangle's part in the layer, and of what it adds to the upper cap.
    fn add(&self, sum: &mut Moments, corners: &[Vector3<f64>; 3]) {
        let heights = corners.map_each(|corner| self.direction.dot(&corner));
        let lowest = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if highest <= self.low || lowest >= self.high {
            return;
        }
        if lowest > self.low && highest < self.high {
            return self.add_cone(sum, corners);
        }
        let part = ClippedPolygon::of(corners, &heights.map_each(|height| height - self.low));
        let part = self.below_top(part.corners());
        for triangle in part.triangles() {
            self.add_cone(sum, &triangle);
        }
        if let (Some([leaves, returns]), true) = (part.edge, self.high > 0.0) {
            self.add_cone(sum, &[self.top, returns, leaves]);
        }
    }

    /// What of a polygon of at most four corners lies below the layer's upper plane.
    fn below_top(&self, corners: &[Vector3<f64>]) -> ClippedPolygon {
        let mut depths = [0.0; 4];
        for (depth, corner) in depths.iter_mut().zip(corners) {
            *depth = self.high - self.direction.dot(corner);
        }
        ClippedPolygon::of(corners, &depths[..corners.len()])
    }

    /// Adds the cone of linear density over a triangle: with σ = Σ ρ_i, S = Σ v_i, u_i = (σ/2 + ρ_i) v_i
    /// and U = Σ u_i, 6V times σ/24, (σ S/2 + U)/120 and (Σ u_i v_iᵀ + (U Sᵀ + S Uᵀ)/2)/360.
    fn add_cone(&self, sum: &mut Moments, corners: &[Vector3<f64>; 3]) {
        let six = self.six_volume(corners);
        let densities = corners.each_ref().map_each(|corner| self.density(corner));
        let half = 0.5 * (self.value + densities.iter().sum::<f64>());
        let total: Vector3<f64> = corners.iter().sum();
        let mut weighed = Vector3::zeros();
        for (corner, density) in corners.iter().zip(densities) {
            let u = corner * (half + density);
            weighed += u;
            sum.second += u * corner.transpose() * (six / 360.0);
        }
        sum.mass += half * six / 12.0;
        sum.first += (total * half + weighed) * (six / 120.0);
        let mixed = weighed * total.transpose();
        sum.second += (mixed + mixed.transpose()) * (six / 720.0);
    }

    fn six_volume(&self, [a, b, c]: &[Vector3<f64>; 3]) -> f64 {
        match self.precision {
            Precision::Single => a.dot(&b.cross(c)),
            Precision::Double => {
                let [a, b, c] = [a, b, c].map_each(|corner| Point3::from(*corner));
                six_volume(&Point3::origin(), [&a, &b, &c])
            }
        }
    }
}
