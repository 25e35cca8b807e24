//! `chebloyd mesh`: files, reports, limits, refusals.

use std::io::Write;

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

const KEYS: [&str; 20] = [
    "points",
    "faces",
    "cells",
    "patches",
    "kinds",
    "volume",
    "non_orthogonality_max",
    "non_orthogonality_mean",
    "skewness_max",
    "skewness_wall_max",
    "bad_pyramids",
    "aspect_max",
    "flatness_min",
    "concave_cells",
    "edge_min",
    "face_min",
    "solid_volume",
    "scaled_jacobian_min",
    "scaled_jacobian_p5",
    "open_cells",
];

const FILES: [&str; 5] = ["points", "faces", "owner", "neighbour", "boundary"];

/// A directory with a run of 30 sites in `run`.
fn with_run() -> TestDir {
    let dir = TestDir::new();
    dir.write(
        "s.json",
        r#"{ "sites": { "random": { "count": 30 } }, "output": { "cells": false, "plot": false } }"#,
    );
    dir.stdout(&[
        "relax",
        "s.json",
        "--iterations",
        "1",
        "--out",
        "run",
        "--quiet",
    ]);
    dir
}

/// Asserts that a command is refused with all of these words.
fn assert_refused(dir: &TestDir, arguments: &[&str], words: &[&str]) {
    assert_all_in(&dir.refusal(arguments), words);
}

fn report(text: &str) -> Value {
    serde_json::from_str(text).expect("one JSON object")
}

#[test]
fn a_run_becomes_a_case_that_reads_back_the_same() {
    let dir = with_run();
    let made = dir.stdout(&[
        "mesh",
        "run",
        "-o",
        "case",
        "--to",
        "polymesh,vtu",
        "--json",
    ]);
    let made = report(&made);
    for key in KEYS {
        assert!(made.get(key).is_some(), "{key}");
    }
    assert_eq!(made, dir.json("case/mesh.json"));
    assert_eq!(
        (&made["cells"], &made["open_cells"], &made["bad_pyramids"]),
        (&30.into(), &0.into(), &0.into())
    );
    assert!((made["volume"].as_f64().expect("a volume") - 1.0).abs() < 1e-12);
    let sides = made["patches"].as_object().expect("patches").keys();
    assert_eq!(
        sides.collect::<Vec<_>>(),
        ["xmax", "xmin", "ymax", "ymin", "zmax", "zmin"]
    );
    let mut checked = report(&dir.stdout(&["mesh", "--check", "case", "--json"]));
    checked["solid_volume"] = made["solid_volume"].clone();
    assert_eq!(checked, made);
    for name in ["controlDict", "fvSchemes", "fvSolution"] {
        assert!(dir.path("case/system").join(name).exists());
    }
    let head = String::from_utf8_lossy(&dir.read("case/mesh.vtu")[..400]).into_owned();
    assert_all_in(&head, &["UnstructuredGrid", "NumberOfCells=\"30\""]);
    let points = format!("NumberOfPoints=\"{}\"", made["points"]);
    assert_all_in(&head, &[points.as_str()]);
    let table = dir.stdout(&["mesh", "--check", "case"]);
    assert_all_in(
        &table,
        &["30 cells", "polyhedron", "non-orthogonality", "skewness"],
    );
}

#[test]
fn threads_do_not_change_a_byte() {
    let dir = with_run();
    for threads in ["1", "3"] {
        dir.stdout(&[
            "mesh",
            "run",
            "-o",
            threads,
            "--to",
            "polymesh,vtu",
            "--quiet",
            "--threads",
            threads,
        ]);
    }
    for name in FILES {
        let name = |threads: &str| format!("{threads}/constant/polyMesh/{name}");
        assert_eq!(dir.read(&name("1")), dir.read(&name("3")));
    }
    assert_eq!(dir.read("1/mesh.vtu"), dir.read("3/mesh.vtu"));
}

