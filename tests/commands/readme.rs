//! The README's commands exist, and its figures are what they print.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn readme() -> String {
    fs::read_to_string(root().join("README.md")).expect("README.md")
}

/// A fenced block: its language and its lines, those that end with a backslash joined to the next; and a block
/// without lines for every heading.
fn blocks(text: &str) -> Vec<(String, Vec<String>)> {
    let mut blocks: Vec<(String, Vec<String>)> = Vec::new();
    let mut is_open = false;
    for line in text.lines() {
        if !is_open && line.starts_with('#') {
            blocks.push(("heading".to_owned(), Vec::new()));
        } else if let Some(language) = line.strip_prefix("```") {
            if !is_open {
                blocks.push((language.to_owned(), Vec::new()));
            }
            is_open = !is_open;
        } else if is_open {
            let lines = &mut blocks.last_mut().expect("a block").1;
            match lines.last_mut().filter(|last| last.ends_with('\\')) {
                Some(last) => {
                    last.pop();
                    last.push_str(line.trim_start());
                }
                None => lines.push(line.to_owned()),
            }
        }
    }
    blocks
}

/// A command's words after `chebloyd`, without its remark; quotes hold words together.
fn words(line: &str) -> Option<Vec<String>> {
    let rest = line.strip_prefix("chebloyd ")?;
    let (mut words, mut quote, mut word) = (Vec::new(), None, String::new());
    for letter in rest.chars().chain([' ']) {
        match (letter, quote) {
            ('#', None) => break,
            ('"' | '\'', None) => quote = Some(letter),
            (_, Some(open)) if letter == open => quote = None,
            (' ', None) if word.is_empty() => {}
            (' ', None) => words.push(std::mem::take(&mut word)),
            _ => word.push(letter),
        }
    }
    Some(words)
}

