//! The triangles of a cell's wall merged to few polygons.
//!
//! Faces on walls of one cell and one patch become one where no feature edge parts them, their union is a
//! disc, and none is turned too far from their mean. Where all of a smooth part cannot become one face, pairs
//! are merged as long as there are any, the least inclined ones first.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};

use crate::complex::edit_mesh::{EditMesh, loop_edges};
use crate::complex::wall_projection::WallProjection;
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;

/// Faces that become one.
struct FaceGroup {
    faces: Vec<u32>,
    corners: Vec<u32>,
    area: Vector3<f64>,
}

/// Merges the faces on the walls of every cell that are turned from their mean by at most `turn` (degrees).
/// `walls` gives the triangle of every face on a wall. Returns how many faces are gone.
pub(crate) fn merge_walls(
    mesh: &mut EditMesh,
    walls: &BTreeMap<u32, u32>,
    surface: &WallProjection,
    turn: f64,
) -> usize {
    let least = turn.to_radians().cos();
    let mut gone = 0;
    for cell in 0..mesh.of_cell.len() as u32 {
        let faces = mesh.of_cell[cell as usize].iter().copied();
        let faces: Vec<u32> = faces.filter(|&face| mesh.patch(face).is_some()).collect();
        for part in smooth_parts(mesh, &faces, walls, surface) {
            let count = part.len();
            let groups = merged(mesh, part, least);
            gone += count - groups.len();
            for group in groups {
                for &face in &group.faces[1..] {
                    mesh.set_loop(face, Vec::new());
                }
                mesh.set_loop(group.faces[0], group.corners);
            }
        }
    }
    mesh.keep();
    gone
}

/// Faces of one patch that hang together across edges that are no features.
fn smooth_parts(
    mesh: &EditMesh,
    faces: &[u32],
    walls: &BTreeMap<u32, u32>,
    surface: &WallProjection,
) -> Vec<Vec<u32>> {
    let normal = |face: u32| walls.get(&face).map(|&wall| surface.normals[wall as usize]);
    let mut at_edge: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut first: BTreeMap<u32, u32> = faces.iter().map(|&face| (face, face)).collect();
    for &face in faces {
        for (from, to) in loop_edges(&mesh.faces[face as usize]) {
            let Some(other) = at_edge.insert((from.min(to), from.max(to)), face) else {
                continue;
            };
            let cosine = normal(face)
                .zip(normal(other))
                .map(|(one, two)| one.dot(&two));
            let is_smooth = cosine.is_none_or(|cosine| cosine > surface.least_cosine);
            if is_smooth && mesh.patch(face) == mesh.patch(other) {
                let [one, other] = [face, other].map(|face| root(&first, face));
                first.insert(one.max(other), one.min(other));
            }
        }
    }
    let mut parts: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &face in faces {
        parts.entry(root(&first, face)).or_default().push(face);
    }
    parts.into_values().collect()
}

fn root(first: &BTreeMap<u32, u32>, mut face: u32) -> u32 {
    while first[&face] != face {
        face = first[&face];
    }
    face
}

/// The faces of a smooth part as few polygons.
fn merged(mesh: &mut EditMesh, part: Vec<u32>, least: f64) -> Vec<FaceGroup> {
    let single = |mesh: &mut EditMesh, face: u32| FaceGroup {
        area: mesh.face_shape(face).area,
        corners: mesh.faces[face as usize].clone(),
        faces: vec![face],
    };
    let mut groups: Vec<FaceGroup> = Vec::new();
    for &face in &part {
        groups.push(single(mesh, face));
    }
    let areas: BTreeMap<u32, Vector3<f64>> = part
        .iter()
        .map(|&face| (face, mesh.face_shape(face).area))
        .collect();
    let whole: Vec<&FaceGroup> = groups.iter().collect();
    if let Some(one) = union(&whole, &areas, least) {
        return vec![one];
    }
    let mut refused = BTreeSet::new();
    while let Some((one, other, union)) = best_pair(&groups, (&areas, least), &mut refused) {
        groups.swap_remove(one.max(other));
        groups.swap_remove(one.min(other));
        groups.push(union);
    }
    groups
}

