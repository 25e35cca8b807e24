//! The global objective: its gradient against central differences, its value against the sum of
//! the cells, in every domain.

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::domain::WeightedDomain;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::mesh::shapes::{bracket, torus, unit_cube_tets};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::{validate_surface, validate_tets};
use crate::relax::frames::Frames;
use crate::relax::optimum::optimal_energy;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use nalgebra::{Point3, Rotation3, Unit, Vector3};

fn random_sites(domain: &dyn Domain, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let bounds = domain.bounds();
    let mut sites = Vec::new();
    while sites.len() < count {
        let part = Vector3::from([0; 3].map(|_| random.uniform()));
        let site = bounds.min + bounds.extent().component_mul(&part);
        if domain.contains(&site) {
            sites.push(site);
        }
    }
    sites
}

fn cuboid(extent: [f64; 3], periodic: [bool; 3]) -> Space {
    let bounds = Bounds {
        min: Point3::new(-0.5, 0.25, 1.0),
        max: Point3::new(-0.5, 0.25, 1.0) + Vector3::from(extent),
    };
    Space::new(Box::new(Cuboid::new(bounds, periodic).unwrap()))
}

/// A tetrahedron with two corners cut off.
fn convex() -> Space {
    let half_space = |normal: [f64; 3], offset| HalfSpace {
        normal: Vector3::from(normal),
        offset,
    };
    let walls = [
        half_space([-1.0, 0.1, 0.0], 0.0),
        half_space([0.0, -1.0, 0.2], 0.0),
        half_space([0.0, 0.0, -1.0], 0.0),
        half_space([1.0, 1.0, 1.0], 1.0),
        half_space([1.0, 0.3, -0.2], 0.7),
        half_space([0.0, 0.2, 1.0], 0.8),
    ];
    Space::new(Box::new(ConvexPolyhedron::new(&walls).unwrap()))
}

/// The largest difference between the gradient and central differences, relative to the largest
/// component of the gradient.
fn gradient_error(space: &Space, sites: &[Point3<f64>], order: u32) -> f64 {
    let exact = space.objective(sites, order).unwrap().gradient;
    let largest = exact.iter().map(Vector3::amax).fold(0.0, f64::max);
    let step = 1e-6;
    let mut worst: f64 = 0.0;
    for site in 0..sites.len() {
        for axis in 0..3 {
            let at = |offset: f64| {
                let mut moved = sites.to_vec();
                moved[site][axis] += offset;
                space.objective(&moved, order).unwrap().energy
            };
            let difference = (at(step) - at(-step)) / (2.0 * step);
            worst = worst.max((difference - exact[site][axis]).abs());
        }
    }
    worst / largest
}

fn check_gradient(space: &Space, count: usize, seed: u64) {
    let sites = random_sites(space.domain(), count, seed);
    for order in [1, 2, 3] {
        let error = gradient_error(space, &sites, order);
        assert!(error < 1e-7, "p = {order}, seed {seed}: {error:e}");
    }
}

#[test]
fn the_gradient_is_that_of_central_differences_in_a_box() {
    check_gradient(&cuboid([1.0, 1.5, 0.7], [false; 3]), 30, 1);
}

#[test]
fn the_gradient_is_that_of_central_differences_in_periodic_boxes() {
    check_gradient(&cuboid([1.0, 1.5, 0.7], [true; 3]), 25, 2);
    check_gradient(&cuboid([1.0, 1.0, 1.0], [true, false, true]), 25, 3);
}

#[test]
fn the_gradient_is_that_of_central_differences_where_images_of_a_site_are_its_neighbors() {
    check_gradient(&cuboid([1.0, 1.2, 0.9], [true; 3]), 2, 4);
}

#[test]
fn the_gradient_is_that_of_central_differences_in_a_convex_polyhedron() {
    check_gradient(&convex(), 25, 5);
}

