//! Runs over ranks, threads of one process here, have the bits of a run by one process.

use std::ops::ControlFlow;
use std::sync::{Barrier, Mutex};

use nalgebra::{Point3, Vector3};

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::relax::driver::drive;
use crate::relax::metrics::Metrics;
use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::ranked_lloyd::{RankedRun, is_plain};
use crate::relax::ranked_sites::RankedSites;
use crate::relax::ranked_space::RankedSpace;
use crate::relax::ranks::{Ranks, SomeSites};
use crate::relax::record::Record;
use crate::relax::relaxation::{Checkpoint, continue_run, random_sites};
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::relax::state::RunState;

/// What ranks have laid down for each other.
struct Table {
    barrier: Barrier,
    words: Mutex<Vec<Vec<Vec<u64>>>>,
    numbers: Mutex<Vec<Vec<f64>>>,
    counts: Mutex<Vec<Vec<i64>>>,
}

struct Thread<'a> {
    rank: usize,
    size: usize,
    table: &'a Table,
}

impl Thread<'_> {
    /// What all ranks have laid down, once all have.
    fn all<T: Clone>(&self, place: &Mutex<Vec<T>>, own: T) -> Vec<T> {
        place.lock().expect("no rank has failed")[self.rank] = own;
        self.table.barrier.wait();
        let all = place.lock().expect("no rank has failed").clone();
        self.table.barrier.wait();
        all
    }
}

impl Ranks for Thread<'_> {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn exchange(&self, parts: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
        let all = self.all(&self.table.words, parts);
        all.into_iter()
            .map(|mut parts| parts.swap_remove(self.rank))
            .collect()
    }

    fn add(&self, numbers: &mut [i64]) {
        let all = self.all(&self.table.counts, numbers.to_vec());
        for (place, number) in numbers.iter_mut().enumerate() {
            *number = all.iter().map(|own| own[place]).sum();
        }
    }

    fn largest(&self, numbers: &mut [f64]) {
        let all = self.all(&self.table.numbers, numbers.to_vec());
        for (place, number) in numbers.iter_mut().enumerate() {
            *number = all
                .iter()
                .map(|own| own[place])
                .fold(f64::NEG_INFINITY, f64::max);
        }
    }
}

fn over_threads<T: Send>(size: usize, work: impl Fn(&Thread<'_>) -> T + Sync) -> Vec<T> {
    let table = Table {
        barrier: Barrier::new(size),
        words: Mutex::new(vec![Vec::new(); size]),
        numbers: Mutex::new(vec![Vec::new(); size]),
        counts: Mutex::new(vec![Vec::new(); size]),
    };
    std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..size)
            .map(|rank| {
                let (table, work) = (&table, &work);
                scope.spawn(move || work(&Thread { rank, size, table }))
            })
            .collect();
        ranks
            .into_iter()
            .map(|rank| rank.join().expect("no rank has failed"))
            .collect()
    })
}

fn spec() -> EnergySpec {
    EnergySpec {
        norm: Norm::Linf,
        order: 1,
        minimizer: Minimizer::Newton,
    }
}

/// Everything of records but their times.
fn bits(records: &[Record]) -> Vec<[u64; 7]> {
    let figures = |r: &Record| {
        [
            r.energy_mean,
            r.energy_max,
            r.energy_percent,
            r.movement_mean,
            r.movement_max,
            r.movement_percent,
            r.evaluations,
        ]
    };
    records
        .iter()
        .map(|record| figures(record).map(f64::to_bits))
        .collect()
}

type Left = (Vec<Point3<f64>>, Vec<[u64; 7]>);

fn by_one_process(space: &Space, plan: &Plan, mut sites: Vec<Point3<f64>>) -> Left {
    let mut state = RunState::new(sites.len(), 0);
    let mut records = Vec::new();
    drive(
        space,
        plan,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            records.push(record.clone());
            ControlFlow::Continue(())
        },
    )
    .expect("a run");
    (sites, bits(&records))
}