/// The two groups that may be merged and are inclined least, and their union.
fn best_pair(
    groups: &[FaceGroup],
    (areas, least): (&BTreeMap<u32, Vector3<f64>>, f64),
    refused: &mut BTreeSet<(Vec<u32>, Vec<u32>)>,
) -> Option<(usize, usize, FaceGroup)> {
    let mut at_edge: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    let mut pairs = BTreeSet::new();
    for (place, group) in groups.iter().enumerate() {
        for (from, to) in loop_edges(&group.corners) {
            if let Some(other) = at_edge.insert((from.min(to), from.max(to)), place) {
                pairs.insert((other, place));
            }
        }
    }
    let cosine = |&(one, other): &(usize, usize)| {
        let [one, other] = [one, other].map(|place| groups[place].area);
        one.dot(&other) / (one.norm() * other.norm()).max(1e-300)
    };
    let mut pairs: Vec<(f64, (usize, usize))> =
        pairs.iter().map(|pair| (cosine(pair), *pair)).collect();
    pairs.sort_by(|one, other| other.0.total_cmp(&one.0).then(one.1.cmp(&other.1)));
    for (_, (one, other)) in pairs {
        let key = (groups[one].faces.clone(), groups[other].faces.clone());
        if refused.contains(&key) {
            continue;
        }
        match union(&[&groups[one], &groups[other]], areas, least) {
            Some(union) => return Some((one, other, union)),
            None => refused.insert(key),
        };
    }
    None
}

/// The union of groups, if it is a disc and the cosine of no face with the mean is below `least`.
fn union(
    groups: &[&FaceGroup],
    areas: &BTreeMap<u32, Vector3<f64>>,
    least: f64,
) -> Option<FaceGroup> {
    let area: Vector3<f64> = groups.iter().map(|group| group.area).sum();
    let faces: Vec<u32> = groups
        .iter()
        .flat_map(|group| group.faces.clone())
        .collect();
    let is_near = |face: &u32| {
        let own = areas[face];
        own.dot(&area) >= (least - 1e-12) * own.norm() * area.norm()
    };
    if !faces.iter().all(is_near) {
        return None;
    }
    let loops: Vec<&[u32]> = groups
        .iter()
        .map(|group| group.corners.as_slice())
        .collect();
    let corners = outline(&loops)?;
    Some(FaceGroup {
        faces,
        corners,
        area,
    })
}

/// The loop around several loops; none where there are several, or one that touches itself.
#[must_use]
pub(crate) fn outline(loops: &[&[u32]]) -> Option<Vec<u32>> {
    let mut edges: Vec<(u32, u32)> = loops
        .iter()
        .flat_map(|corners| loop_edges(corners))
        .collect();
    edges.sort_unstable();
    if edges.windows(2).any(|pair| pair[0] == pair[1]) {
        return None;
    }
    let rim = edges
        .iter()
        .filter(|&&(from, to)| edges.binary_search(&(to, from)).is_err());
    let rim: Vec<(u32, u32)> = rim.copied().collect();
    if rim.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        return None;
    }
    let start = rim.first()?.0;
    let mut corners = vec![start];
    let mut here = start;
    loop {
        let place = rim.binary_search_by_key(&here, |edge| edge.0).ok()?;
        here = rim[place].1;
        if here == start {
            break;
        }
        if corners.len() > rim.len() {
            return None;
        }
        corners.push(here);
    }
    (corners.len() == rim.len() && corners.len() >= 3).then_some(corners)
}

/// Pins the points in the corners of the walls. They lie within `reach` (L) of them.
pub(crate) fn pin_corners(mesh: &mut EditMesh, surface: &WallProjection, reach: f64) {
    let on_walls = (0..mesh.points.len() as u32).filter(|&at| !mesh.patches_at(at).is_empty());
    let on_walls: Vec<u32> = on_walls.collect();
    let place = |number: u32| mesh.points[on_walls[number as usize] as usize];
    let boxes = (0..on_walls.len() as u32).map(|number| Bounds::of(&[place(number)]));
    let tree = Bvh::new(boxes);
    let mut pinned = BTreeSet::new();
    for corner in &surface.corners {
        if let Some(nearest) = nearest(&tree, corner, reach, place) {
            pinned.insert(on_walls[nearest as usize]);
        }
    }
    mesh.pinned = pinned;
}

fn nearest(
    tree: &Bvh,
    point: &Point3<f64>,
    reach: f64,
    place: impl Fn(u32) -> Point3<f64>,
) -> Option<u32> {
    let mut best = None;
    let is_near = |bounds: &Bounds<3>| (bounds.clamp(point) - point).norm() < reach;
    tree.visit(is_near, |number| {
        let distance = (place(number) - point).norm();
        if best.is_none_or(|(known, _)| distance < known) {
            best = Some((distance, number));
        }
    });
    best.map(|(_, number)| number)
}
