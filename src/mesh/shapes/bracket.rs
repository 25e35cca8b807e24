//! An L-shaped bracket with a hole.

use std::f64::consts::TAU;

use nalgebra::Point3;

use crate::mesh::shapes::boxes::split_quad;
use crate::mesh::surface::SurfaceMesh;

/// An L-bracket, 2 × 1 × 1.5 with legs 0.5 thick, and a hole of radius 0.25 through the long
/// leg in `4 · quarter` segments: genus 1, sharp edges, volume 1.5 less the hole.
#[must_use]
pub fn bracket(quarter: u32) -> SurfaceMesh {
    let outline = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 0.5],
        [0.5, 0.5],
        [0.5, 1.5],
        [0.0, 1.5],
    ];
    let mut mesh = SurfaceMesh::default();
    for y in [0.0, 1.0] {
        let corners = outline.iter().map(|&[x, z]| Point3::new(x, y, z));
        mesh.vertices.extend(corners);
    }
    for from in 0..6 {
        let to = (from + 1) % 6;
        if from != 0 && from != 2 {
            mesh.triangles
                .extend(split_quad(&[from, from + 6, to + 6, to]));
        }
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 5], [3, 4, 5]] {
        mesh.triangles.extend([[a, b, c], [a + 6, c + 6, b + 6]]);
    }
    drill(&mut mesh, quarter);
    mesh
}

/// The two drilled faces of the long leg and the hole's wall between them.
fn drill(mesh: &mut SurfaceMesh, quarter: u32) {
    let count = 4 * quarter;
    let first = mesh.vertices.len() as u32;
    for z in [0.0, 0.5] {
        for k in 0..count {
            // The first quarter faces the corner (−x, −y) of the face.
            let turn = TAU * (f64::from(k) / f64::from(count) - 0.5);
            mesh.vertices.push(Point3::new(
                1.25 + 0.25 * turn.cos(),
                0.5 + 0.25 * turn.sin(),
                z,
            ));
        }
    }
    let low = |k: u32| first + k % count;
    let high = |k: u32| low(k) + count;
    for k in 0..count {
        mesh.triangles
            .extend(split_quad(&[low(k), high(k), high(k + 1), low(k + 1)]));
    }
    for corner in 0..4 {
        let next = (corner + 1) % 4;
        let below = [0, 1, 7, 6];
        let above = [3, 2, 8, 9];
        let (begin, end) = (corner * quarter, (corner + 1) * quarter);
        mesh.triangles
            .push([below[corner as usize], low(end), below[next as usize]]);
        mesh.triangles
            .push([above[corner as usize], above[next as usize], high(end)]);
        for k in begin..end {
            mesh.triangles
                .push([below[corner as usize], low(k), low(k + 1)]);
            mesh.triangles
                .push([above[corner as usize], high(k + 1), high(k)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corner_fans_of_the_drilled_face_face_away_from_the_hole() {
        // The face's corner k sees hole vertices k·quarter … (k + 1)·quarter: no triangle may
        // be turned over, so the drilled face's area is the rectangle's less the polygon's.
        let mesh = bracket(4);
        let top = mesh
            .all_corners()
            .filter(|c| c.iter().all(|p| (p.z - 0.5).abs() < 1e-12));
        let area: f64 = top
            .map(|corners| crate::mesh::surface::triangle_area(&corners))
            .sum();
        let hole = 0.5 * 16.0 * 0.25 * 0.25 * (TAU / 16.0).sin();
        assert!((area - (1.5 - hole)).abs() < 1e-12);
    }
}
