//! A temporary directory with the program run in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// A run that takes seconds, so that it can be interrupted.
pub(crate) const LONG: [&str; 6] = ["--count", "1500", "--seed", "3", "--iterations", "40"];

/// A temporary directory, the working directory of the commands run in it.
pub(crate) struct TestDir {
    pub(crate) folder: TempDir,
}

impl TestDir {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder for the test");
        Self { folder }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), content).expect("room for a test file");
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).expect("a JSON file")
    }

    pub(crate) fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_chebloyd"));
        command.current_dir(self.folder.path()).args(arguments);
        command
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments)
            .output()
            .expect("the program starts")
    }

    /// What a successful command prints.
    pub(crate) fn stdout(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
        assert_eq!(stderr, "", "stderr is for errors and terminals");
        String::from_utf8(output.stdout).expect("text")
    }

    /// The error of a command that is refused before it does anything.
    pub(crate) fn refusal(&self, arguments: &[&str]) -> String {
        let before = listing(self.folder.path());
        let output = self.run(arguments);
        let stderr = String::from_utf8(output.stderr).expect("text");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(stderr.starts_with("error: "), "{stderr}");
        assert_eq!(stderr.matches("error:").count(), 1, "one error: {stderr}");
        assert_eq!(before, listing(self.folder.path()), "nothing was touched");
        stderr
    }

    /// The records of the log in `directory` without their times.
    pub(crate) fn records(&self, directory: &str) -> Vec<Value> {
        let text = String::from_utf8(self.read(&format!("{directory}/log.jsonl"))).expect("text");
        let record = |line: &str| {
            let mut record: Value = serde_json::from_str(line).expect("a record");
            record.as_object_mut().expect("an object").remove("seconds");
            record
        };
        text.lines().map(record).collect()
    }

    /// Starts a long run in `directory` and waits until its log has so many lines.
    pub(crate) fn start(&self, directory: &str, lines: usize) -> Child {
        let mut child = self
            .command(&["relax", "--out", directory])
            .args(LONG)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let log = self.path(directory).join("log.jsonl");
        let patience = Instant::now() + Duration::from_secs(60);
        while fs::read_to_string(&log).unwrap_or_default().lines().count() < lines {
            assert!(
                child.try_wait().expect("a child").is_none(),
                "it ended too early"
            );
            assert!(Instant::now() < patience, "no record in a minute");
            std::thread::sleep(Duration::from_millis(5));
        }
        child
    }
}

/// Every file below `folder` with its content.
pub(crate) fn listing(folder: &Path) -> Vec<(PathBuf, Option<Vec<u8>>)> {
    let entries = fs::read_dir(folder).expect("a folder");
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.expect("an entry").path())
        .collect();
    paths.sort();
    let within = |path: PathBuf| {
        if path.is_dir() {
            let mut below = listing(&path);
            below.push((path, None));
            below
        } else {
            let content = fs::read(&path).expect("a file");
            vec![(path, Some(content))]
        }
    };
    paths.into_iter().flat_map(within).collect()
}

/// Fails unless `text` contains all `words`.
pub(crate) fn assert_all_in(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "`{word}` is missing in: {text}");
    }
}

/// A run of no time.
pub(crate) const SMALL: [&str; 4] = ["--count", "20", "--iterations", "2"];
