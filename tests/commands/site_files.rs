//! Sites as other programs write them, given to the command: tables, arrays, packed, through pipes.

use std::io::Write as _;
use std::process::Stdio;

use crate::test_dir::{TestDir, assert_all_in};
use serde_json::Value;

/// The JSON object and the notes of a command that goes well.
fn noted(dir: &TestDir, arguments: &[&str]) -> (Value, String) {
    let output = dir.run(arguments);
    let stderr = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
    let object = serde_json::from_slice(&output.stdout).expect("a JSON object");
    (object, stderr)
}

/// The same with bytes on standard input.
fn piped(dir: &TestDir, arguments: &[&str], input: &[u8]) -> (Option<i32>, String, String) {
    let mut child = dir
        .command(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let written = child.stdin.take().expect("a pipe").write_all(input);
    let output = child.wait_with_output().expect("it ends");
    drop(written);
    let [out, error] = [output.stdout, output.stderr].map(|b| String::from_utf8(b).expect("text"));
    (output.status.code(), out, error)
}

fn gz(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

const TABLE: &str = "0.25,0.5,0.5\n0.75,0.5,0.5\n";

/// A NumPy array of two rows.
fn npy(kind: &str, fortran: bool, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': (2, 3), }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn tables_with_any_separator_are_the_same_sites() {
    let dir = TestDir::new();
    let expected = {
        dir.write("a.csv", TABLE);
        dir.stdout(&["measure", "--sites", "a.csv", "--per-cell"])
    };
    let semicolons = TABLE.replace(',', ";");
    let tabs = TABLE.replace(',', "\t");
    for (name, text) in [
        ("b.csv", &semicolons),
        ("c.csv", &tabs),
        ("d.tsv", &tabs),
        ("e.txt", &tabs),
        ("f.csv", &format!("X [mm];y;Z\n{semicolons}")),
        (
            "g.csv",
            &format!("\"Points:0\",\"Points:1\",\"Points:2\"\n{TABLE}"),
        ),
        ("h.csv", &TABLE.replace('\n', "\r\n")),
        ("i.dat", &TABLE.replace(',', " ")),
        ("j.anything", &semicolons),
    ] {
        dir.write(name, text);
        assert_eq!(
            dir.stdout(&["measure", "--sites", name, "--per-cell"]),
            expected,
            "{name}"
        );
    }
    dir.write("comma.csv", "0,25;0,5;0,5\n");
    let message = dir.refusal(&["measure", "--sites", "comma.csv"]);
    assert_all_in(&message, &["comma.csv, line 1", "`0,25`", "with a point"]);
    dir.write("other.dat", "what is this?\n");
    let message = dir.refusal(&["measure", "--sites", "other.dat"]);
    assert_all_in(&message, &["cannot tell the format", "--sites-format"]);
    dir.write("table", format!("u,v\n{TABLE}"));
    let message = dir.refusal(&["measure", "--sites", "table", "--sites-format", "csv"]);
    assert_all_in(&message, &["line 1", "no column x"]);
}

#[test]
fn a_first_column_of_numbers_is_passed_over_with_a_note() {
    let dir = TestDir::new();
    for (name, text) in [
        ("a.txt", "1 0.25 0.5 0.5\n2 0.75 0.5 0.5\n"),
        ("a.csv", "0,0.25,0.5,0.5\n1,0.75,0.5,0.5\n"),
    ] {
        dir.write(name, text);
        let (figures, note) = noted(&dir, &["measure", "--sites", name]);
        assert_eq!(figures["sites"], 2);
        assert_eq!(
            note,
            "note: the first of 4 columns numbers the sites and is passed over\n"
        );
    }
}

#[test]
fn arrays_of_whole_and_short_numbers_are_sites() {
    let dir = TestDir::new();
    let whole: Vec<u8> = [0, 0, 0, 1, 1, 1_i64]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let columns: Vec<u8> = [0.25, 0.75, 0.5, 0.5, 0.5, 0.5_f32]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    dir.write("whole.npy", npy("<i8", false, &whole));
    dir.write("short.npy", npy("<f4", true, &columns));
    dir.write("bytes.npy", npy("|u1", false, &[0, 0, 0, 1, 0, 1]));
    for name in ["whole.npy", "short.npy", "bytes.npy"] {
        let (figures, _) = noted(&dir, &["measure", "--sites", name]);
        assert_eq!(figures["sites"], 2, "{name}");
    }
    dir.write("complex.npy", npy("<c16", false, &[0; 96]));
    let message = dir.refusal(&["measure", "--sites", "complex.npy"]);
    assert_all_in(&message, &["complex.npy", "'<c16'", "astype(float)"]);
    dir.write("two.npz", b"PK\x03\x04");
    let message = dir.refusal(&["measure", "--sites", "two.npz"]);
    assert_all_in(&message, &[".npz archive", "numpy.save"]);
}

#[test]
fn packed_files_and_standard_input_are_read() {
    let dir = TestDir::new();
    dir.write("a.csv", TABLE)
        .write("a.csv.gz", gz(TABLE.as_bytes()));
    let expected = dir.stdout(&["measure", "--sites", "a.csv"]);
    assert_eq!(dir.stdout(&["measure", "--sites", "a.csv.gz"]), expected);
    let array = npy(
        "<f4",
        false,
        &[0.25_f32, 0.5, 0.5, 0.75, 0.5, 0.5]
            .map(f32::to_le_bytes)
            .concat(),
    );
    for input in [
        TABLE.as_bytes(),
        TABLE.replace(',', " ").as_bytes(),
        "[[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]]".as_bytes(),
        "2\n\nC 0.25 0.5 0.5\nC 0.75 0.5 0.5\n".as_bytes(),
        &gz(TABLE.as_bytes()),
        &array,
    ] {
        let (code, out, error) = piped(&dir, &["measure", "--sites", "-"], input);
        assert_eq!(
            (code, out.as_str()),
            (Some(0), expected.as_str()),
            "{error}"
        );
    }
    let (code, _, error) = piped(&dir, &["measure", "--sites", "-"], b"0.5,0.5,nan\n");
    assert_eq!(code, Some(2));
    assert_all_in(&error, &["standard input, line 1", "nan"]);
    // A run from standard input can be resumed: run.json holds its sites.
    let relax = [
        "relax",
        "--sites",
        "-",
        "--iterations",
        "1",
        "--out",
        "r",
        "--no-pictures",
    ];
    assert_eq!(piped(&dir, &relax, TABLE.as_bytes()).0, Some(0));
    dir.stdout(&["relax", "--resume", "--out", "r", "--iterations", "2"]);
    assert_eq!(dir.json("r/run.json")["scene"]["sites"]["list"][1][0], 0.75);
}

#[cfg(unix)]
#[test]
fn named_pipes_are_read_once() {
    let dir = TestDir::new();
    dir.write("a.csv", TABLE);
    let output = std::process::Command::new("bash")
        .current_dir(dir.folder.path())
        .arg("-c")
        .arg(format!(
            "{} measure --sites <(cat a.csv)",
            env!("CARGO_BIN_EXE_chebloyd")
        ))
        .output();
    // Systems without bash have other pipes.
    if let Ok(output) = output {
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{text}");
    }
}

#[test]
fn dropped_sites_are_counted() {
    let dir = TestDir::new();
    dir.write("a.csv", format!("{TABLE}2,2,2\n-1,0.5,0.5\n"));
    let arguments = ["measure", "--sites", "a.csv", "--drop-outside"];
    let (figures, note) = noted(&dir, &arguments);
    assert_eq!(
        (&figures["sites"], &figures["dropped_outside"]),
        (&2.into(), &2.into())
    );
    assert_eq!(
        note,
        "note: 2 of 4 sites lie outside the domain and are left out\n"
    );
    let relax = [
        "relax",
        "--sites",
        "a.csv",
        "--drop-outside",
        "--iterations",
        "1",
        "--json",
        "--no-pictures",
    ];
    let (run, note) = noted(&dir, &relax);
    assert_eq!(run["dropped_outside"], 2);
    assert!(note.contains("2 of 4 sites"), "{note}");
    let (run, _) = noted(&dir, &["measure", "relaxed"]);
    assert_eq!(run["sites"], 2);
    assert!(run.get("dropped_outside").is_none());
}
