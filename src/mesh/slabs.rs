//! A closed surface cut by parallel planes into closed slabs.
//!
//! A vertex in a plane counts as below it. Where an edge crosses a plane there is one new vertex, the same for
//! all triangles and slabs at it, so that slabs are closed by their numbers and fit together by them; caps are
//! the polygons of the crossing triangles' segments, holes bridged and ears cut.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::geometry::facet_polygons::polygons;
use crate::mesh::polygon::triangulate;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::compact;

/// The parts of the solid within `surface` between the planes n·y = `offsets` (ascending): below the first,
/// between each and the next, above the last. A part may be empty.
pub(crate) fn slabs(
    surface: &SurfaceMesh,
    normal: &Vector3<f64>,
    offsets: &[f64],
) -> Vec<SurfaceMesh> {
    let mut cutter = SlabCutter::new(surface, normal, offsets);
    for &triangle in &surface.triangles {
        cutter.cut(triangle);
    }
    cutter.close(normal);
    let (vertices, slabs) = (cutter.vertices, cutter.slabs);
    let of_slab = |mut triangles: Vec<[u32; 3]>| {
        let mut vertices = vertices.clone();
        compact(&mut vertices, &mut triangles);
        SurfaceMesh {
            vertices,
            triangles,
        }
    };
    slabs.into_iter().map(of_slab).collect()
}

/// Slabs under construction.
struct SlabCutter<'a> {
    offsets: &'a [f64],
    vertices: Vec<Point3<f64>>,
    heights: Vec<f64>,
    /// The vertex where an edge, lower number first, crosses a plane.
    crossings: HashMap<([u32; 2], usize), u32>,
    slabs: Vec<Vec<[u32; 3]>>,
    /// Per plane the directed edges of the cap of the slab below it.
    rims: Vec<Vec<[u32; 2]>>,
}

impl<'a> SlabCutter<'a> {
    fn new(surface: &SurfaceMesh, normal: &Vector3<f64>, offsets: &'a [f64]) -> Self {
        let heights = surface.vertices.iter().map(|v| normal.dot(&v.coords));
        Self {
            offsets,
            vertices: surface.vertices.clone(),
            heights: heights.collect(),
            crossings: HashMap::new(),
            slabs: vec![Vec::new(); offsets.len() + 1],
            rims: vec![Vec::new(); offsets.len()],
        }
    }

    /// The slab of a vertex of the surface.
    fn slab_of(&self, vertex: u32) -> usize {
        let height = self.heights[vertex as usize];
        self.offsets.partition_point(|&offset| offset < height)
    }

    /// The vertex where an edge crosses a plane.
    fn crossing(&mut self, a: u32, b: u32, plane: usize) -> u32 {
        let edge = [a.min(b), a.max(b)];
        if let Some(&vertex) = self.crossings.get(&(edge, plane)) {
            return vertex;
        }
        let [from, to] = edge.map(|vertex| vertex as usize);
        let rise = self.heights[to] - self.heights[from];
        let share = (self.offsets[plane] - self.heights[from]) / rise;
        let vertex = self.vertices.len() as u32;
        let way = self.vertices[to] - self.vertices[from];
        self.vertices.push(self.vertices[from] + way * share);
        self.crossings.insert((edge, plane), vertex);
        vertex
    }

    /// Parts a triangle.
    fn cut(&mut self, triangle: [u32; 3]) {
        let slabs = triangle.map(|vertex| self.slab_of(vertex));
        let lowest = slabs.iter().copied().min().unwrap_or_default();
        let highest = slabs.iter().copied().max().unwrap_or_default();
        for slab in lowest..=highest {
            let part = self.part(triangle, slabs, slab);
            for k in 2..part.len() {
                self.slabs[slab].push([part[0], part[k - 1], part[k]]);
            }
        }
        for plane in lowest..highest {
            self.rim(triangle, slabs, plane);
        }
    }

