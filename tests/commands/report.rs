//! `chebloyd report`: what the page holds, refusals, and the page in a real browser.

use std::collections::HashSet;
use std::fs;
use std::io::Read;

use flate2::read::DeflateDecoder;
use serde_json::Value;

use crate::browser::{Browser, find, from_base64};
use crate::test_dir::{TestDir, assert_all_in};

const QUIET: &str = r#""output": { "cells": false, "plot": false }"#;

/// Leaves a run of a scene, given by its keys, in `out`.
fn relax(dir: &TestDir, out: &str, keys: &str) {
    let scene = format!("{out}.json");
    dir.write(&scene, format!("{{ {keys}, {QUIET} }}"));
    dir.stdout(&["relax", &scene, "--out", out, "--quiet"]);
}

fn random(count: usize, iterations: usize) -> String {
    format!(
        r#""sites": {{ "random": {{ "count": {count} }} }},
        "method": {{ "lloyd": {{ "iterations": {iterations} }} }}"#
    )
}

/// A directory with a small run in `run`.
fn with_run() -> TestDir {
    let dir = TestDir::new();
    relax(&dir, "run", &random(40, 3));
    dir
}

/// The JSON that a page holds.
fn data(page: &str) -> Value {
    let start = r#"<script type="application/json" id="data">"#;
    let text = page.split_once(start).expect("data").1;
    let text = text.split_once("</script>").expect("an end").0;
    serde_json::from_str(text).expect("JSON")
}

/// A second reader of a page's cells.
struct Cells {
    points: Vec<[f64; 3]>,
    /// Owner, neighbor and corners of every face.
    faces: Vec<(usize, Option<usize>, Vec<usize>)>,
    sites: Vec<usize>,
    columns: Vec<(String, Vec<f64>)>,
}

struct Numbers {
    bytes: Vec<u8>,
    place: usize,
}

impl Numbers {
    fn whole(&mut self, count: usize, width: usize) -> Vec<u32> {
        let start = self.place;
        self.place += count * width;
        let byte = |k: usize, plane: usize| u32::from(self.bytes[start + plane * count + k]);
        let number = |k| (0..width).map(|plane| byte(k, plane) << (8 * plane)).sum();
        (0..count).map(number).collect()
    }

    fn places(&mut self, count: usize, header: &Value) -> Vec<[f64; 3]> {
        let mut places = vec![[0.0; 3]; count];
        for axis in 0..3 {
            let number = |key: &str| header[key][axis].as_f64().expect("a number");
            let (origin, step, mut sum) = (number("origin"), number("step"), 0_i64);
            for (place, way) in places.iter_mut().zip(self.whole(count, 3)) {
                let half = i64::from(way >> 1);
                sum += if way & 1 == 0 { half } else { -half - 1 };
                sum = sum.rem_euclid(1 << 24);
                place[axis] = origin + sum as f64 * step;
            }
        }
        places
    }
}

