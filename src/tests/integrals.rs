//! Closed forms of integrals against printed tables, rational arithmetic, additivity.

use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::LinearDensity;
use crate::integrals::monomials::MonomialIntegrals;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::reference::polygon::{self, Face};
use crate::integrals::reference::{cattani_paoluzzi, mirtich, tetrahedron};
use crate::integrals::{mesh_moments, series};
use nalgebra::{Matrix3, Point2, Point3, Vector3};
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::HashMap;

const ORIGIN: Point3<f64> = Point3::new(0.0, 0.0, 0.0);

fn close(got: f64, expected: f64, relative: f64, what: &str) {
    let scale = expected.abs().max(f64::MIN_POSITIVE);
    assert!(
        (got - expected).abs() <= relative * scale,
        "{what}: {got} is not {expected}"
    );
}

/// The faces of the cube with vertex bits (x, y, z), counter-clockwise seen from outside.
const QUADS: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The four outward faces of a right-handed tetrahedron.
const TET_FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

fn cube(min: [f64; 3], side: f64) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let corner = |bits: u32| [0, 1, 2].map(|axis| min[axis] + side * f64::from(bits >> axis & 1));
    let vertices = (0..8).map(|bits| Point3::from(corner(bits))).collect();
    let halves = QUADS
        .iter()
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    (vertices, halves.collect())
}

fn faces<const K: usize>(polygons: &[[u32; K]]) -> Vec<Face> {
    polygons
        .iter()
        .map(|&polygon| Face::simple(polygon))
        .collect()
}

/// [M] section 9: midpoints of edges projected onto the unit sphere, from an icosahedron.
fn icosphere(refinements: usize) -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    let g = f64::midpoint(1.0, 5.0_f64.sqrt());
    let signs = [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)];
    let mut vertices: Vec<Point3<f64>> = signs
        .map(|(s, t)| Point3::new(s, t, 0.0))
        .into_iter()
        .chain(signs.map(|(s, t)| Point3::new(0.0, s, t)))
        .chain(signs.map(|(s, t)| Point3::new(t, 0.0, s)))
        .map(|vertex| Point3::from(vertex.coords.normalize()))
        .collect();
    #[rustfmt::skip]
    let mut triangles = vec![
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
        [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1_u32],
    ];
    for _ in 0..refinements {
        let mut middles = HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q): (u32, u32)| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let sum = vertices[p as usize].coords + vertices[q as usize].coords;
                    vertices.push(Point3::from(sum.normalize()));
                    u32::try_from(vertices.len() - 1).unwrap()
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (vertices, triangles)
}

/// Uniform in [0, 1), with 20 bits so that rational arithmetic stays short.
fn unit(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32() >> 12) / f64::from(1 << 20)
}

fn random_point(random: &mut ChaCha8Rng) -> Point3<f64> {
    Point3::from([(); 3].map(|()| unit(random) - 0.25))
}

fn random_exponents(random: &mut ChaCha8Rng) -> [u32; 3] {
    loop {
        let exponents = [(); 3].map(|()| random.next_u32() % 9);
        if exponents.iter().sum::<u32>() <= 8 {
            return exponents;
        }
    }
}

// ------------------------------------------------------------- rational second opinions

type Rational = BigRational;

fn exact_point(point: &Point3<f64>) -> [Rational; 3] {
    [0, 1, 2].map(|axis| Rational::from_float(point[axis]).unwrap())
}

fn whole(value: u32) -> Rational {
    Rational::from_integer(BigInt::from(value))
}

fn binomial(n: u32, k: u32) -> Rational {
    (0..k).fold(whole(1), |product, i| product * whole(n - i) / whole(i + 1))
}

fn power(base: &Rational, n: u32) -> Rational {
    (0..n).fold(whole(1), |product, _| product * base)
}

/// [CP] eq. 6, literally.
fn unit_triangle(alpha: u32, beta: u32) -> Rational {
    let sum = (0..=alpha + 1).fold(Rational::zero(), |sum, h| {
        let term = binomial(alpha + 1, h) / whole(h + beta + 1);
        if h % 2 == 0 { sum + term } else { sum - term }
    });
    sum / whole(alpha + 1)
}

