//! Cells in domains of non-uniform density.

use std::ops::ControlFlow;

use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::domain::WeightedDomain;
use crate::domain::error::DomainError;
use crate::domain::shape::DomainShape;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::energy::center::Minimizer;
use crate::energy::evaluation::EnergyScratch;
use crate::energy::evaluation::{SignedPiece, energy};
use crate::energy::prepared::PreparedPiece;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::random::Random;
use crate::integrals::mesh_moments::of_piece;
use crate::integrals::polynomial::Polynomial;
use crate::mesh::shapes::{icosphere, torus, unit_cube, unit_cube_tets};
use crate::mesh::validate::{validate_surface, validate_tets};
use crate::minimize::problem::Evaluation;
use crate::relax::driver::drive;
use crate::relax::plan::Plan;
use crate::relax::relaxation_space::{EnergySpec, Norm};
use crate::relax::space::Space;
use crate::relax::state::RunState;
use crate::tests::fragments::{fragments, tetrahedra};
use nalgebra::{Point3, Vector3};

use crate::tests::quadrature::gauss;

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

fn random_sites(count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let mut uniform = || random.uniform();
    (0..count)
        .map(|_| Point3::new(uniform(), uniform(), uniform()))
        .collect()
}

fn polynomial(text: &str) -> Polynomial {
    text.parse().expect("a polynomial")
}

fn cube(text: &str) -> Box<dyn Domain> {
    let density = polynomial(text);
    Box::new(WeightedDomain::new(Box::new(Cuboid::unit()), density).expect("positive"))
}

fn tets(n: u32, density: impl Fn(&Point3<f64>) -> f64) -> Box<dyn Domain> {
    let valid = validate_tets(&unit_cube_tets(n)).expect("a valid mesh").0;
    let values: Vec<f64> = valid.mesh().vertices.iter().map(density).collect();
    let solid = TetSolid::new(&valid).expect("it bounds a solid");
    Box::new(solid.with_density(&values).expect("positive"))
}

fn block() -> Polyhedron {
    let bounds = Bounds {
        min: Point3::new(-0.4, -0.7, -0.3),
        max: Point3::new(0.6, 0.5, 0.8),
    };
    Polyhedron::cuboid(&bounds, [0; 6])
}

fn evaluate(density: &str, center: &Vector3<f64>, order: u32) -> Evaluation<3> {
    let mut piece = PreparedPiece::new(&block());
    piece.set_density(Some(&polynomial(density)));
    let piece = SignedPiece { sign: 1.0, piece };
    energy([&piece], center, order, &mut EnergyScratch::default())
}

const DENSITIES: [&str; 4] = [
    "2",
    "1 + x - 0.5*y",
    "1 + x*y + z^2",
    "2 + x^3 - y*z + x*y*z",
];

#[test]
fn weighted_energies_agree_with_quadrature_over_the_fragments() {
    for density in DENSITIES {
        for order in [1, 2, 4] {
            for center in [[0.0, 0.0, 0.0], [0.2, -0.1, 0.3], [0.9, 0.2, -0.5]] {
                let center = Point3::from(center);
                let weight = polynomial(density);
                let mut expected = 0.0;
                for fragment in fragments(&block(), &center, 9) {
                    for corners in tetrahedra(&fragment, &center) {
                        expected += gauss(&corners, |y| {
                            weight.at(y) * (y - center).amax().powi(order as i32)
                        });
                    }
                }
                let value = evaluate(density, &center.coords, order).value;
                let error = (value - expected).abs();
                assert!(error < 1e-13, "{density}, p = {order}, {center}: {error:e}");
            }
        }
    }
}

#[test]
fn weighted_gradients_and_hessians_agree_with_central_differences() {
    let step = 1e-5;
    for density in DENSITIES {
        for order in [1, 2, 3] {
            let center = Vector3::new(0.13, -0.21, 0.07);
            let here = evaluate(density, &center, order);
            for axis in 0..3 {
                let at = |sign: f64| {
                    let mut moved = center;
                    moved[axis] += sign * step;
                    evaluate(density, &moved, order)
                };
                let (up, down) = (at(1.0), at(-1.0));
                let slope = (up.value - down.value) / (2.0 * step);
                let quotient = (up.gradient - down.gradient) / (2.0 * step);
                let what = format!("{density}, p = {order}, axis {axis}");
                assert!((slope - here.gradient[axis]).abs() < 1e-8, "{what}");
                assert!(
                    (quotient - here.hessian.column(axis)).amax() < 1e-6,
                    "{what}"
                );
            }
        }
    }
}