impl Cells {
    fn of(page: &str, run: usize) -> Self {
        let data = data(page);
        let header = &data["runs"][run]["cells"];
        let count = |key: &str| header[key].as_u64().expect("a count") as usize;
        let start = format!(r#"<script type="text/plain" id="cells-{run}">"#);
        let text = page.split_once(&start).expect("cells").1;
        let text = text.split_once("</script>").expect("an end").0;
        let mut bytes = Vec::new();
        let packed = from_base64(text);
        let read = DeflateDecoder::new(&packed[..]).read_to_end(&mut bytes);
        read.expect("deflated bytes");
        assert_eq!(bytes.len(), count("bytes"));
        let mut numbers = Numbers { bytes, place: 0 };
        let points = numbers.places(count("points"), header);
        let owned = numbers.whole(count("cells"), 4);
        let sizes = numbers.whole(count("faces"), 4);
        let later = numbers.whole(count("faces"), 4);
        let mut next = 0;
        let ways = numbers.whole(count("corners"), 4).into_iter();
        let mut corners = ways.map(|way| {
            next += usize::from(way == 0);
            next - usize::from(way == 0) - way as usize
        });
        let owners = (0..)
            .zip(&owned)
            .flat_map(|(cell, &count)| vec![cell; count as usize]);
        let faces = owners
            .zip(sizes.iter().zip(&later))
            .map(|(owner, (&size, &later))| {
                let neighbor = (later > 0).then_some(owner + later as usize);
                (
                    owner,
                    neighbor,
                    corners.by_ref().take(size as usize).collect(),
                )
            });
        let faces = faces.collect();
        numbers.place += count("corners");
        numbers.places(count("cells"), header);
        let sites = numbers.whole(count("cells"), 4);
        let columns = header["columns"]
            .as_array()
            .expect("columns")
            .iter()
            .map(|column| {
                let bits = numbers.whole(count("cells"), 4).into_iter();
                let values = bits.map(|bits| f64::from(f32::from_bits(bits))).collect();
                (column["name"].as_str().expect("a name").to_owned(), values)
            });
        let columns = columns.collect();
        assert_eq!(numbers.place, numbers.bytes.len());
        Self {
            points,
            faces,
            sites: sites.into_iter().map(|site| site as usize).collect(),
            columns,
        }
    }

    fn column(&self, name: &str) -> &[f64] {
        let found = self.columns.iter().find(|column| column.0 == name);
        &found.unwrap_or_else(|| panic!("no {name}")).1
    }

    /// The cells' volumes by the divergence theorem, in the plane their areas.
    fn volumes(&self, dimension: usize) -> Vec<f64> {
        let mut volumes = vec![0.0; self.sites.len()];
        for (owner, neighbor, corners) in &self.faces {
            for pair in corners[1..].windows(2) {
                let [a, b, c] = [corners[0], pair[0], pair[1]].map(|corner| self.points[corner]);
                let part = if dimension == 2 {
                    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
                } else {
                    (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                        + a[2] * (b[0] * c[1] - b[1] * c[0]))
                        / 6.0
                };
                volumes[*owner] += part;
                if let Some(neighbor) = neighbor {
                    volumes[*neighbor] -= part;
                }
            }
        }
        volumes
    }
}

/// The page of a run, whose cells must have the volumes that `measure` finds, and share their faces.
fn assert_cells_are_measured(keys: &str, dimension: usize, shared: std::ops::RangeInclusive<f64>) {
    let dir = TestDir::new();
    relax(&dir, "run", keys);
    dir.stdout(&["report", "run", "--quiet"]);
    let page = String::from_utf8(dir.read("report.html")).expect("text");
    let cells = Cells::of(&page, 0);
    let measured = dir.stdout(&[
        "measure",
        "run.json",
        "--sites",
        "run/sites.csv",
        "--per-cell",
    ]);
    let measured: Value = serde_json::from_str(&measured).expect("JSON");
    let volumes = cells.volumes(dimension);
    let column = cells.column(if dimension == 2 { "area" } else { "volume" });
    let facets = cells.column(if dimension == 2 { "sides" } else { "facets" });
    assert_eq!(
        cells.sites.len(),
        measured["sites"].as_u64().expect("a count") as usize
    );
    for (cell, &site) in cells.sites.iter().enumerate() {
        let of_site = &measured["cells"][site];
        let volume = of_site["volume"].as_f64().expect("a number");
        let error = (volumes[cell] / volume - 1.0).abs();
        assert!(error < 2e-5, "site {site}: {} for {volume}", volumes[cell]);
        assert!((column[cell] / volume - 1.0).abs() < 1e-6, "site {site}");
        assert_eq!(
            facets[cell].to_string(),
            of_site["facets"].to_string(),
            "site {site}"
        );
    }
    let both = cells.faces.iter().filter(|face| face.1.is_some()).count();
    let share = both as f64 / cells.faces.len() as f64;
    assert!(shared.contains(&share), "{share} of the faces are shared");
}

#[test]
fn cells_of_a_box_have_their_volumes_and_share_their_faces() {
    assert_cells_are_measured(&random(60, 2), 3, 0.6..=0.95);
}

#[test]
fn cells_across_periods_are_whole() {
    let domain = r#""domain": { "box": { "periodic": [true, true, true] } }, "#;
    assert_cells_are_measured(&(domain.to_owned() + &random(40, 1)), 3, 0.3..=0.95);
}

#[test]
fn cells_of_a_solid_are_clipped_to_it() {
    let torus = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/torus.off");
    let domain = format!(r#""domain": {{ "surface": "{torus}" }}, "#);
    assert_cells_are_measured(&(domain + &random(30, 0)), 3, 0.01..=0.9);
}

#[test]
fn linf_cells_have_faces_of_their_own_where_they_do_not_fit() {
    assert_cells_are_measured(
        &(r#""cells": "linf", "#.to_owned() + &random(8, 1)),
        3,
        0.0..=0.95,
    );
}

#[test]
fn cells_of_the_plane_are_polygons() {
    assert_cells_are_measured(
        &(r#""dimension": 2, "#.to_owned() + &random(50, 2)),
        2,
        0.0..=0.0,
    );
}

#[test]
fn one_file_holds_all_of_the_runs_and_asks_for_nothing() {
    let dir = with_run();
    relax(&dir, "other", &random(25, 2));
    let summary = dir.stdout(&[
        "report",
        "run",
        "other",
        "-o",
        "both.html",
        "--title",
        "<a> & b",
        "--json",
    ]);
    let summary: Value = serde_json::from_str(&summary).expect("one object");
    let bytes = dir.read("both.html");
    assert_eq!(summary["bytes"], bytes.len());
    assert_eq!(summary["runs"][1]["cells"], 25);
    let page = String::from_utf8(bytes).expect("text");
    let links = page.replace("http://www.w3.org/2000/svg", "");
    for word in [
        "http:",
        "https:",
        "src=",
        "@import",
        "url(http",
        "eval(",
        "new Function",
        "{{",
    ] {
        assert!(!links.contains(word), "{word}");
    }
    assert_all_in(
        &page,
        &["<title>&lt;a> &amp; b"
            .replace('>', "&gt;")
            .replace("<title&gt;", "<title>")
            .as_str()],
    );
    assert_all_in(&page, &["Content-Security-Policy", "default-src 'none'"]);
    let data = data(&page);
    for (number, name) in ["run", "other"].into_iter().enumerate() {
        let run = &data["runs"][number];
        assert_eq!(run["name"], name);
        assert_eq!(run["run"], dir.json(&format!("{name}/run.json")), "{name}");
        for (line, record) in dir.records(name).iter().enumerate() {
            for key in [
                "iteration",
                "energy_percent",
                "energy_mean",
                "energy_max",
                "movement_percent",
                "evaluations",
            ] {
                assert_eq!(
                    run["records"][key][line], record[key],
                    "{name}, line {line}, {key}"
                );
            }
        }
    }
}

#[test]
fn larger_runs_show_the_cells_at_a_plane() {
    let dir = TestDir::new();
    relax(&dir, "run", &random(90, 1));
    dir.stdout(&["report", "run", "-o", "all.html", "--quiet"]);
    let all = Cells::of(&String::from_utf8(dir.read("all.html")).expect("text"), 0);
    let mut extents = vec![[f64::INFINITY, f64::NEG_INFINITY]; all.sites.len()];
    for (owner, neighbor, corners) in &all.faces {
        for cell in std::iter::once(owner).chain(neighbor) {
            for &corner in corners {
                let x = all.points[corner][0];
                extents[*cell] = [extents[*cell][0].min(x), extents[*cell][1].max(x)];
            }
        }
    }
    let at_plane = all
        .sites
        .iter()
        .zip(extents)
        .filter(|(_, [low, high])| (*low..=*high).contains(&0.3));
    let mut expected: Vec<usize> = at_plane.map(|(&site, _)| site).collect();
    expected.sort_unstable();
    let told = dir.stdout(&[
        "report",
        "run",
        "-o",
        "cut.html",
        "--most-cells",
        "89",
        "--plane",
        "x=0.3",
        "--json",
    ]);
    let told: Value = serde_json::from_str(&told).expect("JSON");
    assert_eq!(told["runs"][0]["selection"], "those that touch x = 0.3");
    assert_eq!(told["runs"][0]["cells_total"], 90);
    let cut = Cells::of(&String::from_utf8(dir.read("cut.html")).expect("text"), 0);
    let mut shown = cut.sites.clone();
    shown.sort_unstable();
    assert_eq!(shown, expected);
    assert!((10..80).contains(&shown.len()), "{}", shown.len());
}

#[test]
fn bad_input_is_refused_before_anything_is_written() {
    let dir = with_run();
    fs::create_dir(dir.path("empty")).expect("room for a folder");
    dir.write("report.html", "mine");
    let refused: [(&[&str], &[&str]); 9] = [
        (&["report"], &["RUN_DIR"]),
        (
            &["report", "nowhere", "-o", "a.html"],
            &["nowhere holds no run", "nowhere/run.json", "relax --out"],
        ),
        (
            &["report", "empty", "-o", "a.html"],
            &["empty holds no run"],
        ),
        (&["report", "run"], &["report.html", "--force", "-o"]),
        (
            &["report", "run", "-o", "run/run.json", "--force"],
            &["run/run.json", "never"],
        ),
        (
            &["report", "run", "-o", "run/sites.csv", "--force"],
            &["run/sites.csv", "never"],
        ),
        (
            &["report", "run", "-o", "empty", "--force"],
            &["is a directory"],
        ),
        (
            &["report", "run", "-o", "a.html", "--plane", "w=1"],
            &["x, y or z"],
        ),
        (
            &["report", "run", "-o", "a.html", "--plane", "x=nan"],
            &["finite"],
        ),
    ];
    for (arguments, words) in refused {
        assert_all_in(&dir.refusal(arguments), words);
    }
    fs::write(dir.path("run/sites.csv"), "x,y,z\n0.5,0.5,nan\n").expect("room");
    let refusal = dir.refusal(&["report", "run", "-o", "a.html"]);
    assert_all_in(
        &refusal,
        &["run has no cells", "sites.csv", "line 2", "--no-cells"],
    );
    dir.stdout(&["report", "run", "--no-cells", "--force", "--quiet"]);
    let page = String::from_utf8(dir.read("report.html")).expect("text");
    assert!(data(&page)["runs"][0]["cells"].is_null());
}

#[test]
fn a_run_that_has_not_ended_shows_its_checkpoint() {
    let dir = with_run();
    let text = String::from_utf8(dir.read("run/run.json")).expect("text");
    fs::write(
        dir.path("run/run.json"),
        text.replace("\"ended\": \"iterations\"", "\"ended\": null"),
    )
    .expect("room");
    fs::remove_file(dir.path("run/sites.csv")).expect("a file");
    let note = |name: &str| {
        let output = dir.run(&["report", "run", "-o", name, "--quiet"]);
        assert_eq!(output.status.code(), Some(0));
        String::from_utf8(output.stderr).expect("text")
    };
    let told = note("with.html");
    assert_all_in(
        &told,
        &[
            "has not ended, 3 of 3",
            "relax --resume --out run",
            "after iteration 3",
        ],
    );
    let page = String::from_utf8(dir.read("with.html")).expect("text");
    assert_eq!(Cells::of(&page, 0).sites.len(), 40);
    assert_eq!(
        data(&page)["runs"][0]["notes"].as_array().map(Vec::len),
        Some(2)
    );
    fs::remove_file(dir.path("run/checkpoint.bin")).expect("a file");
    assert_all_in(&note("without.html"), &["no checkpoint"]);
    let page = String::from_utf8(dir.read("without.html")).expect("text");
    assert!(data(&page)["runs"][0]["cells"].is_null());
}

/// The browser, or none with a word about it.
fn browser() -> Option<Browser> {
    let program = find();
    if program.is_none() {
        println!("SKIPPED: there is no chromium on the path");
    }
    program.map(|program| Browser::start(&program))
}

/// How many colors cover at least a thousandth of a picture.
fn colors(picture: &tiny_skia::Pixmap) -> usize {
    let mut counts = std::collections::HashMap::new();
    for pixel in picture.pixels() {
        *counts
            .entry([pixel.red(), pixel.green(), pixel.blue()])
            .or_insert(0) += 1;
    }
    let enough = picture.pixels().len() / 1000;
    counts.values().filter(|&&count| count >= enough).count()
}

fn sites<const D: usize>(dir: &TestDir, run: &str) -> Vec<[f64; D]> {
    let text = String::from_utf8(dir.read(&format!("{run}/sites.csv"))).expect("text");
    let site = |line: &str| {
        let numbers: Vec<f64> = line
            .split(',')
            .map(|word| word.parse().expect("a number"))
            .collect();
        numbers.try_into().expect("a site")
    };
    text.lines().skip(1).map(site).collect()
}

fn nearest<const D: usize>(sites: &[[f64; D]], point: [f64; D]) -> usize {
    let distance =
        |site: &[f64; D]| -> f64 { (0..D).map(|axis| (site[axis] - point[axis]).powi(2)).sum() };
    let by_distance =
        |&one: &usize, &other: &usize| distance(&sites[one]).total_cmp(&distance(&sites[other]));
    (0..sites.len()).min_by(by_distance).expect("a site")
}

/// The first number after `word`.
fn number_after(text: &str, word: &str) -> f64 {
    let rest = text
        .split_once(word)
        .unwrap_or_else(|| panic!("no {word} in {text}"))
        .1;
    let is_part = |c: char| c.is_ascii_digit() || ".e-".contains(c);
    let rest = rest.trim_start().replace('−', "-");
    let end = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
    rest[..end]
        .parse()
        .unwrap_or_else(|_| panic!("no number after {word} in {text}"))
}

#[test]
fn a_browser_draws_curves_and_cells_without_complaint() {
    let Some(mut browser) = browser() else { return };
    let dir = TestDir::new();
    relax(&dir, "run", &random(60, 4));
    relax(&dir, "long", &random(20, 7));
    dir.stdout(&["report", "run", "long", "--quiet"]);
    browser.resize(1200, 900);
    browser.open(&dir.path("report.html"), "");
    let state = browser.evaluate("document.documentElement.dataset.state");
    assert_eq!(state, "ready");
    assert_curves_show_the_logs(&mut browser, &dir);
    assert_pointer_finds_cells(&mut browser, &dir);
    assert_cells_are_cut_and_turned(&mut browser, &dir);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Reads values of the curves by pointer and by keys.
fn assert_curves_show_the_logs(browser: &mut Browser, dir: &TestDir) {
    let curves = browser.evaluate("document.querySelectorAll('.plot .curve').length");
    assert_eq!(curves, 4);
    let middle = browser.middle_of(".plot");
    browser.mouse("mouseMoved", middle, false);
    browser.settle();
    let tip = browser.text(".plot-frame .tip");
    let iteration = number_after(&tip, "iteration") as usize;
    assert!((2..=5).contains(&iteration), "{tip}");
    for run in ["run", "long"] {
        let records = dir.records(run);
        let record = &records[iteration.min(records.len() - 1)];
        let shown = number_after(&tip, &format!("{run}:"));
        assert_close(shown, &record["energy_percent"], 1e-6, &tip);
    }
    browser.evaluate("document.querySelectorAll('.plot')[1].focus()");
    browser.key("Home");
    browser.key("ArrowRight");
    let tip = browser.text(".plot-place:last-child .tip");
    let expected = &dir.records("long")[1]["movement_percent"];
    assert_close(number_after(&tip, "long:"), expected, 1e-6, &tip);
}

fn assert_close(value: f64, expected: &Value, tolerance: f64, text: &str) {
    let expected = expected.as_f64().expect("a number");
    let error = (value / expected - 1.0).abs();
    assert!(error < tolerance, "{text}: {expected}");
}

/// What is said of the cell in the middle of the picture.
fn tip_at_middle(browser: &mut Browser) -> String {
    let middle = browser.middle_of(".stage");
    browser.mouse("mouseMoved", middle, false);
    browser.settle();
    browser.settle();
    browser.text(".stage .tip")
}

/// The cell in the middle of the picture is that of the wall's point on the way to the viewer.
fn assert_pointer_finds_cells(browser: &mut Browser, dir: &TestDir) {
    let page = String::from_utf8(dir.read("report.html")).expect("text");
    let toward = &data(&page)["toward"];
    let toward = [0, 1, 2].map(|axis| toward[axis].as_f64().expect("a number"));
    let ways = toward.iter().map(|part| 0.5 / part.abs());
    let way = ways.fold(f64::INFINITY, f64::min);
    let sites = sites::<3>(dir, "run");
    let front = nearest(&sites, toward.map(|part| 0.5 + way * part));
    let tip = tip_at_middle(browser);
    assert_all_in(&tip, &[&format!("site {front}:")]);
    let measured = dir.stdout(&[
        "measure",
        "run.json",
        "--sites",
        "run/sites.csv",
        "--per-cell",
    ]);
    let measured: Value = serde_json::from_str(&measured).expect("JSON");
    let cell = &measured["cells"][front];
    let volume = cell["volume"].as_f64().expect("a number");
    let cube = 0.375 * volume.powf(4.0 / 3.0);
    let energy = number_after(&tip, "energy") / 100.0 * cube;
    assert_close(energy, &cell["energy"], 1e-5, &tip);
    let facts = browser.text(".facts");
    let shown = number_after(&facts, "volume");
    assert_close(shown, &cell["volume"], 1e-5, &facts);
    let center = &cell["center"];
    let to_center =
        (0..3).map(|axis| sites[front][axis] - center[axis].as_f64().expect("a number"));
    let to_center = to_center.map(|length| length * length).sum::<f64>().sqrt();
    let diagonal = volume.cbrt() * 3_f64.sqrt();
    let shown = number_after(&facts, "way to center") / 100.0 * diagonal;
    assert!((shown - to_center).abs() < 1e-5 * diagonal, "{facts}");
}

/// The cut, the other color and the turned cells are other pictures of the right cells.
fn assert_cells_are_cut_and_turned(browser: &mut Browser, dir: &TestDir) {
    let (page, sites) = (dir.path("report.html"), sites::<3>(dir, "run"));
    let whole = browser.picture_of(".stage");
    assert!(colors(&whole) > 12, "{} colors", colors(&whole));
    browser.open(&page, "cut=z&mode=through&color=volume");
    let inner = nearest(&sites, [0.5; 3]);
    let tip = tip_at_middle(browser);
    assert_all_in(&tip, &[&format!("site {inner}: volume")]);
    let cut = browser.picture_of(".stage");
    assert_ne!(whole.data(), cut.data());
    let middle = browser.middle_of(".stage");
    let end = [middle[0] + 60.0, middle[1] + 20.0];
    browser.mouse("mousePressed", middle, true);
    browser.mouse("mouseMoved", end, true);
    browser.mouse("mouseReleased", end, false);
    browser.wait_for("location.hash.includes('view=')");
    assert_ne!(browser.picture_of(".stage").data(), cut.data());
    // Whole cells: those on one side of the plane by their sites.
    browser.open(&page, "cut=x&place=250&side=above");
    let hidden = sites.iter().filter(|site| site[0] < 0.25).count();
    let caption = browser.text(".caption");
    assert_all_in(&caption, &[&format!("60 cells; {hidden} hidden")]);
}

#[test]
fn a_browser_draws_the_plane_and_solids_also_on_a_phone_and_without_webgl() {
    let Some(mut browser) = browser() else { return };
    let dir = TestDir::new();
    let torus = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/torus.off");
    relax(
        &dir,
        "plane",
        &(r#""dimension": 2, "#.to_owned() + &random(80, 3)),
    );
    relax(
        &dir,
        "torus",
        &(format!(r#""domain": {{ "surface": "{torus}" }}, "#) + &random(30, 1)),
    );
    dir.stdout(&["report", "plane", "torus", "--quiet"]);
    let page = dir.path("report.html");
    browser.resize(375, 740);
    let mut pictures = HashSet::new();
    for scheme in ["light", "dark"] {
        let features = serde_json::json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        browser.call(
            "Emulation.setEmulatedMedia",
            serde_json::json!({ "features": features }),
        );
        for run in ["run=0", "run=1", "run=1&cut=y&mode=through"] {
            browser.open(&page, run);
            assert_eq!(
                browser.evaluate("document.documentElement.scrollWidth"),
                375,
                "{run}"
            );
            let picture = browser.picture_of(".stage");
            assert!(colors(&picture) > 12, "{run}: {} colors", colors(&picture));
            assert!(pictures.insert(picture.data().to_vec()), "{run}");
        }
    }
    // A browser without WebGL and without its own inflation.
    let poorer = "delete window.DecompressionStream; const get = HTMLCanvasElement.prototype.getContext; \
                  HTMLCanvasElement.prototype.getContext = function (kind, ...more) { \
                  return kind.startsWith('webgl') ? null : get.call(this, kind, ...more); };";
    browser.call(
        "Page.addScriptToEvaluateOnNewDocument",
        serde_json::json!({ "source": poorer }),
    );
    browser.open(&page, "run=0");
    let middle = browser.middle_of(".stage canvas");
    // The square's middle lies above the strip of its scale, 28 − 8 pixels above the canvas's.
    browser.mouse("mouseMoved", [middle[0], middle[1] - 20.0], false);
    browser.settle();
    browser.settle();
    let site = nearest(&sites::<2>(&dir, "plane"), [0.5; 2]);
    assert_all_in(&browser.text(".stage .tip"), &[&format!("site {site}:")]);
    browser.open(&page, "run=1");
    assert_all_in(&browser.text("#cells .note"), &["no WebGL"]);
    assert!(colors(&browser.picture_of(".stage")) > 12);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