#[test]
fn a_mesh_is_replaced_on_request_only_and_system_stays() {
    let dir = with_run();
    let mesh = ["mesh", "run", "-o", "case", "--quiet"];
    dir.stdout(&mesh);
    dir.write("case/system/fvSchemes", "mine");
    assert_refused(&dir, &mesh, &["mesh.json exists", "--force"]);
    dir.stdout(&["mesh", "run", "-o", "case", "--quiet", "--force"]);
    assert_eq!(dir.read("case/system/fvSchemes"), b"mine");
}

#[test]
fn a_passed_limit_fails_and_the_report_is_printed_all_the_same() {
    let dir = with_run();
    let output = dir.run(&[
        "mesh",
        "run",
        "-o",
        "case",
        "--json",
        "--limit",
        "skew=0.01,nonorth=90",
    ]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(report(&text)["cells"], 30);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_all_in(&error, &["skew is", "above 0.01"]);
    assert!(!error.contains("nonorth"));
}

#[test]
fn a_periodic_run_has_pairs_of_patches() {
    let dir = TestDir::new();
    dir.write(
        "s.json",
        r#"{ "domain": { "box": { "max": [2, 1, 1], "periodic": [true, false, false] } }, "sites": { "random": { "count": 40 } },
             "output": { "cells": false, "plot": false } }"#,
    );
    dir.stdout(&[
        "relax",
        "s.json",
        "--iterations",
        "1",
        "--out",
        "run",
        "--quiet",
    ]);
    let made = report(&dir.stdout(&["mesh", "run", "-o", "case", "--scale", "2", "--json"]));
    assert!((made["volume"].as_f64().expect("a volume") - 16.0).abs() < 1e-11);
    let boundary = String::from_utf8(dir.read("case/constant/polyMesh/boundary")).expect("text");
    assert_all_in(
        &boundary,
        &[
            "cyclic;",
            "separationVector (4.0 0.0 0.0)",
            "neighbourPatch  xmin;",
            "ymax",
        ],
    );
    let mut checked = report(&dir.stdout(&["mesh", "--check", "case", "--json"]));
    checked["solid_volume"] = made["solid_volume"].clone();
    assert_eq!(checked, made);
}

#[test]
fn bad_input_is_refused_with_the_mend() {
    let dir = with_run();
    assert_refused(
        &dir,
        &["mesh", "nowhere", "-o", "case"],
        &["nowhere holds no run", "chebloyd relax"],
    );
    assert_refused(&dir, &["mesh", "run"], &["--output"]);
    assert_refused(
        &dir,
        &["mesh", "run", "-o", "case", "--to", "stl"],
        &["polymesh", "vtu"],
    );
    assert_refused(
        &dir,
        &["mesh", "run", "-o", "case", "--limit", "skewness=4"],
        &["skew"],
    );
    assert_refused(
        &dir,
        &["mesh", "run", "-o", "case", "--scale", "0"],
        &["not positive"],
    );
    assert!(!dir.path("case").exists());
    let run = String::from_utf8(dir.read("run/run.json")).expect("text");
    dir.write(
        "run/run.json",
        run.replace("\"dimension\": 3", "\"dimension\": 2"),
    );
    assert_refused(&dir, &["mesh", "run", "-o", "case"], &["\"dimension\": 3"]);
}

#[test]
fn collapse_shortens_the_list_of_faces_and_keeps_the_volume() {
    let dir = with_run();
    let raw = report(&dir.stdout(&["mesh", "run", "-o", "raw", "--json"]));
    let made = report(&dir.stdout(&["mesh", "run", "-o", "case", "--collapse", "0.1", "--json"]));
    let count = |report: &Value| report["faces"].as_u64().expect("a count");
    assert!(count(&made) < count(&raw));
    assert!((made["volume"].as_f64().expect("a volume") - 1.0).abs() < 1e-12);
    assert_eq!(
        (&made["open_cells"], &made["bad_pyramids"]),
        (&0.into(), &0.into())
    );
    let too_far = ["mesh", "run", "-o", "other", "--collapse", "2"];
    assert_refused(&dir, &too_far, &["between 0 and 0.5"]);
}