/// Two programs for the same integrals: that of Lloyd's cells and that of the global objective.
fn check_sums(space: &Space, sites: &[Point3<f64>], order: u32, tolerance: f64) {
    let question = EnergySpec {
        norm: Norm::Linf,
        order,
        minimizer: Minimizer::Newton,
    };
    let check = |found: f64, expected: f64, tolerance: f64| {
        let error = (found - expected).abs() / expected;
        assert!(error < tolerance, "p = {order}: {error:e}");
    };
    let cells = space.assess(sites, question).unwrap();
    let global = space.objective(sites, order).unwrap();
    for (cell, energy) in cells.iter().zip(&global.energies) {
        check(*energy, cell.energy, 1e-12);
    }
    let energy = cells.iter().map(|cell| cell.energy).sum();
    check(global.energy, energy, tolerance);
    let chebyshev = cells.iter().map(|cell| cell.chebyshev).sum();
    check(global.chebyshev, chebyshev, tolerance);
}

#[test]
fn the_objective_is_the_sum_of_the_cells_energies() {
    let space = cuboid([1.0, 1.5, 0.7], [false, true, false]);
    let sites = random_sites(space.domain(), 200, 6);
    for order in [1, 2, 4] {
        check_sums(&space, &sites, order, 1e-13);
    }
}

#[test]
fn no_sites_beat_the_grid_whose_gradient_is_zero() {
    let space = cuboid([1.0, 1.0, 1.0], [false; 3]);
    let least = 64.0 * optimal_energy::<3>(1.0, 64, 1);
    let corner = space.domain().bounds().min;
    let place = |k: usize| (k as f64 + 0.5) / 4.0;
    let grid: Vec<_> = (0..64)
        .map(|k| corner + Vector3::new(place(k % 4), place(k / 4 % 4), place(k / 16)))
        .collect();
    let global = space.objective(&grid, 1).unwrap();
    assert!((global.energy / least - 1.0).abs() < 1e-13);
    let largest = global
        .gradient
        .iter()
        .map(Vector3::amax)
        .fold(0.0, f64::max);
    assert!(largest < 1e-14, "{largest:e}");
    let random = random_sites(space.domain(), 64, 7);
    assert!(space.objective(&random, 1).unwrap().energy > least);
}

#[test]
fn the_objective_does_not_depend_on_the_number_of_threads() {
    let space = convex();
    let sites = random_sites(space.domain(), 500, 8);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| space.objective(&sites, 1).unwrap())
    };
    assert_eq!(on(1), on(3));
}

/// A cube turned by 30 degrees about an axis, with frames turned the same way.
fn turned(degrees: f64) -> (Space, Rotation3<f64>) {
    let axis = Unit::new_normalize(Vector3::new(1.0, 2.0, 0.5));
    let rotation = Rotation3::from_axis_angle(&axis, degrees.to_radians());
    let walls: Vec<_> = [0, 1, 2]
        .into_iter()
        .flat_map(|axis| [1.0, -1.0].map(|sign| (axis, sign)))
        .map(|(axis, sign)| {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            HalfSpace {
                normal: rotation * normal,
                offset: 0.5,
            }
        })
        .collect();
    let domain = Box::new(ConvexPolyhedron::new(&walls).unwrap());
    (Space::with_frames(domain, Frames::One(rotation)), rotation)
}

#[test]
fn a_turned_cube_with_turned_frames_is_worth_the_same() {
    let (upright, _) = turned(0.0);
    let (space, rotation) = turned(30.0);
    let sites = random_sites(upright.domain(), 120, 9);
    let turned_sites: Vec<_> = sites.iter().map(|site| rotation * site).collect();
    let question = EnergySpec {
        norm: Norm::Linf,
        order: 1,
        minimizer: Minimizer::Newton,
    };
    let cells = upright.metrics(&sites, question).unwrap();
    let turned_cells = space.metrics(&turned_sites, question).unwrap();
    for (a, b) in cells.iter().zip(&turned_cells) {
        assert!((a.energy / b.energy - 1.0).abs() < 1e-12);
        assert!((a.center_energy / b.center_energy - 1.0).abs() < 1e-12);
        assert!((rotation * a.center - b.center).norm() < 1e-9);
        assert!((rotation * a.gradient - b.gradient).norm() < 1e-12 * a.volume);
        assert!((a.cubeness - b.cubeness).abs() < 1e-12);
        assert!((a.axis_aligned - b.axis_aligned).abs() < 1e-12);
        assert_eq!(a.facets, b.facets);
    }
    let (a, b) = (
        upright.objective(&sites, 2).unwrap(),
        space.objective(&turned_sites, 2).unwrap(),
    );
    assert!((a.energy / b.energy - 1.0).abs() < 1e-12);
    for (a, b) in a.gradient.iter().zip(&b.gradient) {
        assert!((rotation * a - b).norm() < 1e-12);
    }
}

