//! The command `chebloyd mass`: output and error messages.

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

/// The unit cube with its least corner at (`x`, 0, 0), as OFF quads.
fn cube(x: f64) -> String {
    let mut text = "OFF\n8 6 0\n".to_owned();
    for bits in 0..8 {
        text += &format!(
            "{} {} {}\n",
            x + f64::from(bits & 1),
            bits >> 1 & 1,
            bits >> 2
        );
    }
    text + "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n"
}

fn dir() -> TestDir {
    let dir = TestDir::new();
    dir.write("cube.off", cube(0.0))
        .write("next.off", cube(1.0));
    let nodes = "4 3 1 0\n0 0 0 0 1\n1 1 0 0 2\n2 0 1 0 3\n3 0 0 1 4\n";
    dir.write("tet.node", nodes)
        .write("tet.ele", "1 4 0\n0 0 1 2 3\n");
    dir
}

fn json(dir: &TestDir, arguments: &[&str]) -> Value {
    let arguments = [&["mass", "--json"], arguments].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn near(value: &Value, expected: f64) {
    let got = value.as_f64().expect("a number");
    assert!((got - expected).abs() < 1e-14, "{got} is not {expected}");
}

#[test]
fn the_json_object_holds_what_the_interface_promises() {
    let dir = dir();
    let cube = json(&dir, &["cube.off", "--density", "3"]);
    near(&cube["volume"], 1.0);
    near(&cube["surface_area"], 6.0);
    near(&cube["mass"], 3.0);
    for axis in 0..3 {
        near(&cube["center_of_mass"][axis], 0.5);
        near(&cube["inertia_origin"][axis][axis], 2.0);
        near(&cube["inertia_origin"][axis][(axis + 1) % 3], -0.75);
        near(&cube["inertia_center"][axis][axis], 0.5);
        near(&cube["principal_moments"][axis], 0.5);
        near(&cube["principal_axes"][axis][axis], 1.0);
    }
}

#[test]
fn a_ramp_runs_over_all_parts_together() {
    let dir = dir();
    let ramp = "linear:axis=x,from=0,to=2";
    let both = json(&dir, &["cube.off", "next.off", "--density", ramp]);
    near(&both["mass"], 2.0);
    near(&both["center_of_mass"][0], 4.0 / 3.0);
    near(&both["parts"][0]["mass"], 0.5);
    near(&both["parts"][1]["mass"], 1.5);
    let own = ["--density", "1", "--density", "linear:axis=x,from=0,to=2"];
    let own = json(&dir, &[&["cube.off", "next.off"], &own[..]].concat());
    near(&own["parts"][0]["mass"], 1.0);
}

#[test]
fn parts_may_be_given_by_mass_and_turned_about_any_axis() {
    let dir = dir();
    let masses = ["--mass", "3", "--mass", "1", "--axis", "0.5,0.5,-7,0,0,2"];
    let both = json(&dir, &[&["cube.off", "next.off"], &masses[..]].concat());
    near(&both["mass"], 4.0);
    near(&both["center_of_mass"][0], 0.75);
    near(&both["moment_about_axis"], 4.0 / 6.0 + 1.0);
}

#[test]
fn vertex_data_of_a_tetrahedral_mesh_are_densities() {
    let dir = dir();
    let tet = json(&dir, &["tet.node", "--density", "vertex"]);
    near(&tet["mass"], 2.5 / 6.0);
    near(&tet["center_of_mass"][0], (1.0 + 2.0 / 10.0) / 5.0);
}

#[test]
fn the_table_carries_units_and_ten_digits() {
    let dir = dir();
    let table = dir.stdout(&["mass", "cube.off", "--density", "x", "--units", "mm and g"]);
    let parts = [
        "mass                            0.5000000000",
        "center of mass                  0.6666666667        0.5000000000",
        "principal moments",
        "units                     mm and g",
    ];
    assert_all_in(&table, &parts);
}

#[test]
fn what_cannot_be_weighed_is_refused_by_name() {
    let dir = dir();
    dir.write("open.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    for (arguments, parts) in [
        (
            &["open.off"][..],
            &["open.off", "flat sheet", "3 edges are open"][..],
        ),
        (&["none.off"], &["none.off"]),
        (
            &["cube.off", "--density", "0"],
            &["cube.off", "the mass is 0"],
        ),
        (&["cube.off", "--density", "w"], &["--density", "column 1"]),
        (
            &["cube.off", "--density", "vertex"],
            &["cube.off", "tetrahedral mesh"],
        ),
        (
            &["cube.off", "--mass", "1", "--mass", "2"],
            &["--mass is given 2 times; this body has 1 part"],
        ),
    ] {
        let message = dir.refusal(&[&["mass"], arguments].concat());
        assert_all_in(&message, parts);
    }
}

#[test]
fn formulas_are_weighed_with_an_error_estimate() {
    let dir = dir();
    let exact = std::f64::consts::E - 1.0;
    let formula = json(&dir, &["cube.off", "--density", "exp(x)"]);
    let told = formula["error_estimates"]["mass"]
        .as_f64()
        .expect("a bound");
    let mass = formula["mass"].as_f64().expect("a mass");
    assert!((mass - exact).abs() <= told + 1e-15, "{mass} {told}");
    let relative = formula["error_estimate"].as_f64().expect("a bound");
    assert!(relative <= 1e-6 && told <= relative * mass);
    assert!(json(&dir, &["cube.off"])["error_estimate"].is_null());
    let table = dir.stdout(&[
        "mass",
        "cube.off",
        "--density",
        "exp(x)",
        "--tolerance",
        "0.01",
    ]);
    assert_all_in(&table, &["error estimate", "… of the center"]);
    let message = dir.refusal(&["mass", "cube.off", "--density", "log(x - 2)"]);
    assert_all_in(&message, &["cube.off", "the density is NaN at"]);
}

#[test]
fn the_files_of_a_density_are_written_once_and_never_replace_the_field() {
    let dir = dir();
    let field = r#"{"density": {"clamp": {"low": 1, "of": {"affine": {"value": 0, "gradient": [4, 0, 0]}}}}}"#;
    dir.write("field.json", field);
    let weigh = [
        "mass",
        "cube.off",
        "--density",
        "@field.json",
        "--out",
        "out",
    ];
    // 1 up to x = 1/4, then 4 x: 1/4 + 2 (1 − 1/16).
    assert_all_in(&dir.stdout(&weigh), &["2.125000000"]);
    assert!(dir.read("out/section.png").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(dir.read("out/section.svg")).expect("text");
    assert_all_in(
        &svg,
        &[
            "center of mass (",
            "center of volume (0.50000",
            "@field.json",
        ],
    );
    let vtu = dir.read("out/density.vtu");
    assert_all_in(
        &String::from_utf8_lossy(&vtu),
        &["PointData", "\"density\""],
    );
    // Cut where it bends, at x = 1/4, into two closed bodies.
    let slabs = dir.stdout(&["mass", "out/density.vtu", "--density", "@field.json"]);
    assert_all_in(&slabs, &["2.125000000", "8.000000000"]);
    assert_all_in(&dir.refusal(&weigh), &["out/density.vtu", "--force"]);
    dir.stdout(&[&weigh[..], &["--force", "--cut", "y"]].concat());
    let schema = dir.stdout(&["schema", "--field"]);
    assert_all_in(&schema, &["clamp", "affine", "cells", "vertices"]);
}
