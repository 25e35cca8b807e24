//! The paper's way beside ours: a center of mass put over a point, and a solid that spins about an axis.
//!
//! ```text
//! cargo build --release && cargo run --release --example balance [-- FOLDER_OF_MODELS]
//! ```
//!
//! The paper (section 3.2) lets Powell's method, which knows no gradients, choose five parameters of a
//! clamped ramp, the direction's angles α and β, the offset, the width r and the slope s (t = 1), so that the
//! center's distance from the vertical through the point becomes least. Here it starts three times at random.
//! Ours are `chebloyd stand` and `chebloyd spin`, their seconds those of the whole program. Powell is
//! written after Press et al., *Numerical Recipes*, 10.3 and 10.7.

use std::error::Error;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use chebloyd::mass::density::SolidDensity;
use chebloyd::mass::weigh::weigh_surface;
use chebloyd::mesh::formats::read::read_surface;
use chebloyd::mesh::shapes::icosphere;
use chebloyd::mesh::surface::SurfaceMesh;
use nalgebra::{Point3, Vector3};
use serde_json::Value;

/// Powell gives up after so many evaluations.
const MOST_EVALUATIONS: usize = 3000;

/// Distances below this share of the height are zero for it.
const GOAL: f64 = 1e-10;

/// The rocker arm's bore.
const BORE: &str = "0,0.06717941,0.08491692,0.99997285,-0.00727018,0.00120118";

/// A solid and the point over which its center is to be.
struct Task {
    name: &'static str,
    file: PathBuf,
    mesh: SurfaceMesh,
    up: Vector3<f64>,
    point: Point3<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1);
    let folder = PathBuf::from(folder.unwrap_or_else(|| "../shared/models".to_owned()));
    println!(
        "{:<34}{:>12}{:>10}{:>14}{:>12}",
        "", "evaluations", "seconds", "contrast", "distance"
    );
    for task in tasks(&folder)? {
        for seed in 1..=3 {
            powell_row(&task, seed);
        }
        stand_row(&task)?;
    }
    let rocker = folder.join("rocker-arm.obj");
    if rocker.is_file() {
        let file = rocker.display().to_string();
        let spin = ["spin", &file, "--axis", BORE, "--json"];
        spin_row(
            "rocker arm spins: 1000 cells, 1-4",
            &spin,
            &["--range", "1,4"],
        )?;
        spin_row(
            "  the paper's sine, 400 starts",
            &spin,
            &["--field", "sine"],
        )?;
    }
    Ok(())
}

/// Three leaning spheres, and the models that are there.
fn tasks(folder: &Path) -> Result<Vec<Task>, Box<dyn Error>> {
    let spheres = spheres();
    let file = std::env::temp_dir().join("chebloyd-spheres.off");
    std::fs::write(&file, off(&spheres))?;
    let mut tasks = vec![Task {
        name: "three leaning spheres",
        file,
        mesh: spheres,
        up: Vector3::z(),
        point: Point3::new(0.0, 0.0, -0.5),
    }];
    for (name, file, up) in [
        ("bunny on its head", "bunny.off", -Vector3::y()),
        (
            "rocker arm on its lowest vertex",
            "rocker-arm.obj",
            Vector3::z(),
        ),
    ] {
        let file = folder.join(file);
        if !file.is_file() {
            println!("{} is not there", file.display());
            continue;
        }
        let mesh = read_surface(&file)?;
        let height = |vertex: &&Point3<f64>| up.dot(&vertex.coords);
        let vertices = mesh.vertices.iter();
        let lowest = vertices.min_by(|one, other| height(one).total_cmp(&height(other)));
        tasks.push(Task {
            name,
            file,
            point: *lowest.ok_or("no vertices")?,
            mesh,
            up,
        });
    }
    Ok(tasks)
}

