//! The energy of pieces: value, gradient and Hessian against independent evaluations.

use crate::domain::cuboid::Cuboid;
use crate::energy::evaluation::{EnergyScratch, SignedPiece, energy, energy_jet};
use crate::energy::prepared::PreparedPiece;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::random::Random;
use crate::minimize::problem::Evaluation;
use crate::tests::fragments::{fragments, tetrahedra};
use crate::voronoi::diagram::Diagram;
use nalgebra::{Matrix3, Point3, Vector3};

use crate::tests::quadrature::gauss;

fn point(random: &mut Random) -> Point3<f64> {
    Point3::new(random.uniform(), random.uniform(), random.uniform())
}

/// A random convex polyhedron around the origin: a cube cut by bisectors.
fn random_piece(seed: u64) -> Polyhedron {
    let mut random = Random::new(seed);
    let corner = Point3::new(1.0, 1.0, 1.0);
    let around = Bounds {
        min: -corner,
        max: corner,
    };
    let mut piece = Polyhedron::cuboid(&around, [0; 6]);
    let mut scratch = ClipScratch::default();
    for label in 0..20 {
        let direction = point(&mut random) - Point3::new(0.5, 0.5, 0.5);
        let distance = 1.0 + random.uniform();
        let bisector = HalfSpace::bisector(direction.normalize() * distance);
        clip(&mut piece, &bisector, label, &mut scratch);
    }
    piece
}

fn whole(piece: &Polyhedron) -> [SignedPiece; 1] {
    [SignedPiece {
        sign: 1.0,
        piece: PreparedPiece::new(piece),
    }]
}

fn evaluate(piece: &Polyhedron, center: &Vector3<f64>, order: u32) -> Evaluation<3> {
    energy(&whole(piece), center, order, &mut EnergyScratch::default())
}

fn chebyshev_distance(a: &Point3<f64>, b: &Point3<f64>) -> f64 {
    (a - b).amax()
}

/// Σ over the tetrahedra of all fragments of ∫ distance^p by a product rule of Gauss-Legendre points,
/// which is exact for the polynomial that the integrand is on each.
fn by_fragments(piece: &Polyhedron, center: &Point3<f64>, order: u32) -> f64 {
    let mut sum = 0.0;
    for fragment in fragments(piece, center, 9) {
        for tetrahedron in tetrahedra(&fragment, center) {
            sum += gauss(&tetrahedron, |y| {
                chebyshev_distance(center, y).powi(order as i32)
            });
        }
    }
    sum
}

fn assert_close(actual: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (actual - expected).abs() <= tolerance * (1.0 + expected.abs()),
        "{what}: {actual} instead of {expected}"
    );
}

#[test]
fn a_cube_about_its_center_has_three_eighths_of_its_volume_to_four_thirds() {
    let corner = Point3::new(1.5, 1.5, 1.5);
    let cube = Polyhedron::cuboid(
        &Bounds {
            min: -corner,
            max: corner,
        },
        [0; 6],
    );
    let evaluation = evaluate(&cube, &Vector3::zeros(), 1);
    assert_close(evaluation.value, 0.375 * 81.0, 1e-15, "energy");
    assert_close(evaluation.gradient.amax(), 0.0, 1e-14, "gradient");
}

#[test]
fn energies_of_any_order_agree_with_quadrature_over_the_fragments() {
    let mut random = Random::new(1);
    for seed in 0..60 {
        let piece = random_piece(seed);
        let center = Point3::from((point(&mut random).coords * 2.0).add_scalar(-1.0) * 0.6);
        for order in [1, 2, 3, 6] {
            let value = evaluate(&piece, &center.coords, order).value;
            let expected = by_fragments(&piece, &center, order);
            assert_close(value, expected, 1e-12, &format!("seed {seed}, p = {order}"));
        }
    }
}

