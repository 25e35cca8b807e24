//! Fields: radial densities and formulas against closed forms and brute force, field files, and fields as
//! the background density of cells.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use crate::balance::bases::eighths;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::geometry::bounds::Bounds;
use crate::integrals::adaptive::{Goal, Signs, integrate};
use crate::integrals::cone_rule::{ConePiece, ConeRules};
use crate::mass::body::Body;
use crate::mass::numeric::BodyErrors;
use crate::mesh::formats::read::load;
use crate::mesh::shapes::{cuboid, trefoil, unit_cube, unit_cube_tets};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, validate_surface, validate_tets};
use crate::scene::background::by_field;
use crate::scene::field::{Field, FieldError, GivenField, Weighed};
use crate::tests::models::shared_model;
use crate::tests::quadrature::gauss;

fn solid(mesh: &SurfaceMesh) -> Solid {
    let (valid, report) = validate_surface(mesh).expect("it is closed");
    Solid::Surface(valid, report)
}

fn tets(n: u32) -> Solid {
    let (valid, report) = validate_tets(&unit_cube_tets(n)).expect("they are sound");
    Solid::Tets(valid, report)
}

fn field(text: &str) -> Field {
    Field::of_text(text).expect(text)
}

fn extent(solid: &Solid) -> Bounds<3> {
    crate::mass::weigh::bounds(solid)
}

fn weighed(solid: &Solid, text: &str) -> Weighed {
    let extent = extent(solid);
    field(text)
        .weigh(solid, &extent, None)
        .expect("it has a mass")
}

fn errors(solid: &Solid, part: Weighed) -> BodyErrors {
    let diagonal = extent(solid).extent().norm();
    Weighed::errors_of(&[part], &part.body, diagonal).expect("it has an estimate")
}

/// How far two bodies are apart: mass, center, inertia.
fn apart(one: &Body, other: &Body) -> [f64; 3] {
    [
        (one.mass - other.mass).abs(),
        (one.center_of_mass() - other.center_of_mass()).norm(),
        (one.inertia_center() - other.inertia_center()).amax(),
    ]
}

/// The true errors are at most those that are told.
fn assert_told(solid: &Solid, got: Weighed, exact: &Body, what: &str) {
    let told = errors(solid, got);
    let rounding = 1e-14;
    let found = apart(&got.body, exact);
    for (error, bound) in found
        .into_iter()
        .zip([told.mass, told.center, told.inertia])
    {
        assert!(
            error <= bound + rounding,
            "{what}: {found:?} beyond {told:?}"
        );
    }
}

/// ∫ over the unit cube by Gauss points in the tetrahedra of a fine grid.
fn over_cube(n: u32, integrand: impl Fn(&Point3<f64>) -> f64) -> f64 {
    let mesh = unit_cube_tets(n);
    mesh.all_corners()
        .map(|corners| gauss(&corners, &integrand))
        .sum()
}

#[test]
fn a_sine_over_a_cube_is_that_of_quadrature() {
    let text = "sine:point=-1.4,0.3,0.4,k=2";
    let p = Point3::new(-1.4, 0.3, 0.4);
    let density = |y: &Point3<f64>| (2.0 * (y - p).norm()).sin() + 1.0;
    let mass = over_cube(4, density);
    let first = [0, 1, 2].map(|axis| over_cube(4, |y| density(y) * y[axis]));
    let center = Point3::from(Vector3::from(first) / mass);
    let xy = over_cube(4, |y| density(y) * (y.x - center.x) * (y.y - center.y));
    for solid in [solid(&unit_cube()), tets(2)] {
        let body = weighed(&solid, text).body;
        assert!((body.mass - mass).abs() < 1e-12, "{} {mass}", body.mass);
        assert!((body.center_of_mass() - center).norm() < 1e-12);
        assert!((body.inertia_center()[(0, 1)] + xy).abs() < 1e-12);
        assert!(errors(&solid, weighed(&solid, text)).relative < 1e-12);
    }
}

