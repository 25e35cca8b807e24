//! The command `chebloyd print`: fields, balance, limits, files that are never replaced, reports.

use std::fs;
use std::path::{Path, PathBuf};

use crate::gcode::{kept, shared};
use crate::test_dir::{TestDir, assert_all_in};
use serde_json::Value;

const KEPT: [&str; 3] = [
    "bar-prusaslicer.gcode",
    "bar-gyroid-absolute.gcode",
    "bar-cura.gcode",
];

/// The bore of the rocker arm on the bed, of the samples' README.
const BORE: &str = "105.34127,95.77442,0,0.00120118,0.00727018,0.99997285";

/// The exit code, what `--json` prints, and what stderr says.
fn print(dir: &TestDir, file: &Path, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let file = file.to_str().expect("a path");
    let output = dir.run(&[&["print", file, "-o", "out.gcode", "--json"], arguments].concat());
    let json = serde_json::from_slice(&output.stdout).unwrap_or(Value::Null);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), json, error)
}

fn printed(dir: &TestDir, file: &Path, arguments: &[&str]) -> Value {
    let (code, json, error) = print(dir, file, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {error}");
    assert_eq!(json["written"], true);
    json
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

fn near(value: &Value, expected: f64, tolerance: f64) {
    let got = number(value);
    assert!(
        (got - expected).abs() <= tolerance,
        "{got} is not {expected}"
    );
}

/// density.md 5.3: volume 3777.400, center x 108.0901.
#[test]
fn the_bar_of_rising_density_weighs_what_was_measured() {
    let dir = TestDir::new();
    let bar = kept(KEPT[0]);
    let json = printed(&dir, &bar, &["--density", "0.5 + 0.01*(x - 50)"]);
    let infill = &json["infill"]["obtained"];
    near(&infill["volume"], 3777.400, 1e-3);
    near(&infill["center_of_mass"][0], 108.0901, 3e-3);
    near(
        &json["infill"]["wanted"]["center_of_mass"][0],
        108.0901,
        1e-4,
    );
    assert!(number(&json["center_error"]) < 1e-3);
    let mass = dir.stdout(&["mass", "--json", "out.gcode"]);
    let mass: Value = serde_json::from_str(&mass).expect("JSON");
    for key in [
        "volume",
        "center_of_mass",
        "inertia_center",
        "principal_moments",
    ] {
        let numbers = |value: &Value| -> Vec<f64> {
            let text = value.to_string().replace(['[', ']'], "");
            text.split(',')
                .map(|word| word.parse().expect("a number"))
                .collect()
        };
        let (mass, obtained) = (numbers(&mass[key]), numbers(&json["obtained"][key]));
        for (one, other) in mass.iter().zip(&obtained) {
            let scale = one.abs().max(1.0);
            assert!((one - other).abs() < 1e-9 * scale, "{key}: {one} {other}");
        }
    }
    for spanning in [
        "linear:axis=x,from=0.5,to=1.5",
        "profile:axis=x,0=0.5,100=1.5",
    ] {
        let json = printed(&dir, &bar, &["--force", "--density", spanning]);
        let center = &json["infill"]["obtained"]["center_of_mass"][0];
        near(center, 108.0901, 3e-3);
    }
    let twice = printed(
        &dir,
        &bar,
        &["--force", "--density", "0.02*x", "--relative-to", "mean"],
    );
    near(&twice["infill"]["obtained"]["volume"], 3777.400, 1e-3);
    near(
        &twice["infill"]["obtained"]["center_of_mass"][0],
        108.0901,
        3e-3,
    );
    let half = printed(
        &dir,
        &bar,
        &["--force", "--density", "0.02*x", "--relative-to", "4"],
    );
    near(&half["infill"]["obtained"]["volume"], 3777.400 / 2.0, 1e-3);
}

fn assert_one_is_the_same(samples: impl Iterator<Item = PathBuf>) {
    let dir = TestDir::new();
    for sample in samples {
        let json = printed(&dir, &sample, &["--force", "--density", "1"]);
        assert_eq!(json["moves_changed"], 0);
        let (before, after) = (fs::read(&sample), fs::read(dir.path("out.gcode")));
        assert!(before.expect("a sample") == after.expect("an output"));
    }
}

#[test]
fn a_field_of_one_returns_the_same_bytes() {
    assert_one_is_the_same(KEPT.into_iter().map(kept));
}

#[test]
#[ignore = "needs ../shared/gcode: more samples of sliced parts than the repository keeps"]
fn shared_samples_return_the_same_bytes_for_a_field_of_one() {
    let names = KEPT
        .into_iter()
        .chain(["rocker-bare.gcode", "rocker-skins.gcode"]);
    assert_one_is_the_same(names.map(shared));
}

#[test]
fn the_bar_is_balanced_at_a_target() {
    let dir = TestDir::new();
    let json = printed(&dir, &kept(KEPT[0]), &["--stand", "--target", "97,_,_"]);
    near(&json["obtained"]["center_of_mass"][0], 97.0, 0.01);
    near(&json["distance"], 0.0, 0.01);
    assert_eq!(
        (&json["feasible"], &json["holds"]),
        (&true.into(), &true.into())
    );
    assert_eq!(json["stands"], false);
    let least = number(&json["least_range"]);
    let [low, high] = [0, 1].map(|end| number(&json["multiplier"]["limits"][end]));
    assert!((low - 1.0 + 1.5 * least).abs() < 1e-9 && (high - 1.0 - 1.5 * least).abs() < 1e-9);
    // A hundredth less than the least range is refused, a hundredth more is not.
    for (share, code) in [(0.99, 1), (1.01, 0)] {
        let range = format!("{},{}", 1.0 - share * least, 1.0 + share * least);
        let arguments = [
            "--force", "--stand", "--target", "97,_,_", "--range", &range,
        ];
        assert_eq!(print(&dir, &kept(KEPT[0]), &arguments).0, Some(code));
    }
}

/// density.md 5.3: < 0.005 mm and < 0.01° as read back.
#[test]
#[ignore = "needs ../shared/gcode: more samples of sliced parts than the repository keeps"]
fn shared_rocker_is_balanced_about_its_bore() {
    let dir = TestDir::new();
    let arguments = [
        "--spin", "--axis", BORE, "--range", "0.2,1.8", "--step", "2",
    ];
    let json = printed(&dir, &shared("rocker-bare.gcode"), &arguments);
    near(&json["distance"], 0.0, 0.005);
    near(&json["angle_degrees"], 0.0, 0.01);
    near(&json["obtained"]["volume"], 4100.35, 0.2);
    near(&json["least_range"], 0.703, 1e-3);
    let (code, json, error) = print(
        &dir,
        &shared("rocker-skins.gcode"),
        &["--force", "--spin", "--axis", BORE, "--range", "0.2,1.8"],
    );
    assert_eq!(
        (code, &json["written"], &json["feasible"]),
        (Some(1), &false.into(), &false.into())
    );
    near(&json["least_contrast"], 24.5449, 1e-3);
    near(&json["fixed_share"], 0.592, 1e-3);
    assert_all_in(&error, &["a contrast of 24.5449", "59.2 %", "fewer walls"]);
}

#[test]
fn standing_is_over_the_first_layer() {
    let dir = TestDir::new();
    let bar = kept(KEPT[2]);
    let json = printed(&dir, &bar, &["--stand"]);
    assert_eq!(
        (&json["stands"], &json["moves_changed"]),
        (&true.into(), &0.into())
    );
    near(&json["slack"], 5.0, 0.3);
    assert_all_in(&json["notes"].to_string(), &["stands on a polygon"]);
    let stable = printed(
        &dir,
        &bar,
        &[
            "--force",
            "--stand",
            "--goal",
            "most-stable",
            "--range",
            "0.5,1.5",
        ],
    );
    assert!(number(&stable["tilt_degrees"]) > number(&json["tilt_degrees"]));
    let over = printed(&dir, &bar, &["--force", "--stand", "--point", "109.5,110"]);
    near(&over["obtained"]["center_of_mass"][0], 109.5, 1e-3);
    let spun = printed(
        &dir,
        &bar,
        &[
            "--force",
            "--spin",
            "--axis",
            "110,110.02,4.6,1,0,0",
            "--range",
            "0.2,1.8",
        ],
    );
    near(&spun["distance"], 0.0, 1e-3);
    near(&spun["angle_degrees"], 0.0, 1e-3);
    dir.write("foot.csv", "x,y\n100,100\n108,100\n108,120\n100,120\n");
    let foot = printed(
        &dir,
        &bar,
        &[
            "--force",
            "--stand",
            "--polygon",
            "foot.csv",
            "--margin",
            "0.1",
        ],
    );
    assert!(number(&foot["obtained"]["center_of_mass"][0]) <= 107.9 + 1e-3);
}

#[test]
fn what_would_be_clipped_is_refused_with_what_it_would_give() {
    let dir = TestDir::new();
    let bar = kept(KEPT[0]);
    let (code, json, error) = print(&dir, &bar, &["--density", "0.01*x", "--range", "0.8,1.2"]);
    assert_eq!((code, &json["written"]), (Some(1), &false.into()));
    assert_all_in(
        &error,
        &[
            "would be clipped",
            "0.8000 and 1.2000",
            "--clip",
            "nothing is written",
        ],
    );
    assert!(number(&json["center_error"]) > 1.0 && number(&json["clipped"]["above"].clone()) > 1e3);
    assert!(!dir.path("out.gcode").exists());
    let clipped = ["--density", "0.01*x", "--range", "0.8,1.2", "--clip"];
    let clipped = printed(&dir, &bar, &clipped);
    let center = |json: &Value| number(&json["obtained"]["center_of_mass"][0]);
    assert!((center(&json) - center(&clipped)).abs() < 1e-4);
    let (code, json, error) = print(&dir, &bar, &["--force", "--density", "2.5"]);
    assert_eq!(code, Some(1));
    assert_all_in(
        &error,
        &[
            "more than 100 %",
            "50.0 % as sliced, by the file's settings",
        ],
    );
    near(&json["filling"]["share"], 0.5, 1e-12);
    let filling = ["--force", "--density", "2.5", "--filling", "30"];
    printed(&dir, &bar, &filling);
}

#[test]
fn field_files_lie_by_the_middles_of_boxes() {
    let dir = TestDir::new();
    let field = r#"{"density":{"text":"1 + 0.005*x"},"bounds":{"min":[-50,-5,-5],"max":[50,5,5]}}"#;
    dir.write("field.json", field);
    let bar = kept(KEPT[0]);
    let by_file = printed(&dir, &bar, &["--density", "@field.json"]);
    assert_all_in(
        &by_file["notes"].to_string(),
        &["placed at (100.000, 100.000, 5.000)"],
    );
    let first = fs::read_to_string(dir.path("out.gcode")).expect("an output");
    let formula = printed(&dir, &bar, &["--force", "--density", "1 + 0.005*(x - 100)"]);
    for axis in 0..3 {
        let center = &formula["obtained"]["center_of_mass"][axis];
        near(
            center,
            number(&by_file["obtained"]["center_of_mass"][axis]),
            1e-5,
        );
    }
    let placed = printed(
        &dir,
        &bar,
        &["--force", "--density", "@field.json", "--place", "90,0,0"],
    );
    assert!(number(&placed["infill"]["obtained"]["volume"]) > 3900.0);
    assert!(first.lines().count() > 20_000);
    let (code, _, error) = print(&dir, &bar, &["--force", "--density", "vertex"]);
    assert_eq!(code, Some(2));
    assert_all_in(&error, &["has no vertices"]);
}

#[test]
fn speeds_and_headers_follow() {
    let dir = TestDir::new();
    let bar = kept(KEPT[0]);
    let json = printed(&dir, &bar, &["--density", "0.5", "--keep", "flow"]);
    let text = fs::read_to_string(dir.path("out.gcode")).expect("an output");
    let added = number(&json["seconds_added"]);
    assert!(added < -10.0, "{added}");
    let seconds = (1802.0 + added).round() as u64;
    let time = format!("= {}m {}s\n", seconds / 60, seconds % 60);
    assert!(text.contains(&time), "{time}");
    assert!(text.contains("; filament used [mm] = 1860."), "filament");
    let slow = printed(
        &dir,
        &bar,
        &["--force", "--density", "1.5", "--max-flow", "5"],
    );
    assert!(number(&slow["seconds_added"]) > 10.0);
    let same = printed(
        &dir,
        &bar,
        &[
            "--force",
            "--density",
            "1",
            "--keep",
            "flow",
            "--max-flow",
            "0.1",
        ],
    );
    assert_eq!(same["moves_changed"], 0);
}

#[test]
fn reports_hold_pictures_and_the_profile() {
    let dir = TestDir::new();
    let arguments = [
        "--density",
        "0.01*x",
        "--report",
        "seen",
        "--report-layer",
        "5",
    ];
    printed(&dir, &kept(KEPT[0]), &arguments);
    let read = |name: &str| fs::read_to_string(dir.path("seen").join(name)).expect(name);
    let profile: Value = serde_json::from_str(&read("profile.json")).expect("JSON");
    assert_eq!(
        (&profile["axis"], profile["bins"].as_array().map(Vec::len)),
        (&"x".into(), Some(20))
    );
    // density.md 4.4: 0.5 % rms and 1 % at most against the field times the box; here against the lines.
    assert!(number(&profile["rms_percent"]) < 0.3 && number(&profile["max_percent"]) < 1.0);
    let first = &profile["bins"][1];
    let ratio = number(&first["obtained"]) / number(&first["as_sliced"]);
    assert!((ratio - 0.575).abs() < 0.01, "{ratio}");
    assert_eq!(read("profile.csv").lines().count(), 21);
    for name in ["layer.svg", "profile.svg"] {
        assert!(read(name).starts_with("<svg"), "{name}");
    }
    for name in ["layer.png", "profile.png"] {
        assert!(dir.path("seen").join(name).exists(), "{name}");
    }
    let (code, _, error) = print(
        &dir,
        &kept(KEPT[0]),
        &["--density", "1", "--report", "seen"],
    );
    assert_eq!(code, Some(2));
    assert_all_in(&error, &["there already"]);
}

/// What is asked, and what the refusal says.
type Refused<'a> = (&'a [&'a str], &'a [&'a str]);

fn assert_refused(dir: &TestDir, cases: &[Refused<'_>]) {
    for (arguments, parts) in cases {
        let output = dir.run(&[&["print", "-o", "out.gcode"], *arguments].concat());
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(!dir.path("out.gcode").exists(), "{arguments:?}");
        assert_all_in(&error, parts);
    }
}

const BEGIN: &str = "M83\n;TYPE:FILL\nG1 X1 E1\n";

#[test]
fn bad_files_are_refused_with_nothing_written() {
    let dir = TestDir::new();
    dir.write("cut.gcode", format!("{BEGIN}G1 X2."))
        .write("nul.gcode", format!("{BEGIN}G1 \0X2 E1\n"))
        .write("noise.gcode", b"\x01\x93\xfe\n\x88\n")
        .write("print.bgcode", b"GCDE\x01\0\0\0")
        .write("inverse.gcode", format!("{BEGIN}G93\n"))
        .write("walls.gcode", "M83\n;TYPE:Perimeter\nG1 X1 E1\n");
    assert_refused(
        &dir,
        &[
            (
                &["cut.gcode", "--density", "1"],
                &["line 4: the file ends inside"],
            ),
            (&["nul.gcode", "--density", "1"], &["line 4: a byte 0"]),
            (
                &["noise.gcode", "--density", "1"],
                &["line 1: the byte 0x01"],
            ),
            (&["print.bgcode", "--density", "1"], &["binary_gcode"]),
            (
                &["inverse.gcode", "--density", "1"],
                &["line 4: G93 is refused"],
            ),
            (
                &["walls.gcode", "--density", "1"],
                &["no infill", "'Perimeter'", "--infill"],
            ),
            (&["none.gcode", "--density", "1"], &["none.gcode"]),
        ],
    );
}

#[test]
fn bad_options_are_refused_with_nothing_written() {
    let dir = TestDir::new();
    dir.write("good.gcode", format!("{BEGIN}M84\n"));
    let mean = [
        "good.gcode",
        "--density",
        "x",
        "--relative-to",
        "mean",
        "--place",
        "9,0,0",
    ];
    assert_refused(
        &dir,
        &[
            (&["good.gcode"], &["--density"]),
            (&["good.gcode", "--density", "1 +"], &["--density"]),
            (&["good.gcode", "--density", "@none.json"], &["none.json"]),
            (
                &["good.gcode", "--density", "1", "--margin", "1"],
                &["--margin is for --stand"],
            ),
            (
                &["good.gcode", "--stand", "--axis", "0,0,0,0,0,1"],
                &["--axis is for --spin"],
            ),
            (
                &["good.gcode", "--stand", "--clip"],
                &["--clip is for --density"],
            ),
            (&["good.gcode", "--spin"], &["--axis"]),
            (
                &["good.gcode", "--stand", "--margin", "1"],
                &["a line only"],
            ),
            (
                &["good.gcode", "--density", "1", "--range", "2,1"],
                &["LO 2 is above HI 1"],
            ),
            (&mean, &["not positive"]),
        ],
    );
}

#[test]
fn mixed_line_ends_stay_and_a_missing_end_is_noted() {
    let dir = TestDir::new();
    dir.write("mixed.gcode", "M83\r\n;TYPE:FILL\rG1 X1 E1\n");
    let table = dir.stdout(&[
        "print",
        "mixed.gcode",
        "-o",
        "out.gcode",
        "--density",
        "0.5",
    ]);
    let parts = ["wanted", "obtained", "note: no end marker", "moves changed"];
    assert_all_in(&table, &parts);
    let text = fs::read_to_string(dir.path("out.gcode")).expect("an output");
    assert_eq!(text, "M83\r\n;TYPE:FILL\rG1 X1 E0.5\n");
}

#[test]
fn the_input_is_never_replaced() {
    let dir = TestDir::new();
    let text = "M83\n;TYPE:FILL\nG1 X1 E1\nM84\n";
    dir.write("in.gcode", text).write("out.gcode", "kept");
    fs::hard_link(dir.path("in.gcode"), dir.path("link.gcode")).expect("a link");
    for (output, force) in [
        ("in.gcode", true),
        ("link.gcode", true),
        ("out.gcode", false),
    ] {
        let force: &[&str] = if force { &["--force"] } else { &[] };
        let arguments = ["print", "in.gcode", "--density", "0.5", "-o", output];
        let run = dir.run(&[&arguments, force].concat());
        assert_eq!(run.status.code(), Some(2), "{output}");
        let read = |name: &str| fs::read_to_string(dir.path(name)).expect(name);
        assert_eq!(
            (read("in.gcode"), read("out.gcode")),
            (text.into(), "kept".into())
        );
    }
}
