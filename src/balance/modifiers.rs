//! A density as closed bodies of one density each, which slicers take as modifier meshes.
//!
//! A clamped ramp is parted by planes across its direction: what lies below its start, slabs of equal rise,
//! what lies above its end. Cells are united by levels of their density. A body has the mean density of what
//! it holds, so that the mass stays; the center that the bodies give together is weighed exactly.

use nalgebra::{Point3, Vector3};

use crate::balance::dual::DensityRange;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::constant;
use crate::mesh::poly_mesh::PolyMesh;
use crate::mesh::polygon::triangulate;
use crate::mesh::slabs::slabs;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::compact;

/// Volumes below this share of the solid are rounding.
const NO_VOLUME: f64 = 1e-12;

/// A closed body of one density.
#[derive(Clone, Debug)]
pub(crate) struct ModifierBody {
    /// Its surface.
    pub(crate) surface: SurfaceMesh,
    /// Its density.
    pub(crate) density: f64,
    /// Its moments at density 1.
    moments: Moments,
    /// Where they are measured from.
    origin: Point3<f64>,
}

impl ModifierBody {
    fn new(surface: SurfaceMesh, density: impl Fn(&Moments) -> f64, origin: &Point3<f64>) -> Self {
        let moments = constant(&surface.vertices, &surface.triangles, origin);
        Self {
            density: density(&moments),
            surface,
            moments,
            origin: *origin,
        }
    }

    /// Its moments at its density, from another point.
    pub(crate) fn weigh(&self, origin: &Point3<f64>) -> Moments {
        self.moments.translated(&(self.origin - origin)) * self.density
    }
}

/// Up to `count` bodies of clamp(lo, hi, value + gradient·y) in the solid within `surface`.
pub(crate) fn of_ramp(
    surface: &SurfaceMesh,
    range: &DensityRange,
    value: f64,
    gradient: &Vector3<f64>,
    count: usize,
) -> Vec<ModifierBody> {
    let bounds = surface.bounds();
    let origin = bounds.center();
    if gradient.norm() <= 0.0 {
        let whole = ModifierBody::new(surface.clone(), |_| range.clamp(value), &origin);
        return vec![whole];
    }
    let densities = surface
        .vertices
        .iter()
        .map(|v| value + gradient.dot(&v.coords));
    let (least, most) = densities.fold((f64::MAX, f64::MIN), |(a, b), d| (a.min(d), b.max(d)));
    let levels = levels(range, [least, most], count);
    let offsets: Vec<_> = levels.iter().map(|level| level - value).collect();
    let parts = slabs(surface, gradient, &offsets).into_iter();
    let bodies = parts.map(|part| {
        // A slab's mean density is that at its centroid, or the bound beyond which it lies.
        let mean = |moments: &Moments| {
            let middle = origin + moments.center();
            range.clamp(value + gradient.dot(&middle.coords))
        };
        ModifierBody::new(part, mean, &origin)
    });
    filled(bodies.collect())
}

/// The densities at which a ramp is parted.
fn levels(range: &DensityRange, [least, most]: [f64; 2], count: usize) -> Vec<f64> {
    let (low, high) = (range.low.max(least), range.high.min(most));
    let outer = usize::from(least < range.low) + usize::from(most > range.high);
    let inner = count.saturating_sub(outer).max(1);
    let between = (1..inner).map(|k| low + (high - low) * k as f64 / inner as f64);
    let mut levels: Vec<f64> = between.collect();
    if least < range.low {
        levels.insert(0, low);
    }
    if most > range.high {
        levels.push(high);
    }
    levels
}