#[test]
fn mass_moments_of_a_block_are_those_of_its_product_integrals() {
    let moments = of_piece(Piece::Convex(&block()), &polynomial("1 + x^2*y"));
    let power =
        |low: f64, high: f64, n: i32| (high.powi(n + 1) - low.powi(n + 1)) / f64::from(n + 1);
    let product =
        |[a, b, c]: [i32; 3]| power(-0.4, 0.6, a) * power(-0.7, 0.5, b) * power(-0.3, 0.8, c);
    assert!((moments.mass - product([0, 0, 0]) - product([2, 1, 0])).abs() < 1e-14);
    assert!((moments.first.x - product([1, 0, 0]) - product([3, 1, 0])).abs() < 1e-14);
    let squares = product([2, 0, 0])
        + product([4, 1, 0])
        + product([0, 2, 0])
        + product([2, 3, 0])
        + product([0, 0, 2])
        + product([2, 1, 2]);
    assert!((moments.second.trace() - squares).abs() < 1e-14);
}

#[test]
fn a_linear_density_is_the_same_as_polynomial_and_as_vertex_values() {
    let text = "1 + 2*x + 0.5*z";
    let surface =
        SurfaceSolid::new(&validate_surface(&unit_cube()).expect("closed").0).expect("a volume");
    let surface = WeightedDomain::new(Box::new(surface), polynomial(text)).expect("positive");
    let domains: [Box<dyn Domain>; 3] = [
        cube(text),
        tets(2, |y| 1.0 + 2.0 * y.x + 0.5 * y.z),
        Box::new(surface),
    ];
    let sites = random_sites(40, 1);
    let spaces = domains.map(Space::new);
    for norm in [Norm::Linf, Norm::L2] {
        let question = EnergySpec { norm, ..LINF };
        let [one, two, three] = domains_figures(&spaces, &sites, question);
        for other in [&two, &three] {
            for (one, other) in one.iter().zip(other) {
                assert!((one.0 - other.0).abs() < 1e-12, "{norm:?}");
                assert!((one.1 - other.1).amax() < 1e-11, "{norm:?}");
                assert!((one.2 - other.2).amax() < 1e-11, "{norm:?}");
            }
        }
    }
}

/// Energy, gradient and center.
type Row = (f64, Vector3<f64>, Point3<f64>);

/// The rows of all cells, per domain.
fn domains_figures(
    spaces: &[Space; 3],
    sites: &[Point3<f64>],
    question: EnergySpec,
) -> [Vec<Row>; 3] {
    spaces.each_ref().map(|space| {
        let cells = space.metrics(sites, question).expect("a diagram");
        let figures = cells
            .iter()
            .map(|cell| (cell.energy, cell.gradient, cell.center));
        figures.collect()
    })
}

#[test]
fn cells_follow_the_wanted_size() {
    let size = |y: &Point3<f64>| 0.1 + 0.2 * y.x;
    let space = Space::new(tets(3, |y| size(y).powi(-4)));
    let mut sites = random_sites(150, 2);
    let spread = |sites: &[Point3<f64>]| {
        let cells = space.metrics(sites, LINF).expect("a diagram");
        let ratios: Vec<f64> = cells
            .iter()
            .zip(sites)
            .map(|(cell, site)| cell.volume.cbrt() / size(site))
            .collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let variance = ratios.iter().map(|r| (r / mean - 1.0).powi(2)).sum::<f64>();
        (variance / ratios.len() as f64).sqrt()
    };
    let before = spread(&sites);
    let mut energies = Vec::new();
    let options = Plan::lloyd(LINF, 40);
    let mut state = RunState::new(sites.len(), 0);
    drive(
        &space,
        &options,
        &mut sites,
        &mut state,
        None,
        &mut |record, _, _| {
            energies.push(record.energy_mean);
            ControlFlow::Continue(())
        },
    )
    .expect("sites stay in the solid");
    assert!(
        energies
            .windows(2)
            .all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12)),
        "{energies:?}"
    );
    let after = spread(&sites);
    assert!(after < 0.2 && after < 0.5 * before, "{before} → {after}");
}

#[test]
fn a_density_that_is_not_positive_is_refused_with_its_place() {
    let density = polynomial("x - 0.5");
    let refused = WeightedDomain::new(Box::new(Cuboid::unit()), density).expect_err("negative");
    assert!(
        refused.to_string().contains("must be a positive number"),
        "{refused}"
    );
}