    /// The polygon of a triangle in a slab.
    fn part(&mut self, triangle: [u32; 3], slabs: [usize; 3], slab: usize) -> Vec<u32> {
        let mut part = Vec::new();
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let (from, to) = (slabs[corner], slabs[next]);
            if from == slab {
                part.push(triangle[corner]);
            }
            for plane in self.crossed([from, to], slab) {
                part.push(self.crossing(triangle[corner], triangle[next], plane));
            }
        }
        part
    }

    /// The planes below and above the slab that an edge between two slabs crosses, in the order in which
    /// the edge meets them.
    fn crossed(&self, [from, to]: [usize; 2], slab: usize) -> Vec<usize> {
        let ends = [slab.wrapping_sub(1), slab];
        let is_crossed = |plane: &usize| {
            *plane < self.offsets.len() && from.min(to) <= *plane && *plane < from.max(to)
        };
        let mut met: Vec<usize> = ends.into_iter().filter(is_crossed).collect();
        if from > to {
            met.reverse();
        }
        met
    }

    /// The segment in which a triangle meets a plane, as an edge of the cap below.
    fn rim(&mut self, triangle: [u32; 3], slabs: [usize; 3], plane: usize) {
        let mut ends = [0; 2];
        for corner in 0..3 {
            let next = (corner + 1) % 3;
            let rises = slabs[corner] <= plane && plane < slabs[next];
            let falls = slabs[next] <= plane && plane < slabs[corner];
            if rises || falls {
                let vertex = self.crossing(triangle[corner], triangle[next], plane);
                // The part below runs up at one crossing and comes down at the other.
                ends[usize::from(rises)] = vertex;
            }
        }
        self.rims[plane].push(ends);
    }

    /// Adds the caps: as they are to the slab below, turned to the one above.
    fn close(&mut self, normal: &Vector3<f64>) {
        let places: Vec<_> = self.vertices.iter().map(|vertex| vertex.coords).collect();
        for (plane, rim) in self.rims.iter().enumerate() {
            let mut cap = Vec::new();
            for polygon in polygons(rim, &places, normal) {
                triangulate(&self.vertices, &polygon, &mut cap);
            }
            self.slabs[plane + 1].extend(cap.iter().map(|&[a, b, c]| [a, c, b]));
            self.slabs[plane].extend(cap);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::edges::EdgeTable;
    use crate::mesh::shapes::{icosphere, torus, unit_cube};

    /// Every edge as often in one direction as in the other.
    fn assert_closed(mesh: &SurfaceMesh) {
        for edge in EdgeTable::of(&mesh.triangles, mesh.vertices.len()).iter() {
            let forward = |&&side: &&u32| {
                crate::mesh::edges::side_vertices(&mesh.triangles, side) == edge.vertices
            };
            let count = edge.sides.iter().filter(forward).count();
            assert_eq!(2 * count, edge.sides.len(), "{edge:?}");
        }
    }

    #[test]
    fn slabs_are_closed_and_fill_the_solid() {
        let normal = Vector3::new(0.3, -0.2, 1.0);
        for mesh in [torus(1.0, 0.3, 24, 12), icosphere(2), unit_cube()] {
            let heights = mesh.vertices.iter().map(|v| normal.dot(&v.coords));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(a, b), h| (a.min(h), b.max(h)));
            let offsets: Vec<_> = (1..6)
                .map(|k| low + (high - low) * f64::from(k) / 6.0)
                .collect();
            let parts = slabs(&mesh, &normal, &offsets);
            let sum: f64 = parts.iter().map(SurfaceMesh::volume).sum();
            assert!((sum / mesh.volume() - 1.0).abs() < 1e-13);
            for (slab, part) in parts.iter().enumerate() {
                assert_closed(part);
                assert!(part.volume() > 0.0);
                for vertex in &part.vertices {
                    let height = normal.dot(&vertex.coords);
                    assert!(slab == 0 || height > offsets[slab - 1] - 1e-12);
                    assert!(slab == 5 || height < offsets[slab] + 1e-12);
                }
            }
        }
    }

    #[test]
    fn planes_through_faces_and_vertices_lose_nothing() {
        let cube = unit_cube();
        let parts = slabs(&cube, &Vector3::z(), &[-1.0, 0.0, 0.5, 1.0, 2.0]);
        let volumes: Vec<_> = parts.iter().map(SurfaceMesh::volume).collect();
        for (volume, wanted) in volumes.iter().zip([0.0, 0.0, 0.5, 0.5, 0.0, 0.0]) {
            assert!((volume - wanted).abs() < 1e-15, "{volumes:?}");
        }
        parts.iter().for_each(assert_closed);
    }
}
