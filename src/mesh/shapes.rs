//! Meshes made by formula: boxes, an icosphere, tubes around closed curves, a drilled bracket.

use std::collections::HashMap;
use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;

/// The corners of a box by the bits of their index: bit k set means the greater coordinate
/// along axis k.
const BOX_QUADS: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// A box in 12 triangles.
#[must_use]
pub fn cuboid(bounds: &Bounds<3>) -> SurfaceMesh {
    let triangles = BOX_QUADS.iter().flat_map(split_quad).collect();
    SurfaceMesh {
        vertices: box_corners(bounds).to_vec(),
        triangles,
    }
}

/// The unit cube \[0, 1\]³ in 12 triangles.
#[must_use]
pub fn unit_cube() -> SurfaceMesh {
    cuboid(&unit_box())
}

/// The unit cube in five tetrahedra, the fifth regular.
#[must_use]
pub fn unit_cube_five_tets() -> TetMesh {
    TetMesh {
        vertices: box_corners(&unit_box()).to_vec(),
        tets: vec![
            [0, 1, 2, 4],
            [3, 2, 1, 7],
            [5, 1, 4, 7],
            [6, 4, 2, 7],
            [1, 2, 4, 7],
        ],
        vertex_data: Vec::new(),
    }
}

/// The orders of the three axes, the even permutations first.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 2, 0],
    [2, 0, 1],
    [0, 2, 1],
    [2, 1, 0],
    [1, 0, 2],
];

/// The unit cube in n³ boxes of six tetrahedra each (Kuhn's: one for each order of the axes),
/// conforming.
#[must_use]
pub fn unit_cube_tets(n: u32) -> TetMesh {
    let strides = [1, n + 1, (n + 1) * (n + 1)];
    let mut mesh = TetMesh::default();
    for [x, y, z] in lattice(n + 1) {
        let step = |count: u32| f64::from(count) / f64::from(n);
        mesh.vertices.push(Point3::new(step(x), step(y), step(z)));
    }
    for [x, y, z] in lattice(n) {
        let first = x + y * strides[1] + z * strides[2];
        for (order, odd) in ORDERS.iter().zip([false, false, false, true, true, true]) {
            let one = first + strides[order[0]];
            let two = one + strides[order[1]];
            let last = two + strides[order[2]];
            mesh.tets.push(if odd {
                [first, two, one, last]
            } else {
                [first, one, two, last]
            });
        }
    }
    mesh
}

