//! Triangles that cross each other.
//!
//! Candidates come from a uniform grid over the bounding box; a pair is tested in the one grid
//! box that holds the least corner of its two boxes' intersection. Two triangles cross if an
//! edge of one passes properly through the inside of the other, or through a side of it and of
//! its neighbor there in the same sense, by exact orientation predicates (Shewchuk 1997, crate
//! `robust`). Mere touching is no crossing, nor is an overlap in a common plane.

use nalgebra::Point3;
use robust::Coord3D;

use crate::geometry::bounds::Bounds;
use crate::mesh::edges::{EdgeTable, NO_PARTNER};
use crate::mesh::report::Tally;
use crate::mesh::surface::SurfaceMesh;

/// Larger surfaces are not looked through.
pub const TRIANGLE_LIMIT: usize = 100_000;

/// Boxes along the longest axis at most: a grid of 2¹⁸ boxes.
const FINEST: f64 = 64.0;

/// The pairs of triangles of `mesh` that cross; `None` above [`TRIANGLE_LIMIT`] triangles.
#[must_use]
pub fn crossings(mesh: &SurfaceMesh) -> Option<Tally<[u32; 2]>> {
    if mesh.triangles.len() > TRIANGLE_LIMIT {
        return None;
    }
    let grid = Grid::over(mesh);
    let partners = EdgeTable::of(&mesh.triangles, mesh.vertices.len()).partners();
    let mut pairs: Vec<[u32; 2]> = (0..grid.boxes.len())
        .flat_map(|at| grid.pairs_in(at))
        .filter(|&pair| cross(mesh, &partners, pair))
        .collect();
    pairs.sort_unstable();
    Some(pairs.into_iter().collect())
}

struct Grid {
    origin: Point3<f64>,
    spacing: f64,
    counts: [usize; 3],
    boxes: Vec<Vec<u32>>,
    bounds: Vec<Bounds<3>>,
}

impl Grid {
    fn over(mesh: &SurfaceMesh) -> Self {
        let all = mesh.bounds();
        let boxes_per_axis = (mesh.triangles.len() as f64).sqrt().clamp(1.0, FINEST);
        let spacing = (all.extent().max() / boxes_per_axis).max(f64::MIN_POSITIVE);
        let count = |axis: usize| (all.extent()[axis] / spacing) as usize + 1;
        let counts = [count(0), count(1), count(2)];
        let mut grid = Self {
            origin: all.min,
            spacing,
            counts,
            boxes: vec![Vec::new(); counts.iter().product()],
            bounds: mesh
                .all_corners()
                .map(|corners| Bounds::of(&corners))
                .collect(),
        };
        grid.fill();
        grid
    }

    fn fill(&mut self) {
        for triangle in 0..self.bounds.len() {
            let low = self.steps(&self.bounds[triangle].min);
            let high = self.steps(&self.bounds[triangle].max);
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let at = self.number([x, y, z]);
                        self.boxes[at].push(triangle as u32);
                    }
                }
            }
        }
    }

    /// The grid coordinates of the box that holds `point`.
    fn steps(&self, point: &Point3<f64>) -> [usize; 3] {
        let step = |axis: usize| {
            let step = (point[axis] - self.origin[axis]) / self.spacing;
            (step as usize).min(self.counts[axis] - 1)
        };
        [step(0), step(1), step(2)]
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.counts[1] + y) * self.counts[2] + z
    }

    /// The pairs whose boxes overlap, least common corner in grid box `at`.
    fn pairs_in(&self, at: usize) -> impl Iterator<Item = [u32; 2]> + '_ {
        let members = &self.boxes[at];
        let pairs = members.iter().enumerate();
        let pairs =
            pairs.flat_map(|(k, &one)| members[k + 1..].iter().map(move |&other| [one, other]));
        pairs.filter(move |pair| {
            let [one, other] = pair.map(|triangle| &self.bounds[triangle as usize]);
            one.overlaps(other) && self.number(self.steps(&one.min.sup(&other.min))) == at
        })
    }
}

/// Whether an edge of one triangle passes through the other. Edges at a common vertex cannot.
fn cross(mesh: &SurfaceMesh, partners: &[u32], [one, other]: [u32; 2]) -> bool {
    pierces(mesh, partners, one, other) || pierces(mesh, partners, other, one)
}

fn pierces(mesh: &SurfaceMesh, partners: &[u32], needle: u32, sheet: u32) -> bool {
    let ends = mesh.triangles[needle as usize];
    let vertices = mesh.triangles[sheet as usize];
    let point = |vertex: u32| exact(&mesh.vertices[vertex as usize]);
    let corners = vertices.map(point);
    (0..3).any(|k| {
        let (from, to) = (ends[k], ends[(k + 1) % 3]);
        if vertices.contains(&from) || vertices.contains(&to) {
            return false;
        }
        let needle = [from, to].map(point);
        match passage(needle, corners) {
            Passage::None => false,
            Passage::Inside => true,
            Passage::Side(side) => {
                let beyond = partners[3 * sheet as usize + side];
                beyond != NO_PARTNER && {
                    let beyond = mesh.triangles[beyond as usize / 3].map(point);
                    let [one, other] = [corners, beyond].map(|corners| sense(needle, corners));
                    one * other > 0.0
                }
            }
        }
    })
}

/// Where a segment passes properly through a triangle's plane.
enum Passage {
    None,
    /// Through the inside of the triangle.
    Inside,
    /// Through the inside of the side from this corner.
    Side(usize),
}

fn passage(needle @ [p, q]: [Coord3D<f64>; 2], corners @ [a, b, c]: [Coord3D<f64>; 3]) -> Passage {
    if sense(needle, corners) == 0.0 {
        return Passage::None;
    }
    let turns = [(a, b), (b, c), (c, a)].map(|(a, b)| robust::orient3d(p, q, a, b));
    let sides = turns.iter().filter(|&&turn| turn == 0.0).count();
    let is_one_way = turns.iter().all(|&turn| turn >= 0.0) || turns.iter().all(|&turn| turn <= 0.0);
    match (is_one_way, sides) {
        (true, 0) => Passage::Inside,
        (true, 1) => turns
            .iter()
            .position(|&turn| turn == 0.0)
            .map_or(Passage::None, Passage::Side),
        _ => Passage::None,
    }
}

/// ±1 where the segment passes properly through the triangle's plane, 0 where it does not.
fn sense([p, q]: [Coord3D<f64>; 2], [a, b, c]: [Coord3D<f64>; 3]) -> f64 {
    let [below, above] = [p, q].map(|end| robust::orient3d(a, b, c, end));
    let is_proper = below != 0.0 && above != 0.0 && (below > 0.0) != (above > 0.0);
    if is_proper { below.signum() } else { 0.0 }
}

fn exact(point: &Point3<f64>) -> Coord3D<f64> {
    let [x, y, z] = [point.x, point.y, point.z];
    Coord3D { x, y, z }
}
