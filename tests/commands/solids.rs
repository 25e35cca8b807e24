//! Solids on the command line: accepted files and error messages.

use std::path::Path;

use crate::models::shared_model;
use crate::test_dir::{TestDir, assert_all_in};
use serde_json::Value;

const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

const TRIANGLES: [[usize; 3]; 12] = [
    [0, 3, 2],
    [0, 2, 1],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

type Triangles = [[usize; 3]];

fn off(corners: &[[f64; 3]], triangles: &Triangles) -> String {
    let mut text = format!("OFF\n{} {} 0\n", corners.len(), triangles.len());
    for [x, y, z] in corners {
        text += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

fn cube() -> String {
    off(&CORNERS, &TRIANGLES)
}

/// A dir with a mesh file and a scene of a few sites within it.
fn desk_with(name: &str, mesh: impl AsRef<[u8]>) -> TestDir {
    let dir = TestDir::new();
    dir.write(name, mesh);
    scene(&dir, &format!(r#"{{"surface": "{name}"}}"#), "");
    dir
}

fn scene(dir: &TestDir, domain: &str, more: &str) {
    let text = format!(
        r#"{{"domain": {domain}, "sites": {{"random": {{"count": 20, "seed": 1}}}},
            "method": {{"lloyd": {{"iterations": 3}}}},
            "output": {{"cells": false, "plot": false}}{more}}}"#
    );
    dir.write("scene.json", text);
}

/// The error of both commands that read a solid.
fn refusal(dir: &TestDir) -> String {
    let message = dir.refusal(&["relax", "scene.json", "--out", "run"]);
    assert_eq!(message, dir.refusal(&["measure", "scene.json"]));
    assert!(
        message.lines().count() <= 2 && message.len() < 400,
        "{message}"
    );
    message
}

/// Σ volumes over the domain's volume after a run, which must have lowered the energy.
fn filled(dir: &TestDir) -> f64 {
    let output = dir.run(&["relax", "scene.json", "--out", "run", "-q"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{message}");
    let records = dir.records("run");
    let energy = |k: usize| records[k]["energy_mean"].as_f64().expect("a number");
    assert!(energy(records.len() - 1) < energy(0));
    let last = dir.json("run/run.json")["final"].clone();
    let number = |key: &str| last[key].as_f64().expect("a number");
    number("volume_sum") / number("domain_volume")
}

#[test]
fn open_surfaces_are_refused_with_their_edges_counted() {
    let dir = desk_with("open.off", off(&CORNERS, &TRIANGLES[..11]));
    let message = refusal(&dir);
    assert_all_in(
        &message,
        &["open.off", "3 boundary edges", "triangle 10", "close it"],
    );
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not message"]
fn the_open_model_is_refused_with_its_edges_counted() {
    let shark = shared_model("open-shark.off");
    let dir = desk_with("unused.off", cube());
    scene(&dir, &format!(r#"{{"surface": {shark:?}}}"#), "");
    assert_all_in(
        &refusal(&dir),
        &["open-shark.off", "304 boundary edges", "close it"],
    );
}

#[test]
fn damaged_files_are_refused_with_the_line_and_the_mend() {
    let nan = cube().replacen("1 1 0", "nan 1 0", 1);
    let cut = cube()[..40].to_owned();
    let stranger = cube().replace("3 3 4 7", "3 3 4 70");
    let flat = CORNERS.map(|[x, y, _]| [x, y, 0.0]);
    let cases: [(&str, String, &[&str]); 5] = [
        ("nan.off", nan, &["nan.off:5", "`nan`", "must be finite"]),
        (
            "empty.off",
            String::new(),
            &["empty.off", "the file is empty", "export"],
        ),
        (
            "cut.off",
            cut,
            &["cut.off:7", "truncated", "export it again"],
        ),
        (
            "stranger.off",
            stranger,
            &["stranger.off:22", "vertex 70", "numbered from 0"],
        ),
        (
            "flat.off",
            off(&flat, &TRIANGLES),
            &["flat.off", "no volume", "thickness"],
        ),
    ];
    for (name, mesh, words) in cases {
        assert_all_in(&refusal(&desk_with(name, mesh)), words);
    }
    let dir = TestDir::new();
    scene(&dir, r#"{"surface": "nowhere.off"}"#, "");
    assert_all_in(&refusal(&dir), &["nowhere.off", "check the path"]);
}

#[test]
fn what_needs_no_guess_is_repaired_and_told() {
    let mut flipped = TRIANGLES;
    flipped[3].swap(1, 2);
    let mut doubled = TRIANGLES.to_vec();
    doubled.push(TRIANGLES[0]);
    let inverted = TRIANGLES.map(|[a, b, c]| [a, c, b]);
    let cases: [(&str, &Triangles, &[&str]); 3] = [
        (
            "flipped.off",
            &flipped,
            &["note", "1 triangle", "turned", "element 3"],
        ),
        (
            "doubled.off",
            &doubled,
            &["note", "1 duplicate", "dropped", "element 12"],
        ),
        (
            "inverted.off",
            &inverted,
            &["note", "1 component", "turned inside out"],
        ),
    ];
    for (name, triangles, words) in cases {
        let dir = desk_with(name, off(&CORNERS, triangles));
        let output = dir.run(&["relax", "scene.json", "--out", "run"]);
        let message = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(0), "{message}");
        assert_all_in(&message, words);
        let run = dir.json("run/run.json");
        assert_eq!(run["domain_volume"], 1.0, "{name}");
    }
}

#[test]
fn surfaces_that_cross_themselves_are_refused() {
    for shift in [[0.5, 0.5, 0.5], [0.3, 0.2, 0.1]] {
        let mut corners = CORNERS.to_vec();
        corners.extend(CORNERS.map(|corner| [0, 1, 2].map(|axis| corner[axis] + shift[axis])));
        let mut triangles = TRIANGLES.to_vec();
        triangles.extend(TRIANGLES.map(|triangle| triangle.map(|vertex| vertex + 8)));
        let dir = desk_with("two.off", off(&corners, &triangles));
        assert_all_in(
            &refusal(&dir),
            &["two.off", "crosses itself", "Boolean union"],
        );
    }
}

#[test]
fn thin_solids_and_single_tetrahedra_are_relaxed() {
    let thin = CORNERS.map(|[x, y, z]| [x, y, 1e-3 * z]);
    let dir = desk_with("thin.off", off(&thin, &TRIANGLES));
    assert!((filled(&dir) - 1.0).abs() < 1e-11);
    let single = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n\
                  0 0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n";
    for form in ["tets", "surface"] {
        let dir = desk_with("single.mesh", single);
        scene(&dir, &format!(r#"{{"{form}": "single.mesh"}}"#), "");
        assert!((filled(&dir) - 1.0).abs() < 1e-11);
    }
    let dir = desk_with("cube.off", cube());
    scene(&dir, r#"{"tets": "cube.off"}"#, "");
    assert_all_in(&refusal(&dir), &["cube.off", "no tetrahedra", "surface"]);
}

#[test]
fn solids_are_scaled_into_boxes() {
    let dir = desk_with("cube.off", cube());
    for (target, volume) in [
        (r#""unit_cube""#, 1.0),
        ("2.5", 15.625),
        (r#"{"min": [0, 0, 0], "max": [4, 2, 3]}"#, 8.0),
    ] {
        scene(
            &dir,
            &format!(r#"{{"surface": "cube.off", "scale_to": {target}}}"#),
            "",
        );
        let text = dir.stdout(&["measure", "scene.json"]);
        let measured: Value = serde_json::from_str(&text).expect("JSON");
        let found = measured["domain_volume"].as_f64().expect("a number");
        assert!((found / volume - 1.0).abs() < 1e-12, "{target}: {found}");
    }
    let cases: [(&str, &[&str]); 5] = [
        ("0", &["scale_to", "side 0", "positive"]),
        ("-1", &["scale_to", "side -1", "positive"]),
        (r#""big""#, &["scale_to", "unit_cube"]),
        (
            r#"{"min": [0, 0, 0], "max": [1, 2]}"#,
            &["scale_to.max", "3 are needed"],
        ),
        (
            r#"{"min": [0, 0, 0], "max": [1, 0, 1]}"#,
            &["scale_to", "no volume"],
        ),
    ];
    for (target, words) in cases {
        scene(
            &dir,
            &format!(r#"{{"surface": "cube.off", "scale_to": {target}}}"#),
            "",
        );
        assert_all_in(&refusal(&dir), words);
    }
}

#[test]
fn sites_outside_a_solid_are_named_or_dropped() {
    let dir = desk_with("cube.off", cube());
    let text = r#"{"domain": {"surface": "cube.off"}, "sites": {"file": "p.csv"}}"#;
    dir.write("scene.json", text);
    dir.write("p.csv", "0.5,0.5,0.5\n2,2,2\n0,0.5,0.5\n3,3,3\n");
    assert_all_in(
        &refusal(&dir),
        &["site 1 (2.0, 2.0, 2.0)", "1 more", "--drop-outside"],
    );
    let output = dir.run(&["measure", "scene.json", "--drop-outside"]);
    let note = String::from_utf8_lossy(&output.stderr);
    assert_all_in(&note, &["note: 2 of 4 sites lie outside"]);
    let measured: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(measured["sites"], 2);
    assert_eq!(measured["volume_sum"], 1.0);
    dir.write("p.csv", "2,2,2\n");
    let message = dir.refusal(&["measure", "scene.json", "--drop-outside"]);
    assert_all_in(&message, &["all sites lie outside the domain"]);
}

/// A cube turned by asin 0.6: along its own axes 27 sites have cubes for cells.
#[test]
fn lattices_lie_along_the_one_frame_of_all_cells() {
    let dir = TestDir::new();
    let turned = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let corners = CORNERS.map(|corner| {
        [0, 1, 2].map(|axis| (0..3).map(|side| corner[side] * turned[side][axis]).sum())
    });
    dir.write("cube.off", off(&corners, &TRIANGLES));
    let degrees = 0.6_f64.asin().to_degrees();
    let more = format!(
        r#""frames": {{"axis": [0, 0, 1], "degrees": {degrees}}},
           "sites": {{"random": {{"count": 27, "seed": 1, "lattice": true}}}}"#
    );
    let domain = r#"{"surface": "cube.off"}"#;
    dir.write(
        "scene.json",
        format!(r#"{{"domain": {domain}, {more}, "method": {{"lloyd": {{"iterations": 1}}}}}}"#),
    );
    let (percent, _) = relaxed(&dir, &[]);
    assert!((percent[0] - 100.0).abs() < 1e-9, "{percent:?}");
}

#[test]
fn grids_are_cropped_to_the_solid() {
    let dir = TestDir::new();
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bracket.off");
    for jitter in [0.0, 0.5, 1.0] {
        let text = format!(
            r#"{{"domain": {{"surface": {here:?}}},
                "sites": {{"grid": {{"counts": [8, 8, 8], "jitter": {jitter}, "seed": 1}}}},
                "method": {{"lloyd": {{"iterations": 3}}}}}}"#
        );
        dir.write("scene.json", text);
        let output = dir.run(&["relax", "scene.json", "--out", "run", "--force", "-q"]);
        assert_eq!(output.status.code(), Some(0));
        let last = dir.json("run/run.json")["final"].clone();
        let count = last["sites"].as_u64().expect("a number");
        assert!((150..350).contains(&count), "{count} of 512");
        let number = |key: &str| last[key].as_f64().expect("a number");
        assert!((number("volume_sum") / number("domain_volume") - 1.0).abs() < 1e-11);
    }
}

#[test]
fn densities_of_solids_are_accepted_or_refused_clearly() {
    let dir = desk_with("cube.off", cube());
    let surface = r#"{"surface": "cube.off"}"#;
    for density in [r#""1 + x""#, r#"{"size": "0.1 + 0.1*x"}"#] {
        scene(&dir, surface, &format!(r#", "density": {density}"#));
        dir.stdout(&["measure", "scene.json"]);
    }
    let cases: [(&str, &[&str]); 5] = [
        (r#"{"data": "heat"}"#, &["density", "tets", "size"]),
        (r#""x - 0.5""#, &["density", "-0.5", "positive"]),
        (r#"{"size": "x"}"#, &["size", "0", "positive"]),
        (r#"{"size": "(x - 0.3)^2"}"#, &["size", "farther from zero"]),
        (r#"{"size": "1 + x^9"}"#, &["degree 9", "8 is the highest"]),
    ];
    for (density, words) in cases {
        scene(&dir, surface, &format!(r#", "density": {density}"#));
        assert_all_in(&refusal(&dir), words);
    }
}

#[test]
fn every_method_keeps_sites_in_solids_with_holes_and_bends() {
    for name in ["bracket", "torus", "trefoil"] {
        let dir = TestDir::new();
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.off"));
        let domain = format!(r#"{{"surface": {file:?}}}"#);
        for (method, falls) in [
            (["--method", "lloyd"], true),
            (["--method", "quasi-newton"], true),
            (["--method", "anneal"], false),
            (["--goal", "cubes"], false),
        ] {
            scene(&dir, &domain, "");
            let mut arguments = vec!["relax", "scene.json", "--out", "run", "--force", "-q"];
            arguments.extend(["--count", "40", "--iterations", "30"]);
            arguments.extend(method);
            dir.stdout(&arguments);
            let records = dir.records("run");
            let energy = |k: usize| records[k]["energy_mean"].as_f64().expect("a number");
            let last = records.len() - 1;
            assert!(energy(last) < energy(0), "{name} {method:?}");
            let rises = (1..=last).filter(|&k| energy(k) > energy(k - 1) * (1.0 + 1e-12));
            assert!(!falls || rises.count() == 0, "{name} {method:?}");
            // Sites outside would be refused.
            let text = format!(r#"{{"domain": {domain}, "sites": {{"file": "run/sites.csv"}}}}"#);
            dir.write("end.json", text);
            let measured = dir.stdout(&["measure", "end.json"]);
            let measured: Value = serde_json::from_str(&measured).expect("JSON");
            let number = |key: &str| measured[key].as_f64().expect("a number");
            assert!((number("volume_sum") / number("domain_volume") - 1.0).abs() < 1e-11);
        }
    }
}

#[test]
fn cells_that_the_surface_cuts_are_taken_apart_too() {
    let dir = TestDir::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/trefoil.off");
    scene(&dir, &format!(r#"{{"surface": {file:?}}}"#), "");
    for name in ["parts.png", "parts.vtu"] {
        let message = dir.stdout(&["fragments", "scene.json", "--site", "3", "-o", name]);
        assert_all_in(&message, &[name]);
    }
    let text = String::from_utf8_lossy(&dir.read("parts.vtu")).into_owned();
    assert_all_in(&text, &["NumberOfCells=\"6\"", "energy", "volume"]);
}

/// Relaxes by a method and returns the energies in percent and why the run ended.
fn relaxed(dir: &TestDir, method: &[&str]) -> (Vec<f64>, String) {
    let plain = ["relax", "scene.json", "--out", "run", "--force"];
    dir.stdout(&[&plain[..], method].concat());
    let log = String::from_utf8(dir.read("run/log.jsonl")).expect("text");
    let percent = |line: &str| {
        let record: serde_json::Value = serde_json::from_str(line).expect("a record");
        record["energy_percent"].as_f64().expect("a number")
    };
    let ended = dir.json("run/run.json")["ended"]
        .as_str()
        .map(str::to_owned);
    (log.lines().map(percent).collect(), ended.expect("an end"))
}

const EVERY_METHOD: [&[&str]; 4] = [
    &["--method", "lloyd", "--iterations", "6"],
    &["--method", "lloyd", "--accelerate", "--iterations", "6"],
    &["--method", "quasi-newton", "--iterations", "6"],
    &["--method", "anneal", "--rounds", "2", "--iterations", "12"],
];

/// The bounds of a half-space solid are rounded: a site on its extreme vertex was "outside" of them.
#[test]
fn sites_on_vertices_edges_and_facets_relax_by_every_method() {
    let dir = TestDir::new();
    dir.write("cube.off", cube());
    let octahedron = r#"{"half_spaces": [[1,1,1,1], [1,1,-1,1], [1,-1,1,1], [1,-1,-1,1],
        [-1,1,1,1], [-1,1,-1,1], [-1,-1,1,1], [-1,-1,-1,1]]}"#;
    let unit = r#"{"box": {"min": [0,0,0], "max": [1,1,1]}}"#;
    let in_cube = "[[0,0,0], [1,0.5,0], [0.5,0.5,1], [0.3,0.4,0.2], [0.6,0.7,0.4], [0.2,0.7,0.8]]";
    let in_octahedron = "[[1,0,0], [0,-1,0], [0.5,0,0.5], [0.25,0.25,0.5], [0.1,0.2,0.3], \
        [-0.2,-0.3,0.1], [0.2,-0.3,0.1]]";
    for (domain, sites) in [
        (octahedron, in_octahedron),
        (unit, in_cube),
        (r#"{"surface": "cube.off"}"#, in_cube),
    ] {
        let output = r#""output": {"cells": false, "plot": false}"#;
        let text = format!(r#"{{"domain": {domain}, "sites": {{"list": {sites}}}, {output}}}"#);
        dir.write("scene.json", text);
        for method in EVERY_METHOD {
            let (percent, _) = relaxed(&dir, method);
            let is_lower = percent[percent.len() - 1] < percent[0];
            assert!(
                is_lower && percent.len() > 6,
                "{domain} {method:?}: {percent:?}"
            );
        }
    }
}

/// A U of height 3 and depth 1 as an OFF file, its gap above [1, 2].
fn u_shape() -> String {
    let outline = [
        [0, 0],
        [3, 0],
        [3, 3],
        [2, 3],
        [2, 1],
        [1, 1],
        [1, 3],
        [0, 3],
    ];
    let corners: Vec<[f64; 3]> = (0..16)
        .map(|k| {
            [
                f64::from(outline[k % 8][0]),
                (k / 8) as f64,
                f64::from(outline[k % 8][1]),
            ]
        })
        .collect();
    let cap = [
        [5, 6, 7],
        [0, 5, 7],
        [0, 1, 5],
        [1, 4, 5],
        [1, 2, 4],
        [2, 3, 4],
    ];
    let mut triangles: Vec<[u32; 3]> = cap.to_vec();
    triangles.extend(cap.map(|[a, b, c]| [c + 8, b + 8, a + 8]));
    for i in 0..8 {
        let j = (i + 1) % 8;
        triangles.extend([[j, i, i + 8], [j, i + 8, j + 8]]);
    }
    let mut text = format!("OFF\n{} {} 0\n", corners.len(), triangles.len());
    for [x, y, z] in corners {
        text += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

/// The best place of a single site in a U is in the gap; within the solid it is the middle of the gap's
/// bottom. A step through that wall held up all others: such descents ended at once, by "tolerance".
#[test]
fn a_descent_goes_on_along_the_wall_that_it_meets() {
    let dir = TestDir::new();
    dir.write("u.off", u_shape());
    dir.write(
        "scene.json",
        r#"{"domain": {"surface": "u.off"}, "sites": {"list": [[1.2, 0.3, 0.9999999]]},
            "output": {"cells": false, "plot": false}}"#,
    );
    relaxed(&dir, &["--method", "quasi-newton", "--iterations", "60"]);
    let sites = String::from_utf8(dir.read("run/sites.csv")).expect("text");
    let site: Vec<f64> = sites
        .lines()
        .nth(1)
        .expect("a site")
        .split(',')
        .map(|x| x.parse().expect("a number"))
        .collect();
    let off: Vec<f64> = site
        .iter()
        .zip([1.5, 0.5, 1.0])
        .map(|(x, best)| (x - best).abs())
        .collect();
    assert!(off.iter().all(|off| *off < 1e-6), "{site:?}");
}

/// The solid `scenes/NAME.off` with this many random sites of seed 1, as a scene without pictures.
fn scene_of(name: &str, count: usize) -> String {
    let scenes = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
    let output = r#""output": {"cells": false, "plot": false}"#;
    let sites = format!(r#""sites": {{"random": {{"count": {count}, "seed": 1}}}}"#);
    format!(r#"{{"domain": {{"surface": "{scenes}/{name}.off"}}, {sites}, {output}}}"#)
}

/// Cells' edges cross both walls where a core fills a shell, and planes between boxes of a density touch the
/// bracket's hole: crossings in one place, in either order.
#[test]
fn walls_may_lie_on_each_other_and_touch_boxes_of_a_density() {
    let dir = TestDir::new();
    let once = ["--iterations", "1", "--no-pictures", "--no-cells-file"];
    let core = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/cases/shell-with-core-own-nodes.off"
    );
    let shell = ["relax", core, "--count", "30", "--out", "shell"];
    dir.stdout(&[&shell[..], &once].concat());
    let sized = r#"{"density": {"size": "0.06 + 0.05*x"}, "#;
    dir.write(
        "scene.json",
        scene_of("bracket", 100).replacen('{', sized, 1),
    );
    relaxed(&dir, &[&["--seed", "2"], &once[..]].concat());
}

#[test]
fn a_bracket_of_five_thousand_sites_descends_to_the_last_move() {
    let dir = TestDir::new();
    dir.write("scene.json", scene_of("bracket", 5000));
    let (percents, ended) = relaxed(&dir, &["--method", "quasi-newton", "--iterations", "15"]);
    assert_eq!(ended, "iterations");
    assert!(percents.len() == 16 && percents[15] < 103.0, "{percents:?}");
}

#[test]
fn a_trefoil_is_split_from_coarse_to_fine_without_duplicates() {
    let dir = TestDir::new();
    dir.write("scene.json", scene_of("trefoil", 500));
    relaxed(&dir, &["--coarse-to-fine", "2", "--iterations", "6"]);
    let sites = String::from_utf8(dir.read("run/sites.csv")).expect("text");
    assert_eq!(sites.lines().count(), 501);
}
