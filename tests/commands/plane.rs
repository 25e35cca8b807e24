//! The plane by the command line: squares, polygons, densities, resumption, fragments, curves.

use serde_json::Value;

use crate::test_dir::TestDir;

const HOLE: &str = r#"{ "dimension": 2, "domain": { "polygon": [
    [[0, 0], [4, 0], [4, 1], [2.5, 1.2], [4, 3], [0, 3]], [[0.8, 0.8], [2, 1], [1.2, 2.2]]] },
    "sites": { "random": { "count": 40, "seed": 1 } },
    "method": { "anneal": { "rounds": 3, "iterations": 25 } } }"#;

const SQUARE: &str = r#"{ "dimension": 2, "sites": { "random": { "count": 25, "seed": 1 } } }"#;

/// The error of a command that refuses its input.
fn refusal(here: &TestDir, arguments: &[&str]) -> String {
    let output = here.run(arguments);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
    stderr
}

#[test]
fn random_sites_become_squares_and_the_words_are_those_of_the_plane() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    let summary = here.stdout(&["relax", "square.json", "--goal", "squares", "--out", "run"]);
    assert!(
        summary.contains("four-sided cells") && summary.contains("→ 100.0 %"),
        "{summary}"
    );
    assert!(
        !summary.contains("facet") && !summary.contains("cube"),
        "{summary}"
    );
    let last = here.json("run/run.json")["final"].clone();
    let percent = last["energy_percent"].as_f64().expect("a number");
    assert!((percent - 100.0).abs() < 5e-5, "{percent}");
    assert_eq!(last["four_sided_fraction"], 1.0);
    assert_eq!(last["six_facet_fraction"], 1.0);
    let space = here.stdout(&["measure", "--count", "5"]);
    assert!(!space.contains("four_sided_fraction"));
}

#[test]
fn goals_of_the_other_dimension_are_refused() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    let cubes = refusal(
        &here,
        &["relax", "square.json", "--goal", "cubes", "--out", "run"],
    );
    assert!(cubes.contains("--goal squares"), "{cubes}");
    let squares = refusal(&here, &["relax", "--goal", "squares", "--out", "run"]);
    assert!(squares.contains("--goal cubes"), "{squares}");
    assert!(!here.path("run").exists());
}

#[test]
fn an_interrupted_anneal_in_a_polygon_goes_on_to_the_bit() {
    let here = TestDir::new();
    here.write("hole.json", HOLE);
    here.stdout(&["relax", "hole.json", "--out", "whole"]);
    here.stdout(&["relax", "hole.json", "--iterations", "11", "--out", "parts"]);
    here.stdout(&["relax", "--resume", "--iterations", "25", "--out", "parts"]);
    assert!(here.read("whole/sites.csv") == here.read("parts/sites.csv"));
    let last = here.json("whole/run.json")["final"].clone();
    let volume = |key: &str| last[key].as_f64().expect("a number");
    assert!((volume("volume_sum") / volume("domain_volume") - 1.0).abs() < 1e-12);
    // Cells are drawn in pieces but without lines between them.
    let svg = String::from_utf8(here.read("whole/cells.svg")).expect("text");
    assert_eq!(svg.matches("<circle").count(), 40);
}

