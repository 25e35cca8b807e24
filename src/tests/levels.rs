//! Levels: every split has the sites it should, distinct and in the domain; every ending has all sites.

use std::ops::ControlFlow;

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::points_inside;
use crate::mesh::shapes::torus;
use crate::mesh::validate::validate_surface;
use crate::relax::driver::RunEnd;
use crate::relax::method::Method;
use crate::relax::multilevel::coarsened;
use crate::relax::record::Record;
use crate::relax::relaxation::{Checkpoint, Relaxation};
use crate::relax::relaxation_space::RelaxationSpace;
use crate::relax::space::Space;
use crate::relax::split::{refined, split_to_finest};
use crate::tests::sites::random_sites;

/// A wedge of the angle `height` along a straight edge.
fn wedge(height: f64) -> ConvexPolyhedron {
    let walls = [
        ([0.0, 0.0, -1.0], 0.0),
        ([-height, 0.0, 1.0], 0.0),
        ([1.0, 0.0, 0.0], 1.0),
        ([0.0, 1.0, 0.0], 1.0),
        ([0.0, -1.0, 0.0], 0.0),
    ];
    let walls = walls.map(|(normal, offset)| HalfSpace {
        normal: Vector3::from(normal),
        offset,
    });
    ConvexPolyhedron::new(&walls).unwrap()
}

fn ring(tube: f64) -> SurfaceSolid {
    SurfaceSolid::new(&validate_surface(&torus(1.0, tube, 24, 8)).unwrap().0).unwrap()
}

fn cuboid(extent: [f64; 3], periodic: [bool; 3]) -> Cuboid {
    let min = Point3::new(-1.0, 1e3, 2.0);
    let max = min + Vector3::from(extent);
    Cuboid::new(Bounds { min, max }, periodic).unwrap()
}

/// Solids in which a split has little room: thin, curved, periodic, far from the origin.
fn narrow(kind: usize) -> Box<dyn Domain> {
    match kind {
        0 => Box::new(ring(0.3)),
        1 => Box::new(ring(0.02)),
        2 => Box::new(cuboid([1.0, 1.0, 1e-4], [false; 3])),
        3 => Box::new(cuboid([1.0, 1e-3, 1e-3], [true, true, false])),
        4 => Box::new(cuboid([1.0; 3], [true; 3])),
        _ => Box::new(wedge(1e-3)),
    }
}