/// The part of a run by `size` ranks from `last` on, up to record `end`.
fn part(
    (space, plan): (&Space, &Plan),
    size: usize,
    start: &Checkpoint,
    end: u64,
) -> (Checkpoint, Vec<Record>) {
    let all = over_threads(size, |ranks| {
        let mut records = Vec::new();
        let mut note = |record: &Record| {
            records.push(record.clone());
            match record.iteration == end {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let last = start.record.as_ref();
        if is_plain(plan) {
            // Every rank gives some of the sites.
            let [from, to] = [ranks.rank, ranks.rank + 1].map(|r| r * start.sites.len() / size);
            let some = SomeSites::following(from as u64, start.sites[from..to].to_vec());
            let sites = RankedSites::new(ranks, space, some);
            let mut run = RankedRun::new(sites, plan, last);
            run.run(last, &mut |record, _| note(record)).expect("a run");
            let end = Checkpoint {
                sites: run.sites.gathered(0, u64::MAX),
                record: None,
                state: None,
            };
            return (end, records);
        }
        let space = RankedSpace::new(ranks, space);
        let mut checkpoint = start.clone();
        continue_run(&space, plan, &mut checkpoint, &mut |record, _, _| {
            note(record)
        })
        .expect("a run");
        (checkpoint, records)
    });
    for (_, records) in &all {
        assert_eq!(
            bits(records),
            bits(&all[0].1),
            "ranks have the same records"
        );
    }
    let (mut end, records) = all.into_iter().next().expect("rank 0");
    end.record = records.last().cloned().or(start.record.clone());
    (end, records)
}

/// The run by `size` ranks, interrupted after a move and taken up by as many as `then` says.
fn by_ranks(space: &Space, plan: &Plan, sites: &[Point3<f64>], [size, then]: [usize; 2]) -> Left {
    let start = Checkpoint::at_start(sites.to_vec());
    let (start, mut records) = part((space, plan), size, &start, 1);
    let (end, more) = part((space, plan), then, &start, u64::MAX);
    records.extend(more);
    (end.sites, bits(&records))
}

fn lattice(n: u32, noise: f64) -> Vec<Point3<f64>> {
    let jitter = random_sites(&Cuboid::unit(), (n * n * n) as usize, 1).expect("sites");
    let place = |k: u32| {
        let along = |i: u32| (f64::from(i % n) + 0.5) / f64::from(n);
        let at = [along(k), along(k / n), along(k / (n * n))];
        Point3::from(at) + jitter[k as usize].coords * noise
    };
    (0..n * n * n).map(place).collect()
}

/// Half of the sites uniform, half within a thousandth of a corner of the cube.
fn crowded(count: usize) -> Vec<Point3<f64>> {
    let sites = random_sites(&Cuboid::unit(), count, 3).expect("sites");
    let squeezed = |(number, site): (usize, Point3<f64>)| match number % 2 {
        0 => site,
        _ => Point3::from(site.coords * 1e-3),
    };
    sites.into_iter().enumerate().map(squeezed).collect()
}

type Case = (&'static str, Box<dyn Domain>, Vec<Point3<f64>>);

fn cases() -> Vec<Case> {
    let random = |count: usize| random_sites(&Cuboid::unit(), count, 1).expect("sites");
    let graded = |sites: Vec<Point3<f64>>| -> Vec<Point3<f64>> {
        sites.into_iter().map(|site| site.map(|x| x * x)).collect()
    };
    let periodic = || -> Box<dyn Domain> {
        let bounds = Bounds::from_corners([0.0; 3], [1.0; 3]);
        Box::new(Cuboid::new(bounds, [true, true, false]).expect("a box"))
    };
    let corner = || -> Box<dyn Domain> {
        let walls = [
            (-Vector3::x(), 0.0),
            (-Vector3::y(), 0.0),
            (-Vector3::z(), 0.0),
            (Vector3::repeat(1.0), 1.0),
        ];
        let walls = walls.map(|(normal, offset)| HalfSpace { normal, offset });
        Box::new(ConvexPolyhedron::new(&walls).expect("a tetrahedron"))
    };
    let unit = || -> Box<dyn Domain> { Box::new(Cuboid::unit()) };
    let in_corner = random_sites(corner().as_ref(), 120, 2).expect("sites");
    vec![
        ("random", unit(), random(150)),
        ("graded", unit(), graded(random(100))),
        ("crowded", unit(), crowded(100)),
        ("lattice", unit(), lattice(4, 0.0)),
        ("lattice, graded", unit(), graded(lattice(4, 0.0))),
        ("lattice, jittered, periodic", periodic(), lattice(5, 1e-9)),
        ("lattice, periodic", periodic(), lattice(4, 0.0)),
        ("random, periodic", periodic(), random(150)),
        ("half-spaces", corner(), in_corner),
        ("fewer than ranks", unit(), random(3)),
    ]
}

fn assert_same(plan: &Plan, sizes: &[[usize; 2]]) {
    for (name, domain, sites) in cases() {
        let space = Space::new(domain);
        let one = by_one_process(&space, plan, sites.clone());
        for &sizes in sizes {
            let some = by_ranks(&space, plan, &sites, sizes);
            assert!(one.1 == some.1, "{name}, {sizes:?}: records differ");
            assert!(one.0 == some.0, "{name}, {sizes:?}: sites differ");
        }
    }
}

#[test]
fn lloyd_over_ranks_leaves_the_sites_and_records_of_one_process_to_the_bit() {
    let plan = Plan::lloyd(spec(), 2);
    assert_same(&plan, &[[1, 2], [3, 8], [4, 1]]);
}

#[test]
fn quasi_newton_over_ranks_leaves_the_sites_and_records_of_one_process_to_the_bit() {
    let plan = Plan::quasi_newton(1, 3);
    assert_same(&plan, &[[1, 2], [3, 8], [4, 1]]);
}

#[test]
fn whatever_else_moves_sites_does_so_over_ranks_to_the_bit() {
    let accelerated = Plan {
        is_accelerated: true,
        ..Plan::lloyd(spec(), 3)
    };
    let anneal = Perturbation {
        rounds: 1,
        steps: 2,
        ..Perturbation::default_of(PerturbationKind::Exchange)
    };
    let cubes = Plan {
        iterations: 6,
        levels: 1,
        steps: 2,
        ..Plan::perturbed(1, anneal)
    };
    let space = Space::new(Box::new(Cuboid::unit()));
    let sites = random_sites(&Cuboid::unit(), 64, 5).expect("sites");
    for plan in [accelerated, cubes] {
        let mut one = Checkpoint::at_start(sites.clone());
        let mut records = Vec::new();
        continue_run(&space, &plan, &mut one, &mut |record, _, _| {
            records.push(record.clone());
            ControlFlow::Continue(())
        })
        .expect("a run");
        let (some, of_ranks) = part(
            (&space, &plan),
            3,
            &Checkpoint::at_start(sites.clone()),
            u64::MAX,
        );
        assert_eq!(bits(&records), bits(&of_ranks));
        assert_eq!(one.sites, some.sites);
    }
}

#[test]
fn figures_and_faults_over_ranks_are_those_of_one_process() {
    let space = Space::new(Box::new(Cuboid::unit()));
    let sites = random_sites(&Cuboid::unit(), 100, 7).expect("sites");
    let cells = space.metrics(&sites, spec()).expect("cells");
    let figures = Metrics::of(1.0, &space.optimum(), &cells);
    let mut twice = sites.clone();
    twice[93] = twice[17];
    let fault = space
        .metrics(&twice, spec())
        .expect_err("a duplicate")
        .to_string();
    for size in [1, 2, 3, 8] {
        let all = over_threads(size, |ranks| {
            let mut share = RankedSites::of_all(ranks, &space, &sites);
            let cells = share.own_metrics(spec()).expect("cells");
            // A tenth of the volume is taken away on one rank.
            let figures = cells.iter().enumerate().map(|(place, cell)| {
                let lost = ranks.rank == size - 1 && place == 0;
                (if lost { 0.0 } else { cell.volume }, cell.energy)
            });
            let short = share.check(&figures.collect::<Vec<_>>(), spec().kind());
            let duplicate = RankedSites::of_all(ranks, &space, &twice).own_metrics(spec());
            (share.metrics(&cells), short, duplicate)
        });
        for (of_ranks, short, duplicate) in all {
            assert_eq!(of_ranks, figures, "{size} ranks");
            assert!(
                short
                    .expect_err("volume is missing")
                    .to_string()
                    .contains("sum to 0.9")
            );
            assert_eq!(duplicate.expect_err("a duplicate").to_string(), fault);
        }
    }
}
