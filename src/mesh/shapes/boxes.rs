//! Boxes as surfaces and as tetrahedra.

use nalgebra::Point3;

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

/// The unit cube in n³ boxes of six tetrahedra each (Kuhn's: one for each order of the axes),
/// conforming.
#[must_use]
pub fn unit_cube_tets(n: u32) -> TetMesh {
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
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
