//! `chebloyd fragments`: what its files hold is what `measure` and `mass` say.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

/// Domains of every kind, with the scene's name.
fn domains() -> [(&'static str, String); 5] {
    let file = |name: &str| format!("{}/scenes/{name}", env!("CARGO_MANIFEST_DIR"));
    let octahedron: Vec<String> = (0..8)
        .map(|n| {
            let sign = |axis: u32| if n >> axis & 1 == 1 { -1 } else { 1 };
            format!("[{}, {}, {}, 1]", sign(0), sign(1), sign(2))
        })
        .collect();
    let unit = r#""min": [0, 0, 0], "max": [1, 1, 1]"#;
    [
        ("box", format!(r#"{{"box": {{{unit}}}}}"#)),
        (
            "periodic",
            format!(r#"{{"box": {{{unit}, "periodic": [true, true, false]}}}}"#),
        ),
        (
            "half_spaces",
            format!(r#"{{"half_spaces": [{}]}}"#, octahedron.join(", ")),
        ),
        (
            "surface",
            format!(r#"{{"surface": {:?}}}"#, file("bracket.off")),
        ),
        ("tets", format!(r#"{{"tets": {:?}}}"#, file("cube.mesh"))),
    ]
}

fn scene(domain: &str, more: &str) -> String {
    format!(r#"{{"domain": {domain}, "sites": {{"random": {{"count": 9, "seed": 4}}}}{more}}}"#)
}

/// An array of a VTU file with raw appended data, eight bytes a number.
fn array<T>(file: &[u8], name: &str, number: impl Fn([u8; 8]) -> T) -> Option<Vec<T>> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let data = file.windows(mark.len()).position(|part| part == mark)? + mark.len();
    let head = String::from_utf8_lossy(&file[..data]);
    let (_, tag) = head.split_once(&format!("Name=\"{name}\""))?;
    let offset = tag.split_once("offset=\"")?.1.split_once('"')?.0;
    let start = data + offset.parse::<usize>().ok()?;
    let word = |at: usize| <[u8; 8]>::try_from(&file[at..at + 8]).ok();
    let bytes = usize::try_from(u64::from_le_bytes(word(start)?)).ok()?;
    (0..bytes / 8)
        .map(|k| word(start + 8 + 8 * k).map(&number))
        .collect()
}

fn reals(file: &[u8], name: &str) -> Vec<f64> {
    array(file, name, f64::from_le_bytes).unwrap_or_else(|| panic!("no array {name}"))
}

fn integers(file: &[u8], name: &str) -> Vec<i64> {
    array(file, name, i64::from_le_bytes).unwrap_or_else(|| panic!("no array {name}"))
}

fn cells(measured: &Value) -> Vec<(f64, f64)> {
    let cells = measured["cells"].as_array().expect("cells").iter();
    let figure = |cell: &Value, name: &str| cell[name].as_f64().expect("a number");
    cells
        .map(|cell| (figure(cell, "energy"), figure(cell, "volume")))
        .collect()
}

#[test]
fn fragments_of_a_cell_sum_to_its_energy_in_every_domain_order_norm_and_density() {
    let dir = TestDir::new();
    for (name, domain) in domains() {
        for more in [
            "",
            r#", "order": 3"#,
            r#", "norm": "l2""#,
            r#", "density": "1 + 2*z + z^2""#,
            r#", "order": 2, "density": "3 - z", "frames": {"axis": [1, 2, 3], "degrees": 40}"#,
        ] {
            let more = if name == "half_spaces" {
                more.replace("1 + 2*z", "2 + 2*z")
            } else {
                more.into()
            };
            dir.write("scene.json", scene(&domain, &more));
            dir.stdout(&["fragments", "scene.json", "--all", "--force", "-o", "f.vtu"]);
            let measured = dir.stdout(&["measure", "scene.json", "--per-cell"]);
            let measured: Value = serde_json::from_str(&measured).expect("JSON");
            let file = dir.read("f.vtu");
            let mut sums: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
            let (energy, volume) = (reals(&file, "energy"), reals(&file, "volume"));
            for (k, site) in integers(&file, "site").into_iter().enumerate() {
                let sum = sums.entry(site).or_default();
                sum.0 += energy[k];
                sum.1 += volume[k];
            }
            assert!(!String::from_utf8_lossy(&file).contains("cubeness"));
            for ((site, sum), cell) in sums.iter().zip(cells(&measured)) {
                let off = [sum.0 / cell.0 - 1.0, sum.1 / cell.1 - 1.0];
                assert!(
                    off.iter().all(|off| off.abs() < 1e-12),
                    "{name}{more} {site}: {off:?}"
                );
            }
            assert_eq!(sums.len(), 9);
        }
    }
}

#[test]
fn fragments_say_axis_sign_and_the_distance_at_their_points() {
    let dir = TestDir::new();
    let (_, domain) = &domains()[0];
    dir.write("scene.json", scene(domain, ""));
    dir.stdout(&["fragments", "scene.json", "--site", "3", "-o", "f.vtu"]);
    let file = dir.read("f.vtu");
    let mut sides: Vec<_> = integers(&file, "axis")
        .into_iter()
        .zip(integers(&file, "sign"))
        .collect();
    sides.sort_unstable();
    let all = [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)];
    assert_eq!(sides, all);
    let (points, distances) = (reals(&file, "Points"), reals(&file, "distance"));
    let nearest = (0..distances.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b]));
    let site = &points[3 * nearest.expect("points")..][..3];
    for (point, distance) in points.chunks_exact(3).zip(&distances) {
        let expected = (0..3)
            .map(|k| (point[k] - site[k]).abs())
            .fold(0.0, f64::max);
        assert!((distance - expected).abs() < 1e-15, "{distance} {expected}");
    }
}

/// \[BL\] eq. 7 by a command: the distance is linear on every tetrahedron of a fan.
#[test]
fn the_mass_of_all_fan_tetrahedra_by_distance_is_the_energy_that_measure_prints() {
    let dir = TestDir::new();
    for (name, domain) in domains() {
        dir.write("scene.json", scene(&domain, ""));
        let tets = ["fragments", "scene.json", "--tets", "--all", "--force"];
        dir.stdout(&[&tets[..], &["-o", "t.vtu"]].concat());
        let mass = ["mass", "t.vtu", "--density", "vertex:distance", "--json"];
        let mass: Value = serde_json::from_str(&dir.stdout(&mass)).expect("JSON");
        let measured: Value =
            serde_json::from_str(&dir.stdout(&["measure", "scene.json"])).expect("JSON");
        let figure = |object: &Value, name: &str| object[name].as_f64().expect("a number");
        let energy = 9.0 * figure(&measured, "energy_mean");
        let off = figure(&mass, "mass") / energy - 1.0;
        assert!(off.abs() < 1e-12, "{name}: {off:e}");
        let off = figure(&mass, "volume") / figure(&measured, "domain_volume") - 1.0;
        assert!(off.abs() < 1e-12, "{name}: {off:e}");
    }
}

#[test]
fn pictures_of_tetrahedra_or_of_all_cells_are_refused() {
    let dir = TestDir::new();
    for option in ["--all", "--tets"] {
        let message = dir.refusal(&["fragments", "--count", "20", option, "-o", "f.png"]);
        assert_all_in(&message, &[option, ".vtu"]);
    }
}
