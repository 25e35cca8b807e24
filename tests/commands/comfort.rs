//! Comfort of the command: runs and meshes as scenes, fewer or smaller files, what is said on the way.

use std::path::Path;

use crate::test_dir::{SMALL, TestDir, assert_all_in};
use chebloyd::mesh::formats::off;
use chebloyd::mesh::shapes;
use serde_json::Value;

fn noted(dir: &TestDir, arguments: &[&str]) -> (String, String) {
    let output = dir.run(arguments);
    let [out, error] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).expect("text"));
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    (out, error)
}

/// A small run in `r` without pictures.
fn small_run(dir: &TestDir) {
    let mut relax = vec!["relax", "--out", "r", "--no-pictures"];
    relax.extend(SMALL);
    dir.stdout(&relax);
}

#[test]
fn a_scene_may_name_its_schema() {
    let dir = TestDir::new();
    dir.write("s.json", "{\"$schema\": \"https://example.org/scene.json\", \"sites\": {\"random\": {\"count\": 3}}}");
    dir.stdout(&["measure", "s.json"]);
    dir.stdout(&["relax", "s.json", "--iterations", "1", "--no-pictures"]);
    assert!(
        dir.json("relaxed/run.json")["scene"]
            .get("$schema")
            .is_none()
    );
    let schema: Value = serde_json::from_str(&dir.stdout(&["schema"])).expect("JSON");
    assert!(schema["properties"].get("$schema").is_some());
}

#[test]
fn a_run_is_a_scene() {
    let dir = TestDir::new();
    small_run(&dir);
    let run = dir.json("r/run.json");
    let (figures, note) = noted(&dir, &["measure", "r"]);
    let figures: Value = serde_json::from_str(&figures).expect("JSON");
    assert_eq!(figures["energy_percent"], run["final"]["energy_percent"]);
    assert_all_in(&note, &["note: r is a run", "sites that it left"]);
    let (figures, note) = noted(&dir, &["measure", "r/run.json"]);
    let figures: Value = serde_json::from_str(&figures).expect("JSON");
    assert_eq!(figures["energy_percent"], run["initial"]["energy_percent"]);
    assert!(
        note.contains("r/run.json is a run; its scene is taken"),
        "{note}"
    );
    let (_, note) = noted(&dir, &["fragments", "r", "-o", "f.vtu"]);
    assert!(note.contains("r is a run"), "{note}");
    // Run anew, the scene leaves the same sites.
    noted(&dir, &["relax", "r/run.json", "--out", "again"]);
    assert_eq!(dir.read("again/sites.csv"), dir.read("r/sites.csv"));
    std::fs::create_dir(dir.path("empty")).expect("a folder");
    let message = dir.refusal(&["measure", "empty"]);
    assert_all_in(&message, &["empty", "holds no run", "relax --out"]);
    // A run.json with a wrong key names the place in it.
    let text = String::from_utf8(dir.read("r/run.json")).expect("text");
    dir.write("wrong.json", text.replace("\"norm\"", "\"nrom\""));
    assert_all_in(
        &dir.refusal(&["measure", "wrong.json"]),
        &["wrong.json, line", "did you mean `norm`"],
    );
}

#[test]
fn a_mesh_is_a_scene() {
    let dir = TestDir::new();
    dir.write("cube.off", off::write(&shapes::unit_cube()));
    let text = dir.stdout(&[
        "relax",
        "cube.off",
        "--count",
        "10",
        "--iterations",
        "1",
        "--no-pictures",
        "--json",
    ]);
    let run: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        (&run["sites"], &run["ended"]),
        (&10.into(), &"iterations".into())
    );
    assert_eq!(run, dir.json("relaxed/run.json"));
    let file = run["scene"]["domain"]["surface"].as_str().expect("a file");
    assert!(Path::new(file).ends_with("cube.off"));
    dir.write("part.step", "ISO-10303-21;\n");
    assert_all_in(
        &dir.refusal(&["relax", "part.step", "--out", "o"]),
        &["a STEP file", "export"],
    );
}

#[test]
fn files_are_left_out_or_compressed_on_request() {
    let dir = TestDir::new();
    small_run(&dir);
    let exists = |name: &str| dir.path(name).exists();
    assert!(exists("r/cells.vtu") && exists("r/sites.csv"));
    for picture in ["cells.png", "cells.svg", "convergence.svg"] {
        assert!(!exists(&format!("r/{picture}")), "{picture}");
    }
    let mut relax = vec!["relax", "--out", "n", "--no-cells-file", "--no-pictures"];
    relax.extend(SMALL);
    dir.stdout(&relax);
    assert!(!exists("n/cells.vtu") && exists("n/run.json"));
    let mut relax = vec!["relax", "--out", "z", "--compress", "--no-pictures"];
    relax.extend(SMALL);
    dir.stdout(&relax);
    assert_eq!(dir.json("z/run.json")["scene"]["output"]["compress"], true);
    let [raw, packed] = ["r", "z"].map(|run| dir.read(&format!("{run}/cells.vtu")));
    assert!(
        2 * packed.len() < raw.len(),
        "{} of {}",
        packed.len(),
        raw.len()
    );
    assert_all_in(
        &String::from_utf8_lossy(&packed[..300]),
        &["vtkZLibDataCompressor"],
    );
    assert_eq!(arrays(&packed, true), arrays(&raw, false));
    dir.write("s.json", "{\"sites\": {\"random\": {\"count\": 5}}, \"output\": {\"cells_file\": false, \"pictures\": false}}");
    dir.stdout(&["relax", "s.json", "--iterations", "1", "--out", "k"]);
    assert!(!exists("k/cells.vtu") && !exists("k/cells.png"));
}

