//! Triangles that cross each other.
//!
//! Candidates are pairs whose boxes overlap, from a tree of boxes. Two triangles cross if an
//! edge of one passes properly through the inside of the other, or through a side of it and of
//! its neighbor there in the same sense, by exact orientation predicates (Shewchuk 1997, crate
//! `robust`). Mere touching is no crossing, nor is an overlap in a common plane.

use nalgebra::Point3;
use robust::Coord3D;

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::edges::{EdgeTable, NO_PARTNER};
use crate::mesh::report::Tally;
use crate::mesh::surface::SurfaceMesh;

/// Larger surfaces are not searched.
pub const TRIANGLE_LIMIT: usize = 100_000;

/// The pairs of triangles of `mesh` that cross; `None` above [`TRIANGLE_LIMIT`] triangles.
#[must_use]
pub fn crossings(mesh: &SurfaceMesh) -> Option<Tally<[u32; 2]>> {
    if mesh.triangles.len() > TRIANGLE_LIMIT {
        return None;
    }
    let bounds: Vec<Bounds<3>> = mesh.all_corners().map(|c| Bounds::of(&c)).collect();
    let tree = Bvh::new(bounds.iter().copied());
    let partners = EdgeTable::of(&mesh.triangles, mesh.vertices.len()).partners();
    let mut pairs = Vec::new();
    for (one, own) in (0..).zip(&bounds) {
        let meets = |bounds: &Bounds<3>| own.overlaps(bounds);
        tree.visit(meets, |other| {
            if one < other && cross(mesh, &partners, [one, other]) {
                pairs.push([one, other]);
            }
        });
    }
    pairs.sort_unstable();
    Some(pairs.into_iter().collect())
}

/// Whether an edge of one triangle passes through the other. Edges at a common vertex cannot.
fn cross(mesh: &SurfaceMesh, partners: &[u32], [one, other]: [u32; 2]) -> bool {
    pierces(mesh, partners, one, other) || pierces(mesh, partners, other, one)
}

fn pierces(mesh: &SurfaceMesh, partners: &[u32], needle: u32, sheet: u32) -> bool {
    let ends = mesh.triangles[needle as usize];
    let vertices = mesh.triangles[sheet as usize];
    let point = |vertex: u32| exact(&mesh.vertices[vertex as usize]);
    let corners = vertices.map(point);
    (0..3).any(|k| {
        let (from, to) = (ends[k], ends[(k + 1) % 3]);
        if vertices.contains(&from) || vertices.contains(&to) {
            return false;
        }
        let needle = [from, to].map(point);
        match passage(needle, corners) {
            Passage::None => false,
            Passage::Inside => true,
            Passage::Side(side) => {
                let beyond = partners[3 * sheet as usize + side];
                beyond != NO_PARTNER && {
                    let beyond = mesh.triangles[beyond as usize / 3].map(point);
                    let [one, other] = [corners, beyond].map(|corners| sense(needle, corners));
                    one * other > 0.0
                }
            }
        }
    })
}

/// The relation of a segment that passes properly through a triangle's plane to the triangle.
enum Passage {
    None,
    /// Through the inside of the triangle.
    Inside,
    /// Through the inside of the side from this corner.
    Side(usize),
}

fn passage(needle @ [p, q]: [Coord3D<f64>; 2], corners @ [a, b, c]: [Coord3D<f64>; 3]) -> Passage {
    if sense(needle, corners) == 0.0 {
        return Passage::None;
    }
    let turns = [(a, b), (b, c), (c, a)].map(|(a, b)| robust::orient3d(p, q, a, b));
    let sides = turns.iter().filter(|&&turn| turn == 0.0).count();
    let is_one_way = turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0);
    match (is_one_way, sides) {
        (true, 0) => Passage::Inside,
        (true, 1) => turns
            .iter()
            .position(|&turn| turn == 0.0)
            .map_or(Passage::None, Passage::Side),
        _ => Passage::None,
    }
}

/// ±1 where the segment passes properly through the triangle's plane, 0 where it does not.
fn sense([p, q]: [Coord3D<f64>; 2], [a, b, c]: [Coord3D<f64>; 3]) -> f64 {
    let [below, above] = [p, q].map(|end| robust::orient3d(a, b, c, end));
    let is_proper = below != 0.0 && above != 0.0 && (below > 0.0) != (above > 0.0);
    if is_proper { below.signum() } else { 0.0 }
}

fn exact(point: &Point3<f64>) -> Coord3D<f64> {
    let [x, y, z] = [point.x, point.y, point.z];
    Coord3D { x, y, z }
}
