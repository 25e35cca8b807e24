//! The command `chebloyd stand`: output, files, refusals.

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

const CUBE: &str = "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n\
     4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n";

fn dir() -> TestDir {
    let dir = TestDir::new();
    dir.write("cube.off", CUBE);
    dir
}

fn stand(dir: &TestDir, arguments: &[&str]) -> Value {
    let arguments = [&["stand", "cube.off", "--json"], arguments].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn near(value: &Value, expected: f64, tolerance: f64) {
    let got = value.as_f64().expect("a number");
    assert!(
        (got - expected).abs() <= tolerance,
        "{got} is not {expected}"
    );
}

#[test]
fn the_json_object_holds_what_the_interface_promises() {
    let dir = dir();
    let found = stand(
        &dir,
        &["--target", "0.3333333333333333,_,_", "--range", "1,4.5"],
    );
    assert_eq!(found["stands"], false);
    assert_eq!(found["feasible"], true);
    near(&found["least_contrast"], 4.0, 1e-13);
    near(&found["mass"], 1.78478535875368, 1e-10);
    near(&found["center_of_mass"][0], 1.0 / 3.0, 1e-14);
    near(&found["field"]["gradient"][0], -16.039014932345435, 1e-10);
    near(&found["certificate"]["point"][0], 1.0 / 3.0, 1e-13);
    near(&found["certificate"]["normal"][0], -1.0, 0.0);
    assert!(found["iterations"].as_u64() <= Some(7));
    assert!(found["slack"].is_null() && found["tilt_degrees"].is_null());
    let found = stand(&dir, &[]);
    assert_eq!(found["stands"], true);
    near(&found["least_contrast"], 1.0, 0.0);
    near(&found["slack"], 0.5, 1e-15);
    near(&found["tilt_degrees"], 45.0, 1e-13);
    let found = stand(
        &dir,
        &["--point", "0.3,0.4", "--mass", "3", "--range", "1,9"],
    );
    near(&found["mass"], 3.0, 1e-12);
    near(&found["center_of_mass"][1], 0.4, 1e-13);
    let unbounded = stand(
        &dir,
        &["--target", "0.3333333333333333,_,_", "--range", "1,inf"],
    );
    near(&unbounded["mass"], 1.75, 1e-13);
    assert!(unbounded["range"][1].is_null());
}

#[test]
fn what_cannot_be_reached_is_refused_with_a_proof_and_the_nearest_center() {
    let dir = dir();
    let refused = |arguments: &[&str]| {
        let arguments = [&["stand", "cube.off", "--json"], arguments].concat();
        let output = dir.run(&arguments);
        assert_eq!(output.status.code(), Some(1));
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(report["feasible"], false);
        (report, String::from_utf8(output.stderr).expect("text"))
    };
    let (report, error) = refused(&["--target", "0.25,_,_", "--range", "1,4"]);
    assert_all_in(
        &error,
        &["no density between 1 and 4", "9.000000000", "--range"],
    );
    near(&report["least_contrast"], 9.0, 1e-12);
    near(&report["nearest_center"][0], 1.0 / 3.0, 1e-6);
    near(&report["nearest_distance"], 1.0 / 12.0, 1e-6);
    assert!(report["mass"].is_null() && report["center_of_mass"].is_null());
    let (report, error) = refused(&["--target", "1.25,_,_"]);
    assert!(error.contains("outside the solid's convex hull"), "{error}");
    assert!(report["least_contrast"].is_null());
    near(&report["nearest_center"][0], 1.0, 1e-6);
    let (_, error) = refused(&["--point", "0.5,0.5", "--range", "1,9", "--mass", "20"]);
    assert!(error.contains("it weighs 1 to 9, not 20"), "{error}");
    // As it is, but for its weight.
    let (report, _) = refused(&["--point", "0.3,0.4", "--mass", "8.5", "--range", "1,9"]);
    assert!(report["least_high"].as_f64() > Some(9.0));
    near(&report["nearest_distance"], 0.193_020_136_9, 1e-6);
}

#[test]
fn the_field_file_gives_mass_the_same_center() {
    let dir = dir();
    dir.write(
        "foot.csv",
        "x,y\n0.1,0.1\n0.3,0.1\n0.3,0.3\n0.1,0.3 # a corner\n",
    );
    let wish = [
        "--polygon",
        "foot.csv",
        "--margin",
        "0.05",
        "--tilt",
        "3",
        "--out",
        "run",
    ];
    let found = stand(&dir, &wish);
    let files = [
        "field.json",
        "report.json",
        "log.jsonl",
        "density.vtu",
        "section.svg",
        "section.png",
    ];
    for file in files {
        assert!(dir.path(&format!("run/{file}")).is_file(), "{file}");
    }
    let mass = dir.stdout(&["mass", "cube.off", "--density", "@run/field.json", "--json"]);
    let mass: Value = serde_json::from_str(&mass).expect("JSON");
    near(
        &mass["mass"],
        found["mass"].as_f64().expect("a mass"),
        1e-13,
    );
    for axis in 0..3 {
        let center = found["center_of_mass"][axis].as_f64().expect("a center");
        near(&mass["center_of_mass"][axis], center, 1e-14);
    }
    assert!(found["slack"].as_f64() >= Some(0.05));
    assert!(found["tilt_degrees"].as_f64() > Some(3.0));
    let again = dir.refusal(&["stand", "cube.off", "--out", "run"]);
    assert_all_in(&again, &["is there already", "--force"]);
    dir.stdout(&["stand", "cube.off", "--out", "run", "--force"]);
}

#[test]
fn bad_wishes_are_refused_before_anything_is_written() {
    let dir = dir();
    dir.write(
        "open.off",
        "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2\n",
    );
    dir.write("bad.csv", "0,0\n1,nan\n")
        .write("none.csv", "# nothing\n");
    for (arguments, part) in [
        (&["--range", "4,1"][..], "LO 4 is above HI 1"),
        (&["--range", "0,1"], "LO must be positive"),
        (&["--range", "-1,1"], "LO must be positive"),
        (&["--range", "nan,1"], "LO must be positive"),
        (&["--range", "1"], "two numbers are needed"),
        (
            &["--prefer", "9", "--range", "1,4"],
            "--prefer 9 lies outside --range 1,4",
        ),
        (&["--margin", "0.5"], "a margin of 0.5 leaves nothing"),
        (&["--margin", "-1"], "not negative"),
        (&["--tilt", "90"], "less than 90 degrees"),
        (&["--contact", "2"], "between 0 and 1"),
        (&["--point", "0.5,0.5", "--tilt", "1"], "in a point only"),
        (&["--point", "0.5"], "two numbers X,Y"),
        (
            &["--point", "1,1", "--up", "1,1,1"],
            "takes three coordinates",
        ),
        (&["--target", "0.5,_,_", "--margin", "0.1"], "at one place"),
        (&["--target", "_,_,_"], "at least one coordinate"),
        (&["--target", "0.5,nan,_"], "each a number or _"),
        (
            &["--target", "0.5,_,_", "--point", "1,1"],
            "cannot be used with",
        ),
        (
            &["--target", "0.5,_,_", "--goal", "most-stable"],
            "needs a support polygon",
        ),
        (&["--up", "0,0,0"], "a direction has a length"),
        (&["--polygon", "bad.csv"], "bad.csv, line 2"),
        (&["--polygon", "none.csv"], "holds no points"),
        (&["--polygon", "missing.csv"], "cannot read missing.csv"),
        (&["--mass", "-1"], "a positive number"),
        (&["open.off"], "open.off"),
    ] {
        let all = [&["stand", "cube.off", "--out", "run"], arguments].concat();
        let error = dir.refusal(&all);
        assert!(error.contains(part), "{arguments:?}: {error}");
        assert!(!dir.path("run").exists(), "{arguments:?}");
    }
}

#[test]
fn tetrahedra_and_several_parts_stand_too() {
    let dir = dir();
    let nodes = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
    dir.write("tet.node", nodes)
        .write("tet.ele", "1 4 0\n0 0 1 2 3\n");
    let moved = CUBE.replace("\n1 ", "\n3 ").replace("\n0 ", "\n2 ");
    dir.write("next.off", moved);
    let tet = dir.stdout(&["stand", "tet.ele", "--point", "0.3,0.2", "--json"]);
    let tet: Value = serde_json::from_str(&tet).expect("JSON");
    near(&tet["center_of_mass"][0], 0.3, 1e-13);
    near(&tet["center_of_mass"][1], 0.2, 1e-13);
    let both = dir.stdout(&[
        "stand", "cube.off", "next.off", "--target", "1,_,_", "--json",
    ]);
    let both: Value = serde_json::from_str(&both).expect("JSON");
    near(&both["center_of_mass"][0], 1.0, 1e-13);
    near(&both["native"]["center_of_mass"][0], 1.5, 1e-13);
}