#[test]
fn polygons_sites_and_densities_that_are_none_are_refused_with_the_place() {
    let here = TestDir::new();
    let scene = |domain: &str, more: &str| {
        format!(
            r#"{{ "dimension": 2, "domain": {domain}, "sites": {{ "list": [[0.5, 0.5], [0.6, 0.2]] }}{more} }}"#
        )
    };
    let cases = [
        (
            scene(r#"{ "polygon": [[0, 0], [1, 1], [1, 0], [0, 1]] }"#, ""),
            "sides 0 and 2 of the polygon cross or overlap near (0.5, 0.5)",
        ),
        (
            scene(
                r#"{ "polygon": [[[0,0],[3,0],[3,3],[0,3]], [[0.4,0.4],[2,0.4],[2,2],[0.4,2]]] }"#,
                "",
            ),
            "site 0 (0.5, 0.5) lies outside the domain",
        ),
        (
            scene(
                r#"{ "polygon": [[[0,0],[3,0],[3]], [[0,0],[1,0],[0,1]]] }"#,
                "",
            ),
            "domain.polygon[0][2]",
        ),
        (
            scene(r#"{ "polygon": "star" }"#, ""),
            "a polygon is a list of corners",
        ),
        (
            scene("{}", r#", "density": "x - 0.5""#),
            "the domain needs exactly one of",
        ),
        (
            scene(r#"{ "box": {} }"#, r#", "density": "x - 0.5""#),
            "it must be positive in the domain",
        ),
        (
            scene(r#"{ "box": {} }"#, r#", "density": "1 + z""#),
            "the density depends on z",
        ),
        (
            scene(r#"{ "box": {} }"#, r#", "density": { "size": "0.1" }"#),
            "in the plane a density is a polynomial",
        ),
        (
            scene(
                r#"{ "box": { "periodic": [true, false] } }"#,
                r#", "density": "1 + x""#,
            ),
            "the density changes along x",
        ),
    ];
    for (text, expected) in cases {
        here.write("scene.json", &text);
        let error = refusal(&here, &["measure", "scene.json"]);
        let flat = error.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(expected), "{text}\n{error}");
    }
}

#[test]
fn fragments_of_the_plane_are_pictures_and_those_in_space_svg_too() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    here.stdout(&["fragments", "square.json", "-o", "flat.svg"]);
    here.stdout(&["fragments", "square.json", "--site", "3", "-o", "flat.png"]);
    here.stdout(&["fragments", "--count", "9", "-o", "space.svg"]);
    let flat = String::from_utf8(here.read("flat.svg")).expect("text");
    assert!(flat.contains("Its four fragments") && flat.contains("energy"));
    let space = String::from_utf8(here.read("space.svg")).expect("text");
    assert!(space.contains("Fragments of the cell of site"));
    let file = refusal(&here, &["fragments", "square.json", "-o", "flat.vtu"]);
    assert!(file.contains(".svg or .png"), "{file}");
    let site = refusal(
        &here,
        &["fragments", "square.json", "--site", "25", "-o", "x.svg"],
    );
    assert!(site.contains("no site 25 among 25"), "{site}");
    let name = refusal(&here, &["fragments", "square.json", "-o", "flat.pdf"]);
    assert!(name.contains(".png or .svg or .vtu"), "{name}");
}

#[test]
fn plot_groups_seeds_and_draws_overlays_and_ranges() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    for seed in ["1", "2", "3"] {
        let out = format!("lloyd-{seed}");
        let run = [
            "relax",
            "square.json",
            "--iterations",
            "4",
            "--seed",
            seed,
            "--out",
            &out,
        ];
        here.stdout(&run);
        let out = format!("descent-{seed}");
        let more = ["--method", "quasi-newton", "--iterations", "4"];
        let run = ["relax", "square.json", "--seed", seed, "--out", &out];
        here.stdout(&[&run[..], &more[..]].concat());
    }
    let runs = [
        "lloyd-1",
        "lloyd-2",
        "lloyd-3",
        "descent-1",
        "descent-2",
        "descent-3",
    ];
    here.stdout(&[&["plot", "--band", "-o", "band.svg"][..], &runs[..]].concat());
    let band = String::from_utf8(here.read("band.svg")).expect("text");
    assert!(
        band.contains(">lloyd (3 runs)<") && band.contains(">descent (3 runs)<"),
        "{band}"
    );
    here.stdout(&[&["plot", "-o", "all.svg"][..], &runs[..]].concat());
    let all = String::from_utf8(here.read("all.svg")).expect("text");
    assert!(runs.iter().all(|run| all.contains(&format!(">{run}<"))));
    here.write("points.csv", "iteration,energy_percent\n0,140\n4,110\n");
    let more = [
        "--overlay",
        "points.csv",
        "--range",
        "100,150",
        "-o",
        "over.svg",
    ];
    here.stdout(&[&["plot", "lloyd-1"][..], &more[..]].concat());
    let over = String::from_utf8(here.read("over.svg")).expect("text");
    assert!(
        over.contains(">points<") && over.contains(">150<"),
        "{over}"
    );
}

#[test]
fn bad_overlays_and_ranges_are_refused_with_the_line() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    here.stdout(&["relax", "square.json", "--iterations", "2", "--out", "run"]);
    for (text, expected) in [
        ("k,energy_percent\n0,1\n", "has no column `iteration`"),
        (
            "iteration,energy_percent\n0,130\n1,x\n",
            "points.csv:3: `x` is no finite number",
        ),
        (
            "iteration,energy_percent\n,130\n",
            "points.csv:2: there is no iteration",
        ),
        ("iteration\n0\n", "holds no energies and no movements"),
    ] {
        here.write("points.csv", text);
        let error = refusal(
            &here,
            &["plot", "run", "--overlay", "points.csv", "-o", "x.svg"],
        );
        assert!(error.contains(expected), "{error}");
    }
    for range in ["110,100", "100", "a,b", "100,nan"] {
        let error = refusal(&here, &["plot", "run", "--range", range, "-o", "x.svg"]);
        assert!(error.contains("LO,HI"), "{error}");
    }
    assert!(!here.path("x.svg").exists());
}

#[test]
fn pictures_take_a_range_and_are_drawn_anew_with_another() {
    let here = TestDir::new();
    here.write("square.json", SQUARE);
    let run = ["relax", "square.json", "--iterations", "3", "--out", "run"];
    here.stdout(&[&run[..], &["--range", "100,120"][..]].concat());
    let first = String::from_utf8(here.read("run/cells.svg")).expect("text");
    assert!(
        first.contains(">100<") && first.contains(">120<"),
        "{first}"
    );
    let sites = here.read("run/sites.csv");
    here.stdout(&["relax", "--resume", "--out", "run", "--range", "100,200"]);
    let again = String::from_utf8(here.read("run/cells.svg")).expect("text");
    assert!(again.contains(">200<") && !again.contains(">105<"));
    assert!(sites == here.read("run/sites.csv"));
    let scene: Value = here.json("run/run.json")["scene"].clone();
    assert_eq!(scene["output"]["range"], serde_json::json!([100.0, 200.0]));
}
