//! Errors of an octree's mass properties: \[BL\] eq. 8.
//!
//! Boxes are integrated exactly, so all errors are those of the shape. \[BL\] do not say which touched
//! leaves count as solid; here those count whose middle is inside, the choice whose errors come near
//! theirs (with all of them the mass is half as much again too large, with none two thirds too small).

use nalgebra::{Matrix3, Point3};

use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::LinearDensity;
use crate::mass::body::Body;
use crate::mesh::octree::Octree;

/// ε_C, ε_M and ε_Θ, not in percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OctreeError {
    /// The distance of the centers of mass (L); the paper's solids have unit height.
    pub(crate) center: f64,
    /// Relative error of the mass.
    pub(crate) mass: f64,
    /// Relative errors of the inertia tensor's rows, about each body's own center of mass, added up.
    pub(crate) inertia: f64,
}

impl OctreeError {
    /// The errors of an approximate body; not finite where it has no mass.
    #[must_use]
    pub(crate) fn of(approximate: &Body, exact: &Body) -> Self {
        let (one, other) = (approximate.inertia_center(), exact.inertia_center());
        let rows = one.row_iter().zip(other.row_iter());
        Self {
            center: (approximate.center_of_mass() - exact.center_of_mass()).norm(),
            mass: (approximate.mass - exact.mass).abs() / exact.mass,
            inertia: rows.map(|(a, b)| (a - b).norm() / b.norm()).sum(),
        }
    }
}

/// The mass properties of an octree's solid leaves; `density` is measured from `origin`, and so are the
/// moments.
#[must_use]
pub(crate) fn weigh_octree(tree: &Octree, density: &LinearDensity, origin: &Point3<f64>) -> Body {
    let (mut moments, mut volume) = (Moments::default(), 0.0);
    for leaf in tree.leaves.iter().filter(|leaf| leaf.is_solid) {
        let node = tree.node_box(leaf.place, leaf.level);
        moments += box_moments(&node, density, origin);
        volume += node.volume();
    }
    Body::from_moments(volume, 0.0, &moments, origin)
}

/// The moments of a box, measured from `origin`.
fn box_moments(node: &Bounds<3>, density: &LinearDensity, origin: &Point3<f64>) -> Moments {
    let arm = node.center() - origin;
    let mass = node.volume() * (density.value + density.gradient.dot(&arm));
    // ∫ y y^T / V about the middle.
    let spread = Matrix3::from_diagonal(&node.extent().map(|side| side * side / 12.0));
    let about_middle = Moments {
        mass,
        first: spread * density.gradient * node.volume(),
        second: spread * mass,
    };
    about_middle.translated(&arm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mass::density::{Ramp, SolidDensity};
    use crate::mass::weigh::weigh_surface;
    use crate::mesh::shapes::{cuboid, torus};
    use nalgebra::Vector3;

    #[test]
    fn an_octree_of_a_box_has_no_error() {
        let bounds = Bounds::from_corners([1.0, -2.0, 3.0], [2.0, 0.5, 3.7]);
        let surface = cuboid(&bounds);
        let ramp = Ramp {
            axis: 1,
            from: 0.0,
            to: 1.0,
        };
        let exact = weigh_surface(&surface, &SolidDensity::Ramp(ramp), &bounds).unwrap();
        let density = ramp.over(&bounds, &bounds.min);
        for depth in 0..4 {
            let body = weigh_octree(&Octree::new(&surface, depth), &density, &bounds.min);
            let error = OctreeError::of(&body, &exact);
            let all = [error.center, error.mass, error.inertia];
            assert!(all.iter().all(|error| *error < 1e-13), "{error:?}");
        }
    }

    #[test]
    fn errors_fall_with_the_depth() {
        let surface = torus(1.0, 0.4, 48, 24);
        let density = LinearDensity {
            value: 1.0,
            gradient: Vector3::zeros(),
        };
        let bounds = surface.bounds();
        let exact = weigh_surface(&surface, &SolidDensity::Constant(1.0), &bounds).unwrap();
        let mass_error = |depth| {
            let body = weigh_octree(&Octree::new(&surface, depth), &density, &bounds.min);
            OctreeError::of(&body, &exact).mass
        };
        assert!(
            mass_error(2) > 0.005 && mass_error(6) < 0.003,
            "{}",
            mass_error(2)
        );
    }
}