#[test]
fn radial_densities_add_up_over_parts_and_have_their_values_in_spheres() {
    // A ball's shell: linear from 1 at the middle to 3 at 0.5, in a cube that holds it all but its corners.
    let text = "radial:point=0.4,0.5,0.6,0.1=1,0.3=5,0.31=2";
    let whole = weighed(&solid(&unit_cube()), text).body;
    let half = |min: f64, max: f64| {
        let bounds = Bounds::from_corners([min, 0.0, 0.0], [max, 1.0, 1.0]);
        weighed(&solid(&cuboid(&bounds)), text).body
    };
    let sum = Body::combined(&[half(0.0, 0.45), half(0.45, 1.0)]).expect("there is mass");
    let found = apart(&whole, &sum);
    assert!(found.into_iter().all(|error| error < 1e-11), "{found:?}");
    // 2 everywhere but for the shells, whose masses are 4π ∫ (f − 2) ρ².
    let shell = |from: f64, to: f64, low: f64, high: f64| {
        let slope = (high - low) / (to - from);
        let primitive =
            |rho: f64| (low - 2.0 - slope * from) * rho.powi(3) / 3.0 + slope * rho.powi(4) / 4.0;
        4.0 * std::f64::consts::PI * (primitive(to) - primitive(from))
    };
    let core = 4.0 / 3.0 * std::f64::consts::PI * 0.001 * (1.0 - 2.0);
    let exact = 2.0 + core + shell(0.1, 0.3, 1.0, 5.0) + shell(0.3, 0.31, 5.0, 2.0);
    assert!((whole.mass - exact).abs() < 1e-11, "{} {exact}", whole.mass);
}

#[test]
fn formulas_err_by_no_more_than_they_tell() {
    let knot = solid(&trefoil(0.4, 32, 6));
    let cube = solid(&unit_cube());
    for (solid, formula, exact, tolerance) in [
        (
            &knot,
            "sin(hypot(hypot(x-4, y), z-1))+1",
            "sine:point=4,0,1,k=1",
            1e-6,
        ),
        (
            &knot,
            "1 + 0.1*x^2 + 0.1*pow(y, 4)",
            "1 + 0.1*x^2 + 0.1*y^4",
            1e-6,
        ),
        (
            &cube,
            "abs(x - 0.3) + 1",
            "profile:axis=x,0=1.3,0.3=1,1=1.7",
            1e-4,
        ),
        (
            &cube,
            "min(4, max(1, 8*x + 3*y - 2))",
            "clamp(1, 4, 8*x + 3*y - 2)",
            1e-3,
        ),
        (
            &cube,
            "step(x - 0.3) + 1",
            "profile:axis=x,0.3=1,0.3000000000000001=2",
            0.03,
        ),
        (&cube, "exp(0)*x*y*z", "x*y*z", 1e-6),
        (&cube, "max(r, 0)*r + sqrt(1)", "1 + x^2 + y^2 + z^2", 1e-6),
    ] {
        let got = field(formula).weigh(solid, &extent(solid), Some(tolerance));
        let got = got.expect("it has a mass");
        assert_told(solid, got, &weighed(solid, exact).body, formula);
        assert!(errors(solid, got).relative <= tolerance, "{formula}");
        assert!(got.missed.is_none());
    }
    // The same on tetrahedra.
    let got = weighed(&tets(2), "exp(0)*x*y*z + sin(0)");
    assert_told(&tets(2), got, &weighed(&tets(2), "x*y*z").body, "tets");
}

#[test]
fn distances_in_a_cube_are_those_of_its_six_pyramids() {
    // distance^n over six pyramids of height 1/2: 6 ∫₀^½ h^n (1 − 2h)² dh.
    for solid in [solid(&unit_cube()), tets(2)] {
        for (text, exact) in [
            ("distance", 1.0 / 8.0),
            ("distance^2", 1.0 / 40.0),
            ("1 + 0*distance", 1.0),
        ] {
            let got = field(text).weigh(&solid, &extent(&solid), Some(1e-3));
            let got = got.expect("it has a mass");
            let told = errors(&solid, got);
            let error = (got.body.mass - exact).abs();
            assert!(
                error <= told.mass + 1e-14 && told.relative <= 1e-3,
                "{text}: {error:e} {told:?}"
            );
            assert!(
                (got.body.center_of_mass() - Point3::from([0.5; 3])).norm() <= told.center + 1e-14
            );
        }
    }
}

