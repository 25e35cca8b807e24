//! Files of other programs given to the command: meshes, sites, and solids that are thin.

use std::path::Path;

use crate::test_dir::{TestDir, assert_all_in};
use serde_json::Value;

fn case(name: &str) -> String {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    cases.join(name).display().to_string()
}

fn json(dir: &TestDir, arguments: &[&str]) -> Value {
    serde_json::from_str(&dir.stdout(arguments)).expect("a JSON object")
}

#[test]
fn a_tetrahedron_weighs_a_sixth_in_every_dialect() {
    let dir = TestDir::new();
    for name in [
        "stl-binary-one-byte-too-many.stl",
        "stl-ascii-upper-case.stl",
        "stl-ascii-mixed-case.stl",
        "stl-ascii-end-solid.stl",
        "stl-ascii-text-after-tags.stl",
        "ply-cr-lines.ply",
        "vtk-global-ids.vtk",
        "vtk-string-field.vtk",
        "vtk-nan-in-unused-data.vtk",
        "msh22-parametric-nodes.msh",
    ] {
        let volume = json(&dir, &["mass", &case(name), "--json"])["volume"].as_f64();
        let sixth = volume.expect("a number") * 6.0;
        assert!((sixth - 1.0).abs() < 1e-15, "{name}: {sixth}");
    }
}

#[test]
fn data_without_a_value_for_a_node_are_refused_where_they_are_the_density() {
    let dir = TestDir::new();
    let file = case("msh22-node-data-for-three-of-four.msh");
    dir.stdout(&["mass", &file]);
    let message = dir.refusal(&["mass", &file, "--density", "vertex:rho"]);
    assert_all_in(
        &message,
        &["three-of-four.msh", "`rho`", "node 10 has no value"],
    );
    let nan = case("vtk-nan-in-unused-data.vtk");
    let message = dir.refusal(&["mass", &nan, "--density", "vertex"]);
    assert_all_in(&message, &["unused-data.vtk", "`a`", "point 0", "NaN"]);
    let scene = format!(
        "{{\"domain\": {{\"tets\": {file:?}}}, \"density\": {{\"data\": \"rho\"}}, \"sites\": {{\"random\": {{\"count\": 3}}}}}}"
    );
    dir.write("s.json", scene);
    let message = dir.refusal(&["measure", "s.json"]);
    assert_all_in(&message, &["density", "node 10 has no value"]);
}

#[test]
fn atoms_are_sites() {
    let dir = TestDir::new();
    let measured = json(&dir, &["measure", "--sites", &case("sites-chemistry.xyz")]);
    assert_eq!(measured["sites"], 3);
    dir.write("cr.csv", "x,y,z\r0.1,0.2,0.3\r0.4,0.5,0.6\r");
    assert_eq!(json(&dir, &["measure", "--sites", "cr.csv"])["sites"], 2);
    dir.write("cr.xyz", "# plain\r0.1 0.2 0.3\r0.4 0.5 nan\r");
    assert_all_in(
        &dir.refusal(&["measure", "--sites", "cr.xyz"]),
        &["line 3", "nan"],
    );
}

#[test]
fn a_thin_diagonal_rod_has_random_sites() {
    let dir = TestDir::new();
    let rod = case("diagonal-rod-1e-04.off");
    let scene = format!(
        "{{\"domain\": {{\"surface\": {rod:?}}}, \"sites\": {{\"random\": {{\"count\": 20}}}}}}"
    );
    dir.write("s.json", scene);
    let measured = json(&dir, &["measure", "s.json"]);
    let (sum, volume) = (&measured["volume_sum"], &measured["domain_volume"]);
    let share = sum.as_f64().expect("a number") / volume.as_f64().expect("a number");
    assert!((share - 1.0).abs() < 1e-6, "{share}");
}
