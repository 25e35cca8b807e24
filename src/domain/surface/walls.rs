//! Which triangles are one wall: those in one plane that hang together.

use nalgebra::Vector3;

use crate::mesh::edges::EdgeTable;
use crate::mesh::surface::SurfaceMesh;

/// Neighboring triangles whose unit normals differ by less than this lie in one plane.
const COPLANAR: f64 = 1e-9;

/// Per triangle the number of its wall: that of the wall's first triangle.
#[must_use]
pub fn walls(surface: &SurfaceMesh, edges: &EdgeTable) -> Vec<u32> {
    let normals: Vec<Vector3<f64>> = surface
        .all_corners()
        .map(|[a, b, c]| (b - a).cross(&(c - a)).normalize())
        .collect();
    let mut wall: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    for edge in edges.iter() {
        let &[one, other] = edge.sides else { continue };
        let [one, other] = [one / 3, other / 3];
        if (normals[one as usize] - normals[other as usize]).amax() < COPLANAR {
            let [one, other] = [one, other].map(|triangle| root(&mut wall, triangle));
            wall[one.max(other) as usize] = one.min(other);
        }
    }
    (0..wall.len() as u32)
        .map(|triangle| root(&mut wall, triangle))
        .collect()
}

/// The first triangle of the wall so far; paths are halved on the way.
fn root(wall: &mut [u32], mut triangle: u32) -> u32 {
    while wall[triangle as usize] != triangle {
        let above = wall[triangle as usize];
        wall[triangle as usize] = wall[above as usize];
        triangle = above;
    }
    triangle
}
