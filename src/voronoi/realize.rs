//! A cell from its pattern and the sites: planes, vertices, and whether they are beyond doubt.
//!
//! # When a realized cell is a convex polyhedron
//!
//! A pattern is a sphere made of facets, three to a vertex, since every cut leaves one. Let n_f be
//! the facets' unit normals and place every vertex where its three planes meet. The three normals
//! around a vertex span a cone; if all of them turn the right way (det > 0) and just one of them
//! holds a given direction, the cones cover every direction exactly once: they are a complete fan.
//! If also every edge runs from its one end to the other in the right direction, the support
//! function of the planes is strictly convex across every wall of the fan, hence convex, and
//! {y : n_f·y ≤ d_f for all f} is a polytope with this very pattern. That is checked here, each with
//! a margin far above rounding. A cell that fails is *in doubt*. It is kept as it was cut.
//!
//! What the margins are good for beyond that: see [`carried`](crate::voronoi::carried).

use wide::f64x4;

use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::pattern::{MOST, Pattern};

/// The least volume that three unit normals span: vertices are then known to some 1e-13 of the
/// cell's radius.
const FLATTEST: f64 = 1e-3;

/// The least distance of a vertex from the planes at the other ends of its edges, relative to the
/// cell's radius: far above what rounding does to vertices, and rare.
const MARGIN: f64 = 1e-7;

/// The least distance of a neighbor relative to the cell's radius: bisectors of nearer sites could
/// pass by a vertex within rounding unseen.
const NEAREST: f64 = 0.02;

/// A direction along no edge or facet that people draw.
const UP: [f64; 3] = [0.737_368_878, 0.577_350_269, 0.350_918_142];

/// Planes with unit normals, and the vertices where they meet.
#[derive(Clone, Debug)]
pub(crate) struct Realizer {
    normals: [[f64; MOST]; 3],
    offsets: [f64; MOST],
    vertices: [[f64; MOST]; 3],
    heights: [f64; MOST],
}

impl Default for Realizer {
    fn default() -> Self {
        Self {
            normals: [[0.0; MOST]; 3],
            offsets: [0.0; MOST],
            vertices: [[0.0; MOST]; 3],
            heights: [0.0; MOST],
        }
    }
}

impl Realizer {
    /// Makes `cell` the polyhedron of `pattern` with these planes, one for every facet; returns
    /// whether it is beyond doubt. If it is not, `cell` is not changed.
    #[must_use]
    pub(crate) fn realize(
        &mut self,
        pattern: &Pattern,
        planes: &[HalfSpace],
        cell: &mut Polyhedron,
    ) -> bool {
        let Some(nearest) = self.load(planes, pattern.neighbor_count()) else {
            return false;
        };
        let (flattest, radius_squared) = self.meet(pattern);
        let radius = radius_squared.sqrt();
        let is_known = flattest >= FLATTEST && 2.0 * nearest >= NEAREST * radius;
        if !is_known || !self.is_convex(pattern, MARGIN * radius) {
            return false;
        }
        self.write(pattern, planes, cell);
        true
    }

    /// Normalizes the planes, those of neighbors first; returns the least distance of one of these,
    /// or nothing where a normal is zero.
    fn load(&mut self, planes: &[HalfSpace], neighbors: usize) -> Option<f64> {
        let mut nearest = f64::INFINITY;
        let mut sum = 0.0;
        for (number, plane) in planes.iter().enumerate().take(MOST) {
            let inverse = 1.0 / plane.normal.norm();
            for axis in 0..3 {
                self.normals[axis][number] = plane.normal[axis] * inverse;
            }
            let offset = plane.offset * inverse;
            self.offsets[number] = offset;
            sum += inverse + offset;
            if number < neighbors && offset < nearest {
                nearest = offset;
            }
        }
        // One number that is not finite spoils the sum.
        sum.is_finite().then_some(nearest)
    }