/// The six-fold sum of [CP] eq. 10, literally, without the factor |a × b|.
fn structure_product([o, a, b]: &[[Rational; 3]; 3], exponents: [u32; 3]) -> Rational {
    // One axis: all (power of u, power of v, coefficient) of (o + u a + v b)^n.
    let axis_terms = |axis: usize| {
        let (a, b) = (&a[axis] - &o[axis], &b[axis] - &o[axis]);
        let n = exponents[axis];
        let mut terms = Vec::new();
        for h in 0..=n {
            for i in 0..=h {
                let outer = binomial(n, h) * power(&o[axis], n - h);
                let inner = binomial(h, i) * power(&a, h - i) * power(&b, i);
                terms.push((h - i, i, outer * inner));
            }
        }
        terms
    };
    let [x, y, z] = [0, 1, 2].map(axis_terms);
    let mut total = Rational::zero();
    for (xu, xv, cx) in &x {
        for (yu, yv, cy) in &y {
            for (zu, zv, cz) in &z {
                total += cx * cy * cz * unit_triangle(xu + yu + zu, xv + yv + zv);
            }
        }
    }
    total
}

/// [CP] eq. 14, literally.
fn rational_solid(vertices: &[Point3<f64>], triangles: &[[u32; 3]], e: [u32; 3]) -> Rational {
    let flux = triangles.iter().fold(Rational::zero(), |sum, triangle| {
        let corners = triangle.map(|vertex| exact_point(&vertices[vertex as usize]));
        let [o, a, b] = &corners;
        let normal_x = (&a[1] - &o[1]) * (&b[2] - &o[2]) - (&a[2] - &o[2]) * (&b[1] - &o[1]);
        sum + normal_x * structure_product(&corners, [e[0] + 1, e[1], e[2]])
    });
    flux / whole(e[0] + 1)
}

/// Rounding is judged relative to `scale`, an upper bound of the integral of the absolute value.
fn agrees(got: f64, exact: &Rational, scale: f64, what: &str) {
    let exact = exact.to_f64().unwrap();
    assert!(
        (got - exact).abs() <= 2e-14 * scale,
        "{what}: {got} is not {exact} (scale {scale})"
    );
}

#[test]
fn random_monomials_over_random_tetrahedra_have_their_rational_values() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for case in 0..20 {
        let mut corners = [(); 4].map(|()| random_point(&mut random));
        if tetrahedron::volume(&corners) < 0.0 {
            corners.swap(0, 1);
        }
        let e = random_exponents(&mut random);
        let exact = rational_solid(&corners, &TET_FACES, e);
        let what = format!("case {case} {e:?}");
        agrees(
            cattani_paoluzzi::tetrahedron(&corners, e),
            &exact,
            1.0,
            &what,
        );
        agrees(
            cattani_paoluzzi::solid(&corners, &TET_FACES, e),
            &exact,
            1.0,
            &what,
        );
        let density = Polynomial::monomial(1.0, e);
        for origin in [ORIGIN, random_point(&mut random)] {
            let body = mesh_moments::polynomial(&corners, &TET_FACES, &density, &origin);
            agrees(body.mass, &exact, 1.0, &what);
            let body = mesh_moments::polynomial(&corners, &[[0, 1, 2, 3]], &density, &origin);
            agrees(body.mass, &exact, 1.0, &what);
        }
    }
}

#[test]
fn random_monomials_over_random_polyhedra_have_their_rational_values() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let (sphere, triangles) = icosphere(0);
    for case in 0..5 {
        // A star-shaped, non-convex polyhedron: every vertex at its own radius.
        let center = random_point(&mut random);
        let mut spike = |v: &Point3<f64>| center + v.coords * (0.2 + unit(&mut random));
        let vertices: Vec<_> = sphere.iter().map(&mut spike).collect();
        let e = random_exponents(&mut random);
        let exact = rational_solid(&vertices, &triangles, e);
        let what = format!("case {case} {e:?}");
        let largest = vertices.iter().map(|v| v.coords.amax()).fold(1.0, f64::max);
        let scale = largest.powi(3 + i32::try_from(series::degree(e)).unwrap());
        agrees(
            cattani_paoluzzi::solid(&vertices, &triangles, e),
            &exact,
            scale,
            &what,
        );
        let polygons = faces(&triangles);
        agrees(
            polygon::solid(&vertices, &polygons, e),
            &exact,
            scale,
            &what,
        );
        let density = Polynomial::monomial(1.0, e);
        let body = mesh_moments::polynomial(&vertices, &triangles, &density, &ORIGIN);
        agrees(body.mass, &exact, scale, &what);
    }
}

#[test]
fn a_triangle_in_space_has_the_structure_product_of_equation_10() {
    let mut random = ChaCha8Rng::seed_from_u64(10);
    for _ in 0..20 {
        let corners = [(); 3].map(|()| random_point(&mut random));
        let e = random_exponents(&mut random);
        let exact = structure_product(&corners.each_ref().map(exact_point), e);
        let [o, a, b] = corners;
        let jacobian = (a - o).cross(&(b - o)).norm();
        let got = cattani_paoluzzi::triangle(&corners, e) / jacobian;
        agrees(got, &exact, 1.0, &format!("{e:?}"));
    }
}