#[test]
fn sampled_formulas_tell_how_far_they_are_from_the_formula() {
    let solid = tets(3);
    for formula in ["x^2 + 1", "sin(6*x)*y + 2"] {
        let sampled = weighed(&solid, &format!("vertex:={formula}"));
        let exact = weighed(&solid, &format!("({formula})*exp(0)")).body;
        assert_told(&solid, sampled, &exact, formula);
        assert!(
            errors(&solid, sampled).relative > 1e-4,
            "{formula} is not linear"
        );
    }
    let linear = weighed(&solid, "vertex:=1 + x - 0.5*z");
    assert_told(
        &solid,
        linear,
        &weighed(&solid, "1 + x - 0.5*z").body,
        "linear",
    );
    assert!(errors(&solid, linear).relative < 1e-12);
    let surface = crate::tests::fields::solid(&unit_cube());
    let refused = field("vertex:=x").weigh(&surface, &extent(&surface), None);
    assert!(matches!(refused, Err(FieldError::Weigh(_))));
}

#[test]
fn a_formula_without_a_value_is_refused_with_the_place() {
    let cube = solid(&unit_cube());
    let refused = field("1/(x-0.5) + log(y - 2)").weigh(&cube, &extent(&cube), None);
    let message = refused.expect_err("it is not a number").to_string();
    assert!(message.contains("the density is NaN at ["), "{message}");
}

#[test]
fn a_tolerance_out_of_reach_is_told_with_what_is_reached() {
    let rules = ConeRules::new();
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Point3::from);
    let goal = Goal {
        tolerance: 1e-9,
        extent: 1.7,
        most: 2000,
        signs: Signs::Unknown,
    };
    let step = |y: &Point3<f64>| f64::from(u8::from(y.x > 0.4));
    let whole = vec![ConePiece::new(Point3::origin(), corners, 0)];
    let sum = integrate(whole, goal, &|piece: &ConePiece| {
        rules.estimate(piece, &Point3::origin(), step)
    });
    // The corner x > 0.4 of the unit simplex: 0.6³/6.
    let error = (sum.estimate.moments.mass - 0.036).abs();
    assert!(
        sum.relative > 1e-9 && error <= sum.estimate.errors.mass,
        "{sum:?}"
    );
}

