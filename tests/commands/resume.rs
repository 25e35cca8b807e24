//! Resumed runs: the same bytes as without the interruption.

use std::fs;
use std::process::{Child, Command};

use serde_json::Value;

use crate::test_dir::{LONG, SMALL, TestDir, assert_all_in};

#[test]
fn a_run_goes_on_where_it_ended() {
    let dir = TestDir::new();
    let relax = |rest: &[&str]| {
        let mut arguments = vec!["relax", "--count", "60", "--seed", "5", "--no-pictures"];
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
    dir.stdout(&[
        "relax",
        "--count",
        "30",
        "--iterations",
        "3",
        "--no-pictures",
    ]);
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
    let mut whole = vec!["relax", "--out", "whole", "--no-pictures"];
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
    send(&child, "-INT");
    let output = child.wait_with_output().expect("a child");
    assert_eq!(output.status.code(), Some(130), "{output:?}");
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
    let mut whole = vec!["relax", "--out", "whole", "--no-pictures"];
    whole.extend(LONG);
    whole[9] = &count;
    dir.stdout(&whole);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("r/sites.csv"));
    let more = (done + 2).to_string();
    dir.stdout(&["relax", "--resume", "--out", "r", "--iterations", &more]);
    dir.stdout(&["relax", "--resume", "--out", "whole", "--iterations", &more]);
    assert_eq!(dir.read("whole/sites.csv"), dir.read("r/sites.csv"));
    assert_eq!(dir.records("whole"), dir.records("r"));
}

#[cfg(unix)]
fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
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
            let mut arguments = vec!["relax", "--count", "60", "--seed", "5", "--no-pictures"];
            arguments.extend(method.iter().chain(rest));
            dir.stdout(&arguments);
        };
        relax(&["--iterations", "12", "--out", "whole"]);
        relax(&["--iterations", "12", "--out", "parts"]);
        // What is left of a run that was killed after its last checkpoint.
        let path = dir.path("parts/log.jsonl");
        let text = fs::read_to_string(&path).expect("the log");
        fs::write(&path, format!("{text}{{\"iteration\":13,")).expect("room for it");
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
            let mut arguments = vec!["relax", "--no-pictures", "--out", out];
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
        "--no-pictures",
    ]);
    let before = round();
    let best = |run: &Value| run["final"]["energy_mean"].as_f64().expect("a number");
    let energy = best(&dir.json("r/run.json"));
    dir.stdout(&["relax", "--resume", "--out", "r", "--iterations", "260"]);
    assert!(round() > before, "{before}");
    assert!(best(&dir.json("r/run.json")) <= energy * (1.0 + 1e-12));
}

/// Sites that never become cubes on their coarse level of 30, without pictures.
const COARSE: &str = r#"{"sites": {"random": {"count": 240, "seed": 4}}, "coarse_to_fine": 1,
    "method": {"anneal": {"exchange": true, "iterations": 600}},
    "output": {"cells": false, "plot": false}}"#;

/// Starts a relaxation of the scene `s.json` in `directory` and waits for so many lines of its log.
#[cfg(unix)]
fn start(dir: &TestDir, directory: &str, lines: usize) -> Child {
    let mut command = dir.command(&["relax", "s.json", "-q", "--out", directory]);
    let mut child = command.spawn().expect("the program starts");
    let log = dir.path(directory).join("log.jsonl");
    let count = || fs::read_to_string(&log).map_or(0, |text| text.lines().count());
    while !log.exists() || count() < lines {
        assert!(child.try_wait().expect("a child").is_none(), "too early");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    child
}

#[cfg(unix)]
#[test]
fn a_signal_on_a_coarse_level_leaves_all_sites_and_the_run_goes_on_to_the_bit() {
    let dir = TestDir::new();
    dir.write("s.json", COARSE);
    dir.stdout(&["relax", "s.json", "-q", "--out", "whole"]);
    for (name, code) in [("TERM", 143), ("INT", 130), ("HUP", 129)] {
        let mut child = start(&dir, name, 6);
        send(&child, &format!("-{name}"));
        assert_eq!(child.wait().expect("a child").code(), Some(code));
        let run = dir.json(&format!("{name}/run.json"));
        assert_eq!(run["ended"], "interrupted");
        let records = dir.records(name);
        let last = &records[records.len() - 1];
        assert_eq!((&last["level"], &last["sites"]), (&1.into(), &30.into()));
        let text = String::from_utf8(dir.read(&format!("{name}/sites.csv"))).expect("text");
        assert_eq!(text.lines().count(), 241);
        assert_eq!(run["final"]["sites"], 240);
        let sum = run["final"]["volume_sum"].as_f64().expect("a number");
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");

        dir.stdout(&["relax", "--resume", "-q", "--out", name]);
        let file = |run: &str| dir.read(&format!("{run}/sites.csv"));
        assert_eq!(file(name), file("whole"));
        assert_eq!(dir.records(name), dir.records("whole"));
    }
}

/// A signal before the first record too.
#[cfg(unix)]
#[test]
fn a_signal_at_the_start_of_a_run_leaves_complete_files() {
    let dir = TestDir::new();
    dir.write("s.json", COARSE);
    let mut child = start(&dir, "r", 0);
    send(&child, "-INT");
    assert_eq!(child.wait().expect("a child").code(), Some(130));
    assert_eq!(dir.json("r/run.json")["ended"], "interrupted");
    let text = String::from_utf8(dir.read("r/sites.csv")).expect("text");
    assert_eq!(text.lines().count(), 241);
    assert!(!dir.records("r").is_empty() && dir.path("r/checkpoint.bin").exists());
}

/// A quick run without pictures.
fn quick(dir: &TestDir, out: &str, seed: &str) {
    dir.write(
        "s.json",
        r#"{"sites": {"random": {"count": 9}}, "method": {"lloyd": {"iterations": 3}},
            "output": {"cells": false, "plot": false}}"#,
    );
    dir.stdout(&["relax", "s.json", "-q", "--out", out, "--seed", seed]);
}

