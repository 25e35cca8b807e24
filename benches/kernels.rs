//! The stages of an iteration of 10 000 sites, as `relax` takes them.
//!
//! `cargo bench` times them with criterion; `chebloyd bench` prints them per site and thread.

use std::hint::black_box;

use chebloyd::{Cuboid, Diagram, Method, Norm, Relaxation, random_sites};
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Point3;

const SITES: usize = 10_000;

fn sites() -> Vec<Point3<f64>> {
    random_sites(&Cuboid::unit(), SITES, 1).expect("a cube has room")
}

fn diagrams(criterion: &mut Criterion) {
    let (sites, cube) = (sites(), Cuboid::unit());
    let diagram = || Diagram::new(&cube, &sites).expect("random sites have a diagram");
    let mut group = criterion.benchmark_group("10 000 cells");
    group.sample_size(10);
    group.bench_function("spatial index", |bencher| {
        bencher.iter(|| diagram().sort_sites());
    });
    group.bench_function("built", |bencher| {
        bencher.iter(|| diagram().map_cells(|cell| black_box(cell.site)));
    });
    group.bench_function("moments", |bencher| {
        bencher.iter(|| diagram().map_cells(|cell| black_box(cell.moments())));
    });
    group.finish();
}

/// One move of a method includes the evaluation before it.
fn moves(criterion: &mut Criterion) {
    let sites = sites();
    let mut group = criterion.benchmark_group("one move of 10 000 sites");
    group.sample_size(10);
    for (name, method) in [
        ("lloyd", Method::lloyd(1)),
        ("lloyd, order 3", Method::lloyd(1).order(3)),
        ("lloyd, l2", Method::lloyd(1).norm(Norm::L2)),
        ("quasi-newton", Method::quasi_newton(1)),
    ] {
        let relaxation = Relaxation::new(Cuboid::unit()).method(method);
        group.bench_function(name, |bencher| {
            bencher.iter(|| relaxation.run(&mut sites.clone()));
        });
    }
    group.finish();
}

criterion_group!(benches, diagrams, moves);
criterion_main!(benches);