/// A quadrilateral cut along the diagonal from its first vertex.
pub(crate) fn split_quad(&[a, b, c, d]: &[u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

fn lattice(n: u32) -> impl Iterator<Item = [u32; 3]> {
    (0..n * n * n).map(move |at| [at % n, at / n % n, at / n / n])
}

fn unit_box() -> Bounds<3> {
    let (min, max) = (Point3::origin(), Point3::new(1.0, 1.0, 1.0));
    Bounds { min, max }
}

fn box_corners(bounds: &Bounds<3>) -> [Point3<f64>; 8] {
    let pick = |index: usize, axis: usize| {
        let upper = index >> axis & 1 == 1;
        if upper {
            bounds.max[axis]
        } else {
            bounds.min[axis]
        }
    };
    std::array::from_fn(|index| Point3::new(pick(index, 0), pick(index, 1), pick(index, 2)))
}

/// The unit icosphere: an icosahedron, every triangle split into four `levels` times, vertices
/// on the unit sphere. 20 · 4^levels triangles.
#[must_use]
pub fn icosphere(levels: u32) -> SurfaceMesh {
    let mut mesh = icosahedron();
    for _ in 0..levels {
        mesh = refined(&mesh);
    }
    for vertex in &mut mesh.vertices {
        *vertex = Point3::from(vertex.coords.normalize());
    }
    mesh
}

/// The vertices of the icosahedron of edge length 2: cyclic permutations of (±1, ±φ, 0).
fn icosahedron_vertices() -> Vec<Point3<f64>> {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut vertices = Vec::new();
    for axis in 0..3 {
        for (one, long) in [
            (-1.0, golden),
            (1.0, golden),
            (-1.0, -golden),
            (1.0, -golden),
        ] {
            let mut vertex = Point3::origin();
            vertex[axis] = one;
            vertex[(axis + 1) % 3] = long;
            vertices.push(vertex);
        }
    }
    vertices
}

fn icosahedron() -> SurfaceMesh {
    let vertices = icosahedron_vertices();
    let adjacent = |a: usize, b: usize| (vertices[a] - vertices[b]).norm_squared() < 4.1;
    let mut triangles = Vec::new();
    for a in 0..12 {
        for b in (a + 1..12).filter(|&b| adjacent(a, b)) {
            for c in (b + 1..12).filter(|&c| adjacent(a, c) && adjacent(b, c)) {
                let turn = vertices[a]
                    .coords
                    .dot(&vertices[b].coords.cross(&vertices[c].coords));
                let [a, b, c] = [a, b, c].map(|corner| corner as u32);
                triangles.push(if turn > 0.0 { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    SurfaceMesh {
        vertices,
        triangles,
    }
}

/// Every triangle split into four at its edges' midpoints, pushed out to the unit sphere.
fn refined(mesh: &SurfaceMesh) -> SurfaceMesh {
    let mut vertices: Vec<Point3<f64>> = mesh.vertices.clone();
    let mut midpoints = HashMap::new();
    let mut triangles = Vec::with_capacity(mesh.triangles.len() * 4);
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
            *midpoints
                .entry((from.min(to), from.max(to)))
                .or_insert_with(|| {
                    let sum = vertices[from as usize].coords.normalize()
                        + vertices[to as usize].coords.normalize();
                    vertices.push(Point3::from(sum.normalize()));
                    vertices.len() as u32 - 1
                })
        });
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    SurfaceMesh {
        vertices,
        triangles,
    }
}

/// A torus around the z axis: `around` segments along the ring of radius `ring`, `across`
/// along the tube of radius `tube` (both at least 3).
#[must_use]
pub fn torus(ring: f64, tube: f64, around: u32, across: u32) -> SurfaceMesh {
    let center = |turn: f64| Point3::new(ring * turn.cos(), ring * turn.sin(), 0.0);
    closed_tube(center, tube, around, across)
}

/// A tube of radius `tube` along the trefoil knot (sin t + 2 sin 2t, cos t − 2 cos 2t, −sin 3t),
/// with `around` segments along the knot and `across` along the tube. A radius below 0.5 keeps
/// the tube from touching itself.
#[must_use]
pub fn trefoil(tube: f64, around: u32, across: u32) -> SurfaceMesh {
    let center = |t: f64| {
        let x = t.sin() + 2.0 * (2.0 * t).sin();
        let y = t.cos() - 2.0 * (2.0 * t).cos();
        Point3::new(x, y, -(3.0 * t).sin())
    };
    closed_tube(center, tube, around, across)
}

/// A tube around a closed curve of period 2π, its cross-sections in planes that hold the z-most
/// normal, so that it closes without a twist.
fn closed_tube(
    center: impl Fn(f64) -> Point3<f64>,
    tube: f64,
    around: u32,
    across: u32,
) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for i in 0..around {
        let t = TAU * f64::from(i) / f64::from(around);
        let here = center(t);
        let half_step = TAU / f64::from(around) / 2.0;
        let tangent = (center(t + half_step) - center(t - half_step)).normalize();
        let side = tangent.cross(&Vector3::z()).normalize();
        let up = side.cross(&tangent);
        for j in 0..across {
            let turn = TAU * f64::from(j) / f64::from(across);
            mesh.vertices
                .push(here + (side * turn.cos() + up * turn.sin()) * tube);
        }
    }
    mesh.triangles = torus_triangles(around, across);
    mesh
}

/// The triangles of a grid of `around` · `across` vertices that closes in both directions.
fn torus_triangles(around: u32, across: u32) -> Vec<[u32; 3]> {
    let vertex = |i: u32, j: u32| (i % around) * across + j % across;
    let pairs = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let quad = |(i, j)| {
        let (right, up) = (i + 1, j + 1);
        [
            vertex(i, j),
            vertex(right, j),
            vertex(right, up),
            vertex(i, up),
        ]
    };
    pairs.flat_map(|pair| split_quad(&quad(pair))).collect()
}

/// The bracket's outline in x and z.
const BRACKET: [[f64; 2]; 6] = [
    [0.0, 0.0],
    [2.0, 0.0],
    [2.0, 0.5],
    [0.5, 0.5],
    [0.5, 1.5],
    [0.0, 1.5],
];

/// An L-bracket, 2 × 1 × 1.5 with legs 0.5 thick, and a hole of radius 0.25 through the long
/// leg in `4 · quarter` segments: genus 1, sharp edges, volume 1.5 less the hole.
#[must_use]
pub fn bracket(quarter: u32) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for y in [0.0, 1.0] {
        let corners = BRACKET.iter().map(|&[x, z]| Point3::new(x, y, z));
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
        // The face's corner k is joined to hole vertices k·quarter … (k + 1)·quarter: no triangle
        // may be turned over, so the drilled face's area is the rectangle's less the polygon's.
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