#[test]
fn the_scale_of_energies_is_the_exact_mean_density() {
    // Over the cube means are products of 1/(n + 1), over a shifted cube by the binomials.
    let text = "1 + 3*x^2 - x*y + z^3";
    let surface =
        SurfaceSolid::new(&validate_surface(&unit_cube()).expect("closed").0).expect("a volume");
    let valid = validate_tets(&unit_cube_tets(2)).expect("a valid mesh").0;
    let solid = TetSolid::new(&valid).expect("it bounds a solid");
    let domains: [Box<dyn Domain>; 3] =
        [Box::new(Cuboid::unit()), Box::new(surface), Box::new(solid)];
    for domain in domains {
        let weighted = WeightedDomain::new(domain, polynomial(text)).expect("positive");
        let expected = 1.0 + 1.0 - 0.25 + 0.25;
        assert!((weighted.mean_density() - expected).abs() < 1e-13);
    }
    let torus = validate_surface(&torus(1.0, 0.4, 24, 12))
        .expect("closed")
        .0;
    let torus = SurfaceSolid::new(&torus).expect("a volume");
    // It is symmetric about its middle.
    let weighted = WeightedDomain::new(Box::new(torus), polynomial("5 + x - 2*y + z"));
    assert!((weighted.expect("positive").mean_density() - 5.0).abs() < 1e-13);
}

#[test]
fn a_wanted_size_weighs_the_same_in_every_form_of_the_domain() {
    let size = polynomial("0.1 + 0.2*x - 0.05*y*z");
    let surface =
        SurfaceSolid::new(&validate_surface(&unit_cube()).expect("closed").0).expect("a volume");
    let valid = validate_tets(&unit_cube_tets(2)).expect("a valid mesh").0;
    let solid = TetSolid::new(&valid).expect("it bounds a solid");
    let domains: [Box<dyn Domain>; 3] =
        [Box::new(Cuboid::unit()), Box::new(surface), Box::new(solid)];
    let spaces = domains.map(|domain| {
        let sized = WeightedDomain::sized(domain, &size, 1).expect("positive");
        Space::new(Box::new(sized))
    });
    let mean = spaces[0].domain().mean_density();
    for space in &spaces[1..] {
        assert!((space.domain().mean_density() / mean - 1.0).abs() < 1e-12);
    }
    let sites = random_sites(30, 3);
    let rows = domains_figures(&spaces, &sites, LINF);
    for other in &rows[1..] {
        for (one, other) in rows[0].iter().zip(other) {
            assert!(
                (one.0 / other.0 - 1.0).abs() < 1e-10,
                "{} {}",
                one.0,
                other.0
            );
            assert!((one.2 - other.2).amax() < 1e-9);
        }
    }
}

#[test]
fn cells_follow_a_wanted_size_within_a_surface() {
    let ball = validate_surface(&icosphere(1)).expect("closed").0;
    let ball = SurfaceSolid::new(&ball).expect("a volume");
    let wanted = polynomial("0.2 + 0.08*x");
    let space = WeightedDomain::sized(Box::new(ball), &wanted, 1).expect("positive");
    let space = Space::new(Box::new(space));
    let places = random_sites(1000, 4)
        .into_iter()
        .map(|share| Point3::from(share.coords * 2.0 - Vector3::repeat(1.0)));
    let inside = places.filter(|place| space.domain().contains(place));
    let mut sites: Vec<_> = inside.take(120).collect();
    let spread = |sites: &[Point3<f64>]| {
        let cells = space.metrics(sites, LINF).expect("a diagram");
        let edges = cells
            .iter()
            .map(|cell| cell.volume.cbrt() / wanted.at(&cell.centroid));
        let edges: Vec<f64> = edges.collect();
        let mean = edges.iter().sum::<f64>() / edges.len() as f64;
        let variance = edges.iter().map(|edge| (edge / mean - 1.0).powi(2));
        (variance.sum::<f64>() / edges.len() as f64).sqrt()
    };
    let before = spread(&sites);
    let options = Plan::lloyd(LINF, 30);
    let mut energies = Vec::new();
    let mut state = RunState::new(sites.len(), 0);
    drive(
        &space,
        &options,
        &mut sites,
        &mut state,
        None,
        &mut |record, sites, _| {
            energies.push(record.energy_mean);
            assert!(sites.iter().all(|site| space.domain().contains(site)));
            ControlFlow::Continue(())
        },
    )
    .expect("sites stay in the solid");
    let falls = |pair: &[f64]| pair[1] <= pair[0] * (1.0 + 1e-12);
    assert!(energies.windows(2).all(falls), "{energies:?}");
    let after = spread(&sites);
    assert!(after < 0.2 && after < 0.5 * before, "{before} → {after}");
}

