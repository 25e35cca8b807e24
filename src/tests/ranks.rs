//! Runs over ranks, threads of one process here, have the bits of a run by one process.

use std::ops::ControlFlow;
use std::sync::{Barrier, Mutex};

use nalgebra::{Point3, Vector3};

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::relax::driver::{RunEnd, drive};
use crate::relax::plan::Plan;
use crate::relax::ranks::{RankedRun, Ranks};
use crate::relax::record::Record;
use crate::relax::relaxation::random_sites;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm};
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

/// The run by `size` ranks, interrupted after a move and taken up by as many as `then` says.
fn by_ranks(space: &Space, plan: &Plan, sites: &[Point3<f64>], [size, then]: [usize; 2]) -> Left {
    let part = |size: usize, sites: &[Point3<f64>], last: Option<&Record>, end: u64| {
        let all = over_threads(size, |ranks| {
            let given = (ranks.rank == 0).then(|| sites.to_vec());
            let mut run = RankedRun::new(ranks, space, plan, given, last).expect("Lloyd's");
            let mut records = Vec::new();
            let ended = run.run(last, &mut |record, _| {
                records.push(record.clone());
                match record.iteration == end {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                }
            });
            let expected = if end < plan.iterations {
                RunEnd::Interrupted
            } else {
                RunEnd::Iterations
            };
            // The observer's word counts for the last move too.
            assert!(matches!(ended, Ok(end) if end == expected || end == RunEnd::Interrupted));
            (run.gathered(), records)
        });
        for (_, records) in &all {
            assert_eq!(
                bits(records),
                bits(&all[0].1),
                "ranks have the same records"
            );
        }
        all.into_iter().next().expect("rank 0")
    };
    let (sites, mut records) = part(size, sites, None, 1);
    let sites = sites.expect("rank 0 gathers");
    let last = records.last().cloned();
    let (sites, more) = part(then, &sites, last.as_ref(), u64::MAX);
    records.extend(more);
    (sites.expect("rank 0 gathers"), bits(&records))
}

#[test]
fn ranks_leave_the_sites_and_records_of_one_process_to_the_bit() {
    let cube = Cuboid::unit();
    let random = |count: usize| random_sites(&cube, count, 1).expect("sites");
    let lattice = |n: u32, noise: f64| -> Vec<Point3<f64>> {
        let jitter = random((n * n * n) as usize);
        let place = |k: u32| {
            let along = |i: u32| (f64::from(i % n) + 0.5) / f64::from(n);
            let at = [along(k), along(k / n), along(k / (n * n))];
            Point3::from(at) + jitter[k as usize].coords * noise
        };
        (0..n * n * n).map(place).collect()
    };
    let graded = |count| {
        let sites = random(count).into_iter();
        sites.map(|site| site.map(|x| x * x)).collect()
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
    type Case = (&'static str, Box<dyn Domain>, Vec<Point3<f64>>);
    let cases: Vec<Case> = vec![
        ("random", unit(), random(300)),
        ("graded", unit(), graded(200)),
        ("lattice", unit(), lattice(5, 0.0)),
        ("lattice with noise, periodic", periodic(), lattice(5, 1e-9)),
        ("random, periodic", periodic(), random(200)),
        (
            "half-spaces",
            corner(),
            random_sites(corner().as_ref(), 150, 2).expect("sites"),
        ),
        ("fewer than ranks", unit(), random(3)),
    ];
    let plan = Plan::lloyd(spec(), 3);
    for (name, domain, sites) in cases {
        let space = Space::new(domain);
        let one = by_one_process(&space, &plan, sites.clone());
        for sizes in [[1, 2], [2, 3], [3, 8], [8, 4], [4, 1]] {
            let some = by_ranks(&space, &plan, &sites, sizes);
            assert!(one.1 == some.1, "{name}, {sizes:?}: records differ");
            assert!(one.0 == some.0, "{name}, {sizes:?}: sites differ");
        }
    }
}
