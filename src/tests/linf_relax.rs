//! Relaxation with L∞ cells: the objective, its gradient, descent, and what is refused.

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::{Domain, WeightedDomain};
use crate::domain::planar::PlaneDomain;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polygon::ConvexPolygon;
use crate::geometry::random::Random;
use crate::integrals::polynomial::Polynomial;
use crate::mesh::shapes::unit_cube_tets;
use crate::relax::frames::Frames;
use crate::relax::method::Method;
use crate::relax::planar::Plane;
use crate::relax::record::Record;
use crate::relax::relaxation::{Relaxation, random_sites as random_sites_of};
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::tests::sites::{grid_sites, random_sites};
use crate::voronoi::planar::diagram::PlaneDiagram;
use nalgebra::{Point2, Point3, Rotation3, Vector3};
use std::ops::ControlFlow;

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

/// Of the starts 1 to 8 of 216 sites the one that takes longest.
#[test]
fn the_gradient_falls_to_1e_7_of_its_start_in_less_than_120_evaluations() {
    let space = linf(Cuboid::unit());
    let mut sites = random_sites_of(&Cuboid::unit(), 216, 4).expect("room");
    let gradient = |sites: &[Point3<f64>]| {
        let value = space.objective(sites, 1).expect("cells");
        value.gradient.iter().map(|g| g.amax()).fold(0.0, f64::max)
    };
    let goal = 1e-7 * gradient(&sites);
    let relaxation = Relaxation::new(Cuboid::unit()).cells(Norm::Linf);
    let relaxation = relaxation.method(Method::quasi_newton(120));
    let (mut at_45, mut evaluations) = (0.0, 0.0);
    let observer = |record: &Record, sites: &[Point3<f64>]| {
        if record.evaluations <= 45.0 {
            at_45 = record.energy_percent;
        }
        evaluations = record.evaluations;
        match record.iteration > 70 && gradient(sites) < goal {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    relaxation.run_with(&mut sites, observer).expect("a run");
    assert!((100.0..101.0).contains(&at_45), "{at_45}");
    assert!(
        evaluations < 120.0 && gradient(&sites) < goal,
        "{evaluations}"
    );
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
    let turned = Frames::PerSite(vec![Rotation3::identity(); 2]);
    assert!(cells(Relaxation::new(Cuboid::unit()).frames(turned)).contains("frames"));
    let control = Method::lloyd(1).norm(Norm::L2);
    assert!(cells(Relaxation::new(Cuboid::unit()).method(control)).contains("Euclidean"));
}

/// The unit cube with the density 1 + 2x + z².
fn weighted() -> WeightedDomain {
    let density = Polynomial::from_terms([([0, 0, 0], 1.0), ([1, 0, 0], 2.0), ([0, 0, 2], 1.0)]);
    WeightedDomain::new(Box::new(Cuboid::unit()), density).expect("positive")
}

/// An L-shaped prism: the unit cube without its part x, y > 1/2.
fn l_shaped() -> SurfaceSolid {
    let outline = [
        [0.0, 0.0],
        [1.0, 0.0],
        [1.0, 0.5],
        [0.5, 0.5],
        [0.5, 1.0],
        [0.0, 1.0],
    ];
    let vertices = [0.0, 1.0]
        .into_iter()
        .flat_map(|z| outline.map(|[x, y]| Point3::new(x, y, z)));
    let mut triangles = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, c, b], [a + 6, b + 6, c + 6_u32]]);
    }
    for side in 0..6 {
        let next = (side + 1) % 6;
        triangles.extend([[side, next, next + 6], [side, next + 6, side + 6]]);
    }
    let vertices: Vec<Point3<f64>> = vertices.collect();
    SurfaceSolid::from_arrays(&vertices, &triangles).expect("a solid")
}

/// ∫ ρ min_i d∞ over the domain's box by the midpoint rule, and F.
fn by_midpoints(
    space: &Space,
    sites: &[Point3<f64>],
    density: impl Fn(&Point3<f64>) -> f64,
) -> f64 {
    let steps = 48;
    let at = |n: usize| (n as f64 + 0.5) / steps as f64;
    let mut sum = 0.0;
    for n in 0..steps * steps * steps {
        let point = Point3::new(at(n % steps), at(n / steps % steps), at(n / steps / steps));
        if space.contains(&point) {
            let distances = sites.iter().map(|site| (site - point).amax());
            sum += density(&point) * distances.fold(f64::INFINITY, f64::min);
        }
    }
    sum / (steps * steps * steps) as f64
}