#[test]
fn gradients_and_hessians_agree_with_central_differences() {
    let step = 1e-5;
    let mut random = Random::new(2);
    for seed in 0..60 {
        let piece = random_piece(seed);
        // Also centers outside the piece.
        let center = (point(&mut random).coords * 2.0).add_scalar(-1.0) * 1.5;
        for order in [1, 2, 3, 8] {
            let Evaluation {
                value,
                gradient,
                hessian,
            } = evaluate(&piece, &center, order);
            let at = |axis: usize, sign: f64| {
                let mut shifted = center;
                shifted[axis] += sign * step;
                evaluate(&piece, &shifted, order)
            };
            for axis in 0..3 {
                let (up, down) = (at(axis, 1.0), at(axis, -1.0));
                let slope = (up.value - down.value) / (2.0 * step);
                let what = format!("seed {seed}, p = {order}, axis {axis}");
                assert_close(
                    gradient[axis] / (1.0 + value),
                    slope / (1.0 + value),
                    1e-6,
                    &what,
                );
                let quotient = (up.gradient - down.gradient) / (2.0 * step);
                for other in 0..3 {
                    let size = 1.0 + hessian.amax();
                    assert_close(
                        hessian[(axis, other)] / size,
                        quotient[other] / size,
                        1e-6,
                        &what,
                    );
                }
            }
        }
    }
}

#[test]
fn the_energy_is_never_below_that_of_the_cube_of_equal_volume() {
    for seed in 0..40 {
        let piece = random_piece(seed);
        let volume = piece.moments().mass;
        let least = 0.375 * volume.powf(4.0 / 3.0);
        assert!(evaluate(&piece, &Vector3::zeros(), 1).value >= least);
    }
}

#[test]
fn third_derivatives_agree_with_central_differences() {
    let step = 1e-5;
    let mut random = Random::new(5);
    for seed in 0..60 {
        let piece = random_piece(seed);
        let center = (point(&mut random).coords * 2.0).add_scalar(-1.0);
        let scratch = &mut EnergyScratch::default();
        let third = energy_jet(&whole(&piece), &center, 1, scratch).third;
        let third = third.expect("it is known for p = 1");
        for axis in 0..3 {
            let [up, down] = [step, -step].map(|step| {
                let shifted = center + Vector3::ith(axis, step);
                evaluate(&piece, &shifted, 1).hessian
            });
            let slope = (up - down) / (2.0 * step);
            let what = format!("seed {seed}, axis {axis}");
            assert_close((third[axis] - slope).amax(), 0.0, 1e-6, &what);
        }
    }
}

/// Diagonals lie in the plane of a facet, or leave along it: their triangles with the center have no volume.
#[test]
fn centers_in_the_plane_of_a_facet_that_holds_diagonals_have_the_energy_of_their_fragments() {
    let normals = [
        (1.0, -1.0, 0.0),
        (1.0, 1.0, 0.0),
        (0.0, 1.0, -1.0),
        (2.0, -1.0, -1.0),
    ];
    for (seed, (x, y, z)) in (0..40).flat_map(|seed| normals.map(|normal| (seed, normal))) {
        let mut random = Random::new(seed);
        let normal = Vector3::new(x, y, z);
        let mut piece = random_piece(seed);
        let away = (point(&mut random).coords * 2.0).add_scalar(-1.0) * 0.4;
        let center = if seed == 0 {
            Vector3::zeros()
        } else {
            away - normal * (normal.dot(&away) / normal.norm_squared())
        };
        let plane = HalfSpace {
            normal,
            offset: 0.0,
        };
        clip(&mut piece, &plane, 9, &mut ClipScratch::default());
        for order in [1, 2, 3] {
            let found = evaluate(&piece, &center, order);
            let expected = by_fragments(&piece, &Point3::from(center), order);
            let what = format!("seed {seed}, normal {normal:?}, p = {order}");
            assert_close(found.value, expected, 1e-12, &what);
            let parts = fragments(&piece, &Point3::from(center), 9);
            let volumes = parts.map(|part| part.moments().mass);
            let differences = [0, 2, 4].map(|plus| volumes[plus + 1] - volumes[plus]);
            if order == 1 {
                let error = found.gradient - Vector3::from(differences);
                assert_close(error.amax(), 0.0, 1e-12, &what);
            }
        }
    }
}

