//! What an octree gets wrong: Table 3 and Figure 14 of Bukenberger & Lensch.
//!
//! `cargo run --release --example octree -- [--axis x|y|z] [--depth 8] [MODEL…]`
//!
//! Every model is scaled to unit height, its density grows from 0 at the bottom to 1 at the top.
//! The octree halves the bounding cube wherever a triangle passes, down to a given depth; cells
//! on the last level count if their middle is inside. Cubes are integrated exactly, so all errors
//! are those of the shape. Errors are eq. 8, in percent: mass ε_M and inertia tensor ε_Θ (about
//! the center of mass, rows by their length) relative, center ε_C in units of the height. Without
//! models: three generated shapes.

use chebloyd::Moments;
use chebloyd::mass::body::Body;
use chebloyd::mass::density::{Ramp, SolidDensity};
use chebloyd::mass::weigh::weigh_surface;
use chebloyd::mesh::formats::read::load;
use chebloyd::mesh::shapes::{bracket, icosphere, trefoil};
use chebloyd::mesh::similarity::Similarity;
use chebloyd::mesh::surface::SurfaceMesh;
use chebloyd::mesh::validate::Solid;
use nalgebra::{Matrix3, Point3, Vector3};
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), String> {
    let (mut axis, mut deepest) = (2, 8);
    let mut models = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--axis" => {
                let name = value()?;
                let known = ["x", "y", "z"].iter().position(|known| *known == name);
                axis = known.ok_or("the axis is x, y or z")?;
            }
            "--depth" => deepest = value()?.parse().map_err(|_| "--depth needs a number")?,
            path => models.push((path.to_owned(), read(path)?)),
        }
    }
    if models.is_empty() {
        models.push(("trefoil knot".into(), trefoil(0.4, 600, 60)));
        models.push(("bracket".into(), bracket(8)));
        models.push(("icosphere".into(), icosphere(5)));
    }
    for (name, mesh) in &models {
        compare(name, mesh, axis, deepest);
    }
    Ok(())
}

fn read(path: &str) -> Result<SurfaceMesh, String> {
    match load(Path::new(path)).map_err(|error| error.to_string())? {
        Solid::Surface(closed, _) => Ok(closed.into_mesh()),
        Solid::Tets(sound, _) => Ok(sound.mesh().boundary()),
    }
}

fn compare(name: &str, mesh: &SurfaceMesh, axis: usize, deepest: u32) {
    let mut mesh = mesh.clone();
    Similarity::to_unit_height(&mesh.bounds(), axis).move_all(&mut mesh.vertices);
    let (from, to) = (0.0, 1.0);
    let density = SolidDensity::Ramp(Ramp { axis, from, to });
    let start = Instant::now();
    let exact = weigh_surface(&mesh, &density, &mesh.bounds()).expect("a solid has mass");
    let ours = start.elapsed().as_secs_f64();
    let [x, y, z] = exact.center_of_mass().into();
    let [a, b, c] = exact.principal().moments.into();
    println!(
        "{name}: {} vertices, {} triangles",
        mesh.vertices.len(),
        mesh.triangles.len()
    );
    println!(
        "  exact   mass {:.12}  center {x:.12} {y:.12} {z:.12}",
        exact.mass
    );
    println!(
        "          principal moments {a:.12} {b:.12} {c:.12}  in {:.3} ms",
        ours * 1e3
    );
    println!("  depth      nodes     time s   time/ours      ε_C %      ε_M %      ε_Θ %");
    for depth in 2..=deepest {
        let start = Instant::now();
        let (octree, nodes) = Octree::new(&mesh, axis, depth).weigh();
        let seconds = start.elapsed().as_secs_f64();
        let [center, mass, inertia] = errors(&octree, &exact).map(|error| 100.0 * error);
        println!(
            "  {depth:>5} {nodes:>10} {seconds:>10.4} {:>11.0} {center:>10.4} {mass:>10.4} {inertia:>10.4}",
            seconds / ours
        );
    }
}

/// ε_C, ε_M, ε_Θ of eq. 8.
fn errors(octree: &Body, exact: &Body) -> [f64; 3] {
    let (approximate, reference) = (octree.inertia_center(), exact.inertia_center());
    let rows = approximate.row_iter().zip(reference.row_iter());
    [
        (octree.center_of_mass() - exact.center_of_mass()).norm(),
        (octree.mass - exact.mass).abs() / exact.mass,
        rows.map(|(a, b)| (a - b).norm() / b.norm()).sum(),
    ]
}

struct Octree<'a> {
    mesh: &'a SurfaceMesh,
    /// The height axis, along which the density is the coordinate.
    axis: usize,
    depth: u32,
    corner: Point3<f64>,
    /// The side of a cell on the last level.
    side: f64,
    /// Per column of cells on the last level: heights at which its middle line enters (+1) or
    /// leaves (−1) the solid going down.
    columns: Vec<Vec<(f64, i32)>>,
}

impl<'a> Octree<'a> {
    fn new(mesh: &'a SurfaceMesh, axis: usize, depth: u32) -> Self {
        let bounds = mesh.bounds();
        let count = 1_usize << depth;
        let side = bounds.extent().max() / count as f64;
        let mut octree = Self {
            mesh,
            axis,
            depth,
            corner: bounds.min,
            side,
            columns: vec![Vec::new(); count * count],
        };
        for corners in mesh.all_corners() {
            octree.pierce(&corners);
        }
        octree
    }