#[test]
fn the_unit_triangle_has_the_values_of_equation_6() {
    for alpha in 0..=12 {
        for beta in 0..=12 {
            let exact = unit_triangle(alpha, beta).to_f64().unwrap();
            close(
                cattani_paoluzzi::unit_triangle(alpha, beta),
                exact,
                1e-15,
                "II",
            );
        }
    }
}

/// ∫ t^n over [a, b].
fn span([a, b]: &[Rational; 2], n: u32) -> Rational {
    (power(b, n + 1) - power(a, n + 1)) / whole(n + 1)
}

/// x^e over a box and over its six faces, exactly.
fn box_integrals(min: [f64; 3], max: [f64; 3], e: [u32; 3]) -> [Rational; 2] {
    let exact = |x: f64| Rational::from_float(x).unwrap();
    let along = [0, 1, 2].map(|axis| [exact(min[axis]), exact(max[axis])]);
    let spans = [0, 1, 2].map(|axis| span(&along[axis], e[axis]));
    let volume = &spans[0] * &spans[1] * &spans[2];
    let surface = (0..3).fold(Rational::zero(), |sum, axis| {
        let ends = power(&along[axis][0], e[axis]) + power(&along[axis][1], e[axis]);
        sum + ends * &spans[(axis + 1) % 3] * &spans[(axis + 2) % 3]
    });
    [volume, surface]
}

#[test]
fn every_monomial_to_degree_nine_over_a_box_and_its_surface_is_rational() {
    for (min, max) in [
        ([0.0; 3], [1.0, 0.75, 0.625]),
        ([-0.3, 0.1, -1.7], [0.9, 1.1, 0.4]),
        ([-1.0, -2.0, -0.5], [1.0, 2.0, 0.5]),
        ([1e6, -2e6, 3e6], [1e6 + 1.0, -2e6 + 0.75, 3e6 + 0.5]),
    ] {
        let corner = |bits: usize| {
            [0, 1, 2].map(|axis| {
                if bits >> axis & 1 == 0 {
                    min[axis]
                } else {
                    max[axis]
                }
            })
        };
        let vertices: Vec<_> = (0..8).map(|bits| Point3::from(corner(bits))).collect();
        let (_, triangles) = cube([0.0; 3], 1.0);
        let surface = MonomialIntegrals::over_surface(&vertices, &triangles, 9, None);
        let volume = MonomialIntegrals::over_solid(&vertices, &triangles, 9);
        assert_eq!(surface.exponents().len(), 220);
        let size = [0, 1, 2].map(|axis| max[axis] - min[axis]);
        let [body, wall] = [
            size[0] * size[1] * size[2],
            2.0 * size[0] * size[1] + 2.0 * size[2] * (size[0] + size[1]),
        ];
        for &e in surface.exponents() {
            let [exact_volume, exact_surface] = box_integrals(min, max, e);
            let bound = (0..3).fold(1.0, |bound, axis| {
                let reach: f64 = max[axis].abs().max(min[axis].abs());
                bound * reach.powi(e[axis] as i32)
            });
            let what = format!("{e:?} over {min:?}");
            agrees(volume.of(e), &exact_volume, 0.1 * body * bound, &what);
            agrees(surface.of(e), &exact_surface, 0.1 * wall * bound, &what);
        }
    }
}

#[test]
fn monomials_of_degree_nine_over_random_polyhedra_have_their_rational_values() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let (sphere, triangles) = icosphere(0);
    let mut spike = |v: &Point3<f64>| Point3::from(v.coords * (0.3 + unit(&mut random)));
    let vertices: Vec<_> = sphere.iter().map(&mut spike).collect();
    let solid = MonomialIntegrals::over_solid(&vertices, &triangles, 9);
    let one = triangles[0];
    let facet = MonomialIntegrals::over_surface(&vertices, &[one], 9, None);
    let corners = one.map(|vertex| vertices[vertex as usize]);
    let exact_corners = corners.each_ref().map(exact_point);
    let jacobian = (corners[1] - corners[0])
        .cross(&(corners[2] - corners[0]))
        .norm();
    let e = [3; 3];
    let exact = rational_solid(&vertices, &triangles, e);
    agrees(solid.of(e), &exact, 1.0, &format!("solid {e:?}"));
    let exact = structure_product(&exact_corners, e);
    agrees(facet.of(e) / jacobian, &exact, 1.0, &format!("facet {e:?}"));
    let tet = MonomialIntegrals::over_solid(&vertices[..4], &[[0, 1, 2, 3]], 5);
    let volume = tetrahedron::volume(&[0, 1, 2, 3].map(|k| vertices[k]));
    close(tet.of([0; 3]), volume, 1e-14, "a tetrahedron");
    let product: Polynomial = "(x - 1)^2*(y + 2*z)^3".parse().unwrap();
    let apart: f64 = product.terms().map(|(e, value)| value * tet.of(e)).sum();
    close(
        tet.of_polynomial(&product),
        apart,
        1e-12,
        "a polynomial by its terms",
    );
}

