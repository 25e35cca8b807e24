//! The nearest place of a wall: on the triangles of a patch, or on the edges between two.

use nalgebra::{Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::mesh::edges::EdgeTable;
use crate::mesh::surface::SurfaceMesh;

/// A surface with its patches, their common edges and the corners of these.
#[derive(Clone, Debug)]
pub(crate) struct WallProjection {
    triangles: Vec<[Point3<f64>; 3]>,
    /// The unit normals of the triangles; zero where there is no area.
    pub(crate) normals: Vec<Vector3<f64>>,
    /// The patches of the triangles.
    pub(crate) patches: Vec<u32>,
    tree: Bvh,
    /// Edges between two patches, in ascending order.
    edges: Vec<([Point3<f64>; 2], [u32; 2])>,
    edge_tree: Bvh,
    /// Where edges between patches end, branch or turn by more than the angle.
    pub(crate) corners: Vec<Point3<f64>>,
    /// How far (L) the nearest place may be.
    reach: f64,
    /// The cosine of the angle of a feature.
    pub(crate) least_cosine: f64,
}

impl WallProjection {
    /// The triangles of `surface` in `patches`; places are sought within `reach` (L), and corners are
    /// where edges of patches turn by more than `angle` (degrees).
    #[must_use]
    pub(crate) fn new(surface: &SurfaceMesh, patches: &[u32], angle: f64, reach: f64) -> Self {
        let triangles: Vec<_> = surface.all_corners().collect();
        let normal = |[a, b, c]: &[Point3<f64>; 3]| {
            let area: Vector3<f64> = (b - a).cross(&(c - a));
            area.try_normalize(0.0).unwrap_or_default()
        };
        let least_cosine = angle.to_radians().cos();
        let mut ends: Vec<Vec<u32>> = vec![Vec::new(); surface.vertices.len()];
        let mut edges = Vec::new();
        for edge in EdgeTable::of(&surface.triangles, surface.vertices.len()).iter() {
            let &[one, other] = edge.sides else { continue };
            let mut pair = [one, other].map(|side| patches[side as usize / 3]);
            if pair[0] == pair[1] {
                continue;
            }
            pair.sort_unstable();
            edges.push((edge.vertices.map(|v| surface.vertices[v as usize]), pair));
            let [from, to] = edge.vertices;
            ends[from as usize].push(to);
            ends[to as usize].push(from);
        }
        let corners =
            (0..ends.len()).filter(|&vertex| is_corner(surface, &ends, vertex, least_cosine));
        Self {
            normals: triangles.iter().map(normal).collect(),
            tree: Bvh::new(triangles.iter().map(Bounds::of)),
            edge_tree: Bvh::new(edges.iter().map(|(ends, _)| Bounds::of(ends))),
            corners: corners.map(|vertex| surface.vertices[vertex]).collect(),
            patches: patches.to_vec(),
            triangles,
            edges,
            reach,
            least_cosine,
        }
    }

    /// The place nearest to `point` where all of `patches` are; none if there is none near.
    #[must_use]
    pub(crate) fn nearest(&self, patches: &[u32], point: &Point3<f64>) -> Option<Point3<f64>> {
        match *patches {
            [patch] => self.nearest_by(&self.tree, point, |number| {
                let is_here = self.patches[number as usize] == patch;
                is_here.then(|| on_triangle(point, &self.triangles[number as usize]))
            }),
            [one, other] => self.nearest_by(&self.edge_tree, point, |number| {
                let (ends, pair) = &self.edges[number as usize];
                (*pair == [one, other]).then(|| on_segment(point, ends))
            }),
            _ => None,
        }
    }

    fn nearest_by(
        &self,
        tree: &Bvh,
        point: &Point3<f64>,
        place: impl Fn(u32) -> Option<Point3<f64>>,
    ) -> Option<Point3<f64>> {
        let best = std::cell::Cell::new((self.reach * self.reach, None));
        let is_near =
            |bounds: &Bounds<3>| (bounds.clamp(point) - point).norm_squared() < best.get().0;
        tree.visit(is_near, |number| {
            let Some(found) = place(number) else { return };
            let squared = (found - point).norm_squared();
            if squared < best.get().0 {
                best.set((squared, Some(found)));
            }
        });
        best.get().1
    }
}

/// Whether edges of patches end, branch or turn in a vertex.
fn is_corner(surface: &SurfaceMesh, ends: &[Vec<u32>], vertex: usize, least: f64) -> bool {
    let way = |end: u32| {
        let way = surface.vertices[end as usize] - surface.vertices[vertex];
        way.try_normalize(0.0).unwrap_or_default()
    };
    match ends[vertex][..] {
        [] => false,
        [one, other] => way(one).dot(&way(other)) > -least,
        _ => true,
    }
}

/// The place of a segment nearest to a point.
fn on_segment(point: &Point3<f64>, [a, b]: &[Point3<f64>; 2]) -> Point3<f64> {
    let way = b - a;
    let share = way.dot(&(point - a)) / way.norm_squared().max(1e-300);
    a + way * share.clamp(0.0, 1.0)
}

/// The place of a triangle nearest to a point: its foot, where the barycentric coordinates are not negative
/// (Ericson, *Real-Time Collision Detection*, 2005, section 3.4), else the nearest place of the sides.
fn on_triangle(point: &Point3<f64>, [a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(&ac);
    let size = normal.norm_squared();
    if size > 0.0 {
        let v = ap.cross(&ac).dot(&normal) / size;
        let w = ab.cross(&ap).dot(&normal) / size;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return a + ab * v + ac * w;
        }
    }
    let sides = [[*a, *b], [*b, *c], [*c, *a]].map(|side| on_segment(point, &side));
    let [first, second, third] = sides;
    let nearer = |one: Point3<f64>, other: Point3<f64>| match (other - point).norm_squared()
        < (one - point).norm_squared()
    {
        true => other,
        false => one,
    };
    nearer(nearer(first, second), third)
}
