//! The kernels of an iteration, each on the cells of the same random sites.
//!
//! `cargo bench` times them with criterion; `chebloyd bench` prints the stages of whole iterations.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::energy::evaluation::{EnergyScratch, SignedPiece, energy};
use chebloyd::energy::prepared::PreparedPiece;
use chebloyd::geometry::clip::{ClipScratch, clip};
use chebloyd::geometry::half_space::HalfSpace;
use chebloyd::geometry::moments::Moments;
use chebloyd::geometry::polyhedron::Polyhedron;
use chebloyd::relax::space::Space;
use chebloyd::relax::tessellation::{Minimizer, Norm, Question, Tessellation};
use chebloyd::voronoi::diagram::Diagram;

const SITES: usize = 10_000;

fn sites() -> Vec<Point3<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut number = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    (0..SITES)
        .map(|_| Point3::new(number(), number(), number()))
        .collect()
}

/// The cells of the sites, each about its own site.
fn cells(sites: &[Point3<f64>]) -> Vec<Polyhedron> {
    let domain = Cuboid::unit();
    let diagram = Diagram::new(&domain, sites).expect("random sites have a diagram");
    diagram
        .map(|(): &mut (), cell| cell.polyhedron().clone())
        .expect("random sites are distinct")
}

fn kernels(criterion: &mut Criterion) {
    let cells = cells(&sites());
    let mut turn = cells.iter().cycle();
    let mut next = move || turn.next().expect("a cycle has no end").clone();

    let halving = HalfSpace {
        normal: Vector3::new(1.0, 0.2, 0.1),
        offset: 0.0,
    };
    let mut scratch = ClipScratch::default();
    criterion.bench_function("clip a cell in half", |bencher| {
        let cut = |mut cell: Polyhedron| clip(&mut cell, &halving, 0, &mut scratch);
        bencher.iter_batched(&mut next, cut, BatchSize::SmallInput);
    });
    criterion.bench_function("moments of a cell", |bencher| {
        let moments = |cell: Polyhedron| Moments::of(&cell);
        bencher.iter_batched(&mut next, moments, BatchSize::SmallInput);
    });
    criterion.bench_function("prepare a cell for integrals", |bencher| {
        let prepare = |cell: Polyhedron| PreparedPiece::new(&cell);
        bencher.iter_batched(&mut next, prepare, BatchSize::SmallInput);
    });
    for order in [1, 3] {
        let mut scratch = EnergyScratch::default();
        let mut piece = || SignedPiece {
            sign: 1.0,
            piece: PreparedPiece::new(&next()),
        };
        let name = format!("energy, gradient and Hessian of order {order}");
        criterion.bench_function(&name, |bencher| {
            let evaluate =
                |piece: SignedPiece| energy([&piece], &Vector3::zeros(), order, &mut scratch);
            bencher.iter_batched(&mut piece, evaluate, BatchSize::SmallInput);
        });
    }
}

fn iterations(criterion: &mut Criterion) {
    let sites = sites();
    let space = Space::new(Box::new(Cuboid::unit()));
    let mut group = criterion.benchmark_group("one iteration of 10 000 sites");
    group.sample_size(10);
    for (name, norm, minimizer) in [
        ("linf, Newton", Norm::Linf, Minimizer::Newton),
        ("linf, L-BFGS-B", Norm::Linf, Minimizer::Lbfgsb),
        ("l2", Norm::L2, Minimizer::Newton),
    ] {
        let question = Question {
            norm,
            order: 1,
            minimizer,
        };
        group.bench_function(name, |bencher| {
            bencher.iter(|| space.assess(black_box(&sites), question));
        });
    }
    group.finish();
}

criterion_group!(benches, kernels, iterations);
criterion_main!(benches);
