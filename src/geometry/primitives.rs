//! Boxes and tetrahedra as polyhedra.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// Corner bits of a cuboid (x = 1, y = 2, z = 4) → facets, counter-clockwise from outside. Facets
/// 0…5 are −x, +x, −y, +y, −z, +z.
const CUBOID_FACETS: [[u32; 3]; 8] = [
    [0, 4, 2],
    [1, 2, 4],
    [0, 3, 4],
    [1, 4, 3],
    [0, 2, 5],
    [1, 5, 2],
    [0, 5, 3],
    [1, 3, 5],
];

/// Corner of a cuboid → the corners at the ends of its edges.
const CUBOID_NEXT: [[u32; 3]; 8] = cuboid_next();

const fn cuboid_next() -> [[u32; 3]; 8] {
    let mut next = [[0; 3]; 8];
    let mut corner = 0;
    while corner < 8 {
        let mut slot = 0;
        while slot < 3 {
            // Edge k lies on facets k and k + 2, so it runs along the axis of facet k + 1.
            let axis = CUBOID_FACETS[corner][(slot + 1) % 3] / 2;
            next[corner][slot] = corner as u32 ^ (1 << axis);
            slot += 1;
        }
        corner += 1;
    }
    next
}

/// Corner → facets (named by the opposite corner), counter-clockwise from outside, when the edges
/// from corner 0 to 1, 2, 3 form a right-handed frame.
const TETRAHEDRON_FACETS: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

impl Polyhedron {
    /// The axis-aligned box with labels for the walls −x, +x, −y, +y, −z, +z.
    #[must_use]
    pub fn cuboid(bounds: &Bounds<3>, labels: [Label; 6]) -> Self {
        let mut cuboid = Self::default();
        cuboid.assign_cuboid(bounds, labels);
        cuboid
    }

    /// Becomes the axis-aligned box, as [`Polyhedron::cuboid`], keeping its memory.
    pub fn assign_cuboid(&mut self, bounds: &Bounds<3>, labels: [Label; 6]) {
        self.clear();
        let ends = |axis: usize| [bounds.min[axis], bounds.max[axis]];
        let along = |axis: usize| -> [f64; 8] {
            let ends = ends(axis);
            std::array::from_fn(|corner| ends[corner >> axis & 1])
        };
        self.x.extend(along(0));
        self.y.extend(along(1));
        self.z.extend(along(2));
        self.facets.extend_from_slice(&CUBOID_FACETS);
        self.next.extend_from_slice(&CUBOID_NEXT);
        for axis in 0..3 {
            let mut normal = Vector3::zeros();
            normal[axis] = 1.0;
            self.planes.push(HalfSpace {
                normal: -normal,
                offset: -bounds.min[axis],
            });
            self.planes.push(HalfSpace {
                normal,
                offset: bounds.max[axis],
            });
        }
        self.labels.extend(labels);
    }

    /// The tetrahedron of four corners in any order; facet k lies opposite corner k.
    ///
    /// A flat tetrahedron is a polyhedron of volume zero.
    #[must_use]
    pub fn tetrahedron(corners: &[Point3<f64>; 4], labels: [Label; 4]) -> Self {
        let mut tetrahedron = Self::default();
        tetrahedron.assign_tetrahedron(corners, labels);
        tetrahedron
    }

    /// Becomes the tetrahedron, as [`Polyhedron::tetrahedron`], keeping its memory.
    pub fn assign_tetrahedron(&mut self, corners: &[Point3<f64>; 4], labels: [Label; 4]) {
        self.clear();
        let edges = [1, 2, 3].map(|k| corners[k] - corners[0]);
        let mirrored = edges[0].dot(&edges[1].cross(&edges[2])) < 0.0;
        let order: [usize; 4] = if mirrored { [0, 2, 1, 3] } else { [0, 1, 2, 3] };
        for place in 0..4 {
            let turn = TETRAHEDRON_FACETS[place];
            // Edge k misses facet k + 1, so it ends in the corner opposite that facet.
            let next = [turn[1], turn[2], turn[0]].map(|k| k as u32);
            self.push(corners[order[place]], turn.map(|k| k as u32), next);
        }
        for place in 0..4 {
            let [a, b, c] = TETRAHEDRON_FACETS[place].map(|k| corners[order[k]]);
            let normal = (b - a).cross(&(c - a));
            let inward = (corners[order[place]] - a).dot(&normal) > 0.0;
            let normal = if inward { -normal } else { normal };
            self.planes.push(HalfSpace {
                offset: normal.dot(&a.coords),
                normal,
            });
            self.labels.push(labels[order[place]]);
        }
    }
}
