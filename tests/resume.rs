//! Resumed runs: the same bytes as without the interruption.

#[path = "common/test_dir.rs"]
mod test_dir;

use std::fs;
use std::process::{Child, Command};

use serde_json::Value;

use test_dir::{LONG, SMALL, TestDir, assert_all_in};

#[test]
fn a_run_goes_on_where_it_ended() {
    let dir = TestDir::new();
    let relax = |rest: &[&str]| {
        let mut arguments = vec!["relax", "--count", "60", "--seed", "5"];
        arguments.extend(rest);
        dir.stdout(&arguments);
    };
    relax(&["--iterations", "9", "--out", "whole"]);
    relax(&["--iterations", "4", "--out", "parts"]);
    dir.stdout(&[
        "relax",
        "--resume",
        "--out",
        "parts",
        "--iterations",
        "9",
        "--threads",
        "1",
    ]);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("parts/sites.csv"));
    assert_eq!(dir.records("whole"), dir.records("parts"));
    let (whole, parts) = (dir.json("whole/run.json"), dir.json("parts/run.json"));
    assert_eq!(whole["final"], parts["final"]);
    assert_eq!(whole["initial"], parts["initial"]);
    assert_eq!(parts["scene"]["method"]["lloyd"]["iterations"], 9);

    // Nothing to add: the files stay as they are.
    dir.stdout(&["relax", "--resume", "--out", "parts"]);
    assert_eq!(dir.records("whole"), dir.records("parts"));
    let message = dir.refusal(&["relax", "--resume", "--out", "parts", "--iterations", "3"]);
    assert_all_in(&message, &["9 iterations already", "3"]);
}

#[test]
fn a_resumed_run_can_stop_by_tolerance() {
    let dir = TestDir::new();
    dir.stdout(&["relax", "--count", "30", "--iterations", "3"]);
    dir.stdout(&[
        "relax",
        "--resume",
        "--iterations",
        "500",
        "--tolerance",
        "2",
    ]);
    let run = dir.json("relaxed/run.json");
    assert_eq!(run["ended"], "tolerance");
    let records = dir.records("relaxed");
    let movement = |record: &Value| record["movement_percent"].as_f64().expect("a number");
    assert!(records.len() < 501);
    assert!(movement(&records[records.len() - 1]) < 2.0);
    assert!(
        records[4..records.len() - 1]
            .iter()
            .all(|record| movement(record) >= 2.0)
    );
}

#[cfg(unix)]
#[test]
fn a_killed_run_goes_on_from_its_last_complete_record() {
    use std::os::unix::process::ExitStatusExt;
    let dir = TestDir::new();
    let mut whole = vec!["relax", "--out", "whole"];
    whole.extend(LONG);
    dir.stdout(&whole);

    let mut child = dir.start("killed", 12);
    child.kill().expect("a child to kill");
    let status = child.wait().expect("a child");
    assert_eq!(status.signal(), Some(9), "killed on the way");
    let run = dir.json("killed/run.json");
    assert_eq!(run["ended"], Value::Null);
    assert!(!dir.path("killed/sites.csv").exists());
    // A kill in the middle of a line.
    let mut log = dir.read("killed/log.jsonl");
    log.extend(b"{\"iteration\":");
    dir.write("killed/log.jsonl", log);

    dir.stdout(&["relax", "--resume", "--out", "killed"]);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("killed/sites.csv"));
    assert_eq!(dir.records("whole"), dir.records("killed"));
    assert_eq!(dir.json("killed/run.json")["ended"], "iterations");
}

#[cfg(unix)]
#[test]
fn a_run_killed_before_its_first_record_starts_again() {
    let dir = TestDir::new();
    let mut arguments = vec!["relax", "--out", "r"];
    arguments.extend(SMALL);
    dir.stdout(&arguments);
    let sites = dir.read("r/sites.csv");
    let mut run = dir.json("r/run.json");
    for key in ["initial", "final", "ended"] {
        run[key] = Value::Null;
    }
    dir.write("r/run.json", run.to_string());
    dir.write("r/log.jsonl", "{\"itera");
    for name in ["checkpoint.bin", "sites.csv"] {
        fs::remove_file(dir.path("r").join(name)).expect("a file to remove");
    }
    dir.stdout(&["relax", "--resume", "--out", "r"]);
    assert_eq!(sites, dir.read("r/sites.csv"));
    assert_eq!(dir.records("r").len(), 3);
}