// ------------------------------------------------------------- printed tables

#[test]
fn mirtich_table_1_holds_to_15_digits() {
    let (vertices, triangles) = cube([-10.0; 3], 20.0);
    let fifth = 20.0_f64.powi(5) / 12.0;
    let expected = [8000.0, 0.0, 0.0, 0.0, fifth, fifth, fifth, 0.0, 0.0, 0.0];
    let walked = mirtich::ten_integrals(&vertices, &faces(&QUADS), &ORIGIN).ten();
    let coned = mesh_moments::constant(&vertices, &triangles, &ORIGIN).ten();
    for ((walked, coned), expected) in walked.into_iter().zip(coned).zip(expected) {
        close(walked, expected, 1e-15, "Table 1, cube");
        close(coned, expected, 1e-15, "Table 1, cube");
    }
    let corners = [[0.0; 3], [5.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]].map(Point3::from);
    let expected = [10.0, 12.5, 10.0, 7.5, 25.0, 16.0, 9.0, 10.0, 6.0, 7.5];
    let walked = mirtich::ten_integrals(&corners, &faces(&TET_FACES), &ORIGIN).ten();
    let coned = mesh_moments::constant(&corners, &TET_FACES, &ORIGIN).ten();
    for ((walked, coned), expected) in walked.into_iter().zip(coned).zip(expected) {
        close(walked, expected, 1e-15, "Table 1, tetrahedron");
        close(coned, expected, 1e-15, "Table 1, tetrahedron");
    }
}

#[test]
fn mirtich_table_2_holds_to_all_printed_digits() {
    let table = [
        (12, "2.536", "0.3670"),
        (42, "3.659", "0.6692"),
        (162, "4.047", "0.7911"),
        (642, "4.153", "0.8258"),
        (2562, "4.180", "0.8347"),
        (10242, "4.187", "0.8370"),
    ];
    for (refinements, (count, volume, second)) in table.into_iter().enumerate() {
        let (vertices, triangles) = icosphere(refinements);
        assert_eq!(vertices.len(), count);
        let walked = mirtich::ten_integrals(&vertices, &faces(&triangles), &ORIGIN);
        let coned = mesh_moments::constant(&vertices, &triangles, &ORIGIN);
        for moments in [walked, coned] {
            assert_eq!(format!("{:.3}", moments.mass), volume);
            assert_eq!(format!("{:.4}", moments.second.m11), second);
            let (x, yz) = (moments.first.x, moments.second.m23);
            assert!(x.abs() < 1e-15 && yz.abs() < 1e-15, "{x} {yz}");
        }
    }
}

#[test]
fn the_examples_of_cattani_and_paoluzzi_hold() {
    let simplex = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
    let area = cattani_paoluzzi::surface(&simplex[..3], &[[0, 1, 2]], [0; 3]);
    close(area, 0.5, 1e-15, "test 01, standard triangle");
    let faces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let volume = cattani_paoluzzi::solid(&simplex, &faces, [0; 3]);
    close(volume, 1.0 / 6.0, 1e-15, "test 02, standard tetrahedron");
    let (vertices, triangles) = cube([0.0; 3], 1.0);
    let inside_out: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    for (exponents, expected) in [
        ([0, 0, 0], 1.0),
        ([1, 0, 0], 0.5),
        ([0, 0, 2], 1.0 / 3.0),
        ([1, 1, 0], 0.25),
        ([3, 2, 1], 1.0 / 24.0),
    ] {
        let got = cattani_paoluzzi::solid(&vertices, &triangles, exponents);
        close(got, expected, 1e-15, "test 03, unit cube");
        let got = cattani_paoluzzi::solid(&vertices, &inside_out, exponents);
        close(got, -expected, 1e-15, "unit cube inside out");
    }
    close(
        cattani_paoluzzi::surface(&vertices, &triangles, [0; 3]),
        6.0,
        1e-15,
        "its surface",
    );
    close(
        mesh_moments::area(&vertices, &triangles),
        6.0,
        1e-15,
        "its surface",
    );
}