#[test]
fn damaged_meshes_are_refused_with_the_place() {
    let dir = with_run();
    dir.stdout(&["mesh", "run", "-o", "case", "--quiet"]);
    let check = ["mesh", "--check", "case"];
    let owner = "case/constant/polyMesh/owner";
    let good = String::from_utf8(dir.read(owner)).expect("text");
    dir.write(owner, &good[..good.len() - 20]);
    assert_refused(&dir, &check, &["owner:", "truncated"]);
    dir.write(owner, good.replacen("\n0\n", "\nzero\n", 1));
    assert_refused(&dir, &check, &["owner:", "`zero`"]);
    dir.write(owner, good.replacen("\n0\n", "\n29\n", 1));
    assert_refused(&dir, &check, &["upper-triangular"]);
    dir.write(owner, &good);
    let faces = "case/constant/polyMesh/faces";
    let text = String::from_utf8(dir.read(faces)).expect("text");
    let first = text
        .lines()
        .find(|line| line.contains('(') && line.len() > 2)
        .expect("a face");
    let (count, corners) = first.split_once('(').expect("a face");
    let mut numbers: Vec<&str> = corners.trim_end_matches(')').split(' ').collect();
    numbers.swap(0, 1);
    dir.write(
        faces,
        text.replacen(first, &format!("{count}({})", numbers.join(" ")), 1),
    );
    assert_refused(&dir, &check, &["is not closed"]);
    std::fs::remove_file(dir.path(faces)).expect("it is there");
    assert_refused(&dir, &check, &["faces", "cannot be read"]);
}

/// The numbers of an ASCII list, without its header.
fn body(text: &str) -> &str {
    let start = text.find("}\n").expect("a header") + 2;
    text[start..].trim()
}

#[test]
fn compressed_and_binary_meshes_are_read() {
    let dir = with_run();
    let made = report(&dir.stdout(&["mesh", "run", "-o", "case", "--json"]));
    let folder = "case/constant/polyMesh";
    let owner = dir.read(&format!("{folder}/owner"));
    let file = std::fs::File::create(dir.path(folder).join("owner.gz")).expect("a file");
    let mut packed = flate2::write::GzEncoder::new(file, flate2::Compression::default());
    packed.write_all(&owner).expect("room");
    packed.finish().expect("room");
    std::fs::remove_file(dir.path(folder).join("owner")).expect("it is there");
    let text = String::from_utf8(dir.read(&format!("{folder}/neighbour"))).expect("text");
    let numbers: Vec<i64> = body(&text)
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .skip(1)
        .collect();
    let head = "FoamFile { version 2.0; format binary; arch \"LSB;label=64;scalar=64\"; class labelList; object neighbour; }";
    let mut binary = format!("{head}\n{}\n(", numbers.len()).into_bytes();
    binary.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    binary.extend(b")\n");
    dir.write(&format!("{folder}/neighbour"), binary);
    let mut checked = report(&dir.stdout(&["mesh", "--check", folder, "--json"]));
    checked["solid_volume"] = made["solid_volume"].clone();
    assert_eq!(checked, made);
}

/// Figures of checkMesh (OpenFOAM v1912, Debian), which writes 17 digits where `system/controlDict` says so:
/// `chebloyd mesh run -o case --collapse 0.2`, `WM_PROJECT_DIR=/usr/share/openfoam checkMesh -case case
/// -allGeometry -allTopology`.
const OF_CHECK_MESH: [(&str, f64, f64); 7] = [
    (
        "non_orthogonality_max",
        16.287795212051513,
        24.120755603535507,
    ),
    (
        "non_orthogonality_mean",
        6.201798596570012,
        6.96644212654703,
    ),
    ("skewness_max", 2.78658766207396, 2.7805984454738772),
    ("aspect_max", 2.7642638757105105, 2.728536892381186),
    ("edge_min", 0.0016490200342873795, 0.023729611639617565),
    ("face_min", 4.779541844437855e-06, 0.0008815228437941534),
    ("flatness_min", 0.9999999999999997, 0.9869699837846644),
];