/// Fails unless the sites are in the domain and no two of them are at one place.
fn assert_distinct_and_inside(space: &Space, sites: &[Point3<f64>]) {
    assert!(sites.iter().all(|site| space.contains(site)));
    for (number, site) in sites.iter().enumerate() {
        for other in &sites[..number] {
            assert!(space.displacement(site, other).norm() > 0.0, "{site} twice");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_split_has_all_sites_distinct_and_inside(
        kind in 0..6_usize,
        count in 1..120_usize,
        level in 1..4_u32,
        seed in 0..1000_u64,
    ) {
        let space = Space::new(narrow(kind));
        let contains = |site: &Point3<f64>| space.contains(site);
        let given = points_inside(count, seed, &space.bounds(), contains, || None);
        let given = given.unwrap();
        let coarse = coarsened(&given, (count >> (3 * level)).max(1));
        let fine = split_to_finest(&space, &coarse, count, level).unwrap();
        prop_assert_eq!(fine.len(), count);
        assert_distinct_and_inside(&space, &fine);
        let again = split_to_finest(&space, &coarse, count, level).unwrap();
        prop_assert_eq!(fine, again);
    }
}

/// Sites on corners and edges, where most directions lead out; and a grid twice as fine as the split's
/// own, whose children meet.
#[test]
fn sites_on_walls_and_close_rows_are_split_to_distinct_places() {
    let corners: Vec<Point3<f64>> = (0..8_usize)
        .map(|k| Point3::from([0, 1, 2].map(|axis| (k >> axis & 1) as f64)))
        .collect();
    let cube = Space::new(Box::new(Cuboid::unit()));
    let edge: Vec<Point3<f64>> = (0..4)
        .map(|k| Point3::new(0.0, f64::from(k) / 4.0, 0.0))
        .collect();
    let blade = Space::new(Box::new(wedge(1e-3)));
    // Children stand at ± a quarter of 1/2; rows a quarter apart send theirs to the same places.
    let row = |k: usize| {
        Point3::new(
            0.125 + 0.25 * (k % 4) as f64,
            0.25,
            (k / 4) as f64 * 0.25 + 0.25,
        )
    };
    let rows: Vec<_> = (0..8).map(row).collect();
    for (space, sites) in [(&cube, &corners), (&blade, &edge), (&cube, &rows)] {
        let all = 9 * sites.len();
        for count in [all, all - sites.len(), all - 3] {
            let fine = refined(space, sites, count).unwrap();
            assert_eq!(fine.len(), count);
            assert_distinct_and_inside(space, &fine);
        }
    }
}

/// A run stopped on a coarse level leaves all sites, and so does one of few moves.
#[test]
fn every_ending_has_all_sites() {
    let sites = random_sites(100, 3);
    let until = |stop: u64| {
        move |record: &Record| match record.iteration >= stop {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    // Of 100 sites the coarse level has 13.
    let relaxation = Relaxation::new(Cuboid::unit()).method(Method::cubes(1000));
    let mut checkpoint = Checkpoint::at_start(sites.clone());
    let stop = until(2);
    let ended = relaxation.resume(&mut checkpoint, |record, _| {
        assert!(record.stage.level.is_some());
        stop(record)
    });
    assert_eq!(ended.unwrap(), RunEnd::Interrupted);
    assert_eq!(checkpoint.sites.len(), 13);
    let mut all = sites.clone();
    relaxation
        .run_with(&mut all, |record, _| stop(record))
        .unwrap();
    assert_eq!(all.len(), 100);
    assert_eq!(all, relaxation.sites_of(&checkpoint).unwrap());
    assert!((relaxation.measure(&all).unwrap().volume_sum - 1.0).abs() < 1e-12);

    for iterations in 0..5 {
        let few = Method::cubes(1000).iterations(iterations);
        let relaxation = Relaxation::new(Cuboid::unit()).method(few);
        let mut all = sites.clone();
        let records = relaxation.run(&mut all).unwrap().records;
        assert_eq!((all.len(), records.len() as u64), (100, iterations + 1));
        assert!(records.iter().all(|record| record.stage.level.is_some()));
    }
}

/// Numbers that are of no state are refused, however large they are.
#[test]
fn impossible_checkpoints_are_refused() {
    let mut checkpoint = Checkpoint::at_start(random_sites(30, 3));
    let relaxation = Relaxation::new(Cuboid::unit()).method(Method::cubes(1000).iterations(4));
    let go_on = |_: &Record, _: &[Point3<f64>]| ControlFlow::Continue(());
    relaxation.resume(&mut checkpoint, go_on).unwrap();
    let (numbers, record) = (checkpoint.state_numbers(), checkpoint.record.unwrap());
    let refused = |numbers: &[f64]| {
        let of = |sites: usize| random_sites(sites, 3);
        assert!(Checkpoint::<3>::from_parts(of(29), record.clone(), numbers).is_err());
        Checkpoint::<3>::from_parts(of(30), record.clone(), numbers).is_err()
    };
    assert!(!refused(&numbers));
    // The number of sites, the levels, the counts of the best sites and of the descent.
    let of_descent = 12 + 3 * numbers[11] as usize;
    for place in [1, 2, 11, of_descent, of_descent + 1] {
        for wrong in [1e300, f64::MAX, 7e18] {
            let mut changed = numbers.clone();
            changed[place] = wrong;
            assert!(refused(&changed), "{wrong} at {place}");
        }
    }
}
