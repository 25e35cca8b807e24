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

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::domain::domain::Domain;
use chebloyd::domain::tet_mesh::TetSolid;
use chebloyd::domain::tri_surface::solid::SurfaceSolid;
use chebloyd::geometry::random::Random;
use chebloyd::mesh::formats::read::load;
use chebloyd::mesh::similarity::Similarity;
use chebloyd::relax::driver::drive;
use chebloyd::relax::plan::Plan;
use chebloyd::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use chebloyd::relax::space::Space;
use chebloyd::relax::state::RunState;
use chebloyd::scene::random::Uniform;
use nalgebra::Point3;

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

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
fn domain(path: &Path) -> Result<(Box<dyn Domain>, usize), String> {
    let mut solid = load(path).map_err(|error| error.to_string())?;
    let bounds = match &solid {
        Solid::Surface(surface, _) => surface.mesh().bounds(),
        Solid::Tets(tets, _) => tets.mesh().bounds(),
    };
    solid.transform(&Similarity::into_unit_cube(&bounds));
    Ok(match solid {
        Solid::Surface(surface, _) => {
            let count = surface.mesh().triangles.len();
            let domain = SurfaceSolid::new(&surface).map_err(|error| error.to_string())?;
            (Box::new(domain), count)
        }
        Solid::Tets(tets, _) => {
            let count = tets.mesh().tets.len();
            let domain = TetSolid::new(&tets).map_err(|error| error.to_string())?;
            (Box::new(domain), count)
        }
    })
}

fn sites(space: &Space, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut uniform = Random::new(seed);
    let bounds = space.bounds();
    let places = std::iter::from_fn(|| Some(uniform.point(&bounds)));
    let inside = places.filter(|place| space.domain().contains(place));
    inside.take(count).collect()
}

/// The last energy of a run, in percent.
fn relaxed(space: &Space, start: &[Point3<f64>], norm: Norm, iterations: u64) -> f64 {
    let mut sites = start.to_vec();
    let mut energy = f64::NAN;
    let options = Plan::lloyd(EnergySpec { norm, ..LINF }, iterations);
    let mut state = RunState::new(sites.len(), 0);
    drive(
        space,
        &options,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            energy = record.energy_percent;
            ControlFlow::Continue(())
        },
    )
    .expect("sites stay in the solid");
    energy
}

/// Microseconds a site and iteration.
fn cost(space: &Space, sites: &[Point3<f64>]) -> f64 {
    let once = || {
        let began = Instant::now();
        space.assess(sites, LINF).expect("a diagram");
        began.elapsed().as_secs_f64() * 1e6 / sites.len() as f64
    };
    (0..REPEATS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn row(path: &Path) -> Result<String, String> {
    let (count, iterations) = (number("count", 300), number("iterations", 50) as u64);
    let (domain, elements) = domain(path)?;
    let space = Space::new(domain);
    let start = sites(&space, count, 1);
    let [linf, l2] = [Norm::Linf, Norm::L2].map(|norm| relaxed(&space, &start, norm, iterations));
    let many = sites(&space, number("fill", 1000), 2);
    let figures = space
        .metrics(&many, LINF)
        .map_err(|error| error.to_string())?;
    let sum: f64 = figures.iter().map(|cell| cell.volume).sum();
    let error = (sum / space.volume() - 1.0).abs();
    let cube = Space::new(Box::new(Cuboid::unit()));
    let beside = sites(&cube, many.len(), 2);
    let (here, there) = (cost(&space, &many), cost(&cube, &beside));
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