#[test]
fn a_density_along_a_period_is_refused_and_across_it_weighs() {
    let bounds = Cuboid::unit().bounds();
    let channel = || Box::new(Cuboid::new(bounds, [true, false, false]).expect("a box"));
    let refused = WeightedDomain::new(channel(), polynomial("1 + x")).expect_err("it jumps");
    assert!(
        refused.to_string().contains("periodic along x"),
        "{refused}"
    );
    let weighted = WeightedDomain::new(channel(), polynomial("1 + 2*y^2")).expect("it repeats");
    assert!((weighted.mean_density() - 5.0 / 3.0).abs() < 1e-14);
    let space = Space::new(Box::new(weighted));
    let sites = random_sites(30, 5);
    let moved: Vec<_> = sites
        .iter()
        .map(|site| space.domain().wrap(&(site + Vector3::new(0.3, 0.0, 0.0))))
        .collect();
    let [one, other] = [&sites, &moved].map(|sites| space.metrics(sites, LINF).expect("a diagram"));
    for (one, other) in one.iter().zip(&other) {
        assert!((one.energy - other.energy).abs() < 1e-13);
    }
}

#[test]
fn a_formula_far_from_the_origin_gives_the_energies_of_its_shift() {
    let text = |at: f64| format!("1 + (x - {at:?})^8 + (y - {at:?})^3*(x - {at:?})^5");
    let unit = |at: f64| {
        let bounds = Bounds::from_corners([at; 3], [at + 1.0; 3]);
        Box::new(Cuboid::new(bounds, [false; 3]).expect("a box"))
    };
    let sites = [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5], [0.5, 0.125, 0.25]].map(Point3::from);
    let energies = |at: f64| {
        let domain = WeightedDomain::new(unit(at), polynomial(&text(at))).expect("positive");
        let there: Vec<_> = sites
            .iter()
            .map(|site| site + Vector3::repeat(at))
            .collect();
        let space = Space::new(Box::new(domain));
        let cells = space.metrics(&there, LINF).expect("a diagram");
        cells.iter().map(|cell| cell.energy).collect::<Vec<_>>()
    };
    let base = energies(0.0);
    for at in [1e2, 1e3, 1e6] {
        for (energy, exact) in energies(at).iter().zip(&base) {
            assert!(
                (energy / exact - 1.0).abs() < 1e-12,
                "{at}: {energy} {exact}"
            );
        }
    }
    // The issue's own: ∫ (1 + t⁸) max(|t − 1/4|, |y|, |z|) over [0, 1/2] × [−1/2, 1/2]², and its mirror.
    let bounds = Bounds::from_corners([100.0, 0.0, 0.0], [101.0, 1.0, 1.0]);
    let domain = Box::new(Cuboid::new(bounds, [false; 3]).expect("a box"));
    let domain = WeightedDomain::new(domain, polynomial("1+(x-100.0)^8")).expect("positive");
    let space = Space::new(Box::new(domain));
    let sites = [[100.25, 0.5, 0.5], [100.75, 0.5, 0.5]].map(Point3::from);
    let cells = space.metrics(&sites, LINF).expect("a diagram");
    for (cell, sides) in cells.iter().zip([[0.0, 0.5], [0.5, 1.0]]) {
        // For each t: ∫ max(a, |y|, |z|) dy dz over the square of half side 1/2 is 1/3 + 4 a³/3.
        let primitive = |t: f64, at: f64| {
            let a: f64 = (t - at).abs();
            1.0 / 3.0 + 4.0 / 3.0 * a.powi(3)
        };
        let at = sides[0] + 0.25;
        let steps = 20_000;
        let width = 0.5 / f64::from(steps);
        let sum: f64 = (0..steps)
            .map(|k| sides[0] + (f64::from(k) + 0.5) * width)
            .map(|t| (1.0 + t.powi(8)) * primitive(t, at))
            .sum();
        assert!(
            (cell.energy - sum * width).abs() < 1e-8,
            "{} {}",
            cell.energy,
            sum * width
        );
    }
    assert!((cells[0].energy - 0.16935).abs() < 5e-6 && (cells[1].energy - 0.20715).abs() < 5e-6);
}