#[test]
fn texts_of_fields_are_refused_with_what_would_be_right() {
    for (text, part) in [
        (
            "heavy",
            "`heavy` is not a density: column 1: expected a number",
        ),
        (
            "sin(x",
            "column 6: expected `,`, an operator or `)`, found the end",
        ),
        ("vertex:=2*foo", "column 11: expected a number"),
        (
            "sine:point=0,0,k=1",
            "`k=1` is not a finite number, as in `sine:point=0,0,0.5,k=20`",
        ),
        ("sine:k=1", "it begins with the point"),
        ("sine:point=0,0,0,q=1", "after the point it takes k alone"),
        ("radial:point=0,0,0", "needs at least one `radius=density`"),
        (
            "radial:point=0,0,0,1=2,1=3",
            "the radius 1 is not beyond the one before it",
        ),
        ("radial:point=0,0,0,-1=2", "the radius -1 is negative"),
        ("x^17", "degree 17 is above 16"),
        ("x/0", "division by zero"),
        ("lineal:axis=z", "density kind `lineal` does not exist"),
    ] {
        let message = Field::of_text(text).expect_err(text).to_string();
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn field_files_hold_clamps_cells_vertices_and_texts() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("field.json");
    let cube = solid(&unit_cube());
    let read = |density: &str| {
        std::fs::write(&path, format!("{{\"density\": {density}}}")).expect("it is written");
        GivenField::read(&format!("@{}", path.display()))
    };
    let mass = |density: &str| {
        let given = read(density).expect(density);
        let body = given.field.weigh(&cube, &extent(&cube), Some(1e-3));
        body.expect("it has a mass").body
    };
    let clamp = r#"{"clamp": {"low": 1, "high": 4, "of": {"affine": {"value": 0, "gradient": [8, 0, 0]}}}}"#;
    // 1 up to x = 1/8, 4 from x = 1/2: 1/8 + 3/8 · 2.5 + 2.
    assert!((mass(clamp).mass - 3.0625).abs() < 1e-14);
    let open = r#"{"clamp": {"low": 1, "of": {"affine": {"value": 0, "gradient": [8, 0, 0]}}}}"#;
    assert!((mass(open).mass - (0.125 + 7.0 / 8.0 * 4.5)).abs() < 1e-14);
    let curved = r#"{"clamp": {"low": 0.25, "high": 0.5, "of": {"polynomial": "x^2"}}}"#;
    let exact = 0.25 * 0.5 + (0.5_f64.powf(1.5) - 0.125) / 3.0 + 0.5 * (1.0 - 0.5_f64.sqrt());
    assert!((mass(curved).mass - exact).abs() < 1e-3 * exact);
    let cells = r#"{"cells": {"sites": [[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]], "values": [1, 3], "domain": {"box": {}}}}"#;
    let body = mass(cells);
    assert!((body.mass - 2.0).abs() < 1e-15);
    assert!((body.center_of_mass() - Point3::new(0.625, 0.5, 0.5)).norm() < 1e-15);
    assert!((mass(r#"{"text": "1 + x"}"#).mass - 1.5).abs() < 1e-15);
    for (density, part) in [
        (r#"{"vertices": {"values": [1, 2]}}"#, "tetrahedral mesh"),
        (
            r#"{"cells": {"sites": [[2, 0, 0]], "values": [1], "domain": {"box": {}}}}"#,
            "outside the domain",
        ),
    ] {
        let given = read(density).expect(density);
        let refused = given.field.weigh(&cube, &extent(&cube), None);
        let message = refused.expect_err(density).to_string();
        assert!(message.contains(part), "{message}");
    }
    for (density, part) in [
        (
            r#"{"clam": {}}"#,
            "unknown key `clam`; did you mean `clamp`?",
        ),
        (
            r#"{"cells": {"sites": [], "values": [], "domain": {"box": {}}}}"#,
            "0 sites and 0 values",
        ),
        (
            r#"{"clamp": {"low": 2, "high": 1, "of": {"affine": {"value": 0, "gradient": [0, 0, 0]}}}}"#,
            "`high` 1 is below `low` 2",
        ),
        (
            r#"{"text": "heavy"}"#,
            "field.json: `heavy` is not a density",
        ),
        ("", "line 1, column"),
    ] {
        let message = read(density).expect_err(density).to_string();
        assert!(message.contains(part), "{density}: {message}");
    }
}

#[test]
fn fields_weigh_the_same_as_background_densities() {
    let cube = solid(&unit_cube());
    let cells = Field::Cells {
        sites: [[0.2, 0.3, 0.4], [0.8, 0.6, 0.5], [0.5, 0.1, 0.9]]
            .map(Point3::from)
            .to_vec(),
        values: vec![1.0, 3.0, 2.0],
    };
    for (field, slack) in [
        (field("clamp(1, 4, 8*x + 3*y - 2)"), 1e-13),
        (field("clamp(1, inf, 8*x + 3*y - 2)"), 1e-13),
        (field("profile:axis=z,0.1=1,0.5=3,0.6=2"), 1e-13),
        (field("linear:axis=y,from=1,to=2"), 1e-13),
        (cells, 1e-13),
        (field("2 + sin(9*x)*cos(5*y)"), 5e-3),
        (field("radial:point=0.5,0.5,0.5,0.2=5,0.5=1"), 5e-3),
    ] {
        let exact = field
            .weigh(&cube, &extent(&cube), None)
            .expect("it has a mass");
        let (weighted, note) = by_field(Box::new(Cuboid::unit()), &field, None).expect("positive");
        let mean = weighted.mean_density();
        assert!(
            (mean / exact.body.mass - 1.0).abs() < slack,
            "{field:?}: {mean}"
        );
        assert_eq!(note.is_some(), slack > 1e-3, "{field:?}");
    }
    let size = field("0.1 + 0.2*x + 0*exp(x)");
    let (weighted, _) = by_field(Box::new(Cuboid::unit()), &size, Some(-4)).expect("positive");
    // ∫ (0.1 + 0.2 x)^−4 = (0.1^−3 − 0.3^−3) / 0.6.
    let exact = (1000.0 - 1.0 / 0.027) / 0.6;
    assert!((weighted.mean_density() / exact - 1.0).abs() < 5e-3);
}

/// A model of unit extent along an axis, its least corner in the origin.
fn unit_model(name: &str, axis: usize) -> Solid {
    let Solid::Surface(valid, _) = load(&shared_model(name)).expect("it is there") else {
        panic!("{name} is a surface");
    };
    let mut mesh = valid.into_mesh();
    let bounds = mesh.bounds();
    let length = bounds.extent()[axis];
    for vertex in &mut mesh.vertices {
        *vertex = Point3::from((*vertex - bounds.min) / length);
    }
    solid(&mesh)
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_bunny_with_a_sine_has_the_study_s_masses_and_centers() {
    let bunny = unit_model("bunny.off", 1);
    let middle = extent(&bunny).center();
    for (p, mass, center) in [
        (
            middle + Vector3::new(0.9, 0.1, 0.2),
            0.212_835_496_707_027,
            [0.473_787_27, 0.360_980_29, 0.466_518_19],
        ),
        (
            middle,
            0.215_104_859_583_777,
            [0.465_644_56, 0.350_381_05, 0.473_795_16],
        ),
    ] {
        let [x, y, z] = <[f64; 3]>::from(p);
        let got = weighed(&bunny, &format!("sine:point={x:?},{y:?},{z:?},k=20"));
        assert!(
            (got.body.mass / mass - 1.0).abs() < 1e-12,
            "{:?}",
            got.body.mass
        );
        let off = got.body.center_of_mass() - Point3::from(center);
        assert!(off.amax() < 1e-8, "{off}");
        let formula = format!("sin(20*sqrt((x-{x:?})^2+(y-{y:?})^2+(z-{z:?})^2))+1");
        let numeric = weighed(&bunny, &formula);
        assert_told(&bunny, numeric, &got.body, "the formula");
    }
}

/// Every tetrahedron in eight, neighbors sharing their vertices: centers of edges are the same to the bit.
fn in_eight(mesh: &TetMesh) -> TetMesh {
    let corners: Vec<_> = mesh.all_corners().collect();
    let (mut fine, mut numbers) = (TetMesh::default(), HashMap::new());
    for tet in eighths(&corners) {
        let number = |corner: Point3<f64>| {
            let key = <[f64; 3]>::from(corner).map(f64::to_bits);
            *numbers.entry(key).or_insert_with(|| {
                fine.vertices.push(corner);
                fine.vertices.len() as u32 - 1
            })
        };
        fine.tets.push(tet.map(number));
    }
    fine
}

/// The rows "P1 at vertices" of density.md, section 3.2, for both of its points, on another mesh of the bunny
/// refined once: the error is told on each, and falls as it does there.
#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_sampled_sine_of_tetrahedra_misses_by_no_more_than_it_tells() {
    let Solid::Tets(coarse, _) = load(&shared_model("bunny.mesh")).expect("it is there") else {
        panic!("tetrahedra");
    };
    let mut mesh = coarse.mesh().clone();
    let bounds = Bounds::of(&mesh.vertices);
    let height = bounds.extent().y;
    let k = 20.0 / height;
    let points =
        [[0.9, 0.1, 0.2], [0.0; 3]].map(|aside| bounds.center() + height * Vector3::from(aside));
    for (level, most) in [0.1, 0.03].into_iter().enumerate() {
        let (valid, report) = validate_tets(&mesh).expect("they are sound");
        let bunny = Solid::Tets(valid, report);
        for [x, y, z] in points.map(<[f64; 3]>::from) {
            let formula = format!("sin({k:?}*sqrt((x-{x:?})^2+(y-{y:?})^2+(z-{z:?})^2))+1");
            let exact = weighed(&bunny, &format!("sine:point={x:?},{y:?},{z:?},k={k:?}"));
            let sampled = weighed(&bunny, &format!("vertex:={formula}"));
            let error = (sampled.body.mass / exact.body.mass - 1.0).abs();
            assert!(error < most, "level {level}: {error}");
            assert_told(&bunny, sampled, &exact.body, "sampled");
            if level == 0 {
                assert_told(&bunny, weighed(&bunny, &formula), &exact.body, "cubature");
            }
        }
        mesh = in_eight(&mesh);
    }
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_femur_with_a_gaussian_of_the_distance_has_the_study_s_mass() {
    let femur = unit_model("femur.off", 2);
    let got = weighed(&femur, "exp(-distance^2/(2*0.02^2))");
    // By 27 Gauss points in tetrahedra refined twice (density.md, section 3.4), which other rules meet
    // within 2.1e-5.
    let error = (got.body.mass / 0.011_705_886_7 - 1.0).abs();
    assert!(error < 4e-5, "{} {error:e}", got.body.mass);
    assert!(errors(&femur, got).relative <= 1e-4);
}

/// By parallel surfaces: at the distance t inside a box of sides a, b, c lie 2(ab + bc + ca) of the box
/// a − 2t, b − 2t, c − 2t. Its planes of kinks lie alike to many pieces, so their errors have common signs.
#[test]
fn formulas_of_the_distance_in_a_box_are_off_by_no_more_than_is_told() {
    let sides = [1.0, 0.8, 0.5];
    let mut mesh = unit_cube();
    for vertex in &mut mesh.vertices {
        *vertex = Point3::from(vertex.coords.component_mul(&Vector3::from(sides)));
    }
    let cuboid = solid(&mesh);
    let area = |t: f64| {
        let [a, b, c] = sides.map(|side| side - 2.0 * t);
        2.0 * (a * b + b * c + c * a)
    };
    type Profile = fn(f64) -> f64;
    let profiles: [(&str, Profile); 4] = [
        ("distance", |t| t),
        ("exp(-distance^2/0.02)", |t| (-t * t / 0.02).exp()),
        ("0.2 + sin(20*distance)^2", |t| {
            0.2 + (20.0 * t).sin().powi(2)
        }),
        ("1/(0.05 + distance)", |t| 1.0 / (0.05 + t)),
    ];
    for (formula, profile) in profiles {
        // Simpson's rule on 2000 parts: 1e-12.
        let (parts, step) = (2000, 0.25 / 2000.0);
        let simpson = (0..=parts).map(|k| {
            let weight = match k {
                0 | 2000 => 1.0,
                k if k % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let t = f64::from(k) * step;
            weight * profile(t) * area(t)
        });
        let mass = simpson.sum::<f64>() * step / 3.0;
        for tolerance in [3e-2, 3e-3, 1e-3] {
            let got = (field(formula).weigh(&cuboid, &extent(&cuboid), Some(tolerance)))
                .expect("it has values");
            let told = errors(&cuboid, got);
            let off = (got.body.mass - mass).abs();
            let by = (got.body.center_of_mass() - extent(&cuboid).center()).norm();
            assert!(off <= told.mass, "{formula} {tolerance}: {off:e} {told:?}");
            assert!(by <= told.center, "{formula} {tolerance}: {by:e} {told:?}");
            assert!(
                told.relative <= tolerance,
                "{formula} {tolerance}: {told:?}"
            );
        }
    }
}