    /// Notes where the columns' middle lines meet a triangle. Half-open edges: a line through an
    /// edge meets one of its two triangles.
    fn pierce(&mut self, [a, b, c]: &[Point3<f64>; 3]) {
        let count = 1_usize << self.depth;
        let edge = |p: &Point3<f64>, q: &Point3<f64>, x: f64, y: f64| {
            let (p, q, sign) = if (p.x, p.y) < (q.x, q.y) {
                (p, q, 1.0)
            } else {
                (q, p, -1.0)
            };
            let side = (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
            if side == 0.0 { sign } else { sign * side }
        };
        let span = |axis: usize| {
            let (low, high) = (
                a[axis].min(b[axis]).min(c[axis]),
                a[axis].max(b[axis]).max(c[axis]),
            );
            let cell = |x: f64| ((x - self.corner[axis]) / self.side - 0.5).max(0.0);
            cell(low).floor() as usize..=(cell(high).ceil() as usize).min(count - 1)
        };
        let normal = (b - a).cross(&(c - a));
        for i in span(0) {
            for j in span(1) {
                let x = self.corner.x + (i as f64 + 0.5) * self.side;
                let y = self.corner.y + (j as f64 + 0.5) * self.side;
                let sides = [edge(a, b, x, y), edge(b, c, x, y), edge(c, a, x, y)];
                let up = sides.iter().all(|&side| side > 0.0);
                if up || sides.iter().all(|&side| side < 0.0) {
                    let z = a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z;
                    self.columns[i * count + j].push((z, if up { 1 } else { -1 }));
                }
            }
        }
    }

    fn weigh(&self) -> (Body, usize) {
        let all: Vec<u32> = (0..self.mesh.triangles.len() as u32).collect();
        let (mut moments, mut volume, mut nodes) = (Moments::default(), 0.0, 0);
        self.visit(
            [0; 3],
            0,
            &all,
            &mut |place, size| {
                moments += self.cube(place, size);
                volume += size.powi(3);
            },
            &mut nodes,
        );
        (
            Body::from_moments(volume, 0.0, &moments, &self.corner),
            nodes,
        )
    }

    /// Halves the cell of `level` at `place` (in cells of the last level) while triangles pass.
    fn visit(
        &self,
        place: [usize; 3],
        level: u32,
        near: &[u32],
        take: &mut dyn FnMut(Vector3<f64>, f64),
        nodes: &mut usize,
    ) {
        *nodes += 1;
        let cells = 1_usize << (self.depth - level);
        let size = cells as f64 * self.side;
        let least = Vector3::from(place.map(|k| k as f64)) * self.side;
        if !near.is_empty() && level < self.depth {
            for octant in 0..8_usize {
                let half = cells / 2;
                let child = [0, 1, 2].map(|k| place[k] + (octant >> k & 1) * half);
                let least = Vector3::from(child.map(|k| k as f64)) * self.side;
                let middle = self.corner + least + Vector3::repeat(size / 4.0);
                let passes = |&triangle: &u32| self.passes(triangle, &middle, size / 4.0);
                let near: Vec<u32> = near.iter().copied().filter(passes).collect();
                self.visit(child, level + 1, &near, take, nodes);
            }
        } else if self.is_inside(place) {
            take(least, size);
        }
    }

    /// Whether a triangle may pass through a cube: its box overlaps and its plane cuts.
    fn passes(&self, triangle: u32, middle: &Point3<f64>, half: f64) -> bool {
        let [a, b, c] = self
            .mesh
            .corners(triangle as usize)
            .map(|corner| corner - middle);
        let overlaps = (0..3).all(|axis| {
            let (low, high) = (
                a[axis].min(b[axis]).min(c[axis]),
                a[axis].max(b[axis]).max(c[axis]),
            );
            low <= half && high >= -half
        });
        let normal = (b - a).cross(&(c - a));
        overlaps && normal.dot(&a).abs() <= half * normal.abs().sum()
    }

    /// Whether the middle of the last-level cell at `place` is inside.
    fn is_inside(&self, [i, j, k]: [usize; 3]) -> bool {
        let height = self.corner.z + (k as f64 + 0.5) * self.side;
        let above = self.columns[(i << self.depth) + j]
            .iter()
            .filter(|(z, _)| *z > height);
        above.map(|(_, turn)| turn).sum::<i32>() > 0
    }

    /// The moments of a cube of density = height, measured from the corner.
    fn cube(&self, least: Vector3<f64>, size: f64) -> Moments {
        let middle = least + Vector3::repeat(size / 2.0);
        let spread = size.powi(5) / 12.0;
        let mut gradient = Vector3::zeros();
        gradient[self.axis] = 1.0;
        let mass = (middle[self.axis] + self.corner[self.axis]) * size.powi(3);
        let mixed = gradient * middle.transpose() * spread;
        let own = Matrix3::from_diagonal_element(mass * size * size / 12.0);
        Moments {
            mass,
            first: middle * mass + gradient * spread,
            second: middle * middle.transpose() * mass + own + mixed + mixed.transpose(),
        }
    }
}
