//! The walls of a domain grouped to patches with names.

use nalgebra::Vector3;

use crate::mesh::edges::EdgeTable;
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};
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
    /// Per wall its patch, and per patch its name; several may have one name.
    Named(Vec<u32>, Vec<String>),
}

impl WallPatches {
    /// The triangles of a surface, parted along edges where it turns by more than `angle` (degrees).
    /// Patches are numbered by their first triangles.
    #[must_use]
    pub(crate) fn by_features(surface: &SurfaceMesh, angle: f64) -> Self {
        Self::Grouped(parted(surface, angle, |_, _| true))
    }

    /// The same, parted between groups of triangles too, whose names the patches take. Names are words that
    /// OpenFOAM reads.
    #[must_use]
    pub(crate) fn by_groups(
        surface: &SurfaceMesh,
        angle: f64,
        groups: &[u32],
        names: &[String],
    ) -> Self {
        let is_one = |one: u32, other: u32| groups[one as usize] == groups[other as usize];
        let patches = parted(surface, angle, is_one);
        let count = patches.iter().max().map_or(0, |&last| last as usize + 1);
        let mut named = vec![String::new(); count];
        for (triangle, &patch) in patches.iter().enumerate() {
            if named[patch as usize].is_empty() {
                named[patch as usize] = word(&names[groups[triangle] as usize]);
            }
        }
        Self::Named(patches, named)
    }

    /// The patch of a wall.
    #[must_use]
    pub(crate) fn of(&self, wall: u32) -> u32 {
        match self {
            Self::Grouped(patches) | Self::Named(patches, _) => patches[wall as usize],
            _ => wall,
        }
    }

    /// The name of a patch.
    #[must_use]
    pub(crate) fn name(&self, patch: u32) -> String {
        match (self, SIDES.get(patch as usize)) {
            (Self::Named(_, names), _) => names[patch as usize].clone(),
            (Self::Box, Some(side)) => (*side).to_owned(),
            _ => format!("wall{patch}"),
        }
    }
}

/// Per triangle its patch: connected triangles that no edge parts at which the surface turns by more than
/// `angle` (degrees), and of which each two neighbors may be in one.
fn parted(surface: &SurfaceMesh, angle: f64, may_join: impl Fn(u32, u32) -> bool) -> Vec<u32> {
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
        let is_smooth = normals[one as usize].dot(&normals[other as usize]) > least;
        if is_smooth && may_join(one, other) {
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
    patches
}

/// A name as OpenFOAM reads it: letters, digits and a few signs, the first no digit.
fn word(name: &str) -> String {
    let sign = |sign: char| match sign.is_ascii_alphanumeric() || "_-.".contains(sign) {
        true => sign,
        false => '_',
    };
    let word: String = name.trim().chars().map(sign).collect();
    match word.chars().next() {
        None => "wall".to_owned(),
        Some(first) if first.is_ascii_alphabetic() || first == '_' => word,
        Some(_) => format!("group{word}"),
    }
}

/// A mesh whose patches of one name are one patch. Periods are left as they are.
#[must_use]
pub(crate) fn joined_by_name(mesh: &PolyMesh) -> PolyMesh {
    let mut order: Vec<(&str, Vec<usize>)> = Vec::new();
    for patch in &mesh.patches {
        let faces = patch.start..patch.start + patch.count;
        match order.iter_mut().find(|(name, _)| *name == patch.name) {
            Some((_, known)) => known.extend(faces),
            None => order.push((&patch.name, faces.collect())),
        }
    }
    let has_periods = mesh.patches.iter().any(|patch| patch.partner.is_some());
    if has_periods || order.len() == mesh.patches.len() {
        return mesh.clone();
    }
    let mut joined = PolyMesh::default();
    joined.points.clone_from(&mesh.points);
    joined.neighbor.clone_from(&mesh.neighbor);
    joined.sites.clone_from(&mesh.sites);
    joined.cell_count = mesh.cell_count;
    let mut push = |face: usize| {
        joined.push_corners(mesh.face(face).iter().copied());
        joined.owner.push(mesh.owner[face]);
    };
    (0..mesh.neighbor.len()).for_each(&mut push);
    let mut start = mesh.neighbor.len();
    let mut patches = Vec::new();
    for (name, mut faces) in order {
        faces.sort_by_key(|&face| mesh.owner[face]);
        patches.push(MeshPatch {
            name: name.to_owned(),
            start,
            count: faces.len(),
            partner: None,
        });
        start += faces.len();
        faces.into_iter().for_each(&mut push);
    }
    joined.patches = patches;
    joined
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

    #[test]
    fn groups_part_a_plane_and_name_its_patches() {
        let cube = unit_cube();
        let groups: Vec<u32> = (0..12).map(|triangle| u32::from(triangle == 0)).collect();
        let names = ["rest of it".to_owned(), "2nd inlet".to_owned()];
        let patches = WallPatches::by_groups(&cube, 40.0, &groups, &names);
        let all: Vec<u32> = (0..12).map(|triangle| patches.of(triangle)).collect();
        assert_eq!(all.iter().max(), Some(&6), "one plane is two patches");
        assert_eq!(patches.name(patches.of(0)), "group2nd_inlet");
        assert_eq!(patches.name(patches.of(5)), "rest_of_it");
        let mut mesh = PolyMesh::default();
        for face in 0..12_u32 {
            mesh.push_corners([face, face + 1, face + 2]);
            mesh.owner.push(0);
            mesh.patches.push(MeshPatch {
                name: patches.name(patches.of(face)),
                start: face as usize,
                count: 1,
                partner: None,
            });
        }
        let joined = joined_by_name(&mesh);
        let counts: Vec<_> = joined
            .patches
            .iter()
            .map(|patch| (patch.name.as_str(), patch.start, patch.count))
            .collect();
        assert_eq!(counts, [("group2nd_inlet", 0, 1), ("rest_of_it", 1, 11)]);
        assert_eq!(joined.face(0), mesh.face(0));
    }
}
