//! Convex polyhedra as simple polytopes: three facets at every vertex.
//!
//! Every vertex meets exactly three facets and three edges. Where more than three planes pass
//! through one point (every vertex of a cubic lattice's cells) the point is stored as several
//! vertices joined by edges of length zero; facets may have area zero. That keeps every clip a
//! purely combinatorial step that cannot fail, and costs nothing in exactness, since all
//! integrals are continuous in the positions.
//!
//! # Convention
//!
//! Around vertex v the facets F₀, F₁, F₂ follow counter-clockwise as seen from outside. Edge k
//! leaves v with F_k on its left and F_{k+2} on its right and ends in `next[v][k]`, so that
//! following facet f's slot from vertex to vertex runs around f counter-clockwise.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;

/// A bounded convex polyhedron with labelled facets, or the empty set.
#[derive(Clone, Debug, Default)]
pub struct Polyhedron {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    pub(crate) z: Vec<f64>,
    pub(crate) facets: Vec<[u32; 3]>,
    pub(crate) next: Vec<[u32; 3]>,
    pub(crate) planes: Vec<HalfSpace>,
    pub(crate) labels: Vec<Label>,
}

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

/// One facet of a [`Polyhedron`].
#[derive(Clone, Copy, Debug)]
pub struct Facet<'a> {
    polyhedron: &'a Polyhedron,
    /// The facet's number: its place in the order in which the planes were added.
    pub number: usize,
    first: usize,
}

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
            for (normal, offset) in [(-normal, -bounds.min[axis]), (normal, bounds.max[axis])] {
                self.planes.push(HalfSpace { normal, offset });
            }
        }
        self.labels.extend(labels);
    }

    /// Becomes the tetrahedron between the origin and a triangle, counter-clockwise from outside, that
    /// carries a label; the three other facets carry another one.
    pub(crate) fn assign_tetrahedron(
        &mut self,
        [a, b, c]: [&Vector3<f64>; 3],
        [label, inner]: [Label; 2],
    ) {
        self.clear();
        let origin = Point3::origin();
        let corner = |corner: &Vector3<f64>| Point3::from(*corner);
        // Vertices: the origin, a, b, c. Facets: the triangle, then those beside its edges in turn.
        self.push(origin, [1, 3, 2], [2, 1, 3]);
        self.push(corner(a), [0, 3, 1], [2, 3, 0]);
        self.push(corner(b), [0, 1, 2], [3, 1, 0]);
        self.push(corner(c), [0, 2, 3], [1, 2, 0]);
        let normals = [(b - a).cross(&(c - a)), b.cross(a), c.cross(b), a.cross(c)];
        for (number, normal) in normals.into_iter().enumerate() {
            let normal = normal.try_normalize(0.0).unwrap_or_default();
            let offset = if number == 0 { normal.dot(a) } else { 0.0 };
            self.planes.push(HalfSpace { normal, offset });
        }
        self.labels.extend([label, inner, inner, inner]);
    }

    /// Becomes a copy of `other` moved by `displacement`, keeping its memory.
    pub fn assign_translated(&mut self, other: &Self, displacement: &Vector3<f64>) {
        self.clear();
        self.x.extend(other.x.iter().map(|x| x + displacement.x));
        self.y.extend(other.y.iter().map(|y| y + displacement.y));
        self.z.extend(other.z.iter().map(|z| z + displacement.z));
        self.facets.extend_from_slice(&other.facets);
        self.next.extend_from_slice(&other.next);
        let planes = other.planes.iter();
        self.planes
            .extend(planes.map(|p| p.translated(displacement)));
        self.labels.extend_from_slice(&other.labels);
    }

    /// Becomes the empty set, keeping its memory.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
        self.facets.clear();
        self.next.clear();
        self.planes.clear();
        self.labels.clear();
    }

    /// Whether this is the empty set.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// How many vertices are stored, coincident ones counted each.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.x.len()
    }

    /// The position of vertex `number`.
    ///
    /// # Panics
    /// If there is no such vertex.
    #[must_use]
    pub fn vertex(&self, number: usize) -> Point3<f64> {
        Point3::new(self.x[number], self.y[number], self.z[number])
    }

    /// The positions of all vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Point3<f64>> + '_ {
        (0..self.vertex_count()).map(|v| self.vertex(v))
    }

    /// The least axis-aligned box around the polyhedron.
    #[must_use]
    pub fn bounds(&self) -> Bounds<3> {
        let mut bounds = Bounds::empty();
        for vertex in self.vertices() {
            bounds.include(&vertex);
        }
        bounds
    }

    /// The greatest squared distance of a vertex from the origin (L²); 0 for the empty set.
    #[must_use]
    pub fn radius_squared(&self) -> f64 {
        let mut far = 0.0;
        for ((x, y), z) in self.x.iter().zip(&self.y).zip(&self.z) {
            let square = x * x + y * y + z * z;
            // Not f64::max: its treatment of NaN costs more than the rest.
            if square > far {
                far = square;
            }
        }
        far
    }

    /// Volume and moments about the origin; zero for the empty set.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        let triangles = self.facets().flat_map(|facet| facet.triangles());
        triangles.for_each(|triangle| moments.add_cone(triangle));
        moments
    }

    /// The facets that have vertices, in the order in which their planes were added.
    pub fn facets(&self) -> impl Iterator<Item = Facet<'_>> {
        let mut first = vec![usize::MAX; self.planes.len()];
        for vertex in (0..self.vertex_count()).rev() {
            for facet in self.facets[vertex] {
                first[facet as usize] = vertex;
            }
        }
        let alive = first
            .into_iter()
            .enumerate()
            .filter(|(_, v)| *v != usize::MAX);
        alive.map(|(number, first)| Facet {
            polyhedron: self,
            number,
            first,
        })
    }

    pub(crate) fn push(&mut self, position: Point3<f64>, facets: [u32; 3], next: [u32; 3]) {
        self.x.push(position.x);
        self.y.push(position.y);
        self.z.push(position.z);
        self.facets.push(facets);
        self.next.push(next);
    }

    #[inline]
    pub(crate) fn replace(
        &mut self,
        vertex: usize,
        position: Point3<f64>,
        facets: [u32; 3],
        next: [u32; 3],
    ) {
        (self.x[vertex], self.y[vertex], self.z[vertex]) = (position.x, position.y, position.z);
        (self.facets[vertex], self.next[vertex]) = (facets, next);
    }

    /// Which of the vertex's three slots holds the facet.
    pub(crate) fn slot(&self, vertex: usize, facet: u32) -> usize {
        let [first, second, _] = self.facets[vertex];
        if first == facet {
            0
        } else if second == facet {
            1
        } else {
            2
        }
    }
}

