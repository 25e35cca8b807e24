//! What files must hold: another reader gets back what was written.

use std::fs;

use chebloyd::export::log::{LogError, read_log};

const LINE: &str = r#"{"iteration":0,"energy_mean":1.0,"energy_max":2.0,"energy_percent":126.4,"movement_mean":0.0,"movement_max":0.0,"movement_percent":0.0,"evaluations":1.0,"seconds":0.1,"temperature":0.5}"#;

/// A folder with one file `log.jsonl` of this content.
fn log(content: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("log.jsonl"), content).expect("written");
    folder
}

#[test]
fn a_log_reads_back_without_its_torn_last_line() {
    let whole = log(&format!("{LINE}\n{LINE}\n\n{LINE}"));
    let records = read_log(&whole.path().join("log.jsonl")).expect("reads");
    assert_eq!(records.len(), 3);
    assert!((records[2].energy_percent - 126.4).abs() < 1e-15);
    let torn = log(&format!("{LINE}\n{}", &LINE[..LINE.len() / 2]));
    assert_eq!(
        read_log(&torn.path().join("log.jsonl"))
            .expect("reads")
            .len(),
        1
    );
    let empty = log("");
    assert!(
        read_log(&empty.path().join("log.jsonl"))
            .expect("reads")
            .is_empty()
    );
}

#[test]
fn a_bad_line_is_named() {
    let folder = log(&format!("{LINE}\n{{\"iteration\": 1}}\n{LINE}\n"));
    let path = folder.path().join("log.jsonl");
    let error = read_log(&path).expect_err("refused");
    assert!(matches!(error, LogError::Line { line: 2, .. }));
    let message = error.to_string();
    assert!(
        message.contains("log.jsonl, line 2") && message.contains("energy_mean"),
        "{message}"
    );
    let message = read_log(&folder.path().join("none"))
        .expect_err("refused")
        .to_string();
    assert!(message.contains("none"), "{message}");
}