#[test]
fn figures_are_those_of_check_mesh() {
    let dir = with_run();
    let raw = report(&dir.stdout(&["mesh", "run", "-o", "raw", "--json"]));
    let collapsed = ["mesh", "run", "-o", "case", "--collapse", "0.2", "--json"];
    let collapsed = report(&dir.stdout(&collapsed));
    for (name, of_raw, of_collapsed) in OF_CHECK_MESH {
        for (report, theirs) in [(&raw, of_raw), (&collapsed, of_collapsed)] {
            let ours = report[name].as_f64().expect("a number");
            // The flattest of its faces is bent; there the two differ by 5e-9.
            let most = if name == "flatness_min" { 1e-8 } else { 1e-9 };
            assert!(
                (ours - theirs).abs() < most * theirs.max(1.0),
                "{name}: {ours} {theirs}"
            );
        }
    }
}

#[test]
fn faces_pictures_and_a_vtu_file_are_written_and_measured() {
    let dir = with_run();
    let formats = ["--to", "polymesh,vtu,faces", "--picture", "--json"];
    let made = report(&dir.stdout(&[&["mesh", "run", "-o", "case"], &formats[..]].concat()));
    let head = String::from_utf8_lossy(&dir.read("case/faces.vtu")[..1500]).into_owned();
    let count = format!("NumberOfCells=\"{}\"", made["faces"]);
    assert_all_in(
        &head,
        &[&count, "\"area\"", "\"owner\"", "\"neighbor\"", "\"wall\""],
    );
    assert!(dir.read("case/mesh.png").starts_with(b"\x89PNG"));
    let picture = String::from_utf8(dir.read("case/mesh.svg")).expect("text");
    assert_all_in(
        &picture,
        &[
            "Non-orthogonality",
            "Skewness",
            "Faces of a cell",
            "Scaled Jacobian",
        ],
    );
    let mut checked = report(&dir.stdout(&["mesh", "--check", "case/mesh.vtu", "--json"]));
    for key in ["solid_volume", "patches"] {
        checked[key] = made[key].clone();
    }
    for (key, value) in made.as_object().expect("an object") {
        match value.as_f64() {
            // Sums over faces, which have another order.
            Some(number) => {
                let other = checked[key].as_f64().expect("a number");
                assert!(
                    (number - other).abs() < 1e-12 * number.abs().max(1.0),
                    "{key}"
                );
            }
            None if key == "kinds" => assert_eq!(checked[key]["polyhedron"]["count"], 30),
            None => assert_eq!(&checked[key], value, "{key}"),
        }
    }
    let check = ["mesh", "--check", "case/mesh.svg"];
    assert_refused(&dir, &check, &["mesh.svg", ".vtu file"]);
    dir.write("case/bad.vtu", &dir.read("case/mesh.vtu")[..900]);
    assert_refused(&dir, &["mesh", "--check", "case/bad.vtu"], &["bad.vtu:"]);
}

#[test]
fn parts_that_share_a_wall_are_refused_with_the_mend() {
    let dir = TestDir::new();
    let parts = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/cases/shell-with-core-own-nodes.off"
    );
    let words = [
        "lie on each other at [",
        "every part alone",
        "unite the parts",
    ];
    let at_once = ["mesh", parts, "--edge", "1", "-o", "case"];
    assert_refused(&dir, &at_once, &words);
    assert!(!dir.path("case").exists());
}

