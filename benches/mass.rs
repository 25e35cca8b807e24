//! How fast mass properties are: `cargo bench --bench mass`.
//!
//! Prints one table. Every time is the least of several runs on one thread unless it says
//! otherwise. "Read" rows do nothing but add up the same data by the same path (indices and
//! vertices), which is what no integration can beat. If Python with NumPy is present
//! (`PYTHON=… cargo bench --bench mass` to choose one), `benches/mass_numpy.py` runs the same
//! formulas on the same number of tetrahedra beside it.

use chebloyd::integrals::half_space::{CutPlane, CuttableSolid};
use chebloyd::integrals::mesh_moments;
use chebloyd::integrals::mesh_moments::LinearDensity;
use chebloyd::mass::density::{Ramp, SolidDensity};
use chebloyd::mass::weigh::weigh_surface;
use chebloyd::mesh::formats::read::read_surface;
use chebloyd::mesh::validate::validate_surface;
use nalgebra::{Point3, Vector3};
use std::f64::consts::TAU;
use std::hint::black_box;
use std::process::Command;
use std::time::{Duration, Instant};

/// The least time of so many runs counts, or of as many as fit.
const RUNS: usize = 40;
const PATIENCE: Duration = Duration::from_secs(4);

const ORIGIN: Point3<f64> = Point3::new(0.4, 0.5, 0.6);

fn main() {
    println!(
        "{:<52}{:>12}{:>12}{:>12}",
        "one thread unless it says otherwise", "ms", "ns each", "1e6 each/s"
    );
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.expect("a pool of one thread");
    one.install(|| {
        let linear = tetrahedra_rows(55);
        numpy_row(linear);
        half_space_rows(100);
        surface_rows("closed surface of 198 450 triangles (buddha: 198 736)", 315);
        surface_rows("closed surface of 2 000 000 triangles", 1000);
    });
    println!(
        "all {} threads, from a file to the body",
        rayon::current_num_threads()
    );
    file_rows("  198 450 triangles", 315);
    file_rows("  2 000 000 triangles", 1000);
}

const DENSITY: LinearDensity = LinearDensity {
    value: 1.0,
    gradient: Vector3::new(0.1, 0.2, 0.3),
};

fn tetrahedra_rows(cells: u32) -> f64 {
    let (vertices, tets) = grid_of_tetrahedra(cells);
    let densities: Vec<f64> = vertices.iter().map(|v| 1.0 + v.z).collect();
    let count = tets.len();
    println!("{count} tetrahedra on {} shared vertices", vertices.len());
    let read = row("  read: indices, corners, densities", count, &|| {
        tets.iter()
            .flatten()
            .map(|&v| vertices[v as usize].coords.sum() + densities[v as usize])
            .sum()
    });
    row(
        "  constant density: volume, center, inertia",
        count,
        &|| mesh_moments::constant(&vertices, &tets, &ORIGIN).mass,
    );
    let linear = row("  linear density: mass, center, inertia", count, &|| {
        mesh_moments::at_vertices(&vertices, &tets, &densities, &ORIGIN).mass
    });
    println!("  linear / read = {:.2}", linear / read);
    linear
}

fn surface_rows(name: &str, side: u32) {
    let (vertices, triangles) = torus(side);
    let count = triangles.len();
    println!("{name}");
    row("  read: indices, corners", count, &|| {
        triangles
            .iter()
            .flatten()
            .map(|&v| vertices[v as usize].coords.sum())
            .sum()
    });
    row("  surface area", count, &|| {
        mesh_moments::area(&vertices, &triangles)
    });
    let constant = row(
        "  constant density: volume, center, inertia",
        count,
        &|| mesh_moments::constant(&vertices, &triangles, &ORIGIN).mass,
    );
    let linear = row("  linear density: mass, center, inertia", count, &|| {
        mesh_moments::linear(&vertices, &triangles, &DENSITY, &ORIGIN).mass
    });
    println!("  linear / constant = {:.2}", linear / constant);
    let quadratic = "1 + 2*x - 0.5*y*z".parse().expect("a polynomial");
    row("  density 1 + 2*x - 0.5*y*z", count, &|| {
        mesh_moments::polynomial(&vertices, &triangles, &quadratic, &ORIGIN).mass
    });
}

/// Moments of the part above a plane, beside those of the whole; the plane halves the solid.
fn half_space_rows(side: u32) {
    let (vertices, triangles) = torus(side);
    let count = triangles.len();
    println!("closed surface of {count} triangles, above planes");
    let whole = row("  the whole: volume, center, inertia", count, &|| {
        mesh_moments::constant(&vertices, &triangles, &ORIGIN).mass
    });
    let solid = CuttableSolid::new(&vertices, &triangles);
    let mut worst = 0.0_f64;
    for (name, offset) in [("a tenth", 0.9), ("half", 0.0), ("nine tenths", -0.9)] {
        let normal = Vector3::new(0.8, 0.5, 0.3);
        let plane = CutPlane { normal, offset };
        let above = row(
            &format!("  {name} above: volume, center, second"),
            count,
            &|| solid.above(&plane).mass,
        );
        worst = worst.max(above / whole);
    }
    println!("  above / whole = {worst:.2} at most");
}

