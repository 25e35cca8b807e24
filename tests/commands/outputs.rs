//! Outputs: no file that is there is replaced unless told to, and an input never.

use std::fs;

use crate::test_dir::{TestDir, assert_all_in};

const SITES: &str = "x,y,z\n0.25,0.5,0.5\n0.7,0.5,0.5\n0.3,0.2,0.1\n";

/// A scene without pictures that takes its sites from `p.csv`.
const SCENE: &str = r#"{"sites": {"file": "p.csv"}, "method": {"lloyd": {"iterations": 1}},
    "output": {"cells": false, "plot": false}}"#;

/// A tetrahedron as OFF.
const SOLID: &str = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

fn dir() -> TestDir {
    let dir = TestDir::new();
    fs::create_dir(dir.path("data")).expect("a folder");
    dir.write("p.csv", SITES).write("s.json", SCENE);
    dir
}

#[test]
fn a_file_that_is_there_is_replaced_only_by_force() {
    for name in [
        "sites.csv",
        "cells.vtu",
        "run.json",
        "checkpoint.bin",
        "convergence.svg",
    ] {
        let dir = dir();
        let file = format!("data/{name}");
        dir.write(&file, "mine");
        let message = dir.refusal(&["relax", "s.json", "--out", "data"]);
        assert_all_in(&message, &["data", "--force", "--out"]);
        assert_eq!(dir.read(&file), b"mine");
        dir.stdout(&["relax", "s.json", "-q", "--out", "data", "--force"]);
        assert!(dir.json("data/run.json")["final"].is_object());
    }
}

#[test]
fn an_input_of_a_run_is_never_replaced() {
    let refused = |dir: &TestDir, arguments: &[&str]| {
        for force in [&[][..], &["--force"]] {
            let message = dir.refusal(&[arguments, force].concat());
            assert!(
                message.contains("never done") || message.contains("already holds a run"),
                "{message}"
            );
        }
        let message = dir.refusal(&[arguments, &["--force"]].concat());
        assert_all_in(&message, &["would replace", "--out"]);
    };
    // The sites, by their name.
    let one = dir();
    one.write("data/sites.csv", SITES);
    refused(
        &one,
        &["relax", "--sites", "data/sites.csv", "--out", "data"],
    );
    refused(
        &one,
        &[
            "relax",
            "--sites",
            "data/../data/sites.csv",
            "--out",
            "./data",
        ],
    );
    // A mesh, and the scene itself.
    one.write("data/cells.vtu", SOLID)
        .write("data/run.json", SCENE);
    let scene = r#"{"sites": {"random": {"count": 3}}, "domain": {"surface": "data/cells.vtu"}}"#;
    one.write("mesh.json", scene);
    refused(&one, &["relax", "mesh.json", "--out", "data"]);
    one.write("data/p.csv", SITES);
    refused(&one, &["relax", "data/run.json", "--out", "data"]);
}

#[cfg(unix)]
#[test]
fn links_do_not_lead_past_the_rule() {
    let dir = dir();
    std::os::unix::fs::symlink(dir.path("p.csv"), dir.path("data/sites.csv")).expect("a link");
    fs::hard_link(dir.path("s.json"), dir.path("data/log.jsonl")).expect("a link");
    for force in [&[][..], &["--force"]] {
        let arguments = ["relax", "--sites", "p.csv", "--out", "data"];
        dir.refusal(&[&arguments[..], force].concat());
        dir.refusal(&[&["relax", "s.json", "--out", "data"], force].concat());
    }
    fs::remove_file(dir.path("data/sites.csv")).expect("a link to remove");
    let message = dir.refusal(&["relax", "s.json", "--out", "data", "--force"]);
    assert_all_in(&message, &["data/log.jsonl would replace", "s.json"]);
    std::os::unix::fs::symlink(dir.path("data"), dir.path("link")).expect("a link");
    dir.write("data/cell.vtu", "mine");
    let message = dir.refusal(&["fragments", "s.json", "-o", "link/cell.vtu"]);
    assert_all_in(
        &message,
        &["link/cell.vtu is there already", "--force", "-o"],
    );
}

#[test]
fn plots_and_fragments_replace_nothing_unasked_and_their_inputs_never() {
    let dir = dir();
    dir.stdout(&["relax", "s.json", "-q", "--out", "r"]);
    fs::copy(dir.path("r/log.jsonl"), dir.path("log.svg")).expect("room for a log");
    for force in [&[][..], &["--force"]] {
        let message = dir.refusal(&[&["plot", "log.svg", "-o", "log.svg"], force].concat());
        assert_all_in(&message, &["log.svg would replace log.svg", "-o"]);
    }
    dir.write("solid.vtu", SOLID).write("cell.vtu", "mine");
    let message = dir.refusal(&["fragments", "s.json", "-o", "cell.vtu"]);
    assert_all_in(&message, &["cell.vtu is there already", "--force"]);
    dir.stdout(&["fragments", "s.json", "-o", "cell.vtu", "-q", "--force"]);
    assert!(dir.read("cell.vtu").starts_with(b"<?xml"));
    let scene = r#"{"sites": {"random": {"count": 3}}, "domain": {"surface": "solid.vtu"}}"#;
    dir.write("mesh.json", scene);
    let arguments = ["fragments", "mesh.json", "-o", "solid.vtu", "--force"];
    assert_all_in(&dir.refusal(&arguments), &["solid.vtu would replace"]);
    let arguments = ["bench", "--points", "p.csv", "--save", "p.csv", "--force"];
    assert_all_in(
        &dir.refusal(&arguments),
        &["p.csv would replace p.csv", "--save"],
    );
}
