//! Every scene of the repository loads, runs and ends better than it began.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// So many moves show that a scene works.
const ITERATIONS: &str = "2";

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

fn scenes() -> Vec<PathBuf> {
    let entries = fs::read_dir(folder()).expect("scenes/ is there");
    let paths = entries.map(|entry| entry.expect("an entry").path());
    let mut scenes: Vec<PathBuf> = paths
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "json")
        })
        .collect();
    scenes.sort();
    assert!(scenes.len() >= 8, "{scenes:?}");
    scenes
}

#[test]
fn every_scene_runs_and_its_energy_falls() {
    let out = tempfile::tempdir().expect("a folder for the test");
    for scene in scenes() {
        let name = scene.file_stem().expect("a name");
        let directory = out.path().join(name);
        // A density in 4096 boxes takes a second for every move of 200 sites.
        let few = ["--count", "40"];
        let is_slow = name == "graded-distance";
        let output = Command::new(env!("CARGO_BIN_EXE_chebloyd"))
            .arg("relax")
            .args(if is_slow { &few[..] } else { &[] })
            .args([
                "--iterations",
                ITERATIONS,
                "--tolerance",
                "0",
                "--quiet",
                "--no-pictures",
                "--no-cells-file",
            ])
            .arg(&scene)
            .arg("--out")
            .arg(&directory)
            .output()
            .expect("the program starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name:?}: {stderr}");
        check_run(&name.to_string_lossy(), &directory);
    }
}

fn check_run(name: &str, directory: &Path) {
    let run = fs::read(directory.join("run.json")).expect("run.json");
    let run: Value = serde_json::from_slice(&run).expect("JSON");
    let number = |part: &str, key: &str| run[part][key].as_f64().expect("a number");
    assert_eq!(run["ended"], "iterations", "{name}");
    for part in ["initial", "final"] {
        let volume = number(part, "domain_volume");
        let error = (number(part, "volume_sum") / volume - 1.0).abs();
        assert!(error < 1e-12, "{name}: Σ volume is off by {error}");
        assert!(number(part, "energy_percent") >= 100.0, "{name}");
    }
    let key = "energy_mean";
    assert!(number("final", key) < number("initial", key), "{name}");
}

#[test]
fn every_scene_has_its_line_in_the_readme() {
    let readme = fs::read_to_string(folder().join("README.md")).expect("scenes/README.md");
    for scene in scenes() {
        let name = scene
            .file_name()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        assert!(readme.contains(&format!("| `{name}` |")), "{name}");
    }
}