/// The arrays of a VTU file by their place, unpacked.
fn arrays(file: &[u8], is_packed: bool) -> Vec<Vec<u8>> {
    use std::io::Read as _;
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = file
        .windows(mark.len())
        .position(|w| w == mark)
        .expect("data")
        + mark.len();
    let head = String::from_utf8_lossy(&file[..start]).into_owned();
    let number =
        |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().expect("8 bytes")) as usize;
    let offsets = head.split(" offset=\"").skip(1);
    let offsets = offsets.map(|rest| {
        rest.split('"')
            .next()
            .expect("a quote")
            .parse::<usize>()
            .expect("a number")
    });
    offsets
        .map(|offset| {
            let at = start + offset;
            if !is_packed {
                return file[at + 8..at + 8 + number(at)].to_vec();
            }
            let mut data = Vec::new();
            let mut block = at + 8 * (3 + number(at));
            for k in 0..number(at) {
                let size = number(at + 8 * (3 + k));
                let mut decoder = flate2::read::ZlibDecoder::new(&file[block..block + size]);
                decoder.read_to_end(&mut data).expect("zlib");
                block += size;
            }
            data
        })
        .collect()
}

#[test]
fn verbose_tells_phases_with_seconds() {
    let dir = TestDir::new();
    let mut relax = vec!["relax", "-v", "--no-pictures"];
    relax.extend(SMALL);
    let (_, told) = noted(&dir, &relax);
    for phase in [
        "measured the cells of the first sites in ",
        "relaxed in ",
        "wrote sites",
    ] {
        assert!(told.contains(phase), "{told}");
    }
    assert!(told.lines().all(|line| line.ends_with(" s")), "{told}");
    let output = dir.run(&["relax", "-v", "-q"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn signs_follow_operators_in_densities() {
    let dir = TestDir::new();
    dir.write("cube.off", off::write(&shapes::unit_cube()));
    let mass = |density: &str| {
        let text = dir.stdout(&["mass", "cube.off", "--density", density, "--json"]);
        let object: Value = serde_json::from_str(&text).expect("JSON");
        object["mass"].as_f64().expect("a number")
    };
    assert!((mass("5+-0.1*x") - 4.95).abs() < 1e-14);
    assert!((mass("5--0.1*x") - 5.05).abs() < 1e-14);
    dir.write(
        "s.json",
        "{\"sites\": {\"random\": {\"count\": 3}}, \"density\": \"1 + wurst(x)\"}",
    );
    let message = dir.refusal(&["measure", "s.json"]);
    assert_all_in(
        &message,
        &["density", "column 5", "`wurst`", "one of the functions"],
    );
}

#[test]
fn wide_gaps_are_closed_on_request() {
    let dir = TestDir::new();
    let cube = shapes::unit_cube();
    let mut soup = chebloyd::mesh::surface::SurfaceMesh::default();
    for (number, corners) in cube.all_corners().enumerate() {
        let first = soup.vertices.len() as u32;
        let shift = 1e-6 * (number % 2) as f64;
        soup.vertices.extend(corners.map(|p| p.map(|x| x + shift)));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    dir.write("soup.off", off::write(&soup));
    let message = dir.refusal(&["mass", "soup.off"]);
    assert_all_in(&message, &["not closed", "--weld"]);
    let text = dir.stdout(&["mass", "soup.off", "--weld", "1e-5", "--json"]);
    assert_all_in(&text, &["28 vertices up to 1.73205e-6 apart were merged"]);
    let (_, note) = noted(
        &dir,
        &[
            "relax",
            "soup.off",
            "--weld",
            "1e-5",
            "--count",
            "5",
            "--iterations",
            "1",
            "--no-pictures",
        ],
    );
    assert!(note.contains("28 vertices"), "{note}");
    assert_eq!(
        dir.json("relaxed/run.json")["scene"]["domain"]["weld"],
        1e-5
    );
    let (_, note) = noted(&dir, &["mesh", "relaxed", "-o", "m", "--json"]);
    assert!(note.contains("28 vertices"), "{note}");
    assert_all_in(
        &dir.refusal(&["measure", "--weld", "1"]),
        &["--weld is for meshes"],
    );
}

#[test]
fn a_mesh_is_weighed_from_standard_input() {
    use std::io::Write as _;
    let dir = TestDir::new();
    let mut child = dir
        .command(&["mass", "-", "--json"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let text = off::write(&shapes::unit_cube());
    child
        .stdin
        .take()
        .expect("a pipe")
        .write_all(text.as_bytes())
        .expect("a reader");
    let output = child.wait_with_output().expect("it ends");
    let object: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(object["volume"], 1.0);
}
