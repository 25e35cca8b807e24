//! Frames of cells from files, from one rotation and from the boundary, by the command.

use crate::test_dir::{TestDir, assert_all_in};
use nalgebra::Vector3;

#[test]
fn scenes_take_frames_from_files_and_from_the_boundary() {
    let dir = TestDir::new();
    let scene = |frames: &str| {
        format!(
            r#"{{ "sites": {{ "random": {{ "count": 40 }} }}, "frames": {frames},
            "method": {{ "lloyd": {{ "iterations": 3 }} }}, "output": {{ "plot": false }} }}"#
        )
    };
    let rotation = "0.1,0.2,0.3\n";
    dir.write("frames.csv", format!("x,y,z\n{}", rotation.repeat(40)));
    dir.write("short.csv", rotation.repeat(39));
    let degrees = Vector3::new(0.1_f64, 0.2, 0.3).norm().to_degrees();
    let one = format!(r#"{{ "axis": [1, 2, 3], "degrees": {degrees:?} }}"#);
    for (name, frames) in [
        ("file", r#"{ "file": "frames.csv" }"#),
        ("one", one.as_str()),
        ("boundary", r#""boundary""#),
        ("short", r#"{ "file": "short.csv" }"#),
        ("odd", r#""walls""#),
    ] {
        dir.write(&format!("{name}.json"), scene(frames));
    }
    for name in ["file", "one", "boundary"] {
        dir.stdout(&["relax", &format!("{name}.json"), "--out", name]);
        // Frames belong to the sites of the start, also in a run that goes on.
        dir.stdout(&["relax", "--resume", "--out", name, "--iterations", "5"]);
    }
    let last =
        |name: &str| dir.json(&format!("{name}/run.json"))["final"]["energy_percent"].clone();
    let number = |name: &str| last(name).as_f64().expect("a number");
    assert!((number("file") / number("one") - 1.0).abs() < 1e-9);
    assert!((number("file") / number("boundary") - 1.0).abs() > 1e-6);
    let message = dir.refusal(&["relax", "short.json", "--out", "r"]);
    assert_all_in(&message, &["short.csv", "39 rotations for 40 sites"]);
    let message = dir.refusal(&["relax", "odd.json", "--out", "r"]);
    assert_all_in(&message, &["boundary", "degrees"]);
    let message = dir.refusal(&["relax", "file.json", "--coarse-to-fine", "1", "--out", "r"]);
    assert_all_in(&message, &["coarse_to_fine", "frame"]);
    dir.stdout(&[
        "relax",
        "file.json",
        "--goal",
        "cubes",
        "--iterations",
        "30",
        "--out",
        "r",
    ]);
    dir.stdout(&["fragments", "file.json", "-o", "cell.vtu"]);
}
