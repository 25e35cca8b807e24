//! Nesting of the components of a surface by winding numbers.
//!
//! A component inside an even number of others bounds a part of the solid from outside, one
//! inside an odd number bounds a cavity. Inside is decided by the winding number, the sum of
//! the solid angles of the triangles over 4π: 1 inside and 0 outside an outward component, in
//! between only on the surface itself.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::mesh::orient::{EdgePlaces, Orientation};
use crate::mesh::report::SurfaceReport;
use crate::mesh::surface::{SurfaceMesh, cone_volume};

/// The number of vertices of a component that are tested at most. One suffices unless it lies on the
/// other component: then the one whose winding number is nearest an integer decides.
const PROBES: usize = 5;

/// Turns the closed, consistently oriented components of `surface` outward, cavities inward,
/// and reports how many there are of each.
pub(crate) fn turn_outward(
    surface: &mut SurfaceMesh,
    places: &EdgePlaces<'_>,
    orientation: &Orientation,
    report: &mut SurfaceReport,
) {
    let Sides { volumes, cavities } = sides(surface, orientation);
    report.components = orientation.components;
    report.cavities = cavities.iter().filter(|&&is_cavity| is_cavity).count();
    let mut reported = vec![false; orientation.components];
    for (at, triangle) in surface.triangles.iter_mut().enumerate() {
        let component = orientation.component[at] as usize;
        if (volumes[component] < 0.0) != cavities[component] {
            triangle.swap(1, 2);
            if !std::mem::replace(&mut reported[component], true) {
                report.inverted.add(places.numbers[at]);
            }
        }
    }
}

/// The signed volume of every component and whether it is a cavity.
struct Sides {
    volumes: Vec<f64>,
    cavities: Vec<bool>,
}

fn sides(surface: &SurfaceMesh, orientation: &Orientation) -> Sides {
    if orientation.components == 1 {
        let (volumes, cavities) = (vec![surface.volume()], vec![false]);
        return Sides { volumes, cavities };
    }
    let parts = parts(surface, orientation);
    let depth = |part: &SurfacePart| parts.iter().filter(|outer| outer.encloses(part)).count();
    Sides {
        volumes: parts.iter().map(|part| part.volume).collect(),
        cavities: parts.iter().map(|part| depth(part) % 2 == 1).collect(),
    }
}

/// One component.
struct SurfacePart {
    triangles: Vec<[Point3<f64>; 3]>,
    bounds: Bounds<3>,
    volume: f64,
}

fn parts(mesh: &SurfaceMesh, orientation: &Orientation) -> Vec<SurfacePart> {
    let mut triangles = vec![Vec::new(); orientation.components];
    for (corners, &number) in mesh.all_corners().zip(&orientation.component) {
        triangles[number as usize].push(corners);
    }
    triangles.into_iter().map(SurfacePart::of).collect()
}

impl SurfacePart {
    fn of(triangles: Vec<[Point3<f64>; 3]>) -> Self {
        let bounds = Bounds::of(triangles.iter().flatten());
        let apex = bounds.center();
        let volume = triangles
            .iter()
            .map(|corners| cone_volume(&apex, corners))
            .sum();
        Self {
            triangles,
            bounds,
            volume,
        }
    }

    /// Whether `inner`, another component, lies inside this one.
    fn encloses(&self, inner: &Self) -> bool {
        if std::ptr::eq(self, inner) || !holds(&self.bounds, &inner.bounds) {
            return false;
        }
        let stride = inner.triangles.len().div_ceil(PROBES);
        let probes = inner
            .triangles
            .iter()
            .step_by(stride)
            .map(|corners| corners[0]);
        let windings = probes.map(|probe| self.winding(&probe).abs());
        let unclear = |winding: &f64| (winding - winding.round()).abs();
        let clearest = windings.min_by(|one, other| unclear(one).total_cmp(&unclear(other)));
        clearest.is_some_and(|winding| winding > 0.5)
    }

    fn winding(&self, point: &Point3<f64>) -> f64 {
        let angles = self
            .triangles
            .iter()
            .map(|corners| solid_angle(point, corners));
        angles.sum::<f64>() / (4.0 * std::f64::consts::PI)
    }
}

fn holds(outer: &Bounds<3>, inner: &Bounds<3>) -> bool {
    outer.contains(&inner.min) && outer.contains(&inner.max)
}

/// The signed solid angle of a triangle seen from `point`: van Oosterom & Strackee, "The solid
/// angle of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983), eq. 8.
fn solid_angle(point: &Point3<f64>, corners: &[Point3<f64>; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let [la, lb, lc] = [a.norm(), b.norm(), c.norm()];
    let height = a.dot(&b.cross(&c));
    let base = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    2.0 * height.atan2(base)
}
