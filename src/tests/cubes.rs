//! Descents, perturbations and levels: energies that never rise, cells that become cubes, runs that go on
//! to the bit.

use std::ops::ControlFlow;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::WeightedDomain;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::mesh::shapes::torus;
use crate::mesh::validate::validate_surface;
use crate::relax::driver::{RunEnd, drive};
use crate::relax::metrics::Metrics;
use crate::relax::multilevel::{coarsened, levels_for_cubes, sites_of_level};
use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::record::Record;
use crate::relax::relaxation_space::RelaxationSpace;
use crate::relax::space::Space;
use crate::relax::split::refined;
use crate::relax::state::RunState;
use nalgebra::{Point3, Vector3};

fn boxed(extent: [f64; 3], periodic: [bool; 3]) -> Space {
    let bounds = Bounds {
        min: Point3::new(-1.0, 0.5, 2.0),
        max: Point3::new(-1.0, 0.5, 2.0) + Vector3::from(extent),
    };
    Space::new(Box::new(Cuboid::new(bounds, periodic).unwrap()))
}

/// A cube without one corner.
fn convex() -> Space {
    let mut walls = vec![HalfSpace {
        normal: Vector3::new(1.0, 1.0, 1.0),
        offset: 2.2,
    }];
    for axis in 0..3 {
        for (sign, offset) in [(1.0, 1.0), (-1.0, 0.0)] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            walls.push(HalfSpace { normal, offset });
        }
    }
    Space::new(Box::new(ConvexPolyhedron::new(&walls).unwrap()))
}

/// The unit cube with a density that grows eightfold across it.
fn graded() -> Space {
    let density = "1 + 7*x^2".parse().unwrap();
    Space::new(Box::new(
        WeightedDomain::new(Box::new(Cuboid::unit()), density).unwrap(),
    ))
}

fn ring() -> Space {
    let surface = validate_surface(&torus(1.0, 0.4, 24, 12)).unwrap().0;
    Space::new(Box::new(SurfaceSolid::new(&surface).unwrap()))
}

fn random_sites(space: &Space, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut uniform = Random::new(seed);
    let points = std::iter::repeat_with(|| uniform.point(&space.bounds()));
    points
        .filter(|site| space.domain().contains(site))
        .take(count)
        .collect()
}

struct Run {
    sites: Vec<Point3<f64>>,
    records: Vec<Record>,
    ended: RunEnd,
}

fn run(space: &Space, plan: &Plan, given: &[Point3<f64>]) -> Run {
    let mut sites = given.to_vec();
    let mut state = RunState::new(sites.len(), plan.levels);
    let mut records = Vec::new();
    let ended = drive(
        space,
        plan,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            records.push(record.clone());
            ControlFlow::Continue(())
        },
    );
    Run {
        sites,
        records,
        ended: ended.unwrap(),
    }
}

fn figures(space: &Space, sites: &[Point3<f64>]) -> Metrics {
    let question = Plan::quasi_newton(1, 1).spec;
    Metrics::of(
        space.volume(),
        &space.optimum(),
        &space.metrics(sites, question).unwrap(),
    )
}

fn assert_cubes(space: &Space, sites: &[Point3<f64>]) {
    let figures = figures(space, sites);
    assert!(figures.energy_percent < 100.0001, "{figures:?}");
    assert!(figures.cubeness > 0.999, "{figures:?}");
    assert!(
        (figures.six_facet_fraction - 1.0).abs() < 1e-12,
        "{figures:?}"
    );
    assert!(figures.axis_aligned_area > 0.9999, "{figures:?}");
}

fn untimed(records: &[Record]) -> Vec<Record> {
    let without = |record: &Record| Record {
        seconds: 0.0,
        ..record.clone()
    };
    records.iter().map(without).collect()
}

#[test]
fn descents_never_rise_and_stay_in_the_domain() {
    let spaces = [
        boxed([1.0, 1.0, 1.0], [false; 3]),
        boxed([1.0, 2.0, 1.0], [true, false, true]),
        convex(),
        graded(),
        ring(),
    ];
    for (number, space) in spaces.iter().enumerate() {
        for order in [1, 2] {
            let given = random_sites(space, 150, 10 + number as u64);
            let run = run(space, &Plan::quasi_newton(order, 25), &given);
            assert_eq!(run.records.len(), 26);
            assert_eq!(run.ended, RunEnd::Iterations);
            for pair in run.records.windows(2) {
                assert!(pair[1].energy_mean <= pair[0].energy_mean, "{pair:?}");
            }
            let [first, last] = [0, 25].map(|k| run.records[k].energy_percent);
            assert!(last < 0.85 * first, "{number}: {first} {last}");
            assert!(run.records[25].evaluations < 40.0);
            assert!(run.sites.iter().all(|site| space.domain().contains(site)));
        }
    }
}

/// The energies of the README's table, by evaluations per site: what Lloyd's iteration reaches in a
/// thousand takes a descent twenty.
#[test]
fn a_descent_from_a_thousand_random_sites_is_low_after_few_evaluations() {
    let space = Space::new(Box::new(Cuboid::unit()));
    for seed in [2] {
        let given = random_sites(&space, 1000, seed);
        let run = run(&space, &Plan::quasi_newton(1, 100), &given);
        let percent_within = |evaluations: f64| {
            let within = run
                .records
                .iter()
                .take_while(|record| record.evaluations <= evaluations);
            within.map(|record| record.energy_percent).last().unwrap()
        };
        assert!(percent_within(25.0) <= 101.6, "seed {seed}");
        assert!(percent_within(200.0) <= 101.0, "seed {seed}");
        for pair in run.records.windows(2) {
            assert!(pair[1].energy_mean <= pair[0].energy_mean, "{pair:?}");
        }
    }
}