/// Spheres of diameter 1, each 0.25 further to the right than the one below.
fn spheres() -> SurfaceMesh {
    let mut all = SurfaceMesh::default();
    for sphere in 0..3 {
        let part = icosphere(4);
        let shift = Vector3::new(0.25, 0.0, 0.9682) * f64::from(sphere);
        let first = all.vertices.len() as u32;
        let radius = part.vertices[0].coords.norm();
        let placed = part.vertices.iter().map(|v| v * (0.5 / radius) + shift);
        all.vertices.extend(placed);
        let numbered = part.triangles.iter().map(|t| t.map(|v| v + first));
        all.triangles.extend(numbered);
    }
    all
}

fn off(mesh: &SurfaceMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for v in &mesh.vertices {
        text += &format!("{} {} {}\n", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

fn row(name: &str, evaluations: usize, seconds: f64, contrast: f64, distance: f64) {
    println!("{name:<34}{evaluations:>12}{seconds:>10.3}{contrast:>14.4e}{distance:>12.1e}");
}

/// How far a center is from the vertical through the task's point.
fn off_vertical(task: &Task, center: &Point3<f64>) -> f64 {
    let way = center - task.point;
    (way - task.up * way.dot(&task.up)).norm()
}

fn powell_row(task: &Task, seed: u64) {
    let started = Instant::now();
    let bounds = task.mesh.bounds();
    let (middle, size) = (bounds.center(), bounds.extent().norm());
    let evaluate = |x: &[f64; 5]| {
        let [alpha, beta, offset, width, slope] = *x;
        let (width, slope) = (width.abs() * size, slope.abs() / size);
        let direction = Vector3::new(
            alpha.cos() * beta.cos(),
            alpha.sin() * beta.cos(),
            beta.sin(),
        );
        let start = direction.dot(&middle.coords) + offset * size;
        let gradient = direction * slope;
        let high = 1.0 + slope * width;
        let density = SolidDensity::clamp(1.0, high, 1.0 - slope * start, &gradient);
        let body = density
            .ok()
            .and_then(|density| weigh_surface(&task.mesh, &density, &bounds).ok());
        let distance = body.map_or(f64::MAX, |body| off_vertical(task, &body.center_of_mass()));
        (distance / size, high)
    };
    let mut random = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut uniform = || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    let start = [
        TAU * uniform(),
        0.25 * TAU * (2.0 * uniform() - 1.0),
        uniform() - 0.5,
        uniform(),
        10.0 * uniform(),
    ];
    let (best, evaluations) = powell(start, |x| evaluate(x).0);
    let (distance, contrast) = evaluate(&best);
    let name = format!("{}: Powell {seed}", task.name);
    let seconds = started.elapsed().as_secs_f64();
    row(&name, evaluations, seconds, contrast, distance * size);
}

/// Powell's method: the point reached, and evaluations.
fn powell(start: [f64; 5], evaluate: impl Fn(&[f64; 5]) -> f64) -> ([f64; 5], usize) {
    let mut count = 0;
    let mut counted = |x: &[f64; 5]| {
        count += 1;
        evaluate(x)
    };
    let mut directions = [0, 1, 2, 3, 4].map(|k| {
        let mut unit = [0.0; 5];
        unit[k] = 1.0;
        unit
    });
    let (mut x, mut value, mut spent) = (start, counted(&start), 0);
    while spent < MOST_EVALUATIONS && value > GOAL {
        let (from, before) = (x, value);
        let (mut largest, mut which) = (0.0, 0);
        for k in 0..5 {
            let fell = value;
            (x, value) = along(&x, value, &directions[k], &mut counted, &mut spent);
            if fell - value > largest {
                (largest, which) = (fell - value, k);
            }
        }
        if before - value <= 1e-9 * before {
            break;
        }
        let way: [f64; 5] = std::array::from_fn(|k| x[k] - from[k]);
        let beyond = std::array::from_fn(|k| x[k] + way[k]);
        let farther = counted(&beyond);
        let curved = 2.0 * (before - 2.0 * value + farther) * (before - value - largest).powi(2);
        if farther < before && curved < largest * (before - farther).powi(2) {
            (x, value) = along(&x, value, &way, &mut counted, &mut spent);
            directions[which] = directions[4];
            directions[4] = way;
        }
    }
    (x, count)
}

/// The least value along a direction: bracketed by golden steps, then golden sections.
fn along(
    x: &[f64; 5],
    value: f64,
    direction: &[f64; 5],
    evaluate: &mut impl FnMut(&[f64; 5]) -> f64,
    spent: &mut usize,
) -> ([f64; 5], f64) {
    const GOLDEN: f64 = 1.618_033_988_749_895;
    let at = |share: f64| std::array::from_fn(|k| x[k] + share * direction[k]);
    let mut evaluated = |share: f64| {
        *spent += 1;
        evaluate(&at(share))
    };
    let (mut a, mut b, mut low) = (0.0, 0.1, value);
    let mut next = evaluated(b);
    if next > low {
        (a, b) = (b, a);
        (low, next) = (next, low);
    }
    let mut c = b + GOLDEN * (b - a);
    let mut beyond = evaluated(c);
    for _ in 0..40 {
        if beyond >= next {
            break;
        }
        (a, low, b, next) = (b, next, c, beyond);
        c = b + GOLDEN * (b - a);
        beyond = evaluated(c);
    }
    let _ = low;
    for _ in 0..40 {
        if (c - a).abs() <= 1e-4 * b.abs().max(1e-8) {
            break;
        }
        let wide = if (c - b).abs() > (b - a).abs() { c } else { a };
        let trial = b + 0.381_966 * (wide - b);
        let found = evaluated(trial);
        if found < next {
            if (wide - c).abs() <= 0.0 {
                a = b
            } else {
                c = b
            }
            (b, next) = (trial, found);
        } else if (wide - c).abs() <= 0.0 {
            c = trial;
        } else {
            a = trial;
        }
    }
    if next < value {
        (at(b), next)
    } else {
        (*x, value)
    }
}

fn stand_row(task: &Task) -> Result<(), Box<dyn Error>> {
    let file = task.file.display().to_string();
    let [up, point] = [task.up, task.point.coords].map(|v| format!("{},{},{}", v.x, v.y, v.z));
    let up = format!("--up={up}");
    let point = format!("--point={point}");
    let (report, seconds) = program(&["stand", &file, &up, &point, "--json"])?;
    let center = &report["center_of_mass"];
    let center = Point3::new(number(&center[0]), number(&center[1]), number(&center[2]));
    let contrast = number(&report["range"][1]) / number(&report["range"][0]);
    let evaluations = number(&report["evaluations"]) + number(&report["contrast_evaluations"]);
    let name = format!("{}: stand", task.name);
    row(
        &name,
        evaluations as usize,
        seconds,
        contrast,
        off_vertical(task, &center),
    );
    Ok(())
}

fn spin_row(name: &str, spin: &[&str], more: &[&str]) -> Result<(), Box<dyn Error>> {
    let (report, seconds) = program(&[spin, more].concat())?;
    // The sine reaches zero: its contrast is infinite.
    let range = &report["range"];
    let contrast = match range.is_null() {
        true => f64::INFINITY,
        false => number(&range[1]) / number(&range[0]),
    };
    let evaluations = number(&report["evaluations"]) as usize;
    row(
        name,
        evaluations,
        seconds,
        contrast,
        number(&report["distance"]),
    );
    println!("{:<34}{:>48.1e}°", "", number(&report["angle_degrees"]));
    Ok(())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// What the program prints, and its seconds.
fn program(arguments: &[&str]) -> Result<(Value, f64), Box<dyn Error>> {
    let own = std::env::current_exe()?;
    let folder = own.parent().and_then(Path::parent).ok_or("no folder")?;
    let program = folder.join(format!("chebloyd{}", std::env::consts::EXE_SUFFIX));
    let started = Instant::now();
    let output = Command::new(&program).args(arguments).output();
    let output =
        output.map_err(|error| format!("{}: {error}; build it first", program.display()))?;
    let seconds = started.elapsed().as_secs_f64();
    let report = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).into_owned())?;
    Ok((report, seconds))
}
