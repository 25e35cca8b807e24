//! The layout: allowed imports, no circles between files, limits on the size of files and functions.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folder → the folders from which it may import. What is not listed is a mistake.
const MAY_IMPORT: [(&str, &[&str]); 17] = [
    ("geometry", &[]),
    ("minimize", &[]),
    ("mesh", &["geometry"]),
    ("integrals", &["geometry"]),
    ("domain", &["geometry", "mesh", "integrals"]),
    ("mass", &["geometry", "integrals", "mesh"]),
    ("gcode", &["geometry"]),
    ("voronoi", &["geometry", "domain", "integrals"]),
    ("energy", &["geometry", "integrals", "minimize"]),
    ("complex", &["geometry", "mesh", "domain", "voronoi"]),
    (
        "balance",
        &["geometry", "integrals", "mesh", "mass", "domain", "voronoi"],
    ),
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
        &[
            "geometry",
            "domain",
            "mesh",
            "relax",
            "integrals",
            "mass",
            "voronoi",
        ],
    ),
    ("export", &["geometry", "mesh", "complex", "relax"]),
    ("plot", &["geometry", "mesh", "relax"]),
    ("report", &["geometry", "plot", "relax"]),
    (
        "cli",
        &[
            "geometry",
            "mesh",
            "integrals",
            "complex",
            "balance",
            "domain",
            "mass",
            "gcode",
            "voronoi",
            "energy",
            "relax",
            "scene",
            "export",
            "plot",
            "report",
        ],
    ),
];

/// Lines of a file before its tests.
const LONGEST_FILE: usize = 500;

/// Nine functions in ten have at most so many lines, and none has more than the longest.
const FUNCTION_P90: usize = 22;
const LONGEST_FUNCTION: usize = 60;

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

/// The folder in which a file stands, `None` for lib.rs and main.rs.
fn folder(file: &Path) -> Option<String> {
    let inside = file.strip_prefix(source_root()).unwrap();
    let first = inside.components().next()?.as_os_str().to_str()?;
    (!first.ends_with(".rs")).then(|| first.to_owned())
}

/// The files of the product: without those that are tests as a whole.
fn product() -> Vec<PathBuf> {
    let tests = source_root().join("tests");
    let files = sources(&source_root()).into_iter();
    files.filter(|file| !file.starts_with(&tests)).collect()
}

/// The lines of a file before its tests.
fn before_tests(file: &Path) -> Vec<String> {
    let text = fs::read_to_string(file).unwrap();
    let lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let starts_tests = |pair: &[String]| {
        pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod ") && pair[1].ends_with('{')
    };
    let end = lines.windows(2).position(starts_tests);
    lines[..end.unwrap_or(lines.len())].to_vec()
}

/// The code of a file: neither blank nor comment nor test.
fn code(file: &Path) -> Vec<String> {
    let is_code = |line: &String| !line.trim().is_empty() && !line.trim_start().starts_with("//");
    before_tests(file).into_iter().filter(is_code).collect()
}

/// The paths named after `crate::` in a file's code, groups in braces written out.
fn imports(file: &Path) -> BTreeSet<String> {
    let text = code(file).join("\n");
    let mut paths = BTreeSet::new();
    for piece in text.split("crate::").skip(1) {
        expand("", piece, &mut paths);
    }
    paths
}

/// Adds the paths with which `text` begins, each after `prefix`, and returns what follows them.
fn expand<'a>(prefix: &str, text: &'a str, paths: &mut BTreeSet<String>) -> &'a str {
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
    let (name, mut rest) = text.split_at(end.unwrap_or(text.len()));
    let path = format!("{prefix}{name}");
    if !rest.starts_with('{') || !name.is_empty() && !name.ends_with("::") {
        paths.insert(path.trim_end_matches(':').to_owned());
        return rest;
    }
    rest = &rest[1..];
    while !rest.starts_with('}') && !rest.is_empty() {
        let before = rest.len();
        rest = expand(&path, rest.trim_start(), paths).trim_start();
        assert!(rest.len() < before, "no import: {rest:.80}");
        if let Some(alias) = rest.strip_prefix("as ") {
            rest = &alias[alias.find([',', '}']).unwrap_or(alias.len())..];
        }
        rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
    }
    rest.strip_prefix('}').unwrap_or(rest)
}

/// The file that defines what a path after `crate::` names; none for `mod.rs` and `lib.rs`.
fn defining_file(path: &str) -> Option<PathBuf> {
    let names: Vec<_> = path.split("::").collect();
    (1..=names.len()).rev().find_map(|count| {
        let file = source_root().join(format!("{}.rs", names[..count].join("/")));
        file.is_file().then_some(file)
    })
}

/// What all may import: small arrays and loops over threads.
const BELOW_ALL: [&str; 2] = ["arrays", "parallel"];

#[test]
fn imports_follow_the_arrows() {
    let mut mistakes = Vec::new();
    for file in product() {
        let Some(floor) = folder(&file) else { continue };
        let allowed = MAY_IMPORT.iter().find(|(name, _)| *name == floor);
        let Some((_, allowed)) = allowed else {
            mistakes.push(format!("{} is in no known folder", file.display()));
            continue;
        };
        for path in imports(&file) {
            let target = path.split("::").next().unwrap_or_default();
            if target != floor && !BELOW_ALL.contains(&target) && !allowed.contains(&target) {
                mistakes.push(format!("{} imports {path}", file.display()));
            }
        }
    }
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
}