#[test]
fn the_gradient_is_that_of_central_differences_with_a_frame_for_every_site() {
    let mut random = Random::new(10);
    let frame = |random: &mut Random| {
        let angles = [0; 3].map(|_| 6.0 * random.uniform());
        Rotation3::from_euler_angles(angles[0], angles[1], angles[2])
    };
    let frames = (0..25).map(|_| frame(&mut random)).collect();
    let space = Space::with_frames(Box::new(Cuboid::unit()), Frames::PerSite(frames));
    check_gradient(&space, 25, 11);
}

fn solid(mesh: &SurfaceMesh) -> Box<dyn Domain> {
    Box::new(SurfaceSolid::new(&validate_surface(mesh).unwrap().0).unwrap())
}

fn weighted(domain: Box<dyn Domain>) -> Box<dyn Domain> {
    let density = "2 + x - 0.5*y*z + x^2".parse().unwrap();
    Box::new(WeightedDomain::new(domain, density).unwrap())
}

/// The unit cube in tetrahedra, with a density that is linear on each and has kinks between them.
fn tets(has_density: bool) -> Box<dyn Domain> {
    let valid = validate_tets(&unit_cube_tets(2)).unwrap().0;
    let values = valid.mesh().vertices.iter();
    let values: Vec<f64> = values.map(|v| 1.0 + v.x + v.y * v.y + v.z.abs()).collect();
    let solid = TetSolid::new(&valid).unwrap();
    match has_density {
        true => Box::new(solid.with_density(&values).unwrap()),
        false => Box::new(solid),
    }
}

#[test]
fn the_gradient_is_that_of_central_differences_in_tetrahedra() {
    check_gradient(&Space::new(tets(false)), 20, 12);
}

#[test]
fn the_gradient_is_that_of_central_differences_in_surfaces() {
    check_gradient(&Space::new(solid(&bracket(2))), 20, 13);
    check_gradient(&Space::new(solid(&torus(1.0, 0.4, 12, 8))), 20, 14);
}

#[test]
fn the_gradient_is_that_of_central_differences_with_a_density() {
    check_gradient(&Space::new(weighted(Box::new(Cuboid::unit()))), 12, 15);
    check_gradient(&Space::new(tets(true)), 8, 16);
    check_gradient(&Space::new(weighted(solid(&bracket(2)))), 8, 17);
}

#[test]
fn the_gradient_is_that_of_central_differences_with_a_density_and_frames() {
    let (_, frame) = turned(30.0);
    for domain in [weighted(Box::new(Cuboid::unit())), tets(true)] {
        check_gradient(&Space::with_frames(domain, Frames::One(frame)), 8, 18);
    }
}

#[test]
fn the_objective_is_the_sum_of_the_cells_energies_with_a_density() {
    for domain in [weighted(Box::new(Cuboid::unit())), tets(true)] {
        let space = Space::new(domain);
        let sites = random_sites(space.domain(), 60, 19);
        for order in [1, 2, 3] {
            check_sums(&space, &sites, order, 1e-12);
        }
    }
}

#[test]
fn a_density_of_one_changes_nothing() {
    let plain = Space::new(Box::new(Cuboid::unit()));
    let one = "1 + 0*x".parse().unwrap();
    let domain = WeightedDomain::new(Box::new(Cuboid::unit()), one).unwrap();
    let weighted = Space::new(Box::new(domain));
    let sites = random_sites(plain.domain(), 50, 20);
    for order in [1, 2] {
        let expected = plain.objective(&sites, order).unwrap();
        let found = weighted.objective(&sites, order).unwrap();
        assert!((found.energy / expected.energy - 1.0).abs() < 1e-13);
        for (a, b) in found.gradient.iter().zip(&expected.gradient) {
            assert!((a - b).norm() < 1e-13 * expected.energy);
        }
    }
}