#[test]
fn the_non_convex_polygon_of_test_04_is_integrated_with_signs() {
    let x = [10.0, 10.0, 20.0, 40.0, 30.0, 30.0, 15.0, 15.0];
    let y = [10.0, 20.0, 30.0, 20.0, 10.0, 15.0, 15.0, 10.0];
    // By trapezoids under its edges: 0 + 250 + 500 − 150 + 0 − 225 + 0 − 50 = 325, clockwise.
    let area = -325.0;
    let points: Vec<_> = x
        .into_iter()
        .zip(y)
        .map(|(x, y)| Point2::new(x, y))
        .collect();
    close(
        cattani_paoluzzi::polygon(&points, 0, 0),
        area,
        1e-15,
        "eq. 4",
    );
    let vertices: Vec<_> = points.iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
    let fan: Vec<_> = (1..7).map(|i| [0, i, i + 1]).collect();
    let up = Vector3::new(0.0, 0.0, 3.0);
    let signed = |e| cattani_paoluzzi::planar_surface(&vertices, &fan, &up, e);
    close(signed([0; 3]), area, 1e-15, "signed fan");
    assert!(cattani_paoluzzi::surface(&vertices, &fan, [0; 3]) > area.abs() + 1.0);
    close(
        signed([3, 2, 0]),
        cattani_paoluzzi::polygon(&points, 3, 2),
        1e-13,
        "products",
    );
    let backwards: Vec<_> = fan.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let positive = cattani_paoluzzi::planar_surface(&vertices, &backwards, &up, [0; 3]);
    close(positive, -area, 1e-15, "test 05, reversed");
}

// ------------------------------------------------------------- faces with holes

fn ring(low: f64, high: f64, lift: impl Fn(f64, f64) -> f64) -> [Point3<f64>; 4] {
    [[low, low], [high, low], [high, high], [low, high]].map(|[x, y]| Point3::new(x, y, lift(x, y)))
}

#[test]
fn a_square_plate_with_a_square_hole_is_a_difference() {
    let lift = |x, y| 0.5 * x - 0.25 * y + 1.0;
    let vertices = [ring(0.0, 4.0, lift), ring(1.0, 2.0, lift)].concat();
    let plate = Face {
        loops: vec![vec![0, 1, 2, 3], vec![4, 7, 6, 5]],
    };
    let (outer, hole) = (Face::simple([0, 1, 2, 3]), Face::simple([4, 5, 6, 7]));
    for e in [[0, 0, 0], [1, 0, 0], [2, 1, 0], [0, 1, 3]] {
        let difference = polygon::face(&vertices, &outer, e) - polygon::face(&vertices, &hole, e);
        close(
            polygon::face(&vertices, &plate, e),
            difference,
            1e-14,
            "plate",
        );
    }
    let stretch = (1.0_f64 + 0.25 + 0.0625).sqrt();
    let got = polygon::face(&vertices, &plate, [0; 3]);
    close(got, 15.0 * stretch, 1e-15, "area");
    // ∫x = 4·8 − 1·1.5
    let got = polygon::face(&vertices, &plate, [1, 0, 0]);
    close(got, 30.5 * stretch, 1e-15, "first moment");
}

/// [0,4]² × [0,2] without [1,2]² × [0,2].
fn block_with_tunnel() -> (Vec<Point3<f64>>, Vec<Face>) {
    let level = |low, high, z: f64| ring(low, high, move |_, _| z);
    let vertices = [
        level(0.0, 4.0, 0.0),
        level(0.0, 4.0, 2.0),
        level(1.0, 2.0, 0.0),
        level(1.0, 2.0, 2.0),
    ]
    .concat();
    let mut faces = vec![
        Face {
            loops: vec![vec![3, 2, 1, 0], vec![8, 9, 10, 11]],
        },
        Face {
            loops: vec![vec![4, 5, 6, 7], vec![15, 14, 13, 12]],
        },
    ];
    for i in 0..4 {
        let j = (i + 1) % 4;
        faces.push(Face::simple([i, j, j + 4, i + 4]));
        faces.push(Face::simple([8 + j, 8 + i, 12 + i, 12 + j]));
    }
    (vertices, faces)
}

#[test]
fn a_block_with_a_tunnel_is_integrated_from_faces_with_holes() {
    let (vertices, faces) = block_with_tunnel();
    let along = |low: f64, high: f64, n: u32| {
        let raised = i32::try_from(n + 1).unwrap();
        (high.powi(raised) - low.powi(raised)) / f64::from(n + 1)
    };
    let prism = |low, high, e: [u32; 3]| {
        along(low, high, e[0]) * along(low, high, e[1]) * along(0.0, 2.0, e[2])
    };
    let exact = |e| prism(0.0, 4.0, e) - prism(1.0, 2.0, e);
    for e in [[0, 0, 0], [1, 0, 0], [0, 2, 1], [4, 3, 1]] {
        close(
            polygon::solid(&vertices, &faces, e),
            exact(e),
            1e-14,
            "solid",
        );
    }
    #[rustfmt::skip]
    let powers = [
        [0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0],
        [0, 2, 0], [0, 0, 2], [1, 1, 0], [0, 1, 1], [1, 0, 1],
    ];
    for origin in [ORIGIN, Point3::new(3.0, -1.0, 0.5)] {
        let moments = mirtich::ten_integrals(&vertices, &faces, &origin);
        let ten = moments.translated(&origin.coords).ten();
        for (got, e) in ten.into_iter().zip(powers) {
            close(got, exact(e), 1e-14, "Mirtich with holes");
        }
    }
}

