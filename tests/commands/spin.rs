//! `chebloyd spin` on the command line: fields that `mass` reads back, proofs, bores, modifiers.

use crate::test_dir::{TestDir, assert_all_in};
use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};
use serde_json::Value;

use chebloyd::mesh::shapes::{icosphere, unit_cube_tets};
use chebloyd::mesh::surface::SurfaceMesh;

/// An axis that misses the center of the L and is askew.
const AXIS: &str = "0.8,0.75,0.5,0.05,0.02,1";

/// The corners of an L, counter-clockwise.
const L: [[f64; 2]; 6] = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];

/// A prism over an L.
fn prism() -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    for z in [0.0, 1.0] {
        mesh.vertices.extend(L.map(|[x, y]| Point3::new(x, y, z)));
    }
    let bottom = [[0, 2, 1], [0, 3, 2], [0, 5, 3], [3, 5, 4]];
    mesh.triangles.extend(bottom);
    mesh.triangles
        .extend(bottom.map(|[a, b, c]| [a + 6, c + 6, b + 6]));
    for side in 0..6 {
        let next = (side + 1) % 6;
        mesh.triangles
            .extend([[side, next, next + 6], [side, next + 6, side + 6]]);
    }
    mesh
}

fn off(mesh: &SurfaceMesh) -> String {
    let mut text = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    for v in &mesh.vertices {
        text += &format!("{} {} {}\n", v.x, v.y, v.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

fn desk() -> TestDir {
    let dir = TestDir::new();
    dir.write("l.off", off(&prism()));
    dir
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_fn(|row, _| number(&value[row]))
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("one JSON object")
}

/// The center's distance from an axis, and the angle of the nearest principal axis with it in degrees, of
/// what `mass` prints.
fn spins(mass: &Value, axis: &str) -> (f64, f64) {
    let axis: Vec<f64> = axis
        .split(',')
        .map(|n| n.parse().expect("a number"))
        .collect();
    let along = Vector3::new(axis[3], axis[4], axis[5]).normalize();
    let way = vector(&mass["center_of_mass"]) - Vector3::new(axis[0], axis[1], axis[2]);
    let inertia = Matrix3::from_fn(|row, column| number(&mass["inertia_center"][row][column]));
    let eigen = SymmetricEigen::new(inertia);
    let angles = eigen.eigenvectors.column_iter().map(|found| {
        let found: Vector3<f64> = found.into();
        found.cross(&along).norm().atan2(found.dot(&along).abs())
    });
    let angle = angles.fold(f64::MAX, f64::min);
    (way.cross(&along).norm(), angle.to_degrees())
}

fn assert_spins(mass: &Value, axis: &str) {
    let (distance, angle) = spins(mass, axis);
    assert!(distance < 1e-12 && angle < 1e-9, "{distance:e} {angle:e}");
}

#[test]
fn a_field_of_cells_is_read_back_by_mass() {
    let dir = desk();
    let spin = ["spin", "l.off", "--axis", AXIS, "--basis", "cells:40"];
    let more = ["--range", "1,5", "--out", "run", "--json"];
    let report = json(&dir.stdout(&[&spin[..], &more].concat()));
    assert_eq!(report["feasible"], true);
    assert!(number(&report["distance"]) < 1e-13 && number(&report["angle_degrees"]) < 1e-10);
    assert!(number(&report["native"]["distance"]) > 0.01);
    assert!(number(&report["least_contrast"]) > 1.0 && number(&report["least_contrast"]) < 5.0);
    assert_eq!(dir.json("run/report.json"), report);
    let read = ["mass", "l.off", "--density", "@run/field.json", "--json"];
    let mass = json(&dir.stdout(&read));
    assert_spins(&mass, AXIS);
    assert!((number(&mass["mass"]) - number(&report["mass"])).abs() < 1e-12);
    for name in ["section.png", "section.svg", "density.vtu", "log.jsonl"] {
        assert!(!dir.read(&format!("run/{name}")).is_empty());
    }
    let again = dir.refusal(&[&spin[..], &more].concat());
    assert_all_in(&again, &["is there already", "--force"]);
}

#[test]
fn a_field_of_vertices_is_read_back_by_mass() {
    let dir = TestDir::new();
    let mesh = unit_cube_tets(3);
    let mut text = format!(
        "MeshVersionFormatted 2\nDimension 3\nVertices\n{}\n",
        mesh.vertices.len()
    );
    for v in &mesh.vertices {
        text += &format!("{} {} {} 0\n", v.x, v.y, v.z);
    }
    text += &format!("Tetrahedra\n{}\n", mesh.tets.len());
    for tet in &mesh.tets {
        let [a, b, c, d] = tet.map(|vertex| vertex + 1);
        text += &format!("{a} {b} {c} {d} 0\n");
    }
    dir.write("cube.mesh", text + "End\n");
    let axis = "0.45,0.52,0.5,0.02,0.05,1";
    let spin = ["spin", "cube.mesh", "--axis", axis, "--basis", "vertex"];
    let more = ["--out", "run", "--json", "--stable", "--center-at", "0.03"];
    let report = json(&dir.stdout(&[&spin[..], &more].concat()));
    assert_eq!(report["range_chosen"], true);
    assert_eq!(report["axis_moment"], "largest");
    let contrast = number(&report["range"][1]) / number(&report["least_contrast"]);
    assert!(contrast > 1.49, "{contrast}");
    let read = [
        "mass",
        "cube.mesh",
        "--density",
        "@run/field.json",
        "--json",
    ];
    let mass = json(&dir.stdout(&read));
    assert_spins(&mass, axis);
    let along = Vector3::new(0.02, 0.05, 1.0).normalize();
    let height = (vector(&mass["center_of_mass"]) - Vector3::new(0.45, 0.52, 0.5)).dot(&along);
    assert!((height - 0.03).abs() < 1e-12);
}

#[test]
fn points_are_counted_and_their_formula_is_told() {
    let dir = desk();
    let spin = [
        "spin",
        "l.off",
        "--axis",
        AXIS,
        "--basis",
        "points:2000",
        "--range",
        "1,5",
    ];
    let report = json(&dir.stdout(&[&spin[..], &["--json", "--out", "run"]].concat()));
    assert!(number(&report["basis"]["count"]) >= 2000.0);
    assert!(number(&report["distance"]) < 1e-13);
    let off = number(&report["formula"]["distance"]);
    assert!(off > 1e-12 && off < 1e-2, "{off:e}");
    let field = dir.json("run/field.json");
    assert!((number(&field["density"]["clamp"]["high"]) - 5.0).abs() < 1e-15);
    let picture = String::from_utf8(dir.read("run/section.svg")).expect("text");
    assert_all_in(
        &picture,
        &["nearest principal axis after", "center of mass"],
    );
}

#[test]
fn what_cannot_be_is_refused_with_its_proof() {
    let dir = desk();
    let spin = [
        "spin", "l.off", "--axis", AXIS, "--basis", "cells:40", "--json",
    ];
    let more = ["--range", "1,1.2", "--out", "run"];
    let output = dir.run(&[&spin[..], &more].concat());
    assert_eq!(output.status.code(), Some(1));
    let report = json(&String::from_utf8_lossy(&output.stdout));
    assert_eq!(report["feasible"], false);
    assert!(number(&report["least_contrast"]) > 1.2);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_all_in(
        &error,
        &["no density between 1 and 1.2", "contrast of", "--range"],
    );
    assert_eq!(dir.json("run/report.json"), report);
    assert!(!dir.path("run/field.json").exists());
    // 1.2 where the polynomial is positive and 1 elsewhere is the best there is, and does not do.
    let polynomial = report["certificate"]["polynomial"]
        .as_str()
        .expect("a text");
    let at = ["mass", "l.off", "--density", polynomial, "--json"];
    let output = dir.run(&at);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        message.contains("the mass is -"),
        "its integral is negative: {message}"
    );
    let outside = dir.run(&[
        "spin",
        "l.off",
        "--axis",
        "9,9,0,0,0,1",
        "--basis",
        "cells:40",
    ]);
    let message = String::from_utf8_lossy(&outside.stderr).into_owned();
    assert_eq!(outside.status.code(), Some(1), "{message}");
    assert!(message.contains("no contrast suffices"), "{message}");
}

#[test]
fn bad_input_is_refused_before_anything_is_written() {
    let dir = desk();
    let refused = |more: &[&str], words: &[&str]| {
        let output = dir.run(&[&["spin", "l.off"], more].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{more:?}: {message}");
        assert!(output.stdout.is_empty());
        assert_all_in(&message, words);
    };
    refused(&[], &["--axis"]);
    refused(&["--axis", "0,0,0,0,0,0"], &["no length"]);
    refused(&["--axis", "0,0,1"], &["six numbers"]);
    refused(&["--axis", AXIS, "--range", "4,1"], &["LO 4 is above HI 1"]);
    refused(
        &["--axis", AXIS, "--range", "0,1"],
        &["LO must be positive"],
    );
    refused(
        &["--axis", AXIS, "--range", "1,2", "--prefer", "3"],
        &["--prefer 3"],
    );
    refused(
        &["--axis", AXIS, "--basis", "vertex"],
        &["tetrahedral mesh", "cells:N"],
    );
    refused(&["--axis", AXIS, "--basis", "cells:0"], &["whole number"]);
    refused(
        &["--axis", AXIS, "--basis", "hats:3"],
        &["cells:N, points:N or vertex"],
    );
    refused(&["--axis", AXIS, "--modifiers", "4"], &["--out"]);
    refused(
        &["--axis", AXIS, "--out", "o", "--modifiers", "1"],
        &["from 3 to 200"],
    );
    refused(&["--axis", AXIS, "--find-bores"], &["--find-bores"]);
    refused(
        &["--axis", AXIS, "--field", "sine", "--range", "1,2"],
        &["--range"],
    );
    dir.write("open.off", off(&prism()).replace("12 20 0", "12 19 0"));
    let message = dir.refusal(&["spin", "open.off", "--axis", AXIS]);
    assert!(message.contains("open.off"), "{message}");
    let missing = dir.refusal(&["spin", "no.off", "--axis", AXIS]);
    assert!(missing.contains("no.off"), "{missing}");
}

#[test]
fn mass_and_moment_scale_the_densities() {
    let dir = desk();
    let spin = [
        "spin", "l.off", "--axis", AXIS, "--basis", "cells:60", "--json",
    ];
    let plain = json(&dir.stdout(&spin));
    let heavy = json(&dir.stdout(&[&spin[..], &["--mass", "7"]].concat()));
    assert!((number(&heavy["mass"]) - 7.0).abs() < 1e-12);
    let factor = 7.0 / number(&plain["mass"]);
    assert!((number(&heavy["range"][0]) / factor - 1.0).abs() < 1e-12);
    let stiff = json(&dir.stdout(&[&spin[..], &["--moment", "5"]].concat()));
    assert!((number(&stiff["moment_about_axis"]) - 5.0).abs() < 1e-12);
    let wanted = number(&plain["moment_about_axis"]) / number(&plain["mass"]) * 7.0 * 1.02;
    let wanted = wanted.to_string();
    let both = ["--mass", "7", "--moment", &wanted];
    let both = json(&dir.stdout(&[&spin[..], &both].concat()));
    assert!((number(&both["mass"]) - 7.0).abs() < 1e-12);
    let moment = number(&both["moment_about_axis"]) / wanted.parse::<f64>().expect("a number");
    assert!((moment - 1.0).abs() < 1e-12, "{moment}");
    assert!(number(&both["distance"]) < 1e-13 && number(&both["angle_degrees"]) < 1e-10);
}

#[test]
fn several_files_are_one_solid() {
    let dir = desk();
    let mut ball = icosphere(1);
    for vertex in &mut ball.vertices {
        *vertex = *vertex * 0.5 + Vector3::new(-1.0, 0.5, 0.5);
    }
    dir.write("ball.off", off(&ball));
    let spin = [
        "spin",
        "l.off",
        "ball.off",
        "--axis",
        "0.4,0.6,0.5,0,0.02,1",
    ];
    let more = ["--basis", "cells:60", "--out", "run", "--json"];
    let report = json(&dir.stdout(&[&spin[..], &more].concat()));
    assert!(number(&report["distance"]) < 1e-13);
    let read = [
        "mass",
        "run/solid.off",
        "--density",
        "@run/field.json",
        "--json",
    ];
    assert_spins(&json(&dir.stdout(&read)), "0.4,0.6,0.5,0,0.02,1");
}

#[test]
fn modifiers_are_closed_and_weigh_what_is_told() {
    let dir = desk();
    let spin = [
        "spin", "l.off", "--axis", AXIS, "--basis", "cells:60", "--range", "1,4",
    ];
    let more = ["--modifiers", "5", "--out", "run", "--json"];
    let report = json(&dir.stdout(&[&spin[..], &more].concat()));
    let modifiers = &report["modifiers"];
    let bodies = modifiers["bodies"].as_array().expect("bodies");
    assert!(bodies.len() >= 3 && bodies.len() <= 5);
    let (mut volume, mut mass, mut first) = (0.0, 0.0, Vector3::zeros());
    for body in bodies {
        let file = format!("run/{}", body["file"].as_str().expect("a name"));
        let density = number(&body["density"]);
        assert!((number(&body["fill_percent"]) - 25.0 * density).abs() < 1e-12);
        let weighed = json(&dir.stdout(&["mass", &file, "--json"]));
        volume += number(&weighed["volume"]);
        mass += number(&weighed["mass"]) * density;
        first += vector(&weighed["center_of_mass"]) * (number(&weighed["mass"]) * density);
    }
    // STL holds seven digits.
    assert!((volume - 3.0).abs() < 1e-6, "{volume}");
    assert!((mass / number(&report["mass"]) - 1.0).abs() < 1e-6);
    assert!((first / mass - vector(&modifiers["center_of_mass"])).amax() < 1e-6);
    let near = spins(&report, AXIS).0;
    assert!(near < 1e-12 && number(&modifiers["distance"]) < 0.05);
    assert_eq!(&dir.read("run/modifiers.3mf")[..4], b"PK\x03\x04");
}

#[test]
fn stand_writes_slabs() {
    let dir = desk();
    let stand = [
        "stand",
        "l.off",
        "--target",
        "0.7,0.7,_",
        "--range",
        "1,8",
        "--json",
    ];
    let more = ["--modifiers", "6", "--out", "run"];
    let report = json(&dir.stdout(&[&stand[..], &more].concat()));
    let bodies = report["modifiers"]["bodies"].as_array().expect("bodies");
    assert!(bodies.len() >= 4, "{bodies:?}");
    let mut volume = 0.0;
    for body in bodies {
        let file = format!("run/{}", body["file"].as_str().expect("a name"));
        volume += number(&json(&dir.stdout(&["mass", &file, "--json"]))["volume"]);
    }
    assert!((volume - 3.0).abs() < 1e-6, "{volume}");
    let modifiers = &report["modifiers"];
    assert!((number(&modifiers["mass"]) / number(&report["mass"]) - 1.0).abs() < 1e-12);
    let off = vector(&modifiers["center_of_mass"]) - vector(&report["center_of_mass"]);
    assert!(off.norm() < 0.02, "{off}");
}

#[test]
fn bores_are_listed_ready_for_the_axis() {
    let dir = TestDir::new();
    let mut plate = SurfaceMesh::default();
    let corners = 24;
    for (radius, z) in [(2.0, 0.0), (2.0, 1.0), (0.5, 0.0), (0.5, 1.0)] {
        for corner in 0..corners {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
            plate.vertices.push(Point3::new(
                3.0 + radius * angle.cos(),
                radius * angle.sin(),
                z,
            ));
        }
    }
    for corner in 0..corners as u32 {
        let next = (corner + 1) % corners as u32;
        for [one, other] in [[0, 1], [3, 2], [1, 3], [2, 0]] {
            let at = |ring: u32, corner: u32| ring * corners as u32 + corner;
            let quad = [
                at(one, corner),
                at(one, next),
                at(other, next),
                at(other, corner),
            ];
            plate
                .triangles
                .extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    dir.write("plate.off", off(&plate));
    let report = json(&dir.stdout(&["spin", "plate.off", "--find-bores", "--json"]));
    let bores = report["bores"].as_array().expect("bores");
    assert_eq!(bores.len(), 1);
    assert!((number(&bores[0]["radius"]) - 0.5).abs() < 1e-12);
    assert!((vector(&bores[0]["point"]) - Vector3::new(3.0, 0.0, 0.5)).amax() < 1e-12);
    let axis = bores[0]["axis"].as_str().expect("an axis");
    let spun = [
        "spin",
        "plate.off",
        "--axis",
        axis,
        "--basis",
        "cells:30",
        "--json",
    ];
    let spun = json(&dir.stdout(&spun));
    assert!(number(&spun["native"]["distance"]) < 1e-12);
    // Cells of random sites are not symmetric, but nothing has to vary much.
    assert!(number(&spun["least_contrast"]) < 1.0 + 1e-6);
    assert_eq!(
        dir.stdout(&["spin", "plate.off", "--find-bores"])
            .lines()
            .count(),
        2
    );
}

#[test]
fn a_sine_is_found_and_read_back_by_mass() {
    let dir = desk();
    let spin = [
        "spin", "l.off", "--axis", AXIS, "--basis", "cells:60", "--field", "sine", "--starts",
        "60", "--json", "--out", "sine",
    ];
    let report = json(&dir.stdout(&spin));
    assert!(number(&report["met"]) >= 1.0, "{report}");
    assert!(number(&report["distance"]) < 1e-9, "{report}");
    assert!(number(&report["angle_degrees"]) < 1e-6, "{report}");
    let mass = json(&dir.stdout(&["mass", "l.off", "--density", "@sine/field.json", "--json"]));
    let error = number(&mass["mass"]) / number(&report["mass"]) - 1.0;
    assert!(error.abs() < 1e-9, "{error:e}");
    let center = vector(&mass["center_of_mass"]) - vector(&report["center_of_mass"]);
    assert!(center.amax() < 1e-10, "{center}");
    let (distance, angle) = spins(&mass, AXIS);
    assert!(distance < 1e-8 && angle < 1e-5, "{distance:e} {angle:e}");
    let picture = String::from_utf8(dir.read("sine/section.svg")).expect("text");
    assert_all_in(
        &picture,
        &["nearest principal axis after", "center of mass"],
    );
}

/// The corners of every triangle apart by 1e-7, as exports of single precision have them.
#[test]
fn weld_closes_what_single_precision_left_open() {
    let dir = desk();
    let whole = prism();
    let mut apart = SurfaceMesh::default();
    for (number, corners) in whole.all_corners().enumerate() {
        let first = apart.vertices.len() as u32;
        let shift = Vector3::repeat(1e-7 * f64::from(number as u32 % 3));
        apart.vertices.extend(corners.map(|corner| corner + shift));
        apart.triangles.push([first, first + 1, first + 2]);
    }
    dir.write("apart.off", off(&apart));
    let spin = ["--axis", AXIS, "--basis", "cells:60", "--json"];
    for (command, options) in [("spin", &spin[..]), ("stand", &["--json"][..])] {
        let open = dir.refusal(&[&[command, "apart.off"], options].concat());
        assert!(open.contains("apart.off"), "{open}");
        let weld = [&[command, "apart.off", "--weld", "1e-6"], options].concat();
        let closed = json(&dir.stdout(&weld));
        let plain = json(&dir.stdout(&[&[command, "l.off"], options].concat()));
        let error = number(&closed["mass"]) / number(&plain["mass"]) - 1.0;
        assert!(error.abs() < 1e-5, "{command}: {error:e}");
    }
}
