//! A closed surface of triangles with its edges, walls, bounding boxes and distances.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::candidates::visit_candidates;
use crate::domain::facet_kind::FacetKind;
use crate::domain::tri_surface::distance::DistanceGrid;
use crate::domain::tri_surface::triangle::{Border, Corner, Origin};
use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::edges::EdgeTable;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::winding::{ray_exit, winding};

/// Neighboring triangles whose unit normals differ by less than this lie in one plane.
const COPLANAR: f64 = 1e-9;

/// A closed surface with its search structures.
#[derive(Clone, Debug)]
pub struct IndexedSurface {
    pub(crate) mesh: SurfaceMesh,
    pub(crate) bounds: Bounds<3>,
    /// The triangles' bounds.
    pub(crate) bvh: Bvh,
    /// Per triangle the edges from its corners 0, 1, 2.
    edges: Vec<[u32; 3]>,
    /// Per triangle the number of its wall: that of the wall's first triangle.
    walls: Vec<u32>,
    distance: DistanceGrid,
}

impl IndexedSurface {
    /// The surface `mesh`, which is closed.
    #[must_use]
    pub fn new(mesh: SurfaceMesh) -> Self {
        Self::with_groups(mesh, &[])
    }

    /// The same, where triangles of different `groups` are on different walls; without groups all may be on
    /// one.
    #[must_use]
    pub(crate) fn with_groups(mesh: SurfaceMesh, groups: &[u32]) -> Self {
        let table = EdgeTable::of(&mesh.triangles, mesh.vertices.len());
        let mut edges = vec![[0; 3]; mesh.triangles.len()];
        for (edge, number) in table.iter().zip(0..) {
            for &side in edge.sides {
                edges[side as usize / 3][side as usize % 3] = number;
            }
        }
        Self {
            edges,
            walls: walls(&mesh, &table, groups),
            distance: DistanceGrid::new(&mesh),
            bvh: Bvh::new(mesh.all_corners().map(|corners| Bounds::of(&corners))),
            bounds: mesh.bounds(),
            mesh,
        }
    }

    /// The label of the wall on which a triangle lies.
    pub(crate) fn label(&self, triangle: u32) -> Label {
        FacetKind::Wall(self.walls[triangle as usize]).label()
    }

    /// How often the surface winds about the point, `None` for a point on it.
    pub(crate) fn winding(&self, point: &Point3<f64>) -> Option<i32> {
        winding(&self.mesh, &self.bvh, point)
    }

    /// Whether the point lies within the surface or on it.
    pub(crate) fn contains(&self, point: &Point3<f64>) -> bool {
        self.bounds.contains(point) && self.winding(point).is_none_or(|winding| winding > 0)
    }

    /// The share of `step` after which the way from `from` first crosses the surface outward, and the
    /// triangle where it does.
    pub(crate) fn ray_exit(&self, from: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, u32)> {
        ray_exit(&self.mesh, &self.bvh, from, step)
    }

    /// Whether the triangle runs along its edge from the lower vertex to the higher.
    pub(crate) fn runs_forward(&self, triangle: u32, edge: u32) -> bool {
        let from = self.edges[triangle as usize]
            .iter()
            .position(|&e| e == edge);
        let vertices = self.mesh.triangles[triangle as usize];
        from.is_some_and(|from| vertices[from] < vertices[(from + 1) % 3])
    }

    /// A triangle's corners, relative to `site`.
    pub(crate) fn triangle(&self, triangle: u32, site: &Point3<f64>) -> [Corner; 3] {
        let vertices = self.mesh.triangles[triangle as usize];
        [0, 1, 2].map_each(|k| Corner {
            position: self.mesh.vertices[vertices[k] as usize] - site,
            origin: Origin::Vertex(vertices[k]),
            border: Border::Side(self.edges[triangle as usize][k]),
        })
    }

    /// Whether the distances alone exclude that a triangle touches `cell`, in coordinates relative to
    /// `site`.
    pub(crate) fn is_clear(&self, site: &Point3<f64>, cell: &Polyhedron) -> bool {
        let clearance = self.distance.at(site);
        let reaches_less = |vertex: Point3<f64>| vertex.coords.amax() < clearance;
        clearance > 0.0 && self.bounds.contains(site) && cell.vertices().all(reaches_less)
    }

    /// Appends the triangles that `cell`, in coordinates relative to `site`, may touch.
    pub(crate) fn candidates(&self, site: &Point3<f64>, cell: &Polyhedron, found: &mut Vec<u32>) {
        visit_candidates(&self.bvh, site, cell, |triangle| found.push(triangle));
    }
}

/// Per triangle the first one of its wall: of those of one group in one plane that are connected.
fn walls(surface: &SurfaceMesh, edges: &EdgeTable, groups: &[u32]) -> Vec<u32> {
    let normals: Vec<Vector3<f64>> = surface
        .all_corners()
        .map(|[a, b, c]| (b - a).cross(&(c - a)).normalize())
        .collect();
    let mut wall: Vec<u32> = (0..surface.triangles.len() as u32).collect();
    for edge in edges.iter() {
        let &[one, other] = edge.sides else { continue };
        let [one, other] = [one / 3, other / 3];
        let is_one_group = groups.get(one as usize) == groups.get(other as usize);
        if is_one_group && (normals[one as usize] - normals[other as usize]).amax() < COPLANAR {
            let [one, other] = [one, other].map_each(|triangle| root(&mut wall, triangle));
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