/// Up to `count` bodies of cells with one density each; `moments` are the cells', from `origin`.
pub(crate) fn of_cells(
    mesh: &PolyMesh,
    densities: &[f64],
    moments: &[Moments],
    origin: &Point3<f64>,
    count: usize,
) -> Vec<ModifierBody> {
    let range = densities
        .iter()
        .fold([f64::MAX, f64::MIN], |[a, b], &d| [a.min(d), b.max(d)]);
    let width = (range[1] - range[0]) / count as f64;
    let level = |density: f64| match width > 0.0 {
        true => (((density - range[0]) / width) as usize).min(count - 1),
        false => 0,
    };
    let levels: Vec<usize> = densities.iter().map(|&density| level(density)).collect();
    let bodies = (0..count).map(|wanted| {
        let within = (0..densities.len()).filter(|&cell| levels[cell] == wanted);
        let (volume, mass) = within.fold((0.0, 0.0), |(volume, mass), cell| {
            let own = moments[cell].mass;
            (volume + own, mass + own * densities[cell])
        });
        let surface = united(mesh, |cell| levels[cell] == wanted);
        ModifierBody::new(surface, |_| mass / volume, origin)
    });
    filled(bodies.collect())
}

/// The surface of the cells wanted.
fn united(mesh: &PolyMesh, is_wanted: impl Fn(usize) -> bool) -> SurfaceMesh {
    let mut surface = SurfaceMesh {
        vertices: mesh.points.clone(),
        triangles: Vec::new(),
    };
    for face in 0..mesh.face_count() {
        let inside = is_wanted(mesh.owner[face] as usize);
        let beyond = mesh.neighbor_of(face).is_some_and(&is_wanted);
        if inside == beyond {
            continue;
        }
        let mut corners = mesh.face(face).to_vec();
        if beyond {
            corners.reverse();
        }
        triangulate(&mesh.points, &corners, &mut surface.triangles);
    }
    compact(&mut surface.vertices, &mut surface.triangles);
    surface
}

/// Those that are not empty.
fn filled(bodies: Vec<ModifierBody>) -> Vec<ModifierBody> {
    let whole: f64 = bodies.iter().map(|body| body.moments.mass).sum();
    let is_filled = |body: &ModifierBody| body.moments.mass > NO_VOLUME * whole;
    bodies.into_iter().filter(is_filled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{torus, unit_cube};

    fn weigh(bodies: &[ModifierBody], origin: &Point3<f64>) -> Moments {
        let weighed = bodies.iter().map(|body| body.weigh(origin));
        weighed.fold(Moments::default(), |sum, body| sum + body)
    }

    #[test]
    fn bodies_of_a_ramp_keep_its_mass_and_approach_its_center() {
        let range = DensityRange {
            low: 1.0,
            high: 4.0,
            prefer: 1.0,
        };
        // In the unit cube: 1 below x = 1/4, 4 above x = 3/4, slope 6 between.
        let (cube, slope) = (unit_cube(), Vector3::new(6.0, 0.0, 0.0));
        let origin = Point3::origin();
        let exact = 0.25 * (1.0 / 8.0) + 0.25 * 4.0 * (7.0 / 8.0) + 2.5 * 0.25 + 6.0 * 0.125 / 12.0;
        for count in [3, 4, 10, 40] {
            let bodies = of_ramp(&cube, &range, -0.5, &slope, count);
            assert_eq!(bodies.len(), count);
            let sum = weigh(&bodies, &origin);
            assert!((sum.mass - 2.5).abs() < 1e-14, "{count}: {}", sum.mass);
            // n slabs of the ramp miss 1/16 of the first moment by n².
            let missed = 0.0625 / ((count - 2) as f64).powi(2);
            assert!((sum.first.x + missed - exact).abs() < 1e-14, "{count}");
            assert!((sum.first.y - 1.25).abs() < 1e-14);
        }
        let ring = torus(1.0, 0.3, 24, 12);
        let bodies = of_ramp(&ring, &range, 2.0, &Vector3::new(0.5, 0.4, 1.0), 6);
        let volume: f64 = bodies.iter().map(|body| body.surface.volume()).sum();
        assert!((volume / ring.volume() - 1.0).abs() < 1e-13);
    }
}