#[test]
fn every_projection_axis_gives_the_same_ten_integrals() {
    // Tilting the block by thirds of turns about (1, 1, 1) permutes the axes exactly.
    let (vertices, faces) = block_with_tunnel();
    let moments = mirtich::ten_integrals(&vertices, &faces, &ORIGIN);
    let turned: Vec<_> = vertices
        .iter()
        .map(|v| Point3::new(v.z, v.x, v.y))
        .collect();
    let image = mirtich::ten_integrals(&turned, &faces, &ORIGIN);
    close(image.mass, moments.mass, 1e-15, "volume");
    close(image.second.m12, moments.second.m13, 1e-15, "xy");
    close(image.second.m11, moments.second.m33, 1e-15, "xx");
    // A tilted face projects along its largest normal component; cones need no projection.
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (sphere, triangles) = icosphere(1);
    let spiky: Vec<_> = sphere
        .iter()
        .map(|v| v * (0.5 + unit(&mut random)))
        .collect();
    let walked = mirtich::ten_integrals(&spiky, &self::faces(&triangles), &ORIGIN);
    same(
        &walked,
        &mesh_moments::constant(&spiky, &triangles, &ORIGIN),
        1e-14,
    );
}

// ------------------------------------------------------------- densities

fn same(a: &Moments, b: &Moments, relative: f64) {
    let (a, b) = (a.ten(), b.ten());
    let scale = b
        .iter()
        .fold(0.0_f64, |scale, value| scale.max(value.abs()));
    for (a, b) in a.into_iter().zip(b) {
        assert!((a - b).abs() <= relative * scale, "{a} is not {b}");
    }
}

/// [BL] Fig. 17: A … H, the quad AEHD at x₀ and BFGC at x₀ + h, cross-section 1; its five
/// tetrahedra right-handed.
fn appendix_c(x0: f64, h: f64) -> ([Point3<f64>; 8], [[u32; 4]; 5]) {
    let corner = |x: f64, y: f64, z: f64| Point3::new(x, y - 0.5, z - 0.5);
    let (near, far) = (x0, x0 + h);
    let vertices = [
        corner(near, 0.0, 0.0),
        corner(far, 0.0, 0.0),
        corner(far, 1.0, 0.0),
        corner(near, 1.0, 0.0),
        corner(near, 0.0, 1.0),
        corner(far, 0.0, 1.0),
        corner(far, 1.0, 1.0),
        corner(near, 1.0, 1.0),
    ];
    let mut tets = [
        [0, 1, 3, 4],
        [3, 4, 6, 7],
        [1, 4, 5, 6],
        [1, 2, 3, 6],
        [1, 3, 4, 6],
    ];
    for tet in &mut tets {
        if tetrahedron::volume(&tet.map(|v| vertices[v as usize])) < 0.0 {
            tet.swap(0, 1);
        }
    }
    (vertices, tets)
}