#[test]
fn a_descent_sees_what_lloyd_does_not() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    let given = random_sites(&space, 216, 3);
    let lloyd = Plan {
        descent: None,
        ..Plan::quasi_newton(1, 30)
    };
    let descent = Plan {
        warm_up: 3,
        ..Plan::quasi_newton(1, 30)
    };
    let energy = |plan| run(&space, &plan, &given).records[30].energy_percent;
    assert!(energy(descent) < energy(lloyd) - 0.3);
}

#[test]
fn random_sites_become_cubes() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    for (count, seed) in [(64, 1), (125, 2), (216, 3)] {
        let given = random_sites(&space, count, seed);
        let run = run(&space, &Plan::cubes(1, count), &given);
        assert_eq!(run.ended, RunEnd::Tolerance);
        assert_eq!(run.sites.len(), count);
        assert_cubes(&space, &run.sites);
    }
}

#[test]
fn random_sites_become_cubes_in_long_and_in_periodic_boxes() {
    let long = boxed([2.0, 1.0, 1.0], [false; 3]);
    let given = random_sites(&long, 128, 4);
    assert_cubes(&long, &run(&long, &Plan::cubes(1, 128), &given).sites);
    let periodic = boxed([1.0, 1.0, 1.0], [true; 3]);
    let given = random_sites(&periodic, 64, 5);
    assert_cubes(
        &periodic,
        &run(&periodic, &Plan::cubes(1, 64), &given).sites,
    );
}

#[test]
fn annealing_keeps_the_best_sites() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    let given = random_sites(&space, 64, 6);
    let perturbation = Perturbation {
        rounds: 8,
        ..Perturbation::default_of(PerturbationKind::Anneal)
    };
    let plan = Plan {
        steps: 40,
        ..Plan::perturbed(1, perturbation)
    };
    let run = run(&space, &plan, &given);
    let last = run.records.last().unwrap();
    assert!(last.stage.round.is_some_and(|round| round <= 8));
    let ends_of_rounds = run
        .records
        .windows(2)
        .filter(|pair| pair[0].stage.round != pair[1].stage.round)
        .map(|pair| pair[0].energy_mean);
    let best = ends_of_rounds.fold(f64::INFINITY, f64::min);
    assert!(last.energy_mean <= best * (1.0 + 1e-8));
}

#[test]
fn a_run_with_few_moves_still_ends_with_its_best_sites_and_all_of_them() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    let given = random_sites(&space, 216, 7);
    for iterations in [1, 5, 40, 60] {
        let plan = Plan {
            iterations,
            levels: 1,
            ..Plan::perturbed(1, Perturbation::default_of(PerturbationKind::Anneal))
        };
        let run = run(&space, &plan, &given);
        assert_eq!(run.sites.len(), 216, "{iterations}");
        assert!(run.records.len() as u64 <= iterations + 1);
    }
}

#[test]
fn a_run_goes_on_to_the_bit_after_any_move() {
    let space = boxed([1.0, 1.0, 1.5], [false, true, false]);
    let given = random_sites(&space, 70, 8);
    let perturbation = Perturbation {
        rounds: 3,
        steps: 4,
        ..Perturbation::default_of(PerturbationKind::Exchange)
    };
    let plan = Plan {
        levels: 1,
        warm_up: 2,
        steps: 9,
        ..Plan::perturbed(1, perturbation)
    };
    let whole = run(&space, &plan, &given);
    assert!(whole.records.len() > 40);
    let mut sites = given;
    let mut state = RunState::new(sites.len(), plan.levels);
    let mut records: Vec<Record> = Vec::new();
    loop {
        let last = records.last().cloned();
        let mut shown = Vec::new();
        let mut kept = None;
        let ended = drive(
            &space,
            &plan,
            &mut sites,
            &mut state,
            last.as_ref(),
            &mut |record, sites, state| {
                shown.push(record.clone());
                kept = Some((sites.to_vec(), state.numbers().collect::<Vec<_>>()));
                ControlFlow::Break(())
            },
        );
        records.append(&mut shown);
        if ended.unwrap() != RunEnd::Interrupted {
            break;
        }
        let (kept_sites, numbers) = kept.unwrap();
        sites = kept_sites;
        state = RunState::from_numbers(&numbers).unwrap();
    }
    assert_eq!(untimed(&records), untimed(&whole.records));
    assert_eq!(sites, whole.sites);
}

#[test]
fn levels_have_the_sites_they_are_asked_for() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    let given = random_sites(&space, 1003, 9);
    for count in [1, 7, 8, 125, 126, 1003] {
        let coarse = coarsened(&given, count);
        assert_eq!(coarse.len(), count);
        assert!(coarse.iter().all(|site| given.contains(site)));
        for fine in [8 * count - 3, 8 * count, 8 * count + 4] {
            let sites = refined(&space, &coarse, fine).unwrap();
            assert_eq!(sites.len(), fine, "{count}");
            assert!(sites.iter().all(|site| space.domain().contains(site)));
        }
    }
    assert_eq!(sites_of_level::<3>(1003, 1), 125);
    let levels = [125, 216, 1000, 1728, 4096, 10_648].map(levels_for_cubes::<3>);
    assert_eq!(levels, [0, 1, 1, 2, 2, 1]);
}

#[test]
fn splitting_a_grid_gives_the_finer_grid() {
    let space = boxed([1.0, 1.0, 1.0], [false; 3]);
    let corner = space.bounds().min;
    let place = |k: usize| (k as f64 + 0.5) / 3.0;
    let grid: Vec<_> = (0..27)
        .map(|k| corner + Vector3::new(place(k % 3), place(k / 3 % 3), place(k / 9)))
        .collect();
    assert_cubes(&space, &refined(&space, &grid, 216).unwrap());
}