#[test]
fn fragments_partition_the_piece() {
    for seed in 0..40 {
        let piece = random_piece(seed);
        let center = Point3::new(0.1, -0.2, 0.05);
        let parts = fragments(&piece, &center, 9);
        let sum: f64 = parts.iter().map(|part| part.moments().mass).sum();
        assert_close(sum, piece.moments().mass, 1e-14, "volume");
    }
}

#[test]
fn energies_are_additive_over_a_cut_and_linear_in_signs() {
    let piece = random_piece(3);
    let plane = HalfSpace {
        normal: Vector3::new(0.3, -0.5, 0.7),
        offset: 0.05,
    };
    let behind = HalfSpace {
        normal: -plane.normal,
        offset: -plane.offset,
    };
    let mut scratch = ClipScratch::default();
    let mut parts = [piece.clone(), piece.clone()];
    clip(&mut parts[0], &plane, 9, &mut scratch);
    clip(&mut parts[1], &behind, 9, &mut scratch);
    for order in [1, 2, 4] {
        let center = Vector3::new(0.2, 0.1, -0.3);
        let all = evaluate(&piece, &center, order);
        let [front, back] = [0, 1].map(|k| evaluate(&parts[k], &center, order));
        assert_close(front.value + back.value, all.value, 1e-14, "value");
        assert_close(
            (front.gradient + back.gradient - all.gradient).amax(),
            0.0,
            1e-14,
            "gradient",
        );
        assert_close(
            (front.hessian + back.hessian - all.hessian).amax(),
            0.0,
            1e-13,
            "hessian",
        );
        let signed = parts.iter().chain([&piece]).zip([1.0, 1.0, -1.0]);
        let signed: Vec<_> = signed
            .map(|(p, sign)| SignedPiece {
                sign,
                piece: PreparedPiece::new(p),
            })
            .collect();
        let nothing = energy(&signed, &center, order, &mut EnergyScratch::default());
        assert_close(nothing.value, 0.0, 1e-14, "signed sum");
    }
}

#[test]
fn ties_at_lattice_cells_change_nothing() {
    // Every vertex of a cube cell about its site lies on a diagonal; noise decides its sector.
    for noise in [0.0, 1e-16, 1e-14, 1e-12, 1e-9] {
        let mut random = Random::new(4);
        let mut sites = Vec::new();
        for k in 0..64 {
            let cell = Vector3::new((k % 4) as f64, (k / 4 % 4) as f64, (k / 16) as f64);
            let jitter = (point(&mut random).coords).add_scalar(-0.5) * noise;
            sites.push(Point3::from((cell.add_scalar(0.5) + jitter) / 4.0));
        }
        let domain = Cuboid::unit();
        let diagram = Diagram::new(&domain, &sites).unwrap();
        let evaluations = diagram
            .map(|(): &mut (), cell| {
                let here = evaluate(cell.polyhedron(), &Vector3::zeros(), 1);
                let cubic = evaluate(cell.polyhedron(), &Vector3::zeros(), 3);
                (here, cubic, cell.polyhedron().moments().mass)
            })
            .unwrap();
        let tolerance = 1e-13 + 10.0 * noise;
        for (here, cubic, volume) in &evaluations {
            assert_close(volume * 64.0, 1.0, tolerance, "volume");
            assert_close(here.value * 256.0, 0.375, tolerance, "energy");
            assert_close(here.gradient.amax() * 64.0, 0.0, tolerance, "gradient");
            // Each axis meets eight interfaces of area √2 (s/2)²: Σ A/√2 = 2 s².
            let expected = Matrix3::identity() * 2.0;
            assert_close(
                (here.hessian * 16.0 - expected).amax(),
                0.0,
                tolerance,
                "Hessian",
            );
            // ∫ d³ = ∫₀^{s/2} t³ · 24 t² dt = s⁶/16.
            assert_close(cubic.value * 4096.0, 1.0 / 16.0, tolerance, "cubic energy");
        }
    }
}