#[test]
fn a_solid_is_relaxed_and_meshed_at_once() {
    let dir = TestDir::new();
    dir.write("cube.off", CUBE);
    std::fs::create_dir_all(dir.path("case/system")).expect("room");
    dir.write("case/system/controlDict", "mine");
    let solid = ["cube.off", "--edge", "0.7"];
    let at_once = [&["mesh"], &solid[..], &["-o", "case", "--json"]].concat();
    let made = report(&dir.stdout(&at_once));
    assert_eq!(
        std::fs::read_dir(dir.path("case/system"))
            .expect("a folder")
            .count(),
        1
    );
    let relax = [
        &["relax"],
        &solid[..],
        &["--goal", "mesh", "--out", "run", "--quiet"],
    ]
    .concat();
    dir.stdout(&relax);
    assert_eq!(
        made,
        report(&dir.stdout(&["mesh", "run", "-o", "other", "--json"]))
    );
    assert_eq!(made["cells"], 27);
    assert_refused(
        &dir,
        &["mesh", "cube.off", "-o", "new"],
        &["cube.off", "--edge L"],
    );
    assert_refused(
        &dir,
        &["mesh", "run", "--edge", "1", "-o", "new"],
        &["a run has its sites"],
    );
    assert_refused(
        &dir,
        &["mesh", "cube.off", "--edge", "-1", "-o", "new"],
        &["positive length"],
    );
    assert_refused(
        &dir,
        &["mesh", "cube.off", "--edge", "1+", "-o", "new"],
        &["1+"],
    );
    assert!(!dir.path("new").exists());
    // ∫ h⁻³ over the cube of h = 1/2 + (x − 4)/4 is 4 · 2 · (4 − 1) = 24.
    let graded = ["measure", "cube.off", "--edge", "0.5 + 0.25*(x-4)"];
    assert_eq!(report(&dir.stdout(&graded))["sites"], 24);
}

#[test]
fn cells_of_a_run_share_their_points() {
    let dir = TestDir::new();
    dir.write(
        "s.json",
        r#"{ "sites": { "grid": { "counts": [2, 2, 2] } }, "output": { "plot": false } }"#,
    );
    dir.stdout(&[
        "relax",
        "s.json",
        "--iterations",
        "0",
        "--out",
        "run",
        "--quiet",
    ]);
    let bytes = dir.read("run/cells.vtu");
    let head = String::from_utf8_lossy(&bytes);
    assert_all_in(
        &head,
        &[
            "NumberOfPoints=\"27\" NumberOfCells=\"8\"",
            "Scalars=\"energy\"",
            "Name=\"facets\"",
        ],
    );
}

/// A cube of side 2 about (5, 0, 0), as triangles.
const CUBE: &str = "OFF\n8 12 0\n4 -1 -1\n6 -1 -1\n4 1 -1\n6 1 -1\n4 -1 1\n6 -1 1\n4 1 1\n6 1 1\n\
3 0 2 1\n3 1 2 3\n3 4 5 6\n3 5 7 6\n3 0 1 4\n3 1 5 4\n3 2 6 3\n3 3 6 7\n3 0 4 2\n3 2 4 6\n3 1 3 5\n3 3 7 5\n";