#[test]
fn the_box_of_appendix_c_weighs_what_its_five_tetrahedra_weigh() {
    let (x0, h, s, t) = (0.75, 2.5, 0.3, 0.2);
    let (vertices, tets) = appendix_c(x0, h);
    let densities = vertices.map(|v| s * v.x + t);
    let d0 = s * x0 + t;
    let mass = h / 2.0 * (h * s + 2.0 * d0);
    // w is the vector (h, 0, 0): eq. 14's fraction of the box's length.
    let x = x0 + h * (2.0 * h * s + 3.0 * d0) / (3.0 * h * s + 6.0 * d0);
    let (mut total, mut center) = (0.0, Vector3::zeros());
    for (tet, sixths) in tets.iter().zip([1.0, 1.0, 1.0, 1.0, 2.0]) {
        let corners = tet.map(|v| vertices[v as usize]);
        let values = tet.map(|v| densities[v as usize]);
        close(
            tetrahedron::volume(&corners),
            sixths * h / 6.0,
            1e-15,
            "volume",
        );
        let weight = tetrahedron::mass(&corners, &values);
        total += weight;
        center += tetrahedron::mass_center(&corners, &values).coords * weight;
    }
    close(total, mass, 1e-15, "mass, eq. 13 and 16");
    close(center.x / total, x, 1e-15, "center, eq. 14 and 18");
    assert!((center.y / total).abs() < 1e-15 && (center.z / total).abs() < 1e-15);
    let moments = mesh_moments::at_vertices(&vertices, &tets, &densities, &ORIGIN);
    close(moments.mass, mass, 1e-15, "mass");
    close(moments.center().x, x, 1e-15, "center");
    let primitive = |x: f64| s * x.powi(4) / 4.0 + t * x.powi(3) / 3.0;
    let expected = primitive(x0 + h) - primitive(x0);
    close(moments.second.m11, expected, 1e-14, "∫ρx²");
    close(moments.second.m22, mass / 12.0, 1e-14, "∫ρy²");
    let one_by_one = tets.iter().fold(Matrix3::zeros(), |sum, tet| {
        let corners = tet.map(|v| vertices[v as usize]);
        let densities = tet.map(|v| densities[v as usize]);
        sum + mesh_moments::at_vertices(&corners, &[[0, 1, 2, 3]], &densities, &ORIGIN).inertia()
    });
    assert!((moments.inertia() - one_by_one).amax() < 1e-14);
}

#[test]
fn constant_linear_and_polynomial_densities_agree_where_they_meet() {
    let (vertices, triangles) = icosphere(2);
    let origin = Point3::new(0.3, -0.2, 0.1);
    let constant = mesh_moments::constant(&vertices, &triangles, &origin) * 2.5;
    let flat = LinearDensity {
        value: 2.5,
        gradient: Vector3::zeros(),
    };
    same(
        &mesh_moments::linear(&vertices, &triangles, &flat, &origin),
        &constant,
        1e-14,
    );
    let gradient = Vector3::new(0.5, -1.0, 0.25);
    let density = LinearDensity {
        value: 2.5,
        gradient,
    };
    let polynomial = Polynomial::linear(2.5 - gradient.dot(&origin.coords), &gradient);
    let linear = mesh_moments::linear(&vertices, &triangles, &density, &origin);
    let general = mesh_moments::polynomial(&vertices, &triangles, &polynomial, &origin);
    same(&linear, &general, 1e-14);
    // The cones as tetrahedra of linear density.
    let apex = u32::try_from(vertices.len()).unwrap();
    let cones: Vec<_> = triangles.iter().map(|&[a, b, c]| [apex, a, b, c]).collect();
    let with_apex = [vertices, vec![origin]].concat();
    let values: Vec<_> = with_apex.iter().map(|v| polynomial.at(v)).collect();
    same(
        &mesh_moments::at_vertices(&with_apex, &cones, &values, &origin),
        &linear,
        1e-14,
    );
    same(
        &(mesh_moments::constant(&with_apex, &cones, &origin) * 2.5),
        &constant,
        1e-14,
    );
}

#[test]
fn moving_the_origin_is_moving_the_body() {
    let (vertices, triangles) = icosphere(1);
    let offset = Vector3::new(0.5, 1.0, -0.75);
    let moved: Vec<_> = vertices.iter().map(|v| v + offset).collect();
    let image = mesh_moments::constant(&vertices, &triangles, &ORIGIN).translated(&offset);
    same(
        &image,
        &mesh_moments::constant(&moved, &triangles, &ORIGIN),
        1e-14,
    );
    let from = Point3::from(-offset);
    same(
        &image,
        &mesh_moments::constant(&vertices, &triangles, &from),
        1e-14,
    );
}

#[test]
fn an_affine_map_scales_the_volume_by_its_determinant() {
    let (vertices, triangles) = icosphere(1);
    let map = Matrix3::new(1.0, 0.5, 0.0, -0.25, 2.0, 0.125, 0.0, 1.0, 1.5);
    let mapped: Vec<_> = vertices.iter().map(|v| map * v).collect();
    let moments = mesh_moments::constant(&vertices, &triangles, &ORIGIN);
    let image = mesh_moments::constant(&mapped, &triangles, &ORIGIN);
    close(
        image.mass,
        moments.mass * map.determinant(),
        1e-14,
        "volume",
    );
    let second = map * moments.second * map.transpose() * map.determinant();
    assert!((image.second - second).amax() < 1e-13);
}

#[test]
fn one_thread_or_many_give_the_same_bits() {
    let (vertices, triangles) = icosphere(5);
    let density = LinearDensity {
        value: 1.0,
        gradient: Vector3::new(0.1, 0.2, 0.3),
    };
    let run = || mesh_moments::linear(&vertices, &triangles, &density, &ORIGIN).ten();
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(run).map(f64::to_bits)
    });
    assert_eq!(one, three);
}

