//! The loop in space: its reference curves, descent, determinism and resumption.

use std::ops::ControlFlow;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::shape::DomainShape;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::relax::driver::{RunEnd, drive};
use crate::relax::metrics::Metrics;
use crate::relax::plan::Plan;
use crate::relax::record::Record;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::relax::state::RunState;
use nalgebra::{Point3, Vector3};

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};
const L2: EnergySpec = EnergySpec {
    norm: Norm::L2,
    ..LINF
};

fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Random::new(seed);
    move || random.uniform()
}

fn random_sites(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut number = numbers(seed);
    (0..count)
        .map(|_| Point3::new(number(), number(), number()))
        .collect()
}

/// A k×k×k lattice with every coordinate moved by up to half of `amplitude` cells either way.
fn jittered_lattice(k: usize, amplitude: f64, seed: u64) -> Vec<Point3<f64>> {
    let mut number = numbers(seed);
    let mut at = |n: usize| (n as f64 + 0.5 + amplitude * (number() - 0.5)) / k as f64;
    (0..k * k * k)
        .map(|n| Point3::new(at(n % k), at(n / k % k), at(n / k / k)))
        .collect()
}

fn unit() -> Space {
    Space::new(Box::new(Cuboid::unit()))
}

fn options(iterations: u64, question: EnergySpec) -> Plan {
    Plan::lloyd(question, iterations)
}

/// Relaxes and returns all records.
fn run(space: &Space, sites: &mut Vec<Point3<f64>>, options: &Plan) -> Vec<Record> {
    let mut records = Vec::new();
    let mut state = RunState::new(sites.len(), 0);
    let ended = drive(
        space,
        options,
        sites,
        &mut state,
        None,
        &mut |record, _, _| {
            records.push(record.clone());
            ControlFlow::Continue(())
        },
    );
    assert_eq!(ended.unwrap(), RunEnd::Iterations);
    records
}

fn within(value: f64, (low, high): (f64, f64), what: &str) {
    assert!(
        low <= value && value <= high,
        "{what}: {value} is not in {low}…{high}"
    );
}

#[test]
fn a_thousand_random_sites_follow_the_reference_curve() {
    let seed = 1;
    let mut sites = random_sites(1000, seed);
    let records = run(&unit(), &mut sites, &options(50, LINF));
    let percent = |k: usize| records[k].energy_percent;
    within(percent(0), (124.0, 131.0), "iteration 0");
    within(percent(1), (112.4, 113.8), "iteration 1");
    within(percent(10), (104.5, 105.4), "iteration 10");
    within(percent(50), (102.3, 102.8), "iteration 50");
    within(records[1].movement_percent, (12.0, 13.8), "first movement");
    within(records[50].movement_percent, (0.15, 0.35), "last movement");
    let figures = Metrics::of(
        1.0,
        &unit().optimum(),
        &unit().metrics(&sites, LINF).unwrap(),
    );
    within(figures.cubeness, (0.75, 0.81), "cubeness");
    within(figures.axis_aligned_area, (0.37, 0.47), "axis-aligned area");
    within(
        figures.energy_percent,
        (percent(50) - 1e-9, percent(50) + 1e-9),
        "measure",
    );
}

#[test]
fn the_euclidean_control_stays_above_it() {
    let mut sites = random_sites(1000, 1);
    let records = run(&unit(), &mut sites, &options(50, L2));
    within(records[10].energy_percent, (105.5, 106.3), "iteration 10");
    within(records[50].energy_percent, (104.2, 104.7), "iteration 50");
    // Lloyd's classical descent, in the norm that it minimizes.
    for pair in records.windows(2) {
        assert!(pair[1].energy_mean <= pair[0].energy_mean * (1.0 + 1e-14));
    }
}

#[test]
fn a_jittered_grid_becomes_the_grid() {
    let mut sites = jittered_lattice(6, 0.5, 1);
    let records = run(&unit(), &mut sites, &options(60, LINF));
    within(records[0].energy_percent, (106.5, 108.5), "iteration 0");
    within(records[60].energy_percent, (100.0, 100.01), "iteration 60");
    let figures = Metrics::of(
        1.0,
        &unit().optimum(),
        &unit().metrics(&sites, LINF).unwrap(),
    );
    within(figures.six_facet_fraction, (1.0, 1.0), "six-facet fraction");
    assert_eq!(
        figures.facet_histogram.into_iter().collect::<Vec<_>>(),
        [(6, 216)]
    );
}

#[test]
fn an_exact_grid_is_at_one_hundred_percent_and_stays() {
    let mut sites = jittered_lattice(5, 0.0, 1);
    let before = sites.clone();
    for record in run(&unit(), &mut sites, &options(3, LINF)) {
        within(
            record.energy_percent,
            (100.0 - 1e-11, 100.0 + 1e-11),
            "energy",
        );
    }
    let moved = sites
        .iter()
        .zip(&before)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, f64::max);
    assert!(moved < 1e-13, "{moved}");
}

