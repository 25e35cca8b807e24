//! L∞ cells in the program: runs, figures, resumption, files, refusals.

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

fn measured(dir: &TestDir, arguments: &[&str]) -> Value {
    serde_json::from_str(&dir.stdout(arguments)).expect("one JSON object")
}

#[test]
fn measure_compares_both_tessellations() {
    let dir = TestDir::new();
    let sites = ["measure", "--count", "30", "--seed", "2"];
    let with = |cells: &str| measured(&dir, &[&sites[..], &["--cells", cells]].concat());
    let (l2, linf) = (with("l2"), with("linf"));
    assert_eq!(l2, measured(&dir, &sites));
    assert!(l2["energy_percent_l2"].is_null() && l2["tied_volume"].is_null());
    let number = |of: &Value, key: &str| of[key].as_f64().expect("a number");
    let close = |one: f64, other: f64| (one / other - 1.0).abs() < 1e-12;
    assert!(close(
        number(&linf, "energy_percent_l2"),
        number(&l2, "energy_percent")
    ));
    assert!(close(
        number(&linf, "energy_percent_linf"),
        number(&linf, "energy_percent")
    ));
    assert!(number(&linf, "energy_percent_linf") < number(&linf, "energy_percent_l2"));
    assert!(number(&linf, "tied_volume") < 1e-12);
    assert!(close(number(&linf, "volume_sum"), 1.0));

    dir.write("level.csv", "x,y,z\n0.25,0.5,0.5\n0.75,0.5,0.5\n");
    let level = measured(
        &dir,
        &["measure", "--sites", "level.csv", "--cells", "linf"],
    );
    assert!(number(&level, "tied_volume") > 0.1);
}

#[test]
fn runs_with_l_infinity_cells_resume_to_the_same_bytes() {
    let dir = TestDir::new();
    for method in ["lloyd", "quasi-newton"] {
        let relax = |rest: &[&str]| {
            let run = ["relax", "--count", "6", "--seed", "5", "--cells", "linf"];
            dir.stdout(&[&run[..], &["--method", method], rest].concat());
        };
        let [whole, parts] = ["whole", "parts"].map(|name| format!("{name}-{method}"));
        relax(&["--iterations", "3", "--out", &whole]);
        relax(&["--iterations", "1", "--out", &parts]);
        let resumed = ["relax", "--resume", "--iterations", "3", "--out", &parts];
        dir.stdout(&[&resumed[..], &["--threads", "1"]].concat());
        let [one, other] = [&whole, &parts].map(|run| dir.read(&format!("{run}/sites.csv")));
        assert_eq!(one, other);
        assert_eq!(dir.records(&whole), dir.records(&parts));
        let run = dir.json(&format!("{whole}/run.json"));
        assert_eq!(run["scene"]["cells"], "linf");
        let end = &run["final"];
        assert_eq!(end["energy_mean"], dir.records(&whole)[3]["energy_mean"]);
        assert!(end["energy_percent_linf"].as_f64() < end["energy_percent_l2"].as_f64());
        for name in ["cells.vtu", "cells.svg", "cells.png"] {
            assert!(!dir.read(&format!("{whole}/{name}")).is_empty());
        }
    }
}

#[test]
fn what_does_not_go_with_l_infinity_cells_is_refused_by_name() {
    let dir = TestDir::new();
    let norm = dir.refusal(&["relax", "--cells", "linf", "--norm", "l2"]);
    assert_all_in(&norm, &["cells", "linf", "norm"]);
    let scene = |more: &str| {
        let text =
            format!(r#"{{ "cells": "linf", {more} "sites": {{ "random": {{ "count": 9 }} }} }}"#);
        dir.write("scene.json", text);
        dir.refusal(&["relax", "scene.json"])
    };
    let single = r#""frames": "boundary","#;
    assert_all_in(&scene(single), &["cells", "frames of single sites"]);
    let turned = r#""frames": { "axis": [0, 0, 1], "degrees": 30 },"#;
    let weighted = format!(r#"{turned} "density": "1 + x","#);
    assert_all_in(&scene(&weighted), &["cells", "frames and a density"]);
    let torus = r#""domain": { "box": { "periodic": [true, true, true] } },"#;
    assert_all_in(&scene(&format!("{turned} {torus}")), &["cells", "periodic"]);
    assert_all_in(&dir.refusal(&["relax", "--cells", "l3"]), &["l3", "linf"]);
}

#[test]
fn the_plane_and_densities_have_l_infinity_cells() {
    let dir = TestDir::new();
    for (name, more) in [
        ("plane", r#""dimension": 2,"#),
        ("weighted", r#""density": "1 + x","#),
    ] {
        let text = format!(
            r#"{{ "cells": "linf", {more} "sites": {{ "random": {{ "count": 5 }} }},
                "method": {{ "lloyd": {{ "iterations": 2 }} }} }}"#
        );
        dir.write("scene.json", text);
        dir.stdout(&["relax", "scene.json", "--out", name]);
        let energies = dir.records(name).into_iter();
        let energies: Vec<_> = energies
            .map(|record| record["energy_mean"].as_f64())
            .collect();
        assert!(
            energies[0] > energies[1] && energies[1] > energies[2],
            "{energies:?}"
        );
        let end = &dir.json(&format!("{name}/run.json"))["final"];
        assert!(end["energy_percent_linf"].as_f64() < end["energy_percent_l2"].as_f64());
        assert!(!dir.read(&format!("{name}/cells.svg")).is_empty());
    }
}

#[test]
fn annealing_from_coarse_to_fine_has_l_infinity_cells_and_meshes_refuse_them() {
    let dir = TestDir::new();
    let text = r#"{ "cells": "linf", "sites": { "random": { "count": 16 } }, "coarse_to_fine": 1,
                    "method": { "anneal": { "rounds": 2, "steps": 3, "first_steps": 6 } } }"#;
    dir.write("scene.json", text);
    dir.stdout(&["relax", "scene.json", "--out", "annealed"]);
    let run = dir.json("annealed/run.json");
    let energy = |when: &str| run[when]["energy_percent"].as_f64().expect("a number");
    assert!(energy("final") < energy("initial") - 1.0, "{run}");
    assert_eq!(run["final"]["sites"], 16);
    let refused = dir.refusal(&["mesh", "annealed", "-o", "mesh"]);
    assert_all_in(&refused, &["L2 cells", "--cells l2"]);
}

#[test]
fn fragments_of_l_infinity_cells_add_up_to_what_measure_says() {
    let dir = TestDir::new();
    let sites = ["--count", "6", "--seed", "3", "--cells", "linf"];
    let fragments = |rest: &[&str]| {
        dir.stdout(&[&["fragments"], &sites[..], rest].concat());
    };
    for file in ["one.svg", "one.png", "one.vtu"] {
        fragments(&["-o", file]);
        assert!(!dir.read(file).is_empty());
    }
    fragments(&["--all", "--tets", "-o", "all.vtu"]);
    let mass = ["mass", "all.vtu", "--density", "vertex:distance", "--json"];
    let measured = measured(&dir, &[&["measure"], &sites[..]].concat());
    let energy = measured["energy_mean"].as_f64().expect("a number") * 6.0;
    let mass: Value = serde_json::from_str(&dir.stdout(&mass)).expect("one JSON object");
    let mass = mass["mass"].as_f64().expect("a number");
    assert!((mass / energy - 1.0).abs() < 1e-9, "{mass} {energy}");
}