impl<'a> Facet<'a> {
    /// The facet's label.
    #[must_use]
    pub fn label(&self) -> Label {
        self.polyhedron.labels[self.number]
    }

    /// The half-space of which the facet is the border.
    #[must_use]
    pub fn half_space(&self) -> HalfSpace {
        self.polyhedron.planes[self.number]
    }

    /// The numbers of the facet's vertices, counter-clockwise as seen from outside.
    pub fn vertex_numbers(&self) -> impl Iterator<Item = usize> + use<'a> {
        let (polyhedron, facet, first) = (self.polyhedron, self.number as u32, self.first);
        let step = move |&vertex: &usize| {
            let slot = polyhedron.slot(vertex, facet);
            let next = polyhedron.next[vertex][slot] as usize;
            (next != first).then_some(next)
        };
        std::iter::successors(Some(first), step)
    }

    /// The facet's corners, counter-clockwise as seen from outside.
    pub fn corners(&self) -> impl Iterator<Item = Point3<f64>> + use<'a> {
        let polyhedron = self.polyhedron;
        self.vertex_numbers().map(move |v| polyhedron.vertex(v))
    }

    /// The triangles of the facet's fan from its first corner.
    pub fn triangles(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> + use<'a> {
        let mut corners = self.corners().map(|corner| corner.coords);
        let anchor = corners.next().unwrap_or_default();
        let mut last = corners.next().unwrap_or_default();
        corners.map(move |corner| [anchor, std::mem::replace(&mut last, corner), corner])
    }

    /// The facet's area times its unit normal (L²), from the corners alone.
    #[must_use]
    pub fn area_vector(&self) -> Vector3<f64> {
        let doubled = self.triangles().map(|[a, b, c]| (b - a).cross(&(c - a)));
        0.5 * doubled.sum::<Vector3<f64>>()
    }
}