/// Volumes fill the solid, F is the integral of the least distance, Lloyd lowers it, and its gradient is
/// that of differences, in a domain that is not convex and in one with a density.
#[test]
fn solids_and_densities_have_l_infinity_cells() {
    let ones = |_: &Point3<f64>| 1.0;
    let graded = |at: &Point3<f64>| 1.0 + 2.0 * at.x + at.z * at.z;
    type DensityAt<'a> = &'a dyn Fn(&Point3<f64>) -> f64;
    let all: [(Space, DensityAt<'_>); 2] = [(linf(l_shaped()), &ones), (linf(weighted()), &graded)];
    for (space, density) in all {
        let sites: Vec<_> = random_sites(12, 7)
            .into_iter()
            .filter(|site| space.contains(site))
            .collect();
        let cells = space.metrics(&sites, spec(1)).expect("cells");
        let volume: f64 = cells.iter().map(|cell| cell.volume).sum();
        assert!((volume / space.volume() - 1.0).abs() < 1e-12, "{volume}");
        let value = space.objective(&sites, 1).expect("cells");
        let expected = by_midpoints(&space, &sites, density);
        assert!(
            (value.energy / expected - 1.0).abs() < 2e-3,
            "{} {expected}",
            value.energy
        );
        for axis in 0..3 {
            let energy = |step: f64| {
                let mut moved = sites.clone();
                moved[2][axis] += step;
                space.energy(&moved, spec(1)).expect("cells")
            };
            let slope = (energy(1e-5) - energy(-1e-5)) / 2e-5;
            let error = (slope - value.gradient[2][axis]).abs();
            assert!(error < 1e-8, "{error:e} {slope}");
        }
        let moved: Vec<_> = space.assess(&sites, spec(1)).expect("cells");
        let moved: Vec<_> = moved.into_iter().map(|cell| cell.target).collect();
        assert!(space.energy(&moved, spec(1)).expect("cells") < value.energy);
        let both = space.both(&sites).expect("cells").expect("figures");
        assert!(both.energy_percent_linf < both.energy_percent_l2 && both.tied_volume < 1e-12);
    }
}

/// Cells, energies and moves in tetrahedra that fill the cube are those in the cube.
#[test]
fn tetrahedra_have_the_l_infinity_cells_of_what_they_fill() {
    let tets = unit_cube_tets(2);
    let tets = TetSolid::from_arrays(&tets.vertices, &tets.tets).expect("a solid");
    let (tets, cube) = (linf(tets), linf(Cuboid::unit()));
    let sites = random_sites(14, 7);
    let cells = [&tets, &cube].map(|space| space.metrics(&sites, spec(2)).expect("cells"));
    for (one, other) in cells[0].iter().zip(&cells[1]) {
        assert!((one.volume - other.volume).abs() < 1e-14, "{one:?}");
        assert!((one.energy - other.energy).abs() < 1e-14, "{one:?}");
        assert!((one.center - other.center).amax() < 1e-9, "{one:?}");
    }
    let values = [&tets, &cube].map(|space| space.objective(&sites, 1).expect("cells"));
    assert!((values[0].energy - values[1].energy).abs() < 1e-14);
    for (one, other) in values[0].gradient.iter().zip(&values[1].gradient) {
        assert!((one - other).amax() < 1e-12, "{one} {other}");
    }
}

/// One frame for all cells turns the distance, and what comes back lies in space.
#[test]
fn one_frame_turns_l_infinity_cells() {
    let frame = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
    let space = linf(convex()).framed(Frames::One(frame));
    let sites: Vec<_> = random_sites(10, 7)
        .into_iter()
        .filter(|site| space.contains(site))
        .collect();
    let value = space.objective(&sites, 1).expect("cells");
    let turned: Vec<_> = sites.iter().map(|site| frame.inverse() * site).collect();
    let steps = 40;
    let at = |n: usize| (n as f64 + 0.5) / steps as f64;
    let mut sum = 0.0;
    for n in 0..steps * steps * steps {
        let point = Point3::new(at(n % steps), at(n / steps % steps), at(n / steps / steps));
        if space.contains(&point) {
            let point = frame.inverse() * point;
            let distances = turned.iter().map(|site| (site - point).amax());
            sum += distances.fold(f64::INFINITY, f64::min);
        }
    }
    let expected = sum / (steps * steps * steps) as f64;
    assert!(
        (value.energy / expected - 1.0).abs() < 2e-3,
        "{} {expected}",
        value.energy
    );
    for axis in 0..3 {
        let energy = |step: f64| {
            let mut moved = sites.clone();
            moved[3][axis] += step;
            space.energy(&moved, spec(1)).expect("cells")
        };
        let error = (energy(1e-5) - energy(-1e-5)) / 2e-5 - value.gradient[3][axis];
        assert!(error.abs() < 1e-8, "{error:e}");
    }
    let cells = space.metrics(&sites, spec(1)).expect("cells");
    assert!(
        cells
            .iter()
            .all(|cell| space.contains(&cell.center) && space.contains(&cell.centroid))
    );
    let moved = space.assess(&sites, spec(1)).expect("cells");
    let moved: Vec<_> = moved.into_iter().map(|cell| cell.target).collect();
    assert!(space.energy(&moved, spec(1)).expect("cells") < value.energy);
}

/// Random sites of the unit square, perhaps with coordinates of few values.
fn planar_sites(count: usize, seed: u64, steps: Option<f64>) -> Vec<Point2<f64>> {
    let mut random = Random::new(seed);
    let mut coordinate = || {
        let x = random.uniform();
        steps.map_or(x, |steps| ((x * steps).floor() + 0.5) / steps)
    };
    let mut sites: Vec<Point2<f64>> = Vec::new();
    while sites.len() < count {
        let site = Point2::new(coordinate(), coordinate());
        if !sites.contains(&site) {
            sites.push(site);
        }
    }
    sites
}

/// The gradient of some sites against central differences.
fn check_planar_gradient(plane: &Plane, sites: &[Point2<f64>]) {
    let value = plane.objective(sites, 1).expect("cells");
    for site in (0..sites.len()).step_by(7) {
        for axis in 0..2 {
            let energy = |step: f64| {
                let mut moved = sites.to_vec();
                moved[site][axis] += step;
                plane.energy(&moved, spec(1)).expect("cells")
            };
            let slope = (energy(1e-6) - energy(-1e-6)) / 2e-6;
            let error = (slope - value.gradient[site][axis]).abs();
            assert!(error < 1e-8, "{error:e} {slope}");
        }
    }
}

/// In the plane too: areas fill the domain, F is never above that of L2 cells, its gradient is that of
/// differences, Lloyd lowers it, and a grid is its own minimum.
#[test]
fn planar_domains_have_l_infinity_cells() {
    let unit = PlaneDomain::rectangle(&Bounds::from_corners([0.0; 2], [1.0; 2])).expect("a domain");
    let corners = |places: &[[f64; 2]]| -> PlaneDomain {
        let places: Vec<_> = places.iter().map(|&[x, y]| Point2::new(x, y)).collect();
        PlaneDomain::from_corners(&places).expect("a domain")
    };
    let domains = [
        unit.clone(),
        unit.clone().repeated([true; 2]),
        unit.clone().repeated([false, true]),
        corners(&[[0.0, 0.1], [0.8, 0.0], [1.0, 0.7], [0.4, 1.0]]),
        corners(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 0.5],
            [0.5, 0.5],
            [0.5, 1.0],
            [0.0, 1.0],
        ]),
    ];
    for domain in domains {
        let plane = Plane {
            domain: domain.with_linf_cells(true),
        };
        for (count, steps) in [(1, None), (40, None), (30, Some(8.0))] {
            let sites = planar_sites(count, 5, steps).into_iter();
            let sites: Vec<_> = sites.filter(|site| plane.contains(site)).collect();
            if sites.is_empty() {
                continue;
            }
            let cells = plane.metrics(&sites, spec(1)).expect("cells");
            let area: f64 = cells.iter().map(|cell| cell.volume).sum();
            assert!(
                (area / plane.volume() - 1.0).abs() < 1e-12,
                "{area} {count}"
            );
            let both = plane.both(&sites).expect("cells").expect("figures");
            assert!(both.energy_percent_linf <= both.energy_percent_l2 + 1e-9);
            let value = plane.objective(&sites, 1).expect("cells");
            let moved = plane.assess(&sites, spec(1)).expect("cells");
            let moved: Vec<_> = moved.into_iter().map(|cell| cell.target).collect();
            assert!(plane.energy(&moved, spec(1)).expect("cells") <= value.energy);
            assert_eq!(both.tied_volume > 0.01, steps.is_some() && sites.len() > 1);
            if steps.is_none() {
                check_planar_gradient(&plane, &sites);
            }
        }
    }
}