#[cfg(unix)]
#[test]
fn ctrl_c_finishes_the_iteration_and_leaves_complete_files() {
    let dir = TestDir::new();
    let child = dir.start("r", 4);
    interrupt(&child);
    let output = child.wait_with_output().expect("a child");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_all_in(
        &String::from_utf8_lossy(&output.stdout),
        &["interrupted", "--resume --out r"],
    );
    let run = dir.json("r/run.json");
    assert_eq!(run["ended"], "interrupted");
    assert!(run["final"].is_object());
    let done = dir.records("r").len() - 1;
    assert!(done < 40, "it was interrupted on the way");
    for name in ["sites.csv", "cells.vtu", "convergence.svg"] {
        assert!(dir.path("r").join(name).exists(), "{name}");
    }

    // What was left is exactly what a run of so many iterations leaves, and can go on.
    let count = done.to_string();
    let mut whole = vec!["relax", "--out", "whole"];
    whole.extend(LONG);
    whole[8] = &count;
    dir.stdout(&whole);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("r/sites.csv"));
    let more = (done + 2).to_string();
    dir.stdout(&["relax", "--resume", "--out", "r", "--iterations", &more]);
    dir.stdout(&["relax", "--resume", "--out", "whole", "--iterations", &more]);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("r/sites.csv"));
    assert_eq!(dir.records("whole"), dir.records("r"));
}

#[cfg(unix)]
fn interrupt(child: &Child) {
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.expect("kill is there").success());
}

#[cfg(unix)]
#[test]
fn a_directory_in_use_is_refused() {
    let dir = TestDir::new();
    let mut child = dir.start("r", 2);
    for arguments in [
        &["relax", "--resume", "--out", "r"][..],
        &["relax", "--force", "--out", "r"],
    ] {
        let output = dir.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_all_in(&message, &["r is in use"]);
    }
    child.kill().expect("a child to kill");
    child.wait().expect("a child");
}

#[test]
fn quasi_newton_and_annealing_go_on_where_they_ended() {
    for method in [
        &["--method", "quasi-newton"][..],
        &["--method", "anneal"],
        &["--method", "lloyd", "--accelerate"],
        &["--method", "lloyd", "--accelerate", "--coarse-to-fine", "1"],
        &[
            "--method",
            "quasi-newton",
            "--warm-up",
            "3",
            "--memory",
            "4",
        ],
        &["--method", "lloyd", "--coarse-to-fine", "1"],
        &["--goal", "cubes", "--coarse-to-fine", "1"],
    ] {
        let dir = TestDir::new();
        let relax = |rest: &[&str]| {
            let mut arguments = vec!["relax", "--count", "60", "--seed", "5"];
            arguments.extend(method.iter().chain(rest));
            dir.stdout(&arguments);
        };
        relax(&["--iterations", "30", "--out", "whole"]);
        relax(&["--iterations", "30", "--out", "parts"]);
        // What is left of a run that was killed after its last checkpoint.
        let path = dir.path("parts/log.jsonl");
        let text = fs::read_to_string(&path).expect("the log");
        fs::write(&path, format!("{text}{{\"iteration\":31,")).expect("room for it");
        dir.stdout(&["relax", "--resume", "--out", "parts", "--threads", "1"]);
        assert_eq!(dir.read("whole/sites.csv"), dir.read("parts/sites.csv"));
        assert_eq!(dir.records("whole"), dir.records("parts"));
    }
}

/// Where the method allows, going on to N moves is the same as asking for N at once.
#[test]
fn longer_runs_begin_like_shorter_ones() {
    for method in [
        &["--method", "quasi-newton"][..],
        &["--method", "lloyd", "--accelerate"],
    ] {
        let dir = TestDir::new();
        let relax = |out: &str, rest: &[&str]| {
            let mut arguments = vec!["relax", "--out", out];
            arguments.extend(rest);
            dir.stdout(&arguments);
        };
        let start = |out: &str, iterations: &str| {
            let mut rest = vec!["--count", "60", "--iterations", iterations];
            rest.extend(method);
            relax(out, &rest);
        };
        start("whole", "20");
        start("parts", "8");
        relax("parts", &["--resume", "--iterations", "20"]);
        assert_eq!(dir.read("whole/sites.csv"), dir.read("parts/sites.csv"));
        assert_eq!(dir.records("whole"), dir.records("parts"));
    }
}

/// Rounds cut short for the return to the best sites continue while iterations are left.
#[test]
fn an_annealing_that_was_cut_short_goes_on_with_its_rounds() {
    let dir = TestDir::new();
    let round = || {
        let records = dir.records("r");
        records[records.len() - 1]["round"]
            .as_u64()
            .expect("a round")
    };
    dir.stdout(&[
        "relax",
        "--out",
        "r",
        "--count",
        "60",
        "--method",
        "anneal",
        "--iterations",
        "190",
    ]);
    let before = round();
    let best = |run: &Value| run["final"]["energy_mean"].as_f64().expect("a number");
    let energy = best(&dir.json("r/run.json"));
    dir.stdout(&["relax", "--resume", "--out", "r", "--iterations", "260"]);
    assert!(round() > before, "{before}");
    assert!(best(&dir.json("r/run.json")) <= energy * (1.0 + 1e-12));
}
