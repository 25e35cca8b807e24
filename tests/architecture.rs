//! The house: who may import whom, and how large rooms may grow.

use std::fs;
use std::path::{Path, PathBuf};

/// Floor → the floors from which it may import. What is not listed is a mistake.
const MAY_IMPORT: [(&str, &[&str]); 13] = [
    ("geometry", &[]),
    ("minimize", &[]),
    ("mesh", &["geometry"]),
    ("integrals", &["geometry"]),
    ("domain", &["geometry", "mesh", "integrals"]),
    ("mass", &["geometry", "integrals", "mesh"]),
    ("voronoi", &["geometry", "domain", "integrals"]),
    ("energy", &["geometry", "integrals", "minimize"]),
    (
        "relax",
        &[
            "geometry",
            "integrals",
            "domain",
            "voronoi",
            "energy",
            "minimize",
        ],
    ),
    (
        "scene",
        &["geometry", "domain", "mesh", "relax", "integrals"],
    ),
    ("export", &["geometry", "voronoi", "relax"]),
    ("plot", &["geometry", "voronoi", "relax"]),
    ("cli", &[]),
];

/// Lines of a file before its tests.
const LONGEST_FILE: usize = 500;

fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .flat_map(|path| {
            if path.is_dir() {
                sources(&path)
            } else {
                vec![path]
            }
        })
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect();
    files.sort();
    files
}

fn source_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// The floor on which a file stands, `None` for lib.rs and main.rs.
fn floor(file: &Path) -> Option<String> {
    let inside = file.strip_prefix(source_root()).unwrap();
    let first = inside.components().next()?.as_os_str().to_str()?;
    (!first.ends_with(".rs")).then(|| first.to_owned())
}

/// The floors named after `crate::` in code (not in comments).
fn imports(text: &str) -> Vec<String> {
    let code = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let pieces = code.flat_map(|line| line.split("crate::").skip(1).map(str::to_owned));
    let names = pieces.map(|piece| {
        let is_name = |c: &char| c.is_alphanumeric() || *c == '_';
        piece.chars().take_while(is_name).collect::<String>()
    });
    names.collect()
}

#[test]
fn imports_follow_the_arrows() {
    let mut mistakes = Vec::new();
    for file in sources(&source_root()) {
        let Some(floor) = floor(&file) else { continue };
        let allowed = MAY_IMPORT.iter().find(|(name, _)| *name == floor);
        let Some((_, allowed)) = allowed else {
            mistakes.push(format!("{} is on no floor", file.display()));
            continue;
        };
        for target in imports(&fs::read_to_string(&file).unwrap()) {
            if target != floor && !allowed.contains(&target.as_str()) {
                mistakes.push(format!("{} imports {target}", file.display()));
            }
        }
    }
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
}

#[test]
fn children_do_not_import_their_parents() {
    for file in sources(&source_root()) {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        assert!(!code.contains("use super::"), "{}", file.display());
    }
}

#[test]
fn only_one_floor_names_argmin() {
    for file in sources(&source_root()) {
        let text = fs::read_to_string(&file).unwrap();
        let names = text
            .lines()
            .any(|line| line.trim_start().starts_with("use argmin"));
        assert!(
            !names || floor(&file).as_deref() == Some("minimize"),
            "{}",
            file.display()
        );
    }
}

#[test]
fn only_the_binary_prints_and_parses_arguments() {
    for file in sources(&source_root()) {
        let in_binary = floor(&file).is_none_or(|floor| floor == "cli");
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for word in [
            "println!(",
            "eprintln!(",
            "print!(",
            "use clap",
            "use indicatif",
        ] {
            let named = code
                .lines()
                .any(|line| !line.trim_start().starts_with("//") && line.contains(word));
            assert!(in_binary || !named, "{} uses {word}", file.display());
        }
    }
}

#[test]
fn files_stay_short() {
    let mut long = Vec::new();
    for file in sources(&source_root()) {
        let text = fs::read_to_string(&file).unwrap();
        let lines = text
            .lines()
            .take_while(|line| *line != "#[cfg(test)]")
            .count();
        if lines > LONGEST_FILE {
            long.push(format!("{}: {lines} lines", file.display()));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn a_mod_file_is_a_signboard() {
    for file in sources(&source_root()) {
        if file.file_name().is_none_or(|name| name != "mod.rs") {
            continue;
        }
        for line in fs::read_to_string(&file).unwrap().lines() {
            let is_sign = line.is_empty() || line.starts_with("//") || line.starts_with("#[");
            let is_module = ["pub mod ", "mod ", "pub(crate) mod "]
                .iter()
                .any(|start| line.starts_with(start) && line.ends_with(';'));
            assert!(is_sign || is_module, "{}: {line}", file.display());
        }
    }
}
