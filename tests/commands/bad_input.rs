//! Bad input: exit code 2, one message, no file changed.

use crate::test_dir::{SMALL, TestDir, assert_all_in};

/// A scene, and words that its refusal must hold.
const BAD_SCENES: &[(&str, &[&str])] = &[
    (
        "{\n \"sites\": {\"random\": {\"count\": 9}},\n \"domian\": {}\n}",
        &["s.json, line 3, column 2", "`domian`", "`domain`"],
    ),
    (
        "{\"sites\": {\"random\": {\"cuont\": 9}}}",
        &["line 1", "did you mean `count`"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"norm\": \"l3\"}",
        &["line 1", "did you mean `l2`"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": -9}}}",
        &["line 1, column", "-9"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}",
        &["line 1, column", "EOF"],
    ),
    ("", &["s.json", "empty"]),
    ("{}", &["missing field `sites`"]),
    (
        "{\"sites\": {\"random\": {\"count\": 0}}}",
        &["sites.random.count", "0 sites"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"box\": {\"min\": [0,0,1]}}}",
        &["no volume", "axis 2"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"box\": {\"min\": [0,0]}}}",
        &["domain.box.min", "2 values where 3", "\"dimension\": 2"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"half_spaces\": [[1,0,0,1],[-1,0,0,1],[0,1,0,1],[0,-1,0,1]]}}",
        &["domain", "bound"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"half_spaces\": [[1,0,0,-1],[-1,0,0,-1],[0,1,0,1],[0,-1,0,1],[0,0,1,1],[0,0,-1,1]]}}",
        &["domain", "no interior"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"dimension\": 4}",
        &["dimension", "4 is neither 2 nor 3"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"order\": 0}",
        &["order", "0 is not between"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"method\": {\"lloyd\": {\"tolerance\": -1}}}",
        &["method.lloyd.tolerance", "-1"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"method\": {\"quasi_newton\": {\"gradient_tolerance\": -1}}}",
        &[
            "method.quasi_newton.gradient_tolerance",
            "-1.0 is not 0 or a positive number",
        ],
    ),
    (
        "{\"sites\": {\"grid\": {\"counts\": [2,2]}}}",
        &["sites.grid.counts", "2 values where 3"],
    ),
    (
        "{\"sites\": {\"list\": [[0.1,0.2,0.3],[0.1,0.2]]}}",
        &["sites.list[1]", "2 values where 3"],
    ),
    (
        "{\"sites\": {\"list\": [[0.1,0.2,0.3],[0.1,0.2,0.3]]}}",
        &["sites 0 and 1", "(0.1, 0.2, 0.3)", "remove"],
    ),
    (
        "{\"sites\": {\"file\": \"nowhere.csv\"}}",
        &["cannot read", "nowhere.csv"],
    ),
    (
        "{\"dimension\": 2, \"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"polygon\": [[0,0],[1,1],[1,0],[0,1]]}}",
        &["sides 0 and 2", "cross"],
    ),
    (
        "{\"dimension\": 2, \"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"polygon\": [[0,0],[1,1],[2,2]]}}",
        &["domain", "no area"],
    ),
    (
        "{\"dimension\": 2, \"sites\": {\"random\": {\"count\": 9}}, \"density\": \"1 + x\", \"domain\": {\"box\": {\"periodic\": [true,false]}}}",
        &["density", "along x"],
    ),
    (
        "{\"sites\": {\"random\": {\"count\": 9}}, \"domain\": {\"polygon\": [[0,0],[1,1],[2,2]]}}",
        &["domain.polygon", "\"dimension\": 2"],
    ),
];

#[test]
fn scenes_that_say_something_wrong_are_refused_at_the_place() {
    let dir = TestDir::new();
    for (scene, words) in BAD_SCENES {
        dir.write("s.json", scene);
        for command in ["relax", "measure"] {
            assert_all_in(&dir.refusal(&[command, "s.json"]), words);
        }
    }
}

/// A site file's name and content, and words that its refusal must hold.
const BAD_SITES: &[(&str, &[u8], &[&str])] = &[
    (
        "p.csv",
        b"x,y,z\n0.1,0.2,0.3\n0.5,0.5,0.5\n0.1,0.2,0.3\n",
        &["sites 0 and 2", "remove"],
    ),
    (
        "p.csv",
        b"x,y,z\n0.1,0.2,0.3\n0.5,nan,0.5\n",
        &["p.csv, line 3", "y is nan"],
    ),
    (
        "p.csv",
        b"0.1,0.2,0.3\n0.5,0.5,inf\n",
        &["p.csv, line 2", "z is inf"],
    ),
    (
        "p.csv",
        b"0.1,0.2,0.3\n0.5,1.5,0.5\n0.5,2.5,0.5\n",
        &["site 1 (0.5, 1.5, 0.5)", "outside", "1 more"],
    ),
    (
        "p.csv",
        b"0.1,0.2,0.3\n0.5,0.5\n",
        &["p.csv, line 2", "2 columns where 3"],
    ),
    (
        "p.csv",
        b"0.1,0.2,0.3\n0.5,0.5,0.5,0.5\n",
        &["p.csv, line 2", "4 columns where 3"],
    ),
    (
        "p.csv",
        b"0.1,0.2,0.3\n0.5,0.5,half\n",
        &["p.csv, line 2", "`half`", "not a number"],
    ),
    ("p.csv", b"", &["p.csv", "holds no sites"]),
    ("p.csv", b"x,y,z\n", &["p.csv", "holds no sites"]),
    ("p.xyz", b"# nothing\n", &["p.xyz", "holds no sites"]),
    (
        "p.xyz",
        b"0.1 0.2 0.3\n0.5 0.5 NaN\n",
        &["p.xyz, line 2", "z is NaN"],
    ),
    (
        "p.json",
        b"[[0.1, 0.2, 0.3],\n [0.5, 0.5",
        &["p.json, line 2", "EOF"],
    ),
    ("p.json", b"[]", &["p.json", "holds no sites"]),
    ("p.npy", b"\x93NUMPY\x01\x00\x46\x00{'descr'", &["p.npy"]),
    ("p.npy", b"", &["p.npy"]),
    (
        "p.vtk",
        b"# vtk DataFile Version 3.0\n",
        &["format of p.vtk", ".csv"],
    ),
];

#[test]
fn sites_that_have_no_cells_are_refused_by_name() {
    let dir = TestDir::new();
    for (name, content, words) in BAD_SITES {
        dir.write(name, content);
        for command in ["relax", "measure"] {
            let message = dir.refusal(&[command, "--sites", name]);
            // The program names files by their whole path.
            assert_all_in(&message.replace(&format!("{}/", real(&dir)), ""), words);
        }
    }
}

fn real(dir: &TestDir) -> String {
    let folder = dir.folder.path().canonicalize().expect("a folder");
    folder.display().to_string()
}

#[test]
fn usage_errors_end_with_code_2() {
    let dir = TestDir::new();
    for arguments in [
        &["relx"][..],
        &["relax", "--iteratons", "3"],
        &["relax", "--norm", "l7"],
        &["relax", "--threads", "0"],
        &["relax", "--count", "-3"],
        &["relax", "--resume", "--force"],
        &["relax", "--resume", "--norm", "l2"],
        &["relax", "--resume", "--memory", "3"],
        &["relax", "--resume", "--goal", "cubes"],
        &["relax", "--sites", "p.csv", "--count", "3"],
        &["relax", "--memory", "3"],
        &["relax", "--method", "anneal", "--noise", "NaN"],
        &["relax", "--tolerance", "-1"],
        &["relax", "--tolerance", "NaN"],
        &["relax", "--count", "0"],
        &["relax", "nowhere.json"],
        &["relax", "--sites", "nowhere.csv"],
        &["plot"],
        &["plot", "nowhere.jsonl"],
        &["completions", "tcsh9"],
        &["man", "relx"],
    ] {
        dir.refusal(arguments);
    }
    let nothing = dir.run(&[]);
    assert_eq!(nothing.status.code(), Some(2));
}

#[test]
fn an_occupied_directory_is_refused_unless_forced() {
    let dir = TestDir::new();
    let mut arguments = vec!["relax", "--out", "r", "--seed", "1"];
    arguments.extend(SMALL);
    dir.stdout(&arguments);
    assert_all_in(
        &dir.refusal(&arguments),
        &["r already holds a run", "--resume", "--force", "--out"],
    );

    arguments[4] = "2";
    arguments.push("--force");
    let before = dir.read("r/sites.csv");
    dir.stdout(&arguments);
    assert_ne!(before, dir.read("r/sites.csv"));
    assert_eq!(dir.records("r").len(), 3);

    // Bad input is found before anything is overwritten.
    dir.refusal(&["relax", "--out", "r", "--force", "--count", "0"]);
    dir.refusal(&["relax", "--out", "r", "--force", "--sites", "nowhere.csv"]);
}

#[test]
fn a_place_that_cannot_hold_a_run_is_refused() {
    let dir = TestDir::new();
    dir.write("file", "not a directory");
    assert_all_in(
        &dir.refusal(&["relax", "--out", "file"]),
        &["file is not a directory"],
    );
    assert_all_in(
        &dir.refusal(&["relax", "--out", "file/below"]),
        &["file/below"],
    );
    assert_all_in(
        &dir.refusal(&["relax", "--out", "none", "--resume"]),
        &["none holds no run"],
    );
}

/// More sites than there is memory for, by every way to name them.
#[test]
fn more_sites_than_there_is_memory_for_are_refused_with_the_estimate() {
    let dir = TestDir::new();
    let words = &["000000000000 sites need about", "B of memory", "take fewer"];
    let many = "1000000000000";
    for command in [
        &["measure", "--count", many][..],
        &["relax", "--count", many],
        &["relax", "--count", many, "--method", "quasi-newton"],
        &["fragments", "--count", many, "-o", "cell.vtu"],
        &["bench", "--count", many, "--sites", "random"],
    ] {
        assert_all_in(&dir.refusal(command), words);
    }
    dir.write(
        "s.json",
        r#"{"sites": {"grid": {"counts": [10000, 10000, 10000]}}}"#,
    );
    assert_all_in(&dir.refusal(&["measure", "s.json"]), words);
    let huge = r#"{"sites": {"grid": {"counts": [4000000000000, 4000000000000, 4000000000000]}}}"#;
    dir.write("s.json", huge);
    assert_all_in(&dir.refusal(&["measure", "s.json"]), &words[1..]);

    let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000, 3), }";
    let mut npy = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    npy.extend(format!("{header:<117}\n").as_bytes());
    dir.write("p.npy", npy);
    let announced = dir.refusal(&["measure", "--sites", "p.npy"]);
    assert_all_in(&announced, &["p.npy", "0 of 3000000000000 numbers"]);
}

/// A sparse file of 10 TB takes no room on the disk.
#[cfg(target_os = "linux")]
#[test]
fn a_site_file_larger_than_the_memory_is_refused_unread() {
    let dir = TestDir::new();
    let file = std::fs::File::create(dir.path("p.csv")).expect("a file");
    if file.set_len(10_000_000_000_000).is_err() {
        return;
    }
    let output = dir.run(&["measure", "--sites", "p.csv"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_all_in(&message, &["p.csv: holds 10 TB", "of memory are available"]);
}
