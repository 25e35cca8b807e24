//! The command `chebloyd integrate`: monomials over surfaces, solids and polygons with holes.

use std::path::Path;

use serde_json::{Value, json};

use crate::test_dir::{TestDir, assert_all_in};

/// [0,4]² × [0,2] without [1,2]² × [0,2], its floor and ceiling squares with a hole.
fn block_with_tunnel() -> String {
    let level = |low: f64, high: f64, z: f64| {
        [
            [low, low, z],
            [high, low, z],
            [high, high, z],
            [low, high, z],
        ]
    };
    let vertices = [
        level(0.0, 4.0, 0.0),
        level(0.0, 4.0, 2.0),
        level(1.0, 2.0, 0.0),
        level(1.0, 2.0, 2.0),
    ];
    let mut faces = vec![
        json!([[3, 2, 1, 0], [8, 9, 10, 11]]),
        json!([[4, 5, 6, 7], [12, 13, 14, 15]]),
    ];
    for i in 0..4 {
        let j = (i + 1) % 4;
        faces.push(json!([[i, j, j + 4, i + 4]]));
        faces.push(json!([8 + j, 8 + i, 12 + i, 12 + j]));
    }
    json!({ "vertices": vertices.concat(), "faces": faces }).to_string()
}

fn root(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    path.to_string_lossy().into_owned()
}