/// Prints a row and returns nanoseconds per item.
fn row(name: &str, count: usize, work: &dyn Fn() -> f64) -> f64 {
    let mut best = Duration::MAX;
    let begun = Instant::now();
    for run in 0..RUNS {
        let start = Instant::now();
        black_box(work());
        best = best.min(start.elapsed());
        if run > 0 && begun.elapsed() > PATIENCE {
            break;
        }
    }
    let each = best.as_secs_f64() * 1e9 / count as f64;
    println!(
        "{name:<52}{:>12.2}{each:>12.2}{:>12.1}",
        best.as_secs_f64() * 1e3,
        1e3 / each
    );
    each
}

/// Reading, checking and weighing a surface in a file, apart.
fn file_rows(name: &str, side: u32) {
    let (vertices, triangles) = torus(side);
    let path = std::env::temp_dir().join(format!("chebloyd-bench-{}.off", std::process::id()));
    let mut text = format!("OFF\n{} {} 0\n", vertices.len(), triangles.len());
    for v in &vertices {
        text += &format!("{} {} {}\n", v.x, v.y, v.z);
    }
    for [a, b, c] in &triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    std::fs::write(&path, text).expect("room for a file");
    let (from, to) = (0.0, 1.0);
    let ramp = SolidDensity::Ramp(Ramp { axis: 2, from, to });
    let mesh = read_surface(&path).expect("an OFF file");
    let (closed, _) = validate_surface(&mesh).expect("a closed surface");
    let (extent, count) = (mesh.bounds(), triangles.len());
    row(&format!("{name}: read the OFF file"), count, &|| {
        read_surface(&path).map_or(0.0, |mesh| mesh.vertices[0].x)
    });
    row(&format!("{name}: check it"), count, &|| {
        validate_surface(&mesh).map_or(0.0, |(closed, _)| closed.mesh().vertices[0].x)
    });
    row(&format!("{name}: weigh it, linear density"), count, &|| {
        weigh_surface(closed.mesh(), &ramp, &extent).map_or(0.0, |body| body.mass)
    });
    // A file that stays behind harms nobody.
    let _ = std::fs::remove_file(&path);
}

/// The same formulas in NumPy, if there is one.
fn numpy_row(ours: f64) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/mass_numpy.py");
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let output = Command::new(&python).args([script, "1000000"]).output();
    let each = output
        .ok()
        .filter(|output| output.status.success())
        .and_then(|output| String::from_utf8(output.stdout).ok())
        .and_then(|text| text.trim().parse::<f64>().ok());
    match each {
        Some(each) => {
            let name = "  linear density, NumPy, 1 000 000 tetrahedra";
            println!("{name:<52}{each:>12.2}{each:>12.2}{:>12.1}", 1e3 / each);
            println!("  NumPy / ours = {:.1}", each / ours);
        }
        None => println!("  NumPy row skipped: {python} has no NumPy"),
    }
}

/// `cells`³ cubes of six tetrahedra each, jittered so that no two are alike.
fn grid_of_tetrahedra(cells: u32) -> (Vec<Point3<f64>>, Vec<[u32; 4]>) {
    let side = cells + 1;
    let mut vertices = Vec::new();
    for i in 0..side * side * side {
        let at = [i % side, i / side % side, i / (side * side)].map(f64::from);
        let jitter = (f64::from(i) * 0.618).fract() * 0.2;
        vertices.push(Point3::from(at.map(|x| (x + jitter) / f64::from(cells))));
    }
    let (x, y, z) = (1, side, side * side);
    let mut tets = Vec::new();
    for corner in 0..side * side * side {
        let at = [corner % side, corner / side % side, corner / (side * side)];
        if at.iter().all(|&i| i < cells) {
            for (a, b) in [(x, y), (y, z), (z, x)] {
                let far = corner + x + y + z;
                tets.push([corner, corner + a, corner + a + b, far]);
                tets.push([corner, corner + a + b, corner + b, far]);
            }
        }
    }
    (vertices, tets)
}

/// A torus of 2·`side`² triangles.
fn torus(side: u32) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let angle = |i: u32| f64::from(i) * TAU / f64::from(side);
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..side {
        for j in 0..side {
            let ring = 1.0 + 0.4 * angle(j).cos();
            let (sine, cosine) = angle(i).sin_cos();
            vertices.push(Point3::new(
                ring * cosine,
                ring * sine,
                0.4 * angle(j).sin(),
            ));
            let (next_i, next_j) = ((i + 1) % side, (j + 1) % side);
            let [a, b, c, d] =
                [(i, j), (next_i, j), (next_i, next_j), (i, next_j)].map(|(i, j)| i * side + j);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (vertices, triangles)
}
