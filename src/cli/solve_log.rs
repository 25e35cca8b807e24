//! The log of a density's solution: a line of JSON for every step.

use serde::Serialize;

use crate::balance::solve::SolveStep;
use crate::cli::failure::Failure;

/// A line of the log.
#[derive(Debug, Serialize)]
struct LogLine {
    iteration: usize,
    residual: f64,
    dual_value: f64,
}

/// The text of `log.jsonl`.
pub(crate) fn solve_log(steps: &[SolveStep]) -> Result<String, Failure> {
    let mut log = String::new();
    for step in steps {
        let line = LogLine {
            iteration: step.iteration,
            residual: step.residual,
            dual_value: step.value,
        };
        log += &(serde_json::to_string(&line).map_err(Failure::run)? + "\n");
    }
    Ok(log)
}