fn refused_resumption(dir: &TestDir, words: &[&str]) {
    let message = dir.refusal(&["relax", "--resume", "--out", "r", "--iterations", "5"]);
    assert_all_in(&message, words);
}

#[test]
fn flipped_and_foreign_checkpoints_are_refused() {
    let dir = TestDir::new();
    quick(&dir, "r", "1");
    quick(&dir, "other", "2");
    let own = dir.read("r/checkpoint.bin");
    for place in (0..own.len()).step_by(37).chain([own.len() - 1]) {
        let mut flipped = own.clone();
        flipped[place] ^= 4;
        dir.write("r/checkpoint.bin", &flipped);
        refused_resumption(&dir, &["r/checkpoint.bin cannot be resumed", "--force"]);
    }
    dir.write("r/checkpoint.bin", &own[..own.len() - 3]);
    refused_resumption(&dir, &["r/checkpoint.bin", "cut off"]);
    dir.write("r/checkpoint.bin", dir.read("other/checkpoint.bin"));
    refused_resumption(&dir, &["r/checkpoint.bin", "another run's"]);
    let older = "{\"format\":1,\"dimension\":3,\"sites\":1,\"iteration\":3,\"memory\":0}\n";
    dir.write("r/checkpoint.bin", format!("{older}{}", "0".repeat(24)));
    refused_resumption(&dir, &["r/checkpoint.bin", "older version", "checksum"]);
    dir.write("r/checkpoint.bin", own);
    dir.stdout(&["relax", "--resume", "-q", "--out", "r", "--iterations", "5"]);
}

#[test]
fn a_run_whose_scene_or_sites_have_changed_is_refused() {
    let dir = TestDir::new();
    quick(&dir, "r", "1");
    let text = String::from_utf8(dir.read("r/run.json")).expect("text");
    let order = text.replace("\"order\": 1", "\"order\": 2");
    dir.write("r/run.json", order);
    refused_resumption(&dir, &["r/run.json", "its scene", "--force"]);
    let mut older: Value = serde_json::from_str(&text).expect("JSON");
    older.as_object_mut().expect("an object").remove("identity");
    dir.write("r/run.json", older.to_string());
    refused_resumption(&dir, &["r/run.json", "older version", "--force"]);

    dir.write("p.csv", "0.25,0.5,0.5\n0.7,0.5,0.5\n0.3,0.2,0.1\n");
    dir.stdout(&["relax", "s.json", "-q", "--out", "f", "--sites", "p.csv"]);
    fs::remove_file(dir.path("f/checkpoint.bin")).expect("a file to remove");
    dir.write("p.csv", "0.25,0.5,0.5\n0.7,0.5,0.5\n0.3,0.2,0.2\n");
    let message = dir.refusal(&["relax", "--resume", "--out", "f"]);
    assert_all_in(&message, &["f/run.json", "sites that its scene names"]);
}

#[test]
fn a_whole_checkpoint_goes_on_without_its_log() {
    let dir = TestDir::new();
    quick(&dir, "whole", "1");
    dir.stdout(&[
        "relax",
        "--resume",
        "-q",
        "--out",
        "whole",
        "--iterations",
        "5",
    ]);
    let whole = dir.records("whole");
    for cut in [0, 40, 700] {
        quick(&dir, "r", "1");
        let log = dir.read("r/log.jsonl");
        dir.write("r/log.jsonl", &log[..cut]);
        let output = dir.run(&["relax", "--resume", "-q", "--out", "r", "--iterations", "5"]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_all_in(&message, &["note: log.jsonl lacks", "before iteration 3"]);
        assert_eq!(dir.read("r/sites.csv"), dir.read("whole/sites.csv"));
        let records = dir.records("r");
        assert!(records.iter().all(|record| whole.contains(record)));
        assert_eq!(records[records.len() - 3..], whole[3..]);
        fs::remove_dir_all(dir.path("r")).expect("a directory to remove");
    }
}