// ------------------------------------------------------------- polynomials as text

#[test]
fn polynomials_read_what_they_say() {
    let (x, y, z) = (1.5_f64, -2.0_f64, 3.0_f64);
    let point = Point3::new(x, y, z);
    for (text, value) in [
        ("1 + 2*x - 0.5*y*z", 1.0 + 2.0 * x - 0.5 * y * z),
        ("x^2", x * x),
        ("-x^2 + y^0", -x * x + 1.0),
        ("(x + y)^3*(1 - z)/4", (x + y).powi(3) * (1.0 - z) / 4.0),
        ("1e-3*X*Z + .5", 1e-3 * x * z + 0.5),
        ("2", 2.0),
        (" + 7.25 ", 7.25),
    ] {
        let polynomial: Polynomial = text.parse().unwrap();
        close(polynomial.at(&point), value, 1e-14, text);
        let origin = Point3::new(0.25, 0.5, -1.0);
        let shifted = polynomial.relative_to(&origin);
        close(
            shifted.at(&Point3::from(point - origin)),
            value,
            1e-13,
            text,
        );
    }
}

#[test]
fn what_is_no_polynomial_is_refused_with_its_column() {
    let atom = "expected a number, `x`, `y`, `z` or `(`";
    for (text, message) in [
        ("", format!("column 1: {atom}, found the end")),
        (
            "1 + w",
            format!(
                "column 5: {atom} (a polynomial has no functions), found `w`, which is not known"
            ),
        ),
        (
            "2 x",
            "column 3: expected an operator or the end, found `x`".into(),
        ),
        (
            "x^-1",
            "column 3: expected a whole number after `^`, found `-`".into(),
        ),
        (
            "x^99",
            "column 3: degree 99 is above 16, the highest supported".into(),
        ),
        (
            "x^9*y^9",
            "column 5: degree 18 is above 16, the highest supported".into(),
        ),
        (
            "(1 + x",
            "column 7: expected an operator or `)`, found the end".into(),
        ),
        ("1/0", "column 3: division by zero".into()),
        ("1/x", "column 3: expected a number, found `x`".into()),
        ("1.2.3", "column 1: `1.2.3` is not a finite number".into()),
        ("1e999", "column 1: `1e999` is not a finite number".into()),
        (
            "1e300*1e300",
            "a coefficient is too large for a 64-bit float".into(),
        ),
        (
            &"(".repeat(10_000),
            "column 33: parentheses nest deeper than 32".into(),
        ),
    ] {
        let error = text.parse::<Polynomial>().unwrap_err();
        assert_eq!(error.to_string(), message, "{text:.20}");
    }
}

#[test]
fn differences_keep_all_digits_a_million_units_away() {
    for offset in [1e2_f64, 1e3, 1e6] {
        let middle = Point3::new(offset + 0.5, offset + 0.5, offset + 0.5);
        let text =
            format!("(x - {offset})^8*3 + (x - {offset})^4*(y - {offset})^3*(z-{offset}) + 1");
        let polynomial: Polynomial = text.parse().unwrap();
        let near = polynomial.relative_to(&middle);
        // On sixteenths all is exact in f64.
        for shares in [[1.0, 3.0, 16.0], [5.0, 8.0, 2.0], [16.0, 16.0, 16.0]] {
            let [x, y, z] = shares.map(|share: f64| share / 16.0);
            let exact = x.powi(8) * 3.0 + x.powi(4) * y.powi(3) * z + 1.0;
            let here = Point3::new(offset + x, offset + y, offset + z);
            close(polynomial.at(&here), exact, 1e-15 * exact, &text);
            let relative = Point3::from(here - middle);
            close(near.at(&relative), exact, 1e-14 * exact, &text);
        }
    }
}

#[test]
fn thirty_digits_may_cancel_where_a_text_is_multiplied_out() {
    for (text, x, value) in [
        ("x^2 - 2000000*x + 1000000000000", 1e6 + 0.25, 0.0625),
        ("x/3 - 333333", 1e6, 1.0 / 3.0),
        ("-(x - 1e6)*(x - 1000001)", 1e6 + 0.25, 0.1875),
    ] {
        let polynomial: Polynomial = text.parse().unwrap();
        let place = Point3::new(x, 0.0, 0.0);
        close(polynomial.at(&place), value, 1e-15, text);
        let sum = polynomial.clone() + Polynomial::constant(1.0);
        close(sum.at(&place), value + 1.0, 1e-15, text);
        let square = -(polynomial.clone() * polynomial);
        let near = square.relative_to(&place);
        close(near.at(&Point3::origin()), -value * value, 1e-15, text);
    }
}
