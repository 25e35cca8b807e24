//! Solids whose parts touch, overlap or cross, thin solids, and parts given twice.

use std::path::Path;

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

fn case(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    folder.join(name).display().to_string()
}

fn mass(dir: &TestDir, files: &[&str]) -> Value {
    let arguments = [&["mass", "--json"], files].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn notes(report: &Value) -> String {
    let notes = report["notes"].as_array().into_iter().flatten();
    notes
        .filter_map(Value::as_str)
        .collect::<Vec<_>>()
        .join("\n")
}

fn near(value: &Value, expected: f64, relative: f64) {
    let got = value.as_f64().expect("a number");
    let error = (got - expected).abs();
    assert!(
        error <= relative * expected.abs(),
        "{got} is not {expected}"
    );
}

/// File, volume, words of the notes; none where there are no words.
const CASES: [(&str, f64, &[&str]); 12] = [
    ("cavity-tetrahedron-touches-corners.off", 16.0 / 3.0, &[]),
    ("cavity-flush-with-bottom.off", 7.0, &[]),
    ("shell-with-core-own-nodes.off", 27.0, &[]),
    (
        "overlap-two-boxes-shifted-along-axis.off",
        2.0,
        &["overlap", "a volume of 0.5 around (0."],
    ),
    (
        "overlap-same-box-twice.off",
        2.0,
        &["overlap", "a volume of 1 around (0."],
    ),
    (
        "overlap-peg-in-u-bracket.off",
        7.21,
        &["overlap", "a volume of 0.13 around ("],
    ),
    (
        "nested-box-outward.off",
        9.0,
        &["overlap", "a volume of 1 around ("],
    ),
    (
        "voxels-12-welded-with-walls.off",
        12.0,
        &["64 triangles that lie on each other"],
    ),
    (
        "voxels-7-welded-with-walls.off",
        7.0,
        &["28 triangles that lie on each other"],
    ),
    (
        "two-lenses-share-rim.off",
        8.0 / 3.0,
        &["4 edges belong to more than two triangles"],
    ),
    (
        "stl-cube-with-1e-17-for-0.stl",
        1.0,
        &["7 vertices up to 1.73205e-17 apart were merged"],
    ),
    (
        "vtu-same-tetrahedron-in-two-pieces.vtu",
        1.0 / 6.0,
        &["1 duplicate"],
    ),
];

#[test]
fn touching_and_overlapping_parts_have_their_volumes_and_notes() {
    let dir = TestDir::new();
    for (name, volume, words) in CASES {
        let report = mass(&dir, &[&case(name)]);
        near(&report["volume"], volume, 1e-15);
        assert_all_in(&notes(&report), words);
        assert_eq!(notes(&report).is_empty(), words.is_empty(), "{name}");
    }
}

fn scene(dir: &TestDir, file: &str, sites: &str) {
    let domain = format!(r#"{{"surface": {file:?}}}"#);
    let text = format!(r#"{{"domain": {domain}, "sites": {sites}}}"#);
    dir.write("scene.json", text);
}

#[test]
fn overlapping_parts_are_refused_with_one_site_and_with_many() {
    let dir = TestDir::new();
    for name in [
        "overlap-two-boxes-shifted-along-axis.off",
        "overlap-same-box-twice.off",
        "overlap-peg-in-u-bracket.off",
        "nested-box-outward.off",
    ] {
        for sites in [
            r#"{"list": [[0.4, 0.4, 0.4]]}"#,
            r#"{"random": {"count": 20}}"#,
        ] {
            scene(&dir, &case(name), sites);
            for command in ["relax", "measure"] {
                let message = dir.refusal(&[command, "scene.json"]);
                assert_all_in(
                    &message,
                    &[name, "more than once", "around (", "Boolean union"],
                );
            }
        }
    }
}

#[test]
fn cells_fill_solids_whose_parts_touch() {
    let dir = TestDir::new();
    for (name, volume) in [
        ("cavity-tetrahedron-touches-corners.off", 16.0 / 3.0),
        ("cavity-flush-with-bottom.off", 7.0),
        ("voxels-7-welded-with-walls.off", 7.0),
        ("two-lenses-share-rim.off", 8.0 / 3.0),
        ("stl-cube-with-1e-17-for-0.stl", 1.0),
        ("vtu-same-tetrahedron-in-two-pieces.vtu", 1.0 / 6.0),
    ] {
        scene(&dir, &case(name), r#"{"random": {"count": 15}}"#);
        let output = dir.run(&["measure", "scene.json"]);
        let measured: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        near(&measured["domain_volume"], volume, 1e-14);
        near(&measured["volume_sum"], volume, 1e-10);
    }
}

#[test]
fn thin_diagonal_rods_keep_their_digits() {
    let dir = TestDir::new();
    let thick = mass(&dir, &[&case("diagonal-rod-1e-04.off")]);
    near(&thick["volume"], 1.000_000_000_000_092_8e-8, 1e-15);
    near(&thick["mass"], 1.000_000_000_000_092_8e-8, 1e-15);
    let thin = mass(&dir, &[&case("diagonal-rod-1e-08.off")]);
    near(&thin["volume"], 1.000_000_002_481_098_9e-16, 1e-15);
    near(&thin["mass"], 1.000_000_002_481_098_9e-16, 1e-15);
    for (report, width) in [(&thick, 1e-4), (&thin, 1e-8)] {
        // A rod of length 1: half of it is the center, m/12 the moment across.
        let middle = 0.5 / 3.0_f64.sqrt();
        for axis in 0..3 {
            near(&report["center_of_mass"][axis], middle, 4.0 * width);
        }
        let across = report["mass"].as_f64().expect("a number") / 12.0;
        near(&report["principal_moments"][1], across, 2.0 * width);
        near(&report["principal_moments"][2], across, 2.0 * width);
    }
    let dense = [&case("diagonal-rod-1e-08.off"), "--density", "3*x^0"];
    near(
        &mass(&dir, &dense)["mass"],
        3.000_000_007_443_296_7e-16,
        1e-14,
    );
}

#[test]
fn a_slow_rod_is_weighed_at_once() {
    let dir = TestDir::new();
    let report = mass(&dir, &[&case("slow-diagonal-rod-500-triangles.off")]);
    assert_eq!(notes(&report), "");
}

/// A box as OFF quads.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> String {
    let mut text = "OFF\n8 6 0\n".to_owned();
    for bits in 0..8 {
        let corner = [0, 1, 2].map(|k| if bits >> k & 1 == 0 { low[k] } else { high[k] });
        text += &format!("{} {} {}\n", corner[0], corner[1], corner[2]);
    }
    text + "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n"
}

#[test]
fn files_that_are_one_mesh_or_overlap_are_told() {
    let dir = TestDir::new();
    let nodes = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n";
    dir.write("one.off", cuboid([0.0; 3], [1.0; 3]))
        .write("copy.off", cuboid([0.0; 3], [1.0; 3]))
        .write("beside.off", cuboid([1.0, 0.0, 0.0], [2.0, 1.0, 1.0]))
        .write("shifted.off", cuboid([0.25, 0.0, 0.0], [1.25, 1.0, 1.0]))
        .write("t.node", nodes)
        .write("t.ele", "1 4 0\n0 0 1 2 3\n");
    let pair = mass(&dir, &["t.node", "t.ele"]);
    near(&pair["volume"], 1.0 / 6.0, 1e-15);
    assert_all_in(&notes(&pair), &["t.node and t.ele are one mesh"]);
    for twice in [["one.off", "./one.off"], ["t.ele", "t.ele"]] {
        let message = dir.refusal(&["mass", twice[0], twice[1]]);
        assert_all_in(&message, &["same file", "twice", "once"]);
    }
    let copies = mass(&dir, &["one.off", "copy.off"]);
    near(&copies["volume"], 2.0, 1e-15);
    assert_all_in(
        &notes(&copies),
        &["one.off and copy.off overlap: a volume of 1 around (0."],
    );
    assert_eq!(notes(&mass(&dir, &["one.off", "beside.off"])), "");
    let three = mass(&dir, &["one.off", "beside.off", "shifted.off"]);
    assert_all_in(
        &notes(&three),
        &["shifted.off overlap: a volume of 1 around ("],
    );
}

/// Prisms over polygons of the plane z = 0, by their loops and their corners: bottom, top and sides.
fn prism(corners: &[[f64; 2]], ring: &[usize]) -> String {
    let count = corners.len();
    let mut text = format!("OFF\n{} {} 0\n", 2 * count, ring.len() + 2);
    for z in [0, 1] {
        for [x, y] in corners {
            text += &format!("{x} {y} {z}\n");
        }
    }
    let list = |ring: Vec<usize>| {
        let words: Vec<String> = ring.iter().map(usize::to_string).collect();
        format!("{} {}\n", words.len(), words.join(" "))
    };
    text += &list(ring.iter().rev().copied().collect());
    text += &list(ring.iter().map(|corner| corner + count).collect());
    for (k, &from) in ring.iter().enumerate() {
        let to = ring[(k + 1) % ring.len()];
        text += &list(vec![from, to, to + count, from + count]);
    }
    text
}

#[test]
fn polygons_that_run_twice_around_count_twice_with_a_note() {
    let dir = TestDir::new();
    let corner = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / 5.0).sin_cos();
        [cos, sin]
    };
    let pentagon: Vec<[f64; 2]> = (0..5).map(corner).collect();
    dir.write("star.off", prism(&pentagon, &[0, 2, 4, 1, 3]));
    let star = mass(&dir, &["star.off"]);
    // The inner pentagon, smaller by the golden ratio squared, is wound twice.
    let area = 2.5 * (std::f64::consts::TAU / 5.0).sin();
    let inner = area * ((3.0 - 5.0_f64.sqrt()) / 2.0).powi(2);
    let found = notes(&star);
    let volume = found
        .split("a volume of ")
        .nth(1)
        .and_then(|text| text.split(' ').next());
    let volume: f64 = volume.expect("a note").parse().expect("a number");
    assert!((volume - inner).abs() < 1e-5, "{found}");
    // Signed area of the star: half the sum of its corners' determinants.
    let twice: f64 = 2.5 * (2.0 * std::f64::consts::TAU / 5.0).sin();
    near(&star["volume"], twice, 1e-14);
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    dir.write("twice.off", prism(&square, &[0, 1, 2, 3, 0, 1, 2, 3]));
    let report = mass(&dir, &["twice.off"]);
    assert_ne!(notes(&report), "");
    let volume = report["volume"].as_f64().expect("a number");
    let told = notes(&report).contains("a volume of 1 around");
    assert!(
        (volume - if told { 2.0 } else { 1.0 }).abs() < 1e-14,
        "{report}"
    );
    // One of six faces runs around twice: right, or refused.
    let once = prism(&square, &[0, 1, 2, 3]).replace("\n4 3 2 1 0\n", "\n8 3 2 1 0 3 2 1 0\n");
    dir.write("face.off", once);
    let output = dir.run(&["mass", "--json", "face.off"]);
    if output.status.success() {
        let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        near(&report["volume"], 1.0, 1e-14);
    }
}
