//! Relaxation with L∞ cells: the objective, its gradient, descent, and what is refused.

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::{Domain, WeightedDomain};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::integrals::polynomial::Polynomial;
use crate::relax::frames::Frames;
use crate::relax::method::Method;
use crate::relax::relaxation::Relaxation;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::tests::sites::{grid_sites, random_sites};
use nalgebra::{Point3, Rotation3, Vector3};

fn linf(domain: impl Domain + 'static) -> Space {
    Space::new(Box::new(domain)).with_cells(Norm::Linf)
}

fn torus() -> Cuboid {
    Cuboid::new(Bounds::from_corners([0.0; 3], [1.0; 3]), [true; 3]).expect("a box")
}

/// The unit cube with a corner cut off.
fn convex() -> ConvexPolyhedron {
    let mut walls = vec![HalfSpace {
        normal: Vector3::new(1.0, 2.0, 1.5),
        offset: 3.5,
    }];
    for axis in 0..3 {
        for (sign, offset) in [(1.0, 1.0), (-1.0, 0.0)] {
            let normal = Vector3::ith(axis, sign);
            walls.push(HalfSpace { normal, offset });
        }
    }
    ConvexPolyhedron::new(&walls).expect("a solid")
}

fn spec(order: u32) -> EnergySpec {
    EnergySpec {
        norm: Norm::Linf,
        order,
        minimizer: Minimizer::Newton,
    }
}

#[test]
fn the_gradient_is_that_of_the_objective() {
    for space in [linf(Cuboid::unit()), linf(torus()), linf(convex())] {
        let sites = random_sites(24, 5);
        let sites: Vec<_> = sites
            .into_iter()
            .filter(|site| space.contains(site))
            .collect();
        for order in [1, 2, 3] {
            let value = space.objective(&sites, order).expect("cells");
            let scale = value.gradient.iter().map(Vector3::amax).fold(0.0, f64::max);
            for site in [0, 3, 7, 11] {
                for axis in 0..3 {
                    let energy = |step: f64| {
                        let mut moved = sites.clone();
                        moved[site][axis] += step;
                        space.energy(&moved, spec(order)).expect("cells")
                    };
                    let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
                    let error = (slope - value.gradient[site][axis]).abs();
                    assert!(
                        error < 1e-7 * scale.max(slope.abs()) + 1e-10,
                        "order {order}: {error:e} {slope}"
                    );
                }
            }
        }
    }
}

#[test]
fn energies_lie_between_those_of_cubes_and_of_l2_cells() {
    for seed in 1..4 {
        let sites = random_sites(60, seed);
        let both = linf(Cuboid::unit())
            .both(&sites)
            .expect("cells")
            .expect("figures");
        assert!(both.energy_percent_linf > 100.0);
        assert!(both.energy_percent_linf < both.energy_percent_l2);
        assert!(both.tied_volume.abs() < 1e-12, "{}", both.tied_volume);
    }
}

#[test]
fn a_lattice_is_tied_nowhere_but_a_plane_is() {
    let space = linf(Cuboid::unit());
    let both = space.both(&grid_sites(3)).expect("cells").expect("figures");
    assert!((both.energy_percent_linf - 100.0).abs() < 1e-10);
    assert!(both.tied_volume.abs() < 1e-12);
    // Two sites at one height: all points higher or lower than half their distance are tied.
    let sites = [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]].map(Point3::from);
    let both = space.both(&sites).expect("cells").expect("figures");
    // Points with max(|y|, |z|) ≥ |x| about either site: those of ∫ min over the square.
    let mut random = Random::new(1);
    let is_tied = |point: &Point3<f64>| {
        let [one, other] = sites.map(|site| (point - site).amax());
        (one - other).abs() <= 0.0
    };
    let unit = Bounds::from_corners([0.0; 3], [1.0; 3]);
    let drawn = (0..100_000)
        .filter(|_| is_tied(&random.point(&unit)))
        .count();
    assert!(
        (both.tied_volume - drawn as f64 * 1e-5).abs() < 0.01,
        "{} {drawn}",
        both.tied_volume
    );
}

#[test]
fn the_objective_does_not_depend_on_the_order_of_sites() {
    let mut sites = random_sites(40, 2);
    for site in &mut sites {
        site.x = (site.x * 4.0).round() / 4.0;
        site.z = (site.z * 3.0).round() / 3.0;
    }
    let space = linf(Cuboid::unit());
    let energy = |sites: &[Point3<f64>]| space.energy(sites, spec(1)).expect("cells");
    let first = energy(&sites);
    for shift in [1, 7, 20] {
        sites.rotate_left(shift);
        assert!((energy(&sites) / first - 1.0).abs() < 1e-13);
    }
    sites.reverse();
    assert!((energy(&sites) / first - 1.0).abs() < 1e-13);
}

#[test]
fn lloyds_energy_never_rises_and_lattices_stay() {
    for domain in [Cuboid::unit(), torus()] {
        let relaxation = Relaxation::new(domain).cells(Norm::Linf);
        let run = relaxation.method(Method::lloyd(8));
        let mut sites = random_sites(40, 3);
        let outcome = run.run(&mut sites).expect("a run");
        for pair in outcome.records.windows(2) {
            assert!(pair[1].energy_mean <= pair[0].energy_mean * (1.0 + 1e-14));
            assert!(pair[1].energy_percent >= 100.0);
        }
        let mut lattice = grid_sites(3);
        let outcome = run.run(&mut lattice).expect("a run");
        for record in &outcome.records {
            assert!((record.energy_percent - 100.0).abs() < 1e-9);
        }
        for (site, start) in lattice.iter().zip(grid_sites(3)) {
            assert!((site - start).amax() < 1e-9, "{site} {start}");
        }
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let sites = random_sites(150, 4);
    let relaxation = Relaxation::new(Cuboid::unit()).cells(Norm::Linf);
    let relaxation = relaxation.method(Method::lloyd(1));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let mut sites = sites.clone();
        pool.expect("a pool")
            .install(|| relaxation.run(&mut sites))
            .expect("a run");
        sites
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_descent_of_l_infinity_cells_ends_below_lloyd() {
    let relaxation = Relaxation::new(Cuboid::unit()).cells(Norm::Linf);
    let relaxation = relaxation.method(Method::quasi_newton(25));
    let outcome = relaxation.run(&mut random_sites(27, 1)).expect("a run");
    let percent = outcome.records.last().expect("records").energy_percent;
    assert!((100.0..102.0).contains(&percent), "{percent}");
}

#[test]
fn what_does_not_go_with_l_infinity_cells_is_refused_by_name() {
    let cells = |relaxation: Relaxation| {
        let relaxation = relaxation.cells(Norm::Linf);
        relaxation
            .measure(&[[0.5; 3], [0.25; 3]])
            .expect_err("refused")
            .to_string()
    };
    let density = Polynomial::from_terms([([0, 0, 0], 1.0), ([1, 0, 0], 1.0)]);
    let weighted = WeightedDomain::new(Box::new(Cuboid::unit()), density).expect("positive");
    assert!(cells(Relaxation::new(weighted)).contains("a density"));
    let turned = Frames::PerSite(vec![Rotation3::identity(); 2]);
    assert!(cells(Relaxation::new(Cuboid::unit()).frames(turned)).contains("frames"));
    let control = Method::lloyd(1).norm(Norm::L2);
    assert!(cells(Relaxation::new(Cuboid::unit()).method(control)).contains("Euclidean"));
}
