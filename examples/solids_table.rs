//! Both norms in solids of any shape, cells that fill them, and what an iteration costs: the table
//! of the README.
//!
//! `cargo run --release --example solids_table -- [count=300] [iterations=50] [fill=1000] [MODEL…]`
//!
//! Every solid is fitted into the unit cube. The same random sites (seed 1) are relaxed in both
//! norms; energies are those of the L∞ norm, in percent of equal cubes'. `error` is |Σ volumes /
//! volume − 1| of the cells of `fill` other sites, `cost` the time of an iteration with them, beside
//! that of as many in a cube. Without models: the scenes' torus, trefoil and bracket, and
//! `../shared/models` where that is there.

use std::error::Error;
use std::path::{Path, PathBuf};

use chebloyd::mesh::formats::read::load;
use chebloyd::mesh::similarity::Similarity;
use chebloyd::mesh::validate::Solid;
use chebloyd::{Cuboid, Domain, Method, Norm, Relaxation, SurfaceSolid, TetSolid, random_sites};
use nalgebra::Point3;

/// Iterations that are timed; the fastest counts.
const REPEATS: usize = 3;

fn number(name: &str, default: usize) -> usize {
    let prefix = format!("{name}=");
    let given = std::env::args().find_map(|text| text.strip_prefix(&prefix).map(str::to_owned));
    given.map_or(default, |value| value.parse().expect("a number"))
}

fn models() -> Vec<PathBuf> {
    let given = std::env::args().skip(1).filter(|text| !text.contains('='));
    let given: Vec<PathBuf> = given.map(PathBuf::from).collect();
    if !given.is_empty() {
        return given;
    }
    let scenes = ["torus.off", "trefoil.off", "bracket.off"];
    let mut models: Vec<PathBuf> = scenes.map(|name| Path::new("scenes").join(name)).into();
    let shared = std::fs::read_dir("../shared/models").into_iter().flatten();
    let shared = shared.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    let is_mesh = |path: &PathBuf| {
        let kind = path.extension().and_then(|kind| kind.to_str());
        matches!(kind, Some("off" | "obj" | "mesh"))
    };
    let mut shared: Vec<PathBuf> = shared.filter(is_mesh).collect();
    shared.sort();
    models.extend(shared);
    models
}

/// The domain of a mesh file, and how many elements it has.
fn domain(path: &Path) -> Result<(Box<dyn Domain>, usize), Box<dyn Error>> {
    let mut solid = load(path)?;
    let bounds = match &solid {
        Solid::Surface(surface, _) => surface.mesh().bounds(),
        Solid::Tets(tets, _) => tets.mesh().bounds(),
    };
    solid.transform(&Similarity::into_unit_cube(&bounds));
    Ok(match solid {
        Solid::Surface(surface, _) => {
            let count = surface.mesh().triangles.len();
            (Box::new(SurfaceSolid::new(&surface)?), count)
        }
        Solid::Tets(tets, _) => {
            let count = tets.mesh().tets.len();
            (Box::new(TetSolid::new(&tets)?), count)
        }
    })
}

/// Microseconds a site and iteration: what a move adds to the evaluation of the start.
fn cost(relaxation: &Relaxation, sites: &[Point3<f64>]) -> Result<f64, Box<dyn Error>> {
    let mut least = f64::INFINITY;
    for _ in 0..REPEATS {
        let outcome = relaxation.run(&mut sites.to_vec())?;
        let seconds = outcome.records[1].seconds - outcome.records[0].seconds;
        least = least.min(seconds * 1e6 / sites.len() as f64);
    }
    Ok(least)
}

fn row(path: &Path) -> Result<String, Box<dyn Error>> {
    let (count, iterations) = (number("count", 300), number("iterations", 50) as u64);
    let (domain, elements) = domain(path)?;
    let (start, many) = (
        random_sites(domain.as_ref(), count, 1)?,
        random_sites(domain.as_ref(), number("fill", 1000), 2)?,
    );
    let volume = domain.volume();
    let mut solid = Relaxation::boxed(domain);
    let mut energies = [0.0; 2];
    for (energy, norm) in energies.iter_mut().zip([Norm::Linf, Norm::L2]) {
        solid = solid.method(Method::lloyd(iterations).norm(norm));
        let outcome = solid.run(&mut start.clone())?;
        *energy = outcome
            .records
            .last()
            .map_or(f64::NAN, |record| record.energy_percent);
    }
    let [linf, l2] = energies;
    let error = (solid.measure(&many)?.volume_sum / volume - 1.0).abs();
    let cube = Relaxation::new(Cuboid::unit()).method(Method::lloyd(1));
    let beside = random_sites(&Cuboid::unit(), many.len(), 2)?;
    let here = cost(&solid.method(Method::lloyd(1)), &many)?;
    let there = cost(&cube, &beside)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let verdict = if linf < l2 { "" } else { " NOT LOWER" };
    Ok(format!(
        "| {name} | {elements} | {l2:.2} | {linf:.2}{verdict} | {error:.0e} | {here:.1} | {:.2} |",
        here / there
    ))
}

fn main() {
    println!("| solid | elements | `l2` % | `linf` % | error | cost, µs | of a cube's |");
    println!("|---|---|---|---|---|---|---|");
    for path in models() {
        match row(&path) {
            Ok(row) => println!("{row}"),
            Err(refusal) => println!("| {refusal} |"),
        }
    }
}