fn integrals(dir: &TestDir, arguments: &[&str]) -> Value {
    let arguments = [&["integrate", "--json"], arguments].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn near(value: &Value, expected: f64) {
    let got = value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is not {expected}"));
    let scale = expected.abs().max(1.0);
    assert!(
        (got - expected).abs() <= 1e-14 * scale,
        "{got} is not {expected}"
    );
}

fn all_near(values: &Value, expected: &[f64]) {
    for (at, expected) in expected.iter().enumerate() {
        near(&values[at], *expected);
    }
}

#[test]
fn the_polyhedra_of_mirtichs_table_1_have_its_integrals() {
    let dir = TestDir::new();
    let names = [
        "T1", "Tx", "Ty", "Tz", "Txx", "Tyy", "Tzz", "Txy", "Tyz", "Tzx",
    ];
    let fifth = 20.0_f64.powi(5) / 12.0;
    for (file, expected) in [
        (
            "scenes/mirtich-cube.volint",
            [8000.0, 0.0, 0.0, 0.0, fifth, fifth, fifth, 0.0, 0.0, 0.0],
        ),
        (
            "scenes/mirtich-tetrahedron.volint",
            [10.0, 12.5, 10.0, 7.5, 25.0, 16.0, 9.0, 10.0, 6.0, 7.5],
        ),
    ] {
        let found = integrals(&dir, &[&root(file)]);
        for (name, expected) in names.iter().zip(expected) {
            near(&found["mirtich"][name], expected);
        }
        all_near(&found["second_moments"], &expected[4..7]);
        all_near(
            &found["products_of_inertia"],
            &[expected[8], expected[9], expected[7]],
        );
    }
    let cube = integrals(&dir, &[&root("scenes/mirtich-cube.volint")]);
    assert_eq!(
        cube["faces"].as_array().map(Vec::len),
        Some(6),
        "polygons, not triangles"
    );
    near(&cube["faces"][0]["area"], 400.0);
    all_near(&cube["faces"][0]["normal"], &[0.0, 0.0, -1.0]);
    // A file of his program has no extension.
    let text = std::fs::read(root("scenes/mirtich-tetrahedron.volint")).expect("a scene");
    dir.write("tetra", text);
    near(&integrals(&dir, &["tetra"])["volume"]["0,0,0"], 10.0);
    near(
        &serde_json::from_str::<Value>(&dir.stdout(&["mass", "tetra", "--json"])).expect("JSON")["mass"],
        10.0,
    );
}

#[test]
fn the_polygon_of_cattani_and_paoluzzi_counts_by_the_side_it_shows() {
    let dir = TestDir::new();
    let file = root("tests/cases/polygon-cattani-paoluzzi.json");
    let from_above = integrals(&dir, &[&file, "--signed", "0,0,1"]);
    near(&from_above["surface"]["0,0,0"], -325.0);
    assert!(from_above.get("volume").is_none() && from_above.get("mirtich").is_none());
    assert_eq!(from_above["moments_of"], "surface");
    let from_below = integrals(&dir, &[&file, "--signed", "0,0,-2"]);
    near(&from_below["surface"]["0,0,0"], 325.0);
    near(&integrals(&dir, &[&file])["surface"]["0,0,0"], 325.0);
    let on_edge = integrals(&dir, &[&file, "--signed", "1,0,0"]);
    near(&on_edge["surface"]["0,0,0"], 0.0);
    // The fan of their program: triangles that run either way.
    let polygon: Value =
        serde_json::from_slice(&std::fs::read(&file).expect("a case")).expect("JSON");
    let fan: Vec<[u32; 3]> = (1..7).map(|k| [0, k, k + 1]).collect();
    dir.write(
        "fan.json",
        json!({ "vertices": polygon["vertices"], "faces": fan }).to_string(),
    );
    near(
        &integrals(&dir, &["fan.json", "--signed", "0,0,1"])["surface"]["0,0,0"],
        -325.0,
    );
    let unsigned = integrals(&dir, &["fan.json"])["surface"]["0,0,0"].as_f64();
    assert!(unsigned > Some(326.0), "{unsigned:?}");
}

#[test]
fn polygons_with_holes_are_integrated_to_degree_nine() {
    let dir = TestDir::new();
    dir.write("block.json", block_with_tunnel());
    let found = integrals(
        &dir,
        &["block.json", "--monomials", "9", "--of", "x^2*y - 3*z"],
    );
    let along =
        |low: f64, high: f64, n: i32| (high.powi(n + 1) - low.powi(n + 1)) / f64::from(n + 1);
    let prism = |low, high, [a, b, c]: [i32; 3]| {
        along(low, high, a) * along(low, high, b) * along(0.0, 2.0, c)
    };
    let volume = |e| prism(0.0, 4.0, e) - prism(1.0, 2.0, e);
    let table = found["volume"].as_object().expect("an object");
    assert_eq!(table.len(), 220);
    for (name, value) in table {
        let e: Vec<i32> = name
            .split(',')
            .map(|n| n.parse().expect("a power"))
            .collect();
        let exact = volume([e[0], e[1], e[2]]);
        let got = value.as_f64().expect("a number");
        assert!(
            (got / exact - 1.0).abs() < 1e-13,
            "{name}: {got} is not {exact}"
        );
    }
    near(
        &found["surface"]["0,0,0"],
        2.0 * 15.0 + 4.0 * 8.0 + 4.0 * 2.0,
    );
    near(
        &found["of"]["volume"],
        volume([2, 1, 0]) - 3.0 * volume([0, 0, 1]),
    );
    near(&found["faces"][0]["area"], 15.0);
    all_near(&found["faces"][0]["normal"], &[0.0, 0.0, -1.0]);
    assert_eq!(found["faces"].as_array().map(Vec::len), Some(10));
    let weighed: Value =
        serde_json::from_str(&dir.stdout(&["mass", "block.json", "--json"])).expect("JSON");
    near(&weighed["volume"], 30.0);
}

#[test]
fn tetrahedra_and_quadrangles_are_integrated_too() {
    let dir = TestDir::new();
    let cube = integrals(&dir, &[&root("scenes/cube.mesh")]);
    near(&cube["volume"]["1,1,0"], 0.25);
    near(&cube["surface"]["0,0,2"], 4.0 / 3.0 + 1.0);
    dir.write(
        "open.off",
        "OFF\n4 1 0\n0 0 0\n2 0 0\n2 2 0\n0 2 0.5\n4 0 1 2 3\n",
    );
    let bent = integrals(&dir, &["open.off"]);
    let notes = bent["notes"].to_string();
    assert_all_in(
        &notes,
        &["not closed: 4 boundary edges", "not planar: 1 of the faces"],
    );
    let table = dir.stdout(&["integrate", "open.off", "--monomials", "1"]);
    assert_all_in(
        &table,
        &["integral of", "surface", "first moments", "face", "note: "],
    );
    assert!(!table.contains("over the volume"), "{table}");
}

#[test]
fn what_cannot_be_integrated_is_refused_with_the_mend() {
    let dir = TestDir::new();
    let square = "[[0,0],[4,0],[4,4],[0,4],[5,5],[6,5],[6,6]]";
    let polygons = |faces: &str| format!("{{\"vertices\": {square}, \"faces\": {faces}}}");
    dir.write("outside.json", polygons("[[[0,1,2,3],[4,5,6]]]"))
        .write("short.json", polygons("[[[0,1]]]"))
        .write("range.json", polygons("[[[0,1,9]]]"))
        .write("words.json", "{\"vertices\": [[0,0,0]],\n \"facets\": []}")
        .write("scalar.json", "{\"vertices\": [[0]], \"faces\": []}")
        .write("good.json", polygons("[[[0,1,2,3]]]"))
        .write(
            "cut.volint",
            "4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n4\n3 0 2 1\n3 0 1",
        );
    for (arguments, parts) in [
        (
            &["outside.json"][..],
            &["outside.json", "hole 1 of face 0", "outer loop first"][..],
        ),
        (
            &["short.json"],
            &["loops of at least 3 vertices", "2 at face 0"],
        ),
        (&["range.json"], &["vertex 9 is out of range"]),
        (&["words.json"], &["words.json:2", "facets"]),
        (
            &["scalar.json"],
            &["two or three coordinates", "1 at vertex 0"],
        ),
        (&["cut.volint"], &["cut.volint", "truncated"]),
        (&["none.off"], &["none.off"]),
        (
            &["good.json", "--of", "x^"],
            &["--of", "`x^` is not a polynomial"],
        ),
        (
            &["good.json", "--signed", "0,0,0"],
            &["a direction has a length"],
        ),
        (&["good.json", "--signed", "1,2"], &["three numbers"]),
        (
            &["good.json", "--monomials", "17"],
            &["--monomials", "0..=16"],
        ),
    ] {
        let message = dir.refusal(&[&["integrate"], arguments].concat());
        assert_all_in(&message, parts);
    }
}
