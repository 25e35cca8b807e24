//! The walls of a domain grouped to patches with names.

use nalgebra::Vector3;

use crate::mesh::edges::EdgeTable;
use crate::mesh::surface::SurfaceMesh;

/// The sides of a box in the order of their walls.
const SIDES: [&str; 6] = ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"];

/// Walls by patches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum WallPatches {
    /// Six walls, `xmin` to `zmax`.
    Box,
    /// Every wall a patch, `wall0`, `wall1`, …
    Each,
    /// Per wall its patch, `wall0`, `wall1`, …
    Grouped(Vec<u32>),
}

impl WallPatches {
    /// The triangles of a surface, parted along edges where it turns by more than `angle` (degrees).
    /// Patches are numbered by their first triangles.
    #[must_use]
    pub(crate) fn by_features(surface: &SurfaceMesh, angle: f64) -> Self {
        let normal = |[a, b, c]: [nalgebra::Point3<f64>; 3]| {
            let area: Vector3<f64> = (b - a).cross(&(c - a));
            area.try_normalize(0.0).unwrap_or_default()
        };
        let normals: Vec<Vector3<f64>> = surface.all_corners().map(normal).collect();
        let least = angle.to_radians().cos();
        let mut first: Vec<u32> = (0..normals.len() as u32).collect();
        for edge in EdgeTable::of(&surface.triangles, surface.vertices.len()).iter() {
            let &[one, other] = edge.sides else { continue };
            let [one, other] = [one / 3, other / 3];
            if normals[one as usize].dot(&normals[other as usize]) > least {
                let [one, other] = [one, other].map(|triangle| root(&mut first, triangle));
                first[one.max(other) as usize] = one.min(other);
            }
        }
        let mut patches: Vec<u32> = Vec::with_capacity(first.len());
        let mut count = 0;
        for triangle in 0..first.len() as u32 {
            let first = root(&mut first, triangle);
            let patch = patches.get(first as usize).copied().unwrap_or(count);
            count = count.max(patch + 1);
            patches.push(patch);
        }
        Self::Grouped(patches)
    }

    /// The patch of a wall.
    #[must_use]
    pub(crate) fn of(&self, wall: u32) -> u32 {
        match self {
            Self::Grouped(patches) => patches[wall as usize],
            _ => wall,
        }
    }

    /// The name of a patch.
    #[must_use]
    pub(crate) fn name(&self, patch: u32) -> String {
        match (self, SIDES.get(patch as usize)) {
            (Self::Box, Some(side)) => (*side).to_owned(),
            _ => format!("wall{patch}"),
        }
    }
}

/// The first triangle of a group so far.
fn root(first: &mut [u32], mut triangle: u32) -> u32 {
    while first[triangle as usize] != triangle {
        let above = first[triangle as usize];
        first[triangle as usize] = first[above as usize];
        triangle = above;
    }
    triangle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{icosphere, unit_cube};

    #[test]
    fn a_cube_has_six_patches_and_a_ball_one() {
        let WallPatches::Grouped(patches) = WallPatches::by_features(&unit_cube(), 40.0) else {
            panic!("grouped")
        };
        assert_eq!(patches.len(), 12);
        assert_eq!(patches.iter().max(), Some(&5));
        let ball = WallPatches::by_features(&icosphere(3), 40.0);
        assert_eq!((ball.of(0), ball.of(700)), (0, 0));
        assert_eq!(ball.name(0), "wall0");
        assert_eq!(WallPatches::Box.name(3), "ymax");
    }
}