/// A point belongs to the cell of the site that is nearest by brute force, and to no other.
#[test]
fn planar_cells_hold_the_points_nearest_to_their_sites() {
    let unit = PlaneDomain::rectangle(&Bounds::from_corners([0.0; 2], [1.0; 2])).expect("a domain");
    let domain = unit.with_linf_cells(true);
    let mut random = Random::new(3);
    let sites: Vec<_> = (0..60)
        .map(|_| Point2::new(random.uniform(), random.uniform()))
        .collect();
    let cells = PlaneDiagram::new(&domain, &sites).expect("cells").cells;
    for _ in 0..3000 {
        let point = Point2::new(random.uniform(), random.uniform());
        let distance = |site: &usize| (sites[*site] - point).amax();
        let mut order: Vec<_> = (0..sites.len()).collect();
        order.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        if distance(&order[1]) - distance(&order[0]) < 1e-9 {
            continue;
        }
        let holds = |site: &usize| {
            let at = point - sites[*site].coords;
            let inside = |piece: &ConvexPolygon| {
                piece
                    .edges()
                    .all(|edge| (edge.end - edge.start).perp(&(at - edge.start)) >= 0.0)
            };
            cells[*site].pieces().iter().any(inside)
        };
        let holders: Vec<_> = order.iter().copied().filter(holds).collect();
        assert_eq!(holders, order[..1]);
    }
    for cell in &cells {
        // The outline is that of the parts.
        assert!((cell.polygon.area() - cell.area()).abs() < 1e-14);
    }
}
