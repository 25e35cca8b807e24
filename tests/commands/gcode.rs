//! The command `chebloyd mass` on G-code: figures of sliced samples, options, refusals.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use crate::test_dir::{TestDir, assert_all_in};
use serde_json::Value;

/// What a sample weighs (mm³, mm), and its infill; figures of the samples' README, counted by another
/// program and by the slicer's own length of filament.
struct Sample {
    name: &'static str,
    volume: f64,
    center: [f64; 3],
    infill: (&'static str, f64),
}

const KEPT: [Sample; 3] = [
    Sample {
        name: "bar-prusaslicer.gcode",
        volume: 6363.222,
        center: [100.00372, 100.00034, 5.01511],
        infill: ("Internal infill", 3777.400),
    },
    Sample {
        name: "bar-gyroid-absolute.gcode",
        volume: 4532.517,
        center: [100.03089, 99.99578, 5.01353],
        infill: ("Internal infill", 2396.059),
    },
    Sample {
        name: "bar-cura.gcode",
        volume: 4902.827,
        center: [109.99923, 109.99953, 4.60535],
        infill: ("FILL", 1294.498),
    },
];

const SHARED: [Sample; 2] = [
    Sample {
        name: "rocker-skins.gcode",
        volume: 6610.774,
        center: [101.24126, 97.81052, 8.93756],
        infill: ("Internal infill", 2698.303),
    },
    Sample {
        name: "rocker-bare.gcode",
        volume: 4979.838,
        center: [101.66588, 97.39448, 9.04191],
        infill: ("Internal infill", 3699.810),
    },
];

pub(crate) fn kept(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("tests/cases/gcode").join(name)
}

pub(crate) fn shared(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folders = ["../shared/gcode", "../../shared/gcode"].map(|folder| root.join(folder));
    let folder = folders.iter().find(|folder| folder.exists());
    folder.unwrap_or(&folders[0]).join(name)
}

fn json(dir: &TestDir, arguments: &[&str]) -> Value {
    let arguments = [&["mass", "--json"], arguments].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn near(value: &Value, expected: f64, tolerance: f64) {
    let got = value.as_f64().expect("a number");
    assert!(
        (got - expected).abs() <= tolerance,
        "{got} is not {expected}"
    );
}

fn assert_weighs(path: &Path, sample: &Sample) {
    let print = json(&TestDir::new(), &[path.to_str().expect("a path")]);
    near(&print["volume"], sample.volume, 1e-3);
    near(&print["mass"], sample.volume, 1e-3);
    for axis in 0..3 {
        near(&print["center_of_mass"][axis], sample.center[axis], 1e-5);
    }
    let (name, volume) = sample.infill;
    near(&print["types"][name]["volume"], volume, 1e-3);
    let types = print["types"].as_object().expect("types").values();
    let sum: f64 = types
        .map(|one| one["volume"].as_f64().expect("a volume"))
        .sum();
    near(&print["deposited"]["volume"], sum, 1e-9);
}

#[test]
fn samples_weigh_what_their_readme_says() {
    for sample in &KEPT {
        assert_weighs(&kept(sample.name), sample);
    }
}

#[test]
#[ignore = "needs ../shared/gcode: more samples of sliced parts than the repository keeps"]
fn shared_samples_weigh_what_their_readme_says() {
    for sample in KEPT.iter().chain(&SHARED) {
        assert_weighs(&shared(sample.name), sample);
    }
}

/// Two bars of 10 mm, one by each tool, for two objects; a skirt, a prime line and an end.
const PLATE: &str = "M83\nG1 X5 E10\n;LAYER_CHANGE\n;HEIGHT:0.2\n;TYPE:Skirt\nG0 Z.2\nG1 X50 E1\n;TYPE:Outer wall\n\
EXCLUDE_OBJECT_START NAME=left\nG0 X0 Y0\nG1 X10 E1\nEXCLUDE_OBJECT_END NAME=left\nT1\n\
EXCLUDE_OBJECT_START NAME=right\nG0 X20 Y0\n;TYPE:Sparse infill\nG1 X30 E3\nEXCLUDE_OBJECT_END NAME=right\nM84\n\
; filament_diameter = 1.75,1.75\n; filament_density = 1.25,1\n";

/// mm³ of a mm of filament.
const SECTION: f64 = 2.405_281_875_404_685;

fn plate() -> TestDir {
    let dir = TestDir::new();
    dir.write("plate.gcode", PLATE);
    dir
}

#[test]
fn part_types_tools_and_objects_are_told_apart() {
    let print = json(&plate(), &["plate.gcode"]);
    near(&print["volume"], 4.0 * SECTION, 1e-12);
    assert!(print["surface_area"].is_null());
    near(&print["center_of_mass"][0], 20.0, 1e-12);
    near(&print["center_of_mass"][2], 0.1, 1e-12);
    near(&print["deposited"]["volume"], 15.0 * SECTION, 1e-12);
    near(
        &print["types"]["(start code)"]["volume"],
        10.0 * SECTION,
        1e-12,
    );
    near(&print["types"]["Skirt"]["center_of_mass"][0], 27.5, 1e-12);
    near(&print["tools"]["0"]["volume"], SECTION, 1e-12);
    near(
        &print["tools"]["0"]["deposited"]["volume"],
        12.0 * SECTION,
        1e-12,
    );
    near(&print["tools"]["1"]["center_of_mass"][0], 25.0, 1e-12);
    near(&print["objects"]["left"]["center_of_mass"][0], 5.0, 1e-12);
    near(&print["objects"]["right"]["volume"], 3.0 * SECTION, 1e-12);
    near(&print["grams"], 4.25 * SECTION / 1000.0, 1e-14);
    near(&print["deposited"]["grams"], 18.0 * SECTION / 1000.0, 1e-14);
    near(&print["tools"]["1"]["grams"], 3.0 * SECTION / 1000.0, 1e-14);
    for tensor in ["inertia_origin", "inertia_center", "principal_axes"] {
        assert!(print["deposited"][tensor][2][2].is_f64(), "{tensor}");
    }
    let notes = print["notes"].to_string();
    assert_all_in(
        &notes,
        &[
            "not in the part: (start code) (24.053 mm³), Skirt",
            "different densities",
        ],
    );
}

#[test]
fn options_choose_types_and_say_densities_and_diameters() {
    let dir = plate();
    let of = |arguments: &[&str]| json(&dir, &[&["plate.gcode"], arguments].concat());
    near(&of(&["--only", "skirt"])["volume"], SECTION, 1e-12);
    near(
        &of(&["--only", "Skirt,outer WALL"])["volume"],
        2.0 * SECTION,
        1e-12,
    );
    near(
        &of(&["--without", "Outer wall"])["volume"],
        3.0 * SECTION,
        1e-12,
    );
    let heavy = of(&["--material-density", "2"]);
    near(&heavy["mass"], 8.0 * SECTION, 1e-12);
    near(&heavy["deposited"]["mass"], 30.0 * SECTION, 1e-12);
    let two = of(&["--material-density", "3,1"]);
    near(&two["mass"], 6.0 * SECTION, 1e-12);
    near(&two["center_of_mass"][0], 15.0, 1e-12);
    let weighed = of(&["--mass", "8", "--axis", "20,0,0,0,0,1"]);
    near(&weighed["mass"], 8.0, 1e-12);
    near(&weighed["deposited"]["mass"], 30.0, 1e-12);
    assert!(weighed["moment_about_axis"].is_f64());
    let thick = of(&["--filament", "3.5", "--filament-density", "2"]);
    near(&thick["volume"], 16.0 * SECTION, 1e-11);
    near(&thick["grams"], 32.0 * SECTION / 1000.0, 1e-13);
    assert!(of(&["--filament-density", "0"]).get("grams").is_none());
}

#[test]
fn inertia_is_that_of_the_beads() {
    let dir = TestDir::new();
    // A bead 10 long along x, 0.2 high, 0.4 wide: its box's inertia.
    let pushed = 10.0 * 0.2 * 0.4 / SECTION;
    dir.write(
        "bead.gcode",
        format!("M83\n;HEIGHT:0.2\nG0 Z.2\nG1 X10 E{pushed}\nM84\n"),
    );
    let bead = json(&dir, &["bead.gcode"]);
    let squares = [100.0, 0.16, 0.04];
    for axis in 0..3 {
        let expected = 0.8 / 12.0 * (squares.iter().sum::<f64>() - squares[axis]);
        near(&bead["inertia_center"][axis][axis], expected, 1e-12);
    }
}

#[test]
fn the_table_lists_types_and_notes() {
    let path = kept("bar-gyroid-absolute.gcode");
    let table = TestDir::new().stdout(&["mass", path.to_str().expect("a path")]);
    let parts = [
        "volume                           4532.516798",
        "deposited volume                 4649.918294",
        "type Internal infill             2396.059351         100.0474715",
        "note: not in the part: Skirt/Brim (117.401 mm³)",
    ];
    assert_all_in(&table, &parts);
    assert!(!table.contains("surface area"), "{table}");
}

#[test]
fn bad_files_and_options_are_refused_with_nothing_printed() {
    let dir = plate();
    dir.write("spline.gcode", "M83\nG1 X1 E1\nG5 X2 E1\n")
        .write("nul.gcode", b"M83\nG1 X1 E1\nG1 \0X2 E1\n")
        .write("cut.gcode", "M83\nG1 X1 E1\nG1 X2.")
        .write("noise.gcode", b"\x01\x93\xfe\n\x88\n")
        .write("print.bgcode", b"GCDE\x01\0\0\0")
        .write("plate.gcode.3mf", b"PK\x03\x04")
        .write("empty.gcode", "")
        .write("skirt.gcode", ";TYPE:Skirt\nM83\nG1 X1 E1\n")
        .write("cube.off", "OFF\n");
    for (arguments, parts) in [
        (
            &["spline.gcode"][..],
            &["spline.gcode: line 3: G5 is refused"][..],
        ),
        (&["nul.gcode"], &["line 3: a byte 0"]),
        (
            &["cut.gcode"],
            &["line 3: the file ends inside this command"],
        ),
        (&["noise.gcode"], &["line 1: the byte 0x01 at column 1"]),
        (&["print.bgcode"], &["binary_gcode"]),
        (&["plate.gcode.3mf"], &["Export G-code", "use_3mf"]),
        (&["empty.gcode"], &["deposits nothing"]),
        (&["none.gcode"], &["none.gcode"]),
        (&["skirt.gcode"], &["'Skirt'", "--only"]),
        (
            &["plate.gcode", "--only", "Wall"],
            &["no feature type 'Wall'", "'Outer wall'"],
        ),
        (
            &["plate.gcode", "--material-density", "1,2,-3"],
            &["zero or more"],
        ),
        (&["plate.gcode", "--filament", "0"], &["positive"]),
        (&["plate.gcode", "plate.gcode"], &["one at a time"]),
        (&["plate.gcode", "--density", "2"], &["--material-density"]),
        (
            &["plate.gcode", "--mass", "2", "--mass", "3"],
            &["--mass is given 2 times"],
        ),
        (&["cube.off", "--only", "Wall"], &["--only is for G-code"]),
    ] {
        let output = dir.run(&[&["mass"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert_all_in(&String::from_utf8_lossy(&output.stderr), parts);
    }
}

/// Prints the times of weighing 100 MB beside `wc -l` and `gzip -d` of the same file.
#[test]
#[ignore = "writes 100 MB and measures; `cargo test --release --test commands -- --ignored --nocapture hundred`"]
fn a_hundred_megabytes_beside_wc_and_gzip() {
    let dir = TestDir::new();
    let sample = fs::read(kept("bar-prusaslicer.gcode")).expect("a sample");
    let path = dir.path("long.gcode");
    let mut file = BufWriter::new(File::create(&path).expect("a file"));
    for _ in 0..100_000_000 / sample.len() + 1 {
        file.write_all(&sample).expect("room");
    }
    drop(file);
    let timed = |command: &mut Command| {
        let start = Instant::now();
        let status = command.stdout(Stdio::null()).status().expect("it starts");
        assert!(status.success(), "{command:?}");
        start.elapsed().as_secs_f64()
    };
    let mut times = Vec::new();
    times.push(("wc -l", timed(Command::new("wc").arg("-l").arg(&path))));
    timed(Command::new("gzip").arg("-k").arg(&path));
    let packed = dir.path("long.gcode.gz");
    times.push((
        "gzip -d",
        timed(Command::new("gzip").arg("-dc").arg(packed)),
    ));
    times.push((
        "chebloyd mass",
        timed(&mut dir.command(&["mass", "long.gcode"])),
    ));
    for (name, seconds) in times {
        println!("{name:<16}{seconds:>6.2} s");
    }
}