#[test]
fn no_energy_is_below_that_of_cubes_in_any_domain_or_order() {
    let solid = |scale: f64| -> Box<dyn Domain> {
        let wall = |signs: u32| HalfSpace {
            normal: Vector3::from([0, 1, 2].map(|k| 1.0 - 2.0 * f64::from(signs >> k & 1))),
            offset: scale,
        };
        let walls: Vec<_> = (0..8).map(wall).collect();
        Box::new(ConvexPolyhedron::new(&walls).unwrap())
    };
    let torus = Cuboid::new(Cuboid::unit().bounds(), [true, true, false]).unwrap();
    let spaces = [unit(), Space::new(Box::new(torus)), Space::new(solid(2.5))];
    for (k, space) in spaces.iter().enumerate() {
        for order in [1, 2, 5] {
            let mut sites = random_sites(60, 5);
            let question = EnergySpec { order, ..LINF };
            let records = run(space, &mut sites, &options(8, question));
            let least = 3.0 / (3.0 + f64::from(order)) / 2f64.powi(order as i32);
            let side = (space.volume() / 60.0).cbrt();
            for record in &records {
                let relative = record.energy_mean / (least * side.powi(3 + order as i32));
                assert!(relative >= 1.0, "space {k}, p = {order}: {relative}");
                assert!(record.energy_percent >= 100.0);
            }
            assert!(
                records[8].energy_mean < records[0].energy_mean,
                "space {k}, p = {order}"
            );
            assert!(sites.iter().all(|site| space.domain().contains(site)));
        }
    }
}

#[test]
fn newton_and_lbfgsb_find_the_same_centers() {
    let sites = random_sites(300, 6);
    for (order, most) in [(1, 2.95), (2, 5.15), (4, 5.6)] {
        let question = |minimizer| EnergySpec {
            minimizer,
            order,
            ..LINF
        };
        let newton = unit().assess(&sites, question(Minimizer::Newton)).unwrap();
        let lbfgsb = unit().assess(&sites, question(Minimizer::Lbfgsb)).unwrap();
        for (one, other) in newton.iter().zip(&lbfgsb) {
            let apart = (one.target - other.target).norm() / (1.0f64 / 300.0).cbrt();
            assert!(apart < 1e-8, "p = {order}: {apart:e}");
        }
        let mean = |cells: &[crate::relax::relaxation_space::CellResult<3>]| {
            cells
                .iter()
                .map(|cell| f64::from(cell.evaluations))
                .sum::<f64>()
                / 300.0
        };
        assert!(
            mean(&newton) <= most,
            "p = {order}: {} evaluations",
            mean(&newton)
        );
    }
}

#[test]
fn a_center_is_in_the_domain_and_never_worse_than_its_site() {
    let space = unit();
    for cell in space.metrics(&random_sites(200, 8), LINF).unwrap() {
        assert!(cell.center.iter().all(|x| (0.0..=1.0).contains(x)));
        assert!(cell.center_energy <= cell.energy);
        assert!(cell.center_energy >= 0.375 * cell.volume.powf(4.0 / 3.0));
    }
}

#[test]
fn interrupted_and_continued_is_the_same_to_the_bit() {
    let space = unit();
    let mut whole = random_sites(120, 9);
    let records = run(&space, &mut whole, &options(12, LINF));
    for stop in [0, 5, 11] {
        let mut sites = random_sites(120, 9);
        let mut last = None;
        let mut state = RunState::new(sites.len(), 0);
        let ended = drive(
            &space,
            &options(12, LINF),
            &mut sites,
            &mut state,
            None,
            &mut |record, _, _| {
                last = Some(record.clone());
                if record.iteration == stop {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
        assert_eq!(ended.unwrap(), RunEnd::Interrupted);
        let mut rest = Vec::new();
        // Plain Lloyd goes on from the record alone as well as from the state.
        let last = last.expect("a record");
        let mut state = if stop == 5 {
            RunState::of_lloyd(sites.len(), &last)
        } else {
            state
        };
        let ended = drive(
            &space,
            &options(12, LINF),
            &mut sites,
            &mut state,
            Some(&last),
            &mut |record, _, _| {
                rest.push(Record {
                    seconds: 0.0,
                    ..record.clone()
                });
                ControlFlow::Continue(())
            },
        );
        assert_eq!(ended.unwrap(), RunEnd::Iterations);
        assert_eq!(sites, whole);
        let timeless = |r: &Record| Record {
            seconds: 0.0,
            ..r.clone()
        };
        let expected: Vec<_> = records[stop as usize + 1..].iter().map(timeless).collect();
        assert_eq!(rest, expected);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut sites = random_sites(500, 10);
        pool.install(|| run(&unit(), &mut sites, &options(3, LINF)));
        sites
    };
    let one = with(1);
    for threads in [2, 5] {
        assert_eq!(with(threads), one);
    }
}

#[test]
fn a_tolerance_ends_the_run() {
    let mut sites = jittered_lattice(3, 0.3, 2);
    let options = Plan {
        tolerance: 1e-3,
        ..Plan::lloyd(LINF, 500)
    };
    let mut last = None;
    let mut state = RunState::new(sites.len(), 0);
    let ended = drive(
        &unit(),
        &options,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            last = Some(record.clone());
            ControlFlow::Continue(())
        },
    );
    assert_eq!(ended.unwrap(), RunEnd::Tolerance);
    let last = last.unwrap();
    assert!(last.movement_percent < 1e-3 && last.iteration < 500);
}

#[test]
fn one_two_and_three_sites_relax() {
    for count in 1..=3 {
        let mut sites = random_sites(count, 3);
        let records = run(&unit(), &mut sites, &options(40, LINF));
        let energies = records.iter().map(|record| record.energy_percent);
        assert!(energies.fold(f64::INFINITY, f64::min) >= 100.0 - 1e-12);
        if count == 1 {
            assert!((sites[0] - Point3::new(0.5, 0.5, 0.5)).norm() < 1e-11);
        }
    }
}