#[test]
fn a_solid_keeps_the_coordinates_of_its_file_and_has_patches() {
    let dir = TestDir::new();
    dir.write("cube.off", CUBE);
    dir.write(
        "s.json",
        r#"{ "domain": { "surface": "cube.off", "scale_to": "unit_cube" },
             "sites": { "random": { "count": 20 } }, "output": { "cells": false, "plot": false } }"#,
    );
    dir.stdout(&[
        "relax",
        "s.json",
        "--iterations",
        "1",
        "--out",
        "run",
        "--quiet",
    ]);
    let made = report(&dir.stdout(&["mesh", "run", "-o", "case", "--json"]));
    for key in ["volume", "solid_volume"] {
        assert!(
            (made[key].as_f64().expect("a volume") - 8.0).abs() < 1e-12,
            "{key}"
        );
    }
    assert_eq!(made["patches"].as_object().expect("patches").len(), 6);
    let text = String::from_utf8(dir.read("case/constant/polyMesh/points")).expect("text");
    let points = body(&text)
        .lines()
        .filter(|line| line.starts_with('(') && line.len() > 1);
    let first = |line: &str| {
        let number = line.trim_start_matches('(').split(' ').next();
        number
            .and_then(|word| word.parse::<f64>().ok())
            .expect("a number")
    };
    let x: Vec<f64> = points.map(first).collect();
    let ends = x
        .iter()
        .fold([9.0_f64, 0.0], |[low, high], &x| [low.min(x), high.max(x)]);
    assert!(
        (ends[0] - 4.0).abs() < 1e-12 && (ends[1] - 6.0).abs() < 1e-12,
        "{ends:?}"
    );
}

// All formats were read back once, of the bracket's 1981 elements (`mesh SOLID --edge 0.112 --elements hexes --to
// polymesh,vtu,msh,inp,medit,su2`): VTK 9.7.2 (no negative volume, prisms included, sum 1.4030009), Gmsh 4.15.2 (MSH,
// hexahedra and tetrahedra of MEDIT: all determinants positive), meshio 5.3.5 (MSH, INP, MEDIT, SU2: the same counts), CalculiX 2.20 (a heat
// step, pyramids as degenerate C3D8, volume 1.403001), checkMesh v1912 (the same counts, Mesh OK).

/// The elements of an MSH 4.1 file: type and the places of the corners, in file order.
fn gmsh_elements(text: &str) -> Vec<(u32, Vec<[f64; 3]>)> {
    let section = |name: &str| -> Vec<&str> {
        let start = text.find(&format!("${name}\n")).expect("a section");
        let body = &text[start + name.len() + 2..];
        let end = body.find("$End").expect("its end");
        body[..end].lines().collect()
    };
    let nodes = section("Nodes");
    let count: usize = nodes[1]
        .split(' ')
        .nth(3)
        .expect("a count")
        .parse()
        .expect("a number");
    let place = |line: &str| -> [f64; 3] {
        let numbers: Vec<f64> = line
            .split(' ')
            .map(|x| x.parse().expect("a number"))
            .collect();
        numbers.try_into().expect("three")
    };
    let points: Vec<[f64; 3]> = nodes[2 + count..].iter().map(|line| place(line)).collect();
    assert_eq!(points.len(), count);
    let mut lines = section("Elements").into_iter().skip(1);
    let mut elements = Vec::new();
    while let Some(head) = lines.next() {
        let head: Vec<u32> = head
            .split(' ')
            .map(|x| x.parse().expect("a number"))
            .collect();
        for line in lines.by_ref().take(head[3] as usize) {
            let tags = line.split(' ').skip(1);
            let corners = tags.map(|tag| points[tag.parse::<usize>().expect("a tag") - 1]);
            elements.push((head[2], corners.collect()));
        }
    }
    elements
}

/// Six times the volume of a tetrahedron.
fn six_volume(a: [f64; 3], b: [f64; 3], c: [f64; 3], d: [f64; 3]) -> f64 {
    let [u, v, w] = [b, c, d].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    let normal = [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ];
    normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2]
}

