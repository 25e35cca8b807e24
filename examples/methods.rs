//! Prints what every method makes of the same random sites: the tables of the README.
//!
//! `cargo run --release --example methods -- [count=1000] [from=1] [to=1] [extent=1] [periodic=0]
//! [scene=FILE] [surface=FILE] [only=NAME,…] [trace=0]`: `count` sites of every seed `from` … `to`, in
//! a box of the lengths `extent`, 1, 1, in the domain of a scene, or in a surface fitted into the unit
//! cube.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::geometry::bounds::Bounds;
use chebloyd::relax::driver::drive;
use chebloyd::relax::metrics::Metrics;
use chebloyd::relax::plan::{Perturbation, PerturbationKind, Plan};
use chebloyd::relax::relaxation_space::{EnergySpec, RelaxationSpace};
use chebloyd::relax::space::Space;
use chebloyd::relax::state::RunState;
use chebloyd::scene::random::Uniform;
use chebloyd::scene::read;
use nalgebra::Point3;

fn option(name: &str) -> Option<String> {
    let prefix = format!("{name}=");
    std::env::args().find_map(|argument| argument.strip_prefix(&prefix).map(str::to_owned))
}

fn number(name: &str, default: f64) -> f64 {
    option(name).map_or(default, |value| value.parse().expect("a number"))
}

/// The methods of the tables.
fn plans(count: usize) -> Vec<(&'static str, Plan)> {
    let lloyd = |iterations| Plan::lloyd(Plan::quasi_newton(1, 1).spec, iterations);
    let accelerated = |iterations| Plan {
        is_accelerated: true,
        ..lloyd(iterations)
    };
    vec![
        ("lloyd-50", lloyd(50)),
        ("lloyd-150", lloyd(150)),
        ("lloyd-400", lloyd(400)),
        ("accelerated-50", accelerated(50)),
        ("accelerated-150", accelerated(150)),
        ("quasi-newton-24", Plan::quasi_newton(1, 24)),
        ("quasi-newton-175", Plan::quasi_newton(1, 175)),
        (
            "anneal",
            Plan::perturbed(1, Perturbation::default_of(PerturbationKind::Anneal)),
        ),
        (
            "exchange",
            Plan::perturbed(1, Perturbation::default_of(PerturbationKind::Exchange)),
        ),
        ("cubes", Plan::cubes(1, count)),
    ]
}

fn space() -> Space {
    if let Some(path) = option("scene") {
        let scene = read::scene(Path::new(&path)).expect("a scene");
        return Space::new(scene.solid().expect("a solid").0);
    }
    if let Some(path) = option("surface") {
        let path = Path::new(&path).canonicalize().expect("a file");
        let domain = serde_json::json!({ "surface": path, "scale_to": "unit_cube" });
        let text = serde_json::json!({ "domain": domain, "sites": { "random": { "count": 1 } } });
        let scene = read::parse(&text.to_string(), Path::new("surface")).expect("a scene");
        return Space::new(scene.solid().expect("a solid").0);
    }
    let bounds = Bounds {
        min: Point3::origin(),
        max: Point3::new(number("extent", 1.0), 1.0, 1.0),
    };
    let periodic = number("periodic", 0.0) > 0.0;
    Space::new(Box::new(Cuboid::new(bounds, [periodic; 3]).expect("a box")))
}

fn figures(space: &Space, sites: &[Point3<f64>], question: EnergySpec) -> Metrics {
    let cells = space.metrics(sites, question).expect("sites have cells");
    Metrics::of(space.volume(), &cells)
}

fn run(space: &Space, name: &str, plan: &Plan, given: &[Point3<f64>], seed: usize) {
    let mut sites = given.to_vec();
    let mut state = RunState::new(sites.len(), plan.levels);
    let mut evaluations = 0.0;
    let began = Instant::now();
    let trace = number("trace", 0.0) > 0.0;
    drive(
        space,
        plan,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            evaluations = record.evaluations;
            if trace {
                println!(
                    "{} level {:?} round {:?} sites {:?} energy {:.5} evaluations {:.1} {:.2} s",
                    record.iteration,
                    record.stage.level,
                    record.stage.round,
                    record.stage.sites,
                    record.energy_percent,
                    record.evaluations,
                    record.seconds
                );
            }
            ControlFlow::Continue(())
        },
    )
    .expect("the run ends well");
    let seconds = began.elapsed().as_secs_f64();
    let figures = figures(space, &sites, plan.spec);
    println!(
        "| {name} | {} | {seed} | {:.4} | {:.4} | {:.3} | {:.4} | {evaluations:.0} | {seconds:.2} |",
        sites.len(),
        figures.energy_percent,
        figures.cubeness,
        figures.six_facet_fraction,
        figures.axis_aligned_area,
    );
}

/// As many random sites as asked for that lie in the domain.
fn sites(space: &Space, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut uniform = Random::new(seed);
    let points = std::iter::repeat_with(|| uniform.point(&space.bounds()));
    let inside = points.filter(|site| space.domain().contains(site));
    inside.take(count).collect()
}

fn main() {
    let count = number("count", 1000.0) as usize;
    let space = space();
    let only = option("only");
    let is_asked = |name: &str| {
        let names = only.as_ref().map(|only| only.split(','));
        names.is_none_or(|mut names| names.any(|only| only == name))
    };
    println!(
        "| method | sites | seed | energy % | cubeness | six-facet | aligned | evaluations | s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for seed in number("from", 1.0) as usize..=number("to", 1.0) as usize {
        let given = sites(&space, count, seed as u64);
        for (name, plan) in plans(count) {
            if is_asked(name) {
                run(&space, name, &plan, &given, seed);
            }
        }
    }
}