#[test]
fn no_arrow_is_stale() {
    let mut used: BTreeSet<(String, String)> = BTreeSet::new();
    for file in product() {
        let Some(from) = folder(&file) else { continue };
        for path in imports(&file) {
            let to = path.split("::").next().unwrap_or_default();
            used.insert((from.clone(), to.to_owned()));
        }
    }
    for (from, allowed) in MAY_IMPORT {
        for to in allowed {
            let arrow = (from.to_owned(), (*to).to_owned());
            assert!(used.contains(&arrow), "{from} no longer imports {to}");
        }
    }
}

/// The files that can be reached from `file` along imports.
fn reachable(file: &Path, arrows: &BTreeMap<PathBuf, BTreeSet<PathBuf>>) -> BTreeSet<PathBuf> {
    let mut known = BTreeSet::new();
    let mut stack: Vec<_> = arrows[file].iter().cloned().collect();
    while let Some(next) = stack.pop() {
        if known.insert(next.clone()) {
            stack.extend(arrows.get(&next).into_iter().flatten().cloned());
        }
    }
    known
}

#[test]
fn there_are_no_circles_between_files() {
    let arrows: BTreeMap<_, _> = product()
        .into_iter()
        .filter(|file| !file.ends_with("mod.rs") && !file.ends_with("lib.rs"))
        .map(|file| {
            let targets = imports(&file)
                .into_iter()
                .filter_map(|path| defining_file(&path));
            let targets = targets.filter(|target| *target != file).collect();
            (file, targets)
        })
        .collect();
    let in_circles: Vec<_> = arrows
        .keys()
        .filter(|file| reachable(file, &arrows).contains(*file))
        .map(|file| file.display().to_string())
        .collect();
    assert!(in_circles.is_empty(), "{}", in_circles.join("\n"));
}

#[test]
fn children_do_not_import_their_parents() {
    for file in product() {
        let code = code(&file).join("\n");
        assert!(!code.contains("use super::"), "{}", file.display());
    }
}

#[test]
fn argmin_and_voronator_stand_in_one_folder_each() {
    for (name, home) in [("argmin", "minimize"), ("voronator", "voronoi")] {
        for file in product() {
            let names = code(&file)
                .iter()
                .any(|line| line.trim_start().starts_with(&format!("use {name}")));
            let is_home = folder(&file).as_deref() == Some(home);
            assert!(!names || is_home, "{} uses {name}", file.display());
        }
    }
}

#[test]
fn only_the_command_prints_and_parses_arguments() {
    for file in product() {
        let in_command = folder(&file).is_some_and(|folder| folder == "cli");
        for word in [
            "println!(",
            "eprintln!(",
            "print!(",
            "use clap",
            "use indicatif",
        ] {
            let named = code(&file).iter().any(|line| line.contains(word));
            assert!(in_command || !named, "{} uses {word}", file.display());
        }
    }
}

#[test]
fn files_stay_short() {
    let mut long = Vec::new();
    for file in product() {
        let lines = before_tests(&file).len();
        if lines > LONGEST_FILE {
            long.push(format!("{}: {lines} lines", file.display()));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

/// The lengths of all functions, signature and braces counted, by the formatter's indentation.
fn function_lengths(file: &Path) -> Vec<(String, usize)> {
    let lines = before_tests(file);
    let mut lengths = Vec::new();
    for (first, line) in lines.iter().enumerate() {
        let words: Vec<_> = line.split_whitespace().collect();
        let is_function = words.first().is_some_and(|word| !word.starts_with("//"))
            && words.iter().take(4).any(|word| *word == "fn");
        if !is_function || line.ends_with(';') {
            continue;
        }
        let indent: String = line.chars().take_while(|c| *c == ' ').collect();
        let close = format!("{indent}}}");
        let is_declared =
            |line: &String| line.starts_with(&format!("{indent})")) && line.ends_with(';');
        let ends = |line: &String| *line == close || is_declared(line);
        let length = if line.ends_with('}') {
            1
        } else {
            lines[first..]
                .iter()
                .position(ends)
                .map_or(0, |last| last + 1)
        };
        lengths.push((format!("{}:{}", file.display(), first + 1), length));
    }
    lengths
}

#[test]
fn functions_stay_short() {
    let files = product();
    let lines: usize = files.iter().map(|file| code(file).len()).sum();
    println!("{lines} lines of code, without blanks, comments and tests");
    let mut lengths: Vec<_> = files
        .iter()
        .flat_map(|file| function_lengths(file))
        .collect();
    lengths.sort_by_key(|(_, length)| *length);
    assert!(lengths.len() > 1000, "{} functions found", lengths.len());
    let p90 = lengths[lengths.len() * 9 / 10].1;
    println!(
        "{} functions, p90 {p90}, longest {:?}",
        lengths.len(),
        lengths.last()
    );
    assert!(p90 <= FUNCTION_P90, "{p90} lines");
    let longest = lengths.last().unwrap();
    assert!(longest.1 <= LONGEST_FUNCTION, "{longest:?}");
}

#[test]
fn a_mod_file_is_a_signboard() {
    for file in product() {
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

#[test]
fn headlines_say_what_a_file_computes() {
    for file in product() {
        let text = fs::read_to_string(&file).unwrap();
        let headline = text.lines().next().unwrap_or_default();
        assert!(
            headline.starts_with("//! "),
            "{} has no headline",
            file.display()
        );
        let first = headline
            .trim_start_matches("//! ")
            .split_whitespace()
            .next();
        let is_riddle = first.is_some_and(|word| {
            ["What", "Where", "Whether", "Which", "Who", "How", "Why"].contains(&word)
        });
        assert!(!is_riddle, "{}: {headline}", file.display());
    }
}