#[test]
fn hexahedra_go_to_six_formats_and_fill_the_cube() {
    let dir = with_run();
    let arguments = "mesh run -o hexes --elements hexes --collapse 0.1 --json \
                     --to polymesh,vtu,msh,inp,medit,su2";
    let report = report(&dir.stdout(&arguments.split_whitespace().collect::<Vec<_>>()));
    let kinds = ["hexahedron", "prism", "pyramid", "tetrahedron"];
    let counts = kinds.map(|kind| report["kinds"][kind]["count"].as_u64().expect("a count"));
    let all: u64 = counts.iter().sum();
    assert_eq!(report["cells"], all);
    assert!((report["volume"].as_f64().expect("a volume") - 1.0).abs() < 1e-12);
    let checked: Value = self::report(&dir.stdout(&["mesh", "--check", "hexes", "--json"]));
    assert_eq!(
        (&checked["cells"], &checked["kinds"]),
        (&report["cells"], &report["kinds"])
    );
    let text = |name: &str| String::from_utf8(dir.read(&format!("hexes/{name}"))).expect("text");
    let elements = gmsh_elements(&text("mesh.msh"));
    let of = |kind: u32| elements.iter().filter(|(of, _)| *of == kind).count() as u64;
    assert_eq!([5, 6, 7, 4].map(of), counts);
    // Prisms and pyramids by tetrahedra along diagonals; their quadrilaterals are not plane, so this and the
    // sum with the rest agree to the twist only.
    let tetrahedra = elements.iter().filter(|(kind, _)| *kind == 4);
    for (_, p) in tetrahedra {
        assert!(six_volume(p[0], p[1], p[2], p[3]) > 0.0);
    }
    assert_all_in(
        &text("mesh.msh"),
        &["2 1 \"xmin\"", "2 6 \"zmax\"", "3 7 \"volume\""],
    );
    let su2 = text("mesh.su2");
    assert_all_in(
        &su2,
        &[&format!("NELEM= {all}"), "NMARK= 6", "MARKER_TAG= ymax"],
    );
    let medit = text("mesh.mesh");
    for (keyword, count) in ["Hexahedra", "Prisms", "Pyramids", "Tetrahedra"]
        .iter()
        .zip(counts)
    {
        let section = format!("{keyword}\n{count}\n");
        assert!(count == 0 || medit.contains(&section), "{section}");
    }
    let inp = text("mesh.inp");
    assert_all_in(
        &inp,
        &["*SURFACE, NAME=xmin, TYPE=ELEMENT", "*ELSET, ELSET=SOLID"],
    );
    let walls = elements
        .iter()
        .filter(|(kind, _)| [2, 3].contains(kind))
        .count();
    let sides = inp
        .lines()
        .filter(|line| line.contains(", S"))
        .filter(|line| !line.starts_with('*'));
    assert_eq!(sides.count(), walls);
}

#[test]
fn polyhedra_are_refused_where_a_format_has_none() {
    let dir = with_run();
    for format in ["msh", "inp", "medit", "su2"] {
        let arguments = ["mesh", "run", "-o", "case", "--to", format];
        assert_refused(
            &dir,
            &arguments,
            &[format, "--elements hexes", "polymesh,vtu"],
        );
    }
    assert!(!dir.path("case").exists());
}