    /// Computes all vertices, four at a time; returns the least volume of three normals and the
    /// greatest squared distance of a vertex.
    fn meet(&mut self, pattern: &Pattern) -> (f64, f64) {
        let mut flattest = f64x4::splat(f64::INFINITY);
        let mut far = f64x4::ZERO;
        for block in 0..pattern.vertex_count.div_ceil(4) {
            // Lanes beyond the last vertex repeat the first.
            let vertex = |lane: usize| {
                let vertex = 4 * block + lane;
                if vertex < pattern.vertex_count {
                    vertex
                } else {
                    0
                }
            };
            let facets = [0, 1, 2, 3].map(|lane| pattern.facets[vertex(lane)]);
            let gather = |all: &[f64; MOST], slot: usize| {
                f64x4::new(facets.map(|facets| all[usize::from(facets[slot]) % MOST]))
            };
            let normal = |slot: usize| [0, 1, 2].map(|axis| gather(&self.normals[axis], slot));
            let [a, b, c] = [0, 1, 2].map(normal);
            let [ab, bc, ca] = [cross(&a, &b), cross(&b, &c), cross(&c, &a)];
            let volume = a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
            flattest = flattest.fast_min(volume);
            let scale = f64x4::ONE / volume;
            let [d, e, f] = [0, 1, 2].map(|slot| gather(&self.offsets, slot) * scale);
            let position = [0, 1, 2].map(|axis| d * bc[axis] + e * ca[axis] + f * ab[axis]);
            let mut square = f64x4::ZERO;
            let mut height = f64x4::ZERO;
            for axis in 0..3 {
                square += position[axis] * position[axis];
                height += position[axis] * f64x4::splat(UP[axis]);
                self.vertices[axis][4 * block..][..4].copy_from_slice(&position[axis].to_array());
            }
            self.heights[4 * block..][..4].copy_from_slice(&height.to_array());
            far = far.fast_max(square);
        }
        let least = |[a, b, c, d]: [f64; 4]| a.min(b).min(c.min(d));
        let most = |[a, b, c, d]: [f64; 4]| a.max(b).max(c.max(d));
        (least(flattest.to_array()), most(far.to_array()))
    }

    /// Whether every edge runs the right way, `margin` long as seen from the plane it leaves, and
    /// one vertex alone is higher than its neighbors.
    fn is_convex(&self, pattern: &Pattern, margin: f64) -> bool {
        let [x, y, z] = &self.vertices;
        let [a, b, c] = &self.normals;
        let mut least = f64::INFINITY;
        let mut summits = 0;
        for vertex in 0..pattern.vertex_count {
            let mut highest = f64::NEG_INFINITY;
            for slot in 0..3 {
                let end = usize::from(pattern.next[vertex][slot]) % MOST;
                // The edge runs along the facets left and right of it and leaves the third.
                let plane = usize::from(pattern.facets[vertex][(slot + 1) % 3]) % MOST;
                let along = a[plane] * x[end] + b[plane] * y[end] + c[plane] * z[end];
                let room = self.offsets[plane] - along;
                least = if room < least { room } else { least };
                let height = self.heights[end];
                highest = if height > highest { height } else { highest };
            }
            summits += u32::from(self.heights[vertex] > highest);
        }
        least >= margin && summits == 1
    }

    fn write(&self, pattern: &Pattern, planes: &[HalfSpace], cell: &mut Polyhedron) {
        cell.clear();
        let count = pattern.vertex_count;
        let [x, y, z] = &self.vertices;
        cell.x.extend_from_slice(&x[..count]);
        cell.y.extend_from_slice(&y[..count]);
        cell.z.extend_from_slice(&z[..count]);
        let widened = |row: &[u8; 3]| row.map(u32::from);
        cell.facets
            .extend(pattern.facets[..count].iter().map(widened));
        cell.next.extend(pattern.next[..count].iter().map(widened));
        cell.planes.extend_from_slice(planes);
        cell.labels.extend_from_slice(pattern.labels());
    }
}

fn cross(a: &[f64x4; 3], b: &[f64x4; 3]) -> [f64x4; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
