//! The distance from a point to a surface: that to the nearest triangle, exact to rounding.

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::surface::SurfaceMesh;

/// Triangles in a tree of their boxes.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceDistance {
    triangles: Vec<[Point3<f64>; 3]>,
    tree: Bvh,
}

impl SurfaceDistance {
    pub(crate) fn new(surface: &SurfaceMesh) -> Self {
        let triangles: Vec<_> = surface.all_corners().collect();
        let tree = Bvh::new(triangles.iter().map(Bounds::of));
        Self { triangles, tree }
    }

    /// The distance of a point (L). `hint` is a triangle that may be near, and becomes the nearest: for
    /// points near each other the tree's boxes are then passed over at once.
    pub(crate) fn at(&self, point: &Point3<f64>, hint: &mut u32) -> f64 {
        let squared = |number: u32| point_triangle(point, &self.triangles[number as usize]);
        let Some((number, squared)) = self.tree.nearest(point, *hint, squared) else {
            return f64::NAN;
        };
        *hint = number;
        squared.sqrt()
    }
}

/// The square of the distance from a point to a triangle, by the region of the triangle's plane in which
/// its foot lies (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
fn point_triangle(point: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.norm_squared();
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.norm_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).norm_squared();
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.norm_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).norm_squared();
    }
    let va = d3 * d6 - d5 * d4;
    let (e, f) = (d4 - d3, d5 - d6);
    if va <= 0.0 && e >= 0.0 && f >= 0.0 {
        return (bp - (c - b) * (e / (e + f))).norm_squared();
    }
    let sum = va + vb + vc;
    (ap - ab * (vb / sum) - ac * (vc / sum)).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::trefoil;
    use nalgebra::Vector3;

    /// The least of the distances to many points of the triangle.
    fn by_points(point: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> f64 {
        let steps = 200;
        let places = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| [i, j]));
        let shares = places.map(|pair| pair.map(|k| f64::from(k) / f64::from(steps)));
        let place = |[u, v]: [f64; 2]| a + (b - a) * u + (c - a) * v;
        shares.fold(f64::INFINITY, |least, pair| {
            least.min((place(pair) - point).norm())
        })
    }

    #[test]
    fn distances_are_those_to_the_nearest_of_many_points() {
        let triangle = [[0.0, 0.0, 0.0], [2.0, 0.1, 0.0], [0.3, 1.0, 0.5]].map(Point3::from);
        for k in 0..1000_u32 {
            let along = |k: u32| f64::from(k % 10) * 0.4 - 1.3;
            let point = Point3::new(along(k), along(k / 10), along(k / 100));
            let (own, other) = (
                point_triangle(&point, &triangle).sqrt(),
                by_points(&point, &triangle),
            );
            assert!(
                own <= other + 1e-14 && other - own < 0.01,
                "{point}: {own} {other}"
            );
        }
    }

    #[test]
    fn the_tree_finds_what_a_scan_finds() {
        let surface = trefoil(0.4, 64, 8);
        let distance = SurfaceDistance::new(&surface);
        let bounds = surface.bounds();
        let mut hint = 0;
        for k in 0..500_u32 {
            let share = |k: u32| f64::from(k % 8) / 7.0;
            let share = Vector3::new(share(k), share(k / 8), share(k / 64));
            let place = bounds.min + bounds.extent().component_mul(&share);
            let scan = surface
                .all_corners()
                .map(|corners| point_triangle(&place, &corners));
            let scan = scan.fold(f64::INFINITY, f64::min).sqrt();
            assert!(
                (distance.at(&place, &mut hint) - scan).abs() < 1e-15,
                "{place}"
            );
        }
    }
}
