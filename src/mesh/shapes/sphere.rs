//! The icosphere.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::mesh::surface::SurfaceMesh;

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

fn icosahedron() -> SurfaceMesh {
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
