//! A cell cut in two by a plane.
//!
//! Vertices near the plane count as on it. Every face with corners on both sides is divided between the two
//! places where its loop passes the plane; the rim of one side is closed by a new face. New vertices on walls
//! are moved to the nearest place of the wall.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::complex::edit_mesh::{Behind, EditMesh, loop_edges};
use crate::complex::wall_projection::WallProjection;

/// A plane that cuts a cell.
#[derive(Clone, Debug)]
pub(crate) struct CuttingPlane {
    /// A point of it.
    pub(crate) point: Point3<f64>,
    /// Its unit normal.
    pub(crate) normal: Vector3<f64>,
    /// Vertices that lie on it.
    pub(crate) on: Vec<u32>,
    /// How near (L) others count as on it.
    pub(crate) reach: f64,
}

/// A corner of a face: a vertex, or where an edge passes the plane; and its side.
#[derive(Clone, Copy, Debug)]
struct Corner {
    place: CornerPlace,
    side: i8,
}

#[derive(Clone, Copy, Debug)]
enum CornerPlace {
    Vertex(u32),
    Edge(u32, u32),
}

/// What becomes of a face.
enum Division {
    Above,
    Below,
    /// The loops of both sides.
    Both(Vec<Corner>, Vec<Corner>),
}

/// Cuts `cell` by a plane: what lies above becomes a new cell, which is returned. None, perhaps with the
/// mesh half changed, where the plane does not part it in two.
pub(crate) fn cut(
    mesh: &mut EditMesh,
    cell: u32,
    plane: &CuttingPlane,
    walls: &WallProjection,
) -> Option<u32> {
    let mut faces = mesh.of_cell[cell as usize].clone();
    faces.sort_unstable();
    let mut heights = BTreeMap::new();
    for &face in &faces {
        for &corner in &mesh.faces[face as usize] {
            let height = plane
                .normal
                .dot(&(mesh.points[corner as usize] - plane.point));
            let is_on = plane.on.contains(&corner) || height.abs() < plane.reach;
            heights.insert(corner, if is_on { 0.0 } else { height });
        }
    }
    let is_cut = [1.0, -1.0].map(|sign| heights.values().any(|height| height * sign > 0.0));
    if is_cut != [true; 2] {
        return None;
    }
    let divisions: Option<Vec<(u32, Division)>> = faces
        .iter()
        .map(|&face| Some((face, divide(&mesh.faces[face as usize], &heights)?)))
        .collect();
    let divisions = divisions?;
    let mut crossings = BTreeMap::new();
    for (_, division) in &divisions {
        let Division::Both(above, _) = division else {
            continue;
        };
        for corner in above {
            if let CornerPlace::Edge(a, b) = corner.place {
                crossings.entry((a.min(b), a.max(b))).or_insert(0_u32);
            }
        }
    }
    for (&(a, b), point) in &mut crossings {
        *point = split_edge(
            mesh,
            (a, b),
            heights[&a] / (heights[&a] - heights[&b]),
            walls,
        )?;
    }
    let upper = mesh.add_cell(mesh.sites.get(cell as usize).copied().unwrap_or(0));
    for (face, division) in divisions {
        apply(mesh, (cell, upper), face, division, &crossings);
    }
    close(mesh, cell, upper)?;
    Some(upper)
}

/// Divides a loop at the plane; none where it passes it more than twice.
fn divide(corners: &[u32], heights: &BTreeMap<u32, f64>) -> Option<Division> {
    let side = |corner: u32| {
        let height = heights[&corner];
        i8::from(height > 0.0) - i8::from(height < 0.0)
    };
    let mut all = Vec::new();
    for (from, to) in loop_edges(corners) {
        all.push(Corner {
            place: CornerPlace::Vertex(from),
            side: side(from),
        });
        if side(from) * side(to) < 0 {
            all.push(Corner {
                place: CornerPlace::Edge(from, to),
                side: 0,
            });
        }
    }
    let has = |wanted: i8| all.iter().any(|corner| corner.side == wanted);
    match (has(1), has(-1)) {
        (true, false) => return Some(Division::Above),
        (false, _) => return Some(Division::Below),
        (true, true) => {}
    }
    // Of several corners in a row on the plane, the one next to the upper side.
    let count = all.len();
    let mut passes = Vec::new();
    for place in 0..count {
        let before = (place + count - 1) % count;
        if all[place].side != 0 || all[before].side == 0 {
            continue;
        }
        let mut end = place;
        while all[(end + 1) % count].side == 0 {
            end = (end + 1) % count;
        }
        if all[before].side * all[(end + 1) % count].side < 0 {
            passes.push(if all[before].side > 0 { place } else { end });
        }
    }
    let &[one, other] = passes.as_slice() else {
        return None;
    };
    let (low, high) = (one.min(other), one.max(other));
    let first = all[low..=high].to_vec();
    let second = [&all[high..], &all[..=low]].concat();
    let is_above = |part: &[Corner]| part.iter().any(|corner| corner.side > 0);
    match (is_above(&first), is_above(&second)) {
        (true, false) => Some(Division::Both(first, second)),
        (false, true) => Some(Division::Both(second, first)),
        _ => None,
    }
}

/// Puts a point on an edge, in all faces along it.
fn split_edge(
    mesh: &mut EditMesh,
    (a, b): (u32, u32),
    share: f64,
    walls: &WallProjection,
) -> Option<u32> {
    let faces = mesh.faces_along(a, b);
    let mut patches: Vec<u32> = faces.iter().filter_map(|&face| mesh.patch(face)).collect();
    patches.sort_unstable();
    patches.dedup();
    let [from, to] = [a, b].map(|point| mesh.points[point as usize]);
    let mut place = from + (to - from) * share;
    if !patches.is_empty() {
        place = walls.nearest(&patches, &place)?;
    }
    let point = mesh.add_point(place);
    for face in faces {
        let mut corners = mesh.faces[face as usize].clone();
        let edge = loop_edges(&corners).position(|edge| edge == (a, b) || edge == (b, a))?;
        corners.insert(edge + 1, point);
        mesh.set_loop(face, corners);
    }
    Some(point)
}

fn apply(
    mesh: &mut EditMesh,
    (cell, upper): (u32, u32),
    face: u32,
    division: Division,
    crossings: &BTreeMap<(u32, u32), u32>,
) {
    let (owner, behind) = (mesh.owner[face as usize], mesh.behind[face as usize]);
    let raised = match owner == cell {
        true => (upper, behind),
        false => (owner, Behind::Cell(upper)),
    };
    let number = |corner: &Corner| match corner.place {
        CornerPlace::Vertex(vertex) => vertex,
        CornerPlace::Edge(a, b) => crossings[&(a.min(b), a.max(b))],
    };
    match division {
        Division::Below => {}
        Division::Above => mesh.set_sides(face, raised.0, raised.1),
        Division::Both(above, below) => {
            mesh.set_loop(face, below.iter().map(number).collect());
            mesh.add_face(above.iter().map(number).collect(), raised.0, raised.1);
        }
    }
}

/// Adds the face between the two cells: the rim of the upper one's faces.
fn close(mesh: &mut EditMesh, cell: u32, upper: u32) -> Option<()> {
    let faces = mesh.of_cell[upper as usize].iter();
    let loops: Vec<Vec<u32>> = faces.map(|&face| mesh.outward(face, upper)).collect();
    let loops: Vec<&[u32]> = loops.iter().map(Vec::as_slice).collect();
    let mut rim = crate::complex::wall_polygons::outline(&loops)?;
    rim.reverse();
    mesh.add_face(rim, upper, Behind::Cell(cell));
    Some(())
}