#[test]
fn dips_below_zero_are_found_in_every_kind_of_domain() {
    use crate::domain::convex::ConvexPolyhedron;
    use crate::geometry::half_space::HalfSpace;

    let half_spaces = [1.0, -1.0].map(|sign| {
        [Vector3::x(), Vector3::y(), Vector3::z()].map(|normal| HalfSpace {
            normal: normal * sign,
            offset: if sign > 0.0 { 1.0 } else { 0.0 },
        })
    });
    let cubes = || -> [Box<dyn Domain>; 4] {
        let surface = validate_surface(&unit_cube()).expect("closed").0;
        let tets = validate_tets(&unit_cube_tets(1)).expect("a valid mesh").0;
        [
            Box::new(Cuboid::unit()),
            Box::new(ConvexPolyhedron::new(&half_spaces.concat()).expect("bounded")),
            Box::new(SurfaceSolid::new(&surface).expect("a volume")),
            Box::new(TetSolid::new(&tets).expect("it bounds a solid")),
        ]
    };
    let dip = "(x - 0.337)^2 + (y - 0.611)^2 + (z - 0.273)^2 - 0.0001";
    for domain in cubes() {
        let refused = WeightedDomain::new(domain, polynomial(dip)).expect_err("a dip");
        let DomainError::Density { value, position } = refused else {
            panic!("{refused}");
        };
        assert!(
            value < 0.0
                && (Point3::from(position) - Point3::new(0.337, 0.611, 0.273)).norm() < 0.01
        );
    }
    for domain in cubes() {
        let touching = polynomial("(x - 0.337)^2 + (y - 0.611)^2 + (z - 0.273)^2");
        assert!(WeightedDomain::new(domain, touching).is_ok());
    }
    let ball = || {
        let valid = validate_surface(&icosphere(2)).expect("closed").0;
        SurfaceSolid::new(&valid).expect("a volume")
    };
    let farthest = ball().bounds().max.x;
    for (text, is_positive) in [
        ("1.45 - x - y".to_owned(), true),
        (format!("{} - x", farthest - 1e-4), false),
        (format!("{} - x", farthest + 1e-9), true),
    ] {
        let weighted = WeightedDomain::new(Box::new(ball()), polynomial(&text));
        assert_eq!(weighted.is_ok(), is_positive, "{text}");
    }
}

#[test]
fn energies_with_a_density_are_relative_to_the_asymptotic_optimum() {
    // 1 + 80 x⁴: relative to equal cubes the percentage ran down to 87.
    let space = Space::new(cube("1 + 80*x^4"));
    let optimum = crate::relax::relaxation_space::RelaxationSpace::optimum(&space);
    let steps = 100_000;
    let shares = (0..steps).map(|k| (f64::from(k) + 0.5) / f64::from(steps));
    let power = shares
        .map(|x| (1.0 + 80.0 * x.powi(4)).powf(0.75))
        .sum::<f64>()
        / f64::from(steps);
    let exact = 3.0 / 8.0 * (power / 100.0).powf(4.0 / 3.0);
    let found = optimum.energy::<3>(100);
    assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
    assert!(optimum.energy_error::<3>(100) < 1e-5 * found);
    // The same in vertex values of a linear density, where it is a series.
    let tets = Space::new(tets(2, |y| 1.0 + 8.0 * y.x));
    let optimum = crate::relax::relaxation_space::RelaxationSpace::optimum(&tets);
    let linear = (9.0_f64.powf(1.75) - 1.0) / 14.0;
    let exact = 3.0 / 8.0 * linear.powf(4.0 / 3.0);
    assert!((optimum.energy::<3>(1) / exact - 1.0).abs() < 1e-10);
    // A cell's own density: cubes in a constant one are optimal whatever that is.
    let twice = Space::new(cube("2"));
    let cells = twice
        .metrics(&[Point3::new(0.5, 0.5, 0.5)], LINF)
        .expect("one cell");
    assert!((cells[0].relative_density - 1.0).abs() < 1e-14);
    let graded = Space::new(cube("1 + 2*x"));
    let sites = [Point3::new(0.25, 0.5, 0.5), Point3::new(0.75, 0.5, 0.5)];
    let cells = graded.metrics(&sites, LINF).expect("two cells");
    assert!((cells[0].relative_density - 0.75).abs() < 1e-14);
    assert!((cells[1].relative_density - 1.25).abs() < 1e-14);
}