fn program(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_chebloyd"))
        .current_dir(root())
        .args(arguments)
        .output()
        .expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn commands_and_options_of_the_readme_exist() {
    let mut wrong = Vec::new();
    let mut helps = std::collections::BTreeMap::new();
    for (_, lines) in blocks(&readme())
        .into_iter()
        .filter(|(kind, _)| kind == "sh")
    {
        for words in lines.iter().filter_map(|line| words(line)) {
            let command = words[0].clone();
            let help = helps
                .entry(command.clone())
                .or_insert_with(|| program(&[&command, "--help"]));
            for word in words.iter().filter(|word| word.starts_with("--")) {
                let option = word.split('=').next().unwrap_or(word);
                if !help.contains(option) {
                    wrong.push(format!("{command} {word}"));
                }
            }
        }
    }
    assert!(helps.len() >= 6, "{:?}", helps.keys());
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn files_of_the_readme_are_there() {
    let text = readme();
    let is_part = |letter: char| letter.is_alphanumeric() || "./_-".contains(letter);
    let named: BTreeSet<&str> = text
        .split(|letter| !is_part(letter))
        .filter(|word| {
            ["scenes/", "examples/", "tests/cases/", "benches/"]
                .iter()
                .any(|folder| word.starts_with(folder))
        })
        .map(|word| word.trim_end_matches('.'))
        .collect();
    assert!(named.len() > 5, "{named:?}");
    let generic = "scenes/NAME.json";
    let missing: Vec<_> = named
        .into_iter()
        .filter(|name| *name != generic && !root().join(name).exists())
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// A block of what a command prints stands behind the block of the command, the last one with its files
/// in the repository; `…` stands for lines left out.
#[test]
fn printed_blocks_are_what_the_commands_print() {
    let blocks = blocks(&readme());
    let mut checked = 0;
    for pair in blocks.windows(2) {
        let [(shell, commands), (kind, printed)] = pair else {
            continue;
        };
        if shell != "sh" || kind != "text" {
            continue;
        }
        // Those that write files are not run in the repository.
        let writes = |words: &Vec<String>| words.iter().any(|word| word == "-o" || word == "--out");
        let commands: Vec<_> = commands.iter().filter_map(|line| words(line)).collect();
        let commands: Vec<_> = commands
            .into_iter()
            .filter(|words| !writes(words))
            .collect();
        if commands.is_empty() {
            continue;
        }
        let outputs: Vec<String> = commands
            .iter()
            .map(|words| program(&words.iter().map(String::as_str).collect::<Vec<_>>()))
            .collect();
        let shown = |line: &&String| !line.contains('…') && !line.trim().is_empty();
        let holds = |output: &String| {
            printed.iter().filter(shown).all(|line| {
                output
                    .lines()
                    .any(|found| found.trim_end() == line.trim_end())
            })
        };
        assert!(
            outputs.iter().any(holds),
            "{commands:?} print no longer\n{}\nbut\n{}",
            printed.join("\n"),
            outputs.join("\n")
        );
        checked += 1;
    }
    assert!(checked >= 2, "{checked} blocks");
}

/// The cells of the row of a table that begins with this.
fn row(start: &str) -> Vec<String> {
    let text = readme();
    let line = text.lines().find(|line| line.starts_with(start));
    let line = line.unwrap_or_else(|| panic!("no row {start}"));
    let cells = line.trim_matches('|').split('|');
    cells.map(|cell| cell.trim().to_owned()).collect()
}

/// The rows of the methods' table that take below a second.
#[test]
fn rows_of_the_methods_table_are_what_runs_end_with() {
    let out = tempfile::tempdir().expect("a folder for the test");
    for (start, arguments) in [
        ("| `lloyd`, 50 iterations |", &["--iterations", "50"][..]),
        (
            "| `quasi-newton`, 24 steps |",
            &["--method", "quasi-newton", "--iterations", "24"],
        ),
        ("| `--goal cubes` |", &["--goal", "cubes"]),
    ] {
        let row = row(start);
        let directory = out.path().join(row[0].replace(['`', ' ', ','], "-"));
        let folder = directory.to_string_lossy();
        let common = [
            "relax", "--count", "1000", "--seed", "1", "--quiet", "--out", &folder,
        ];
        program(&[&common[..], arguments].concat());
        let run = fs::read(directory.join("run.json")).expect("run.json");
        let run: Value = serde_json::from_slice(&run).expect("JSON");
        let number = |key: &str| run["final"][key].as_f64().expect("a number");
        let decimals = row[1].split('.').nth(1).map_or(0, str::len);
        assert_eq!(
            row[1],
            format!("{:.decimals$}", number("energy_percent")),
            "{start}"
        );
        assert_eq!(row[2], format!("{:.2}", number("cubeness")), "{start}");
        let share = row[3].trim_end_matches(" %");
        let decimals = share.split('.').nth(1).map_or(0, str::len);
        let six_facets = 100.0 * number("six_facet_fraction");
        assert_eq!(share, format!("{six_facets:.decimals$}"), "{start}");
        assert_eq!(
            row[4],
            format!("{:.2}", number("axis_aligned_area")),
            "{start}"
        );
        let log = fs::read_to_string(directory.join("log.jsonl")).expect("a log");
        let last: Value =
            serde_json::from_str(log.lines().last().expect("a record")).expect("JSON");
        let evaluations = last["evaluations"].as_f64().expect("a number");
        assert_eq!(row[5], format!("{evaluations:.0}"), "{start}");
    }
}

/// The figures of octrees at depths 4 and 8, where the models are.
#[test]
#[ignore = "needs ../shared/models; .ci/run runs it where they are"]
fn rows_of_the_octree_table_are_what_the_command_prints() {
    let models = root().join("../shared/models");
    let both = [("rocker-arm", "rocker-arm.obj"), ("casting", "casting.off")];
    for ((name, file), depth) in both
        .into_iter()
        .flat_map(|model| [(model, "4"), (model, "8")])
    {
        let file = models.join(file);
        let printed = program(&[
            "octree",
            &file.to_string_lossy(),
            "--depths",
            depth,
            "--json",
        ]);
        let report: Value = serde_json::from_str(&printed).expect("JSON");
        let tree = &report["models"][0]["trees"][0];
        let paper = &tree["paper"];
        let row = row(&format!("| {name} | {depth} |"));
        let number = |value: &Value| value.as_f64().expect("a number");
        assert_eq!(row[2], format!("{} ({})", tree["nodes"], paper["nodes"]));
        let both = |key: &str| format!("{:.4} ({:.4})", number(&tree[key]), number(&paper[key]));
        assert_eq!(row[3], both("center_error_percent"));
        assert_eq!(row[4], both("mass_error_percent"));
        let (ours, theirs) = (number(&tree["nodes"]), number(&paper["nodes"]));
        assert!(
            (ours / theirs - 1.0).abs() < 0.01,
            "{ours} nodes, not {theirs}"
        );
    }
}
