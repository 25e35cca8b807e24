//! The command line: output, files, exit codes.

use std::fs;
use std::process::Stdio;

use serde_json::Value;

use crate::test_dir::{SMALL, TestDir, assert_all_in};

#[test]
fn relax_leaves_what_the_interface_promises() {
    let dir = TestDir::new();
    let mut arguments = vec!["relax", "--out", "a/b"];
    arguments.extend(SMALL);
    let message = dir.stdout(&arguments);
    assert_all_in(&message, &["20 sites", "2 iterations", "energy", "a/b"]);

    let records = dir.records("a/b");
    assert_eq!(records.len(), 3);
    for key in [
        "iteration",
        "energy_mean",
        "energy_max",
        "energy_percent",
        "movement_mean",
        "movement_max",
        "movement_percent",
        "evaluations",
    ] {
        assert!(
            records.iter().all(|record| record[key].is_number()),
            "{key}"
        );
    }
    assert_eq!(records[0]["movement_mean"], 0.0);

    let run = dir.json("a/b/run.json");
    assert_eq!(run["program"], "chebloyd");
    assert_eq!(run["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(run["scene"]["method"]["lloyd"]["iterations"], 2);
    assert_eq!(
        run["scene"]["domain"]["box"]["max"],
        serde_json::json!([1.0, 1.0, 1.0])
    );
    assert_eq!(run["sites"], 20);
    assert_eq!(run["ended"], "iterations");
    assert_eq!(run["initial"]["energy_mean"], records[0]["energy_mean"]);
    assert_eq!(run["final"]["energy_mean"], records[2]["energy_mean"]);
    assert!(run["threads"].as_u64() >= Some(1) && run["seconds"].as_f64() >= Some(0.0));

    let sites = String::from_utf8(dir.read("a/b/sites.csv")).expect("text");
    assert_eq!(sites.lines().next(), Some("x,y,z"));
    assert_eq!(sites.lines().count(), 21);
    for name in ["cells.vtu", "cells.svg", "cells.png", "convergence.svg"] {
        assert!(!dir.read(&format!("a/b/{name}")).is_empty());
    }
}

#[test]
fn measure_prints_one_object_and_cells_in_site_order() {
    let dir = TestDir::new();
    dir.write("p.csv", "x,y,z\n0.25,0.5,0.5\n0.75,0.5,0.5\n");
    let bare: Value =
        serde_json::from_str(&dir.stdout(&["measure", "--sites", "p.csv"])).expect("JSON");
    assert_eq!(bare["sites"], 2);
    assert_eq!(bare["facet_histogram"], serde_json::json!({ "6": 2 }));
    assert!(bare.get("cells").is_none());
    let full = dir.stdout(&["measure", "--sites", "p.csv", "--per-cell"]);
    let full: Value = serde_json::from_str(&full).expect("JSON");
    let cells = full["cells"].as_array().expect("cells");
    let x: Vec<f64> = cells
        .iter()
        .filter_map(|cell| cell["centroid"][0].as_f64())
        .collect();
    assert!(
        (x[0] - 0.25).abs() < 1e-15 && (x[1] - 0.75).abs() < 1e-15,
        "{x:?}"
    );
    for key in [
        "volume",
        "energy",
        "gradient",
        "center",
        "center_energy",
        "facets",
    ] {
        assert!(cells.iter().all(|cell| !cell[key].is_null()), "{key}");
    }
}

#[test]
fn a_run_measures_as_its_last_record_says_in_both_norms() {
    for norm in ["linf", "l2"] {
        let dir = TestDir::new();
        let mut arguments = vec!["relax", "--norm", norm, "-q"];
        arguments.extend(SMALL);
        assert_eq!(dir.stdout(&arguments), "");
        let text = dir.stdout(&["measure", "--sites", "relaxed/sites.csv", "--norm", norm]);
        let measured: Value = serde_json::from_str(&text).expect("JSON");
        let last = &dir.records("relaxed")[2];
        for key in ["energy_mean", "energy_max", "energy_percent"] {
            let ratio = measured[key]
                .as_f64()
                .zip(last[key].as_f64())
                .map(|(a, b)| a / b);
            assert!(
                ratio.is_some_and(|r| (r - 1.0).abs() < 1e-14),
                "{norm} {key}"
            );
        }
        assert_eq!(measured, dir.json("relaxed/run.json")["final"]);
    }
}

#[test]
fn every_site_format_gives_the_same_tessellation() {
    let dir = TestDir::new();
    dir.write("p.csv", "x,y,z\n0.25,0.5,0.5\n0.75,0.5,0.375\n");
    dir.write("p.xyz", "# two sites\n0.25 0.5 0.5\n0.75 0.5 0.375\n");
    dir.write("p.txt", "0.25\t0.5\t0.5\n0.75\t0.5\t0.375");
    dir.write("p.json", "[[0.25, 0.5, 0.5], [0.75, 0.5, 0.375]]");
    let mut npy = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }";
    npy.extend(format!("{header:<69}\n").as_bytes());
    npy.extend(
        [0.25, 0.5, 0.5, 0.75, 0.5, 0.375]
            .iter()
            .flat_map(|x: &f64| x.to_le_bytes()),
    );
    dir.write("p.npy", npy);
    let expected = dir.stdout(&["measure", "--sites", "p.csv", "--per-cell"]);
    for file in ["p.xyz", "p.txt", "p.json", "p.npy"] {
        assert_eq!(
            dir.stdout(&["measure", "--sites", file, "--per-cell"]),
            expected,
            "{file}"
        );
    }
}

#[test]
fn a_scene_finds_its_sites_beside_it() {
    let dir = TestDir::new();
    fs::create_dir(dir.path("scenes")).expect("a folder");
    dir.write("scenes/p.csv", "0.25,0.5,0.5\n0.75,0.5,0.375\n");
    dir.write(
        "scenes/s.json",
        r#"{"sites": {"file": "p.csv"}, "method": {"lloyd": {"iterations": 1}}}"#,
    );
    dir.stdout(&["relax", "scenes/s.json"]);
    assert_eq!(dir.json("relaxed/run.json")["sites"], 2);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let dir = TestDir::new();
    for threads in ["1", "3"] {
        dir.stdout(&[
            "relax",
            "--count",
            "300",
            "--iterations",
            "3",
            "--threads",
            threads,
            "--out",
            threads,
        ]);
    }
    assert_eq!(dir.read("1/sites.csv"), dir.read("3/sites.csv"));
    assert_eq!(dir.records("1"), dir.records("3"));
    assert_eq!(dir.json("3/run.json")["threads"], 3);
}

#[test]
fn plot_draws_one_or_several_runs_as_svg_or_png() {
    let dir = TestDir::new();
    for norm in ["linf", "l2"] {
        dir.stdout(&[
            "relax",
            "--count",
            "20",
            "--iterations",
            "3",
            "--norm",
            norm,
            "--out",
            norm,
        ]);
    }
    assert_eq!(dir.stdout(&["plot", "linf/log.jsonl"]), "convergence.svg\n");
    let svg = String::from_utf8(dir.read("convergence.svg")).expect("text");
    assert_all_in(&svg, &["<svg", "movement", "energy"]);
    dir.stdout(&["plot", "linf/log.jsonl", "l2", "-o", "both.svg"]);
    let svg = String::from_utf8(dir.read("both.svg")).expect("text");
    assert_all_in(&svg, &["linf", "l2"]);
    assert_eq!(
        dir.stdout(&["plot", "linf", "l2", "-o", "both.png", "--quiet"]),
        ""
    );
    assert!(dir.read("both.png").starts_with(b"\x89PNG"));
    assert_all_in(
        &dir.refusal(&["plot", "linf", "-o", "both.pdf"]),
        &[".svg or .png"],
    );
    assert_all_in(
        &dir.refusal(&["plot", "linf"]),
        &["convergence.svg is there already", "--force", "-o"],
    );
    dir.stdout(&["plot", "linf", "--force"]);
    dir.write("bad.jsonl", "{\"iteration\": 0}\n");
    let refusal = |file| dir.refusal(&["plot", file, "-o", "new.svg"]);
    assert_all_in(&refusal("bad.jsonl"), &["bad.jsonl, line 1"]);
    dir.write("empty.jsonl", "");
    assert_all_in(&refusal("empty.jsonl"), &["no records"]);
}

#[test]
fn the_program_describes_itself() {
    let dir = TestDir::new();
    let schema: Value = serde_json::from_str(&dir.stdout(&["schema"])).expect("JSON");
    for key in [
        "dimension",
        "domain",
        "sites",
        "norm",
        "order",
        "method",
        "output",
    ] {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
    assert_eq!(schema["required"], serde_json::json!(["sites"]));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        assert_all_in(&dir.stdout(&["completions", shell]), &["chebloyd", "relax"]);
    }
    assert_all_in(&dir.stdout(&["man"]), &[".TH chebloyd 1", "relax"]);
    assert_all_in(
        &dir.stdout(&["man", "relax"]),
        &[".TH chebloyd-relax 1", "iterations"],
    );
    let version = format!("chebloyd {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(dir.stdout(&["--version"]), version);
    for command in [
        "relax",
        "measure",
        "plot",
        "report",
        "schema",
        "completions",
        "man",
    ] {
        let help = dir.stdout(&[command, "--help"]);
        assert_all_in(&help, &["Usage: chebloyd", "--threads", "--quiet"]);
        assert!(dir.stdout(&[command, "--version"]).ends_with(&version[8..]));
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_leaves_is_no_error() {
    let dir = TestDir::new();
    let mut child = dir
        .command(&["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("a child");
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_cell_is_taken_apart_as_picture_and_as_polyhedra() {
    let dir = TestDir::new();
    for (name, beginning) in [("cell.png", "\u{fffd}PNG"), ("cell.vtu", "<?xml")] {
        let output = dir.run(&["fragments", "--count", "50", "--site", "7", "-o", name]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let bytes = dir.read(name);
        assert!(
            String::from_utf8_lossy(&bytes).starts_with(beginning),
            "{name}"
        );
    }
    let message = dir.refusal(&["fragments", "--count", "50", "--site", "50", "-o", "no.png"]);
    assert_all_in(&message, &["site 50", "50"]);
    assert!(!dir.path("no.png").exists());
}

#[test]
fn bench_tells_what_was_asked_and_nothing_else() {
    let dir = TestDir::new();
    let row = |arguments: &[&str]| {
        let message = dir.stdout(arguments);
        let mut lines = message.lines();
        let names = lines.next().expect("the columns");
        let numbers = lines.next().expect("a row");
        // "µs per site" and "random 200" take three words and two.
        let names: Vec<_> = names
            .split_whitespace()
            .skip(3)
            .map(str::to_owned)
            .collect();
        let numbers: Vec<_> = numbers
            .split_whitespace()
            .skip(2)
            .map(str::to_owned)
            .collect();
        assert_eq!(names.len(), numbers.len());
        names
            .into_iter()
            .zip(numbers)
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    let few = ["bench", "--threads", "1", "--repeat", "1", "--count", "200"];
    let random = row(&[&few[..], &["--sites", "random"]].concat());
    assert!(random["iteration"].parse::<f64>().is_ok());
    assert!(random["evaluations"].parse::<f64>().is_ok());
    let global = row(&[&few[..], &["--sites", "random", "--stages", "global"]].concat());
    assert!(global["global"].parse::<f64>().is_ok());
    assert_eq!([&global["iteration"], &global["evaluations"]], ["-", "-"]);
}

#[test]
fn bench_replaces_a_file_only_when_told_to() {
    let dir = TestDir::new();
    let arguments = [
        "bench",
        "--count",
        "8",
        "--sites",
        "random",
        "--save",
        "sites.csv",
    ];
    assert!(dir.stdout(&arguments).is_empty());
    let sites = dir.read("sites.csv");
    fs::write(dir.path("sites.csv"), "mine").expect("room for a word");
    let message = dir.refusal(&arguments);
    assert_all_in(&message, &["sites.csv", "--force"]);
    assert_eq!(dir.read("sites.csv"), b"mine");
    dir.stdout(&[&arguments[..], &["--force"]].concat());
    assert_eq!(dir.read("sites.csv"), sites);
}