#[test]
fn tables_of_cells_and_faces_balance() {
    let dir = with_run();
    for cells in ["l2", "linf"] {
        let arguments = [
            "measure",
            "--sites",
            "run/sites.csv",
            "--cells",
            cells,
            "--cells-table",
            "c.csv",
            "--faces-table",
            "f.csv",
        ];
        dir.stdout(&[&arguments[..], &["--force"]].concat());
        assert_refused(&dir, &arguments, &["c.csv", "--force"]);
        assert_balanced(&dir);
    }
    dir.write("s.json", r#"{ "domain": { "half_spaces": [[1,1,1,1],[-1,0,0,0],[0,-1,0,0],[0,0,-1,0]] }, "sites": { "random": { "count": 9 } } }"#);
    let arguments = [
        "measure",
        "s.json",
        "--cells",
        "linf",
        "--cells-table",
        "d.csv",
    ];
    dir.stdout(&arguments);
    dir.write("level.csv", "0.25,0.5,0.5\n0.75,0.5,0.5\n");
    let arguments = [
        "measure",
        "--sites",
        "level.csv",
        "--cells",
        "linf",
        "--cells-table",
        "e.csv",
    ];
    // A tied region belongs to the first.
    dir.stdout(&arguments);
    dir.write("close.csv", "0.25,0.5,0.5\n0.25000000000000006,0.5,0.5\n");
    let arguments = arguments.map(|word| {
        if word == "level.csv" {
            "close.csv"
        } else {
            word
        }
    });
    let arguments = [&arguments[..], &["--force"]].concat();
    assert_refused(&dir, &arguments, &["tables of L∞ cells", "--cells l2"]);
}

/// The tables of thirty cells in the unit cube.
fn assert_balanced(dir: &TestDir) {
    let rows = |name: &str| -> Vec<Vec<String>> {
        let text = String::from_utf8(dir.read(name)).expect("text");
        let lines = text.lines().skip(1);
        lines
            .map(|line| line.split(',').map(str::to_owned).collect())
            .collect()
    };
    let number = |text: &String| text.parse::<f64>().expect("a number");
    let cells = rows("c.csv");
    assert_eq!(cells.len(), 30);
    let volume: f64 = cells.iter().map(|row| number(&row[4])).sum();
    assert!((volume - 1.0).abs() < 1e-12);
    let faces = rows("f.csv");
    for (site, cell) in cells.iter().enumerate() {
        let own: Vec<&Vec<String>> = faces
            .iter()
            .filter(|row| row[0] == site.to_string())
            .collect();
        assert_eq!(own.len().to_string(), cell[9]);
        // The divergence theorem: areas close, and their moments are the volume.
        let flux = |axis: usize| {
            own.iter()
                .map(|row| number(&row[3]) * number(&row[4 + axis]))
                .sum::<f64>()
        };
        assert!((0..3).all(|axis| flux(axis).abs() < 1e-12));
        let moment = |row: &&Vec<String>| {
            let along = |axis: usize| number(&row[4 + axis]) * number(&row[7 + axis]);
            number(&row[3]) * (along(0) + along(1) + along(2)) / 3.0
        };
        let sum: f64 = own.iter().map(moment).sum();
        assert!((sum - number(&cell[4])).abs() < 1e-12);
        for row in own.iter().filter(|row| !row[1].is_empty()) {
            let back = faces
                .iter()
                .any(|other| other[0] == row[1] && other[1] == row[0] && other[3] == row[3]);
            assert!(back, "{row:?}");
        }
    }
    let walls = faces.iter().filter(|row| !row[2].is_empty());
    let area: f64 = walls.map(|row| number(&row[3])).sum();
    assert!((area - 6.0).abs() < 1e-12);
}

/// The unit cube as OBJ; the upper face is the group `lid`.
const GROUPED_CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    g lid\nf 5 6 7\nf 5 7 8\ng hull\nf 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";

#[test]
fn walls_of_solids_are_polygons_by_default_and_exact_on_request() {
    let dir = TestDir::new();
    dir.write("cube.obj", GROUPED_CUBE);
    dir.write(
        "s.json",
        r#"{ "domain": { "surface": "cube.obj" }, "sites": { "random": { "count": 40 } },
             "output": { "cells": false, "plot": false } }"#,
    );
    let relax = [
        "relax",
        "s.json",
        "--iterations",
        "3",
        "--out",
        "run",
        "--quiet",
    ];
    dir.stdout(&relax);
    for walls in ["polygons", "exact"] {
        let made = report(&dir.stdout(&["mesh", "run", "-o", walls, "--walls", walls, "--json"]));
        assert!((made["volume"].as_f64().expect("a volume") - 1.0).abs() < 1e-12);
        assert_eq!(
            (&made["open_cells"], &made["cells"]),
            (&0.into(), &40.into())
        );
        let patches = made["patches"].as_object().expect("patches");
        assert_eq!(
            patches.keys().collect::<Vec<_>>(),
            ["hull", "lid"],
            "{walls}"
        );
    }
    let wrong = ["mesh", "run", "-o", "other", "--walls", "round"];
    assert_refused(&dir, &wrong, &["polygons", "exact"]);
}
