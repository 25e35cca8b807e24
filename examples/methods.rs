//! Prints what every method makes of the same random sites: the table of the README.
//!
//! `cargo run --release --example methods -- [count=1000] [from=1] [to=1] [extent=1] [periodic=0]
//! [only=NAME] [trace=0]`

use std::ops::ControlFlow;
use std::time::Instant;

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::geometry::bounds::Bounds;
use chebloyd::relax::figures::Figures;
use chebloyd::relax::plan::{KickStyle, Kicks, Plan};
use chebloyd::relax::space::Space;
use chebloyd::relax::stand::Stand;
use chebloyd::relax::tessellation::{Question, Tessellation};
use chebloyd::relax::travel::travel;
use chebloyd::scene::random::Uniform;
use nalgebra::Point3;

fn option(name: &str) -> Option<String> {
    let prefix = format!("{name}=");
    std::env::args().find_map(|argument| argument.strip_prefix(&prefix).map(str::to_owned))
}

fn number(name: &str, default: f64) -> f64 {
    option(name).map_or(default, |value| value.parse().expect("a number"))
}

/// The methods of the table.
fn plans(count: usize) -> Vec<(&'static str, Plan)> {
    let lloyd = |iterations| Plan {
        descent: None,
        ..Plan::quasi_newton(1, iterations)
    };
    vec![
        ("lloyd-50", lloyd(50)),
        ("lloyd-400", lloyd(400)),
        ("quasi-newton-20", Plan::quasi_newton(1, 20)),
        ("quasi-newton-200", Plan::quasi_newton(1, 200)),
        (
            "anneal",
            Plan::kicked(1, Kicks::default_of(KickStyle::Anneal)),
        ),
        (
            "exchange",
            Plan::kicked(1, Kicks::default_of(KickStyle::Exchange)),
        ),
        ("cubes", Plan::cubes(1, count)),
    ]
}

fn space(extent: f64, periodic: bool) -> Space {
    let bounds = Bounds {
        min: Point3::origin(),
        max: Point3::new(extent, 1.0, 1.0),
    };
    Space::new(Box::new(Cuboid::new(bounds, [periodic; 3]).expect("a box")))
}

fn figures(space: &Space, sites: &[Point3<f64>], question: Question) -> Figures {
    let cells = space.figures(sites, question).expect("sites have cells");
    Figures::of(space.volume(), &cells)
}

fn run(space: &Space, name: &str, plan: &Plan, given: &[Point3<f64>], seed: usize) {
    let mut sites = given.to_vec();
    let mut stand = Stand::new(sites.len(), plan.levels);
    let mut evaluations = 0.0;
    let began = Instant::now();
    let trace = number("trace", 0.0) > 0.0;
    travel(
        space,
        plan,
        &mut sites,
        &mut stand,
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
    let figures = figures(space, &sites, plan.question);
    println!(
        "| {name} | {} | {seed} | {:.4} | {:.4} | {:.3} | {:.4} | {evaluations:.0} | {seconds:.2} |",
        sites.len(),
        figures.energy_percent,
        figures.cubeness,
        figures.six_facet_fraction,
        figures.axis_aligned_area,
    );
}

fn main() {
    let count = number("count", 1000.0) as usize;
    let space = space(number("extent", 1.0), number("periodic", 0.0) > 0.0);
    let only = option("only");
    println!(
        "| method | sites | seed | energy % | cubeness | six-facet | aligned | evaluations | s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for seed in number("from", 1.0) as usize..=number("to", 1.0) as usize {
        let mut uniform = Uniform::new(seed as u64);
        let given: Vec<_> = (0..count).map(|_| uniform.point(&space.bounds())).collect();
        for (name, plan) in plans(count) {
            if only.as_ref().is_none_or(|only| only == name) {
                run(&space, name, &plan, &given, seed);
            }
        }
    }
}
