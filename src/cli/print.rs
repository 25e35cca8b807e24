//! `chebloyd print`: a sliced print whose infill is modulated so that its mass lies where it should.

use crate::cli::failure::{Failure, print};
use crate::cli::options::Common;
use crate::cli::output::OutputRule;
use crate::cli::print_balance::Balanced;
use crate::cli::print_field::PlacedField;
use crate::cli::print_files::{self, BinnedFlow, Bins, profile_axis};
use crate::cli::print_options::{PrintOptions, Relative};
use crate::cli::print_report::PrintOutcome;
use crate::cli::print_task::{Run, Task};
use crate::gcode::flow::{FieldFlow, Flow, PieceFlow};
use crate::scene::field::GivenField;

pub(crate) fn run(options: &PrintOptions, common: Common) -> Result<(), Failure> {
    if let Some((option, owner)) = options.misplaced() {
        return Err(Failure::input(format!("{option} is for {owner}")));
    }
    let given = options.density.as_deref().map(GivenField::read).transpose();
    let given = given.map_err(|error| Failure::input(format!("--density: {error}")))?;
    check_outputs(options, given.as_ref())?;
    let mut task = Task::open(options)?;
    let outcome = match (given, &options.density) {
        (Some(given), Some(text)) => by_field(&mut task, text, given)?,
        _ => by_balance(&mut task)?,
    };
    if let (Some(directory), Some(wanted)) = (&options.report, &outcome.profile) {
        print_files::write(directory, &mut task, wanted)?;
    }
    if options.json {
        print(outcome.json()?)?;
    } else if !common.quiet {
        print(outcome.table())?;
    }
    outcome.refusal.map_or(Ok(()), |why| Err(Failure::Run(why)))
}

/// Refuses to replace what must not be.
fn check_outputs(options: &PrintOptions, given: Option<&GivenField>) -> Result<(), Failure> {
    let mut inputs = vec![options.file.clone()];
    inputs.extend(given.and_then(|given| given.file.clone()));
    inputs.extend(options.balance.polygon.clone());
    let mut rule = OutputRule {
        inputs: &inputs,
        force: options.force,
        option: "-o",
    };
    rule.check(std::slice::from_ref(&options.output))?;
    if let Some(directory) = &options.report {
        rule.option = "--report";
        rule.check(&print_files::FILES.map(|name| directory.join(name)))?;
    }
    Ok(())
}

/// --density.
fn by_field(task: &mut Task<'_>, text: &str, given: GivenField) -> Result<PrintOutcome, Failure> {
    let options = task.options;
    let field = PlacedField::new(text, given, &task.part.bounds, options.place)?;
    let function = field.function()?;
    let mut flow = FieldFlow {
        field: &*function,
        unit: 1.0,
    };
    match options.relative_to {
        None => {}
        Some(Relative::Value(value)) => flow.unit = value,
        Some(Relative::Mean) => flow.unit = mean(task, &flow)?,
    }
    let asked = options.range.unwrap_or([0.0, f64::INFINITY]);
    let notes = field.note().into_iter().collect();
    let limits = task.limits(asked);
    finished(task, &flow, limits, None, notes)
}

/// The field's mean over the infill.
fn mean(task: &mut Task<'_>, flow: &dyn Flow) -> Result<f64, Failure> {
    let tried = task.tried(flow, [f64::NEG_INFINITY, f64::INFINITY])?;
    let mean = tried.wanted.mass / tried.sliced.mass;
    if mean > 0.0 && mean.is_finite() {
        return Ok(mean);
    }
    Err(Failure::input(format!(
        "--relative-to mean: the field's mean over the infill is {mean}, not positive"
    )))
}

/// --stand and --spin.
fn by_balance(task: &mut Task<'_>) -> Result<PrintOutcome, Failure> {
    let balanced = Balanced::solve(task)?;
    let (limits, notes) = (balanced.limits, balanced.notes.clone());
    let flow = PieceFlow(balanced.multipliers.clone());
    finished(task, &flow, limits, Some(balanced), notes)
}

/// Tries a flow, and writes the file if it may be written.
fn finished(
    task: &mut Task<'_>,
    flow: &dyn Flow,
    limits: [f64; 2],
    balanced: Option<Balanced>,
    notes: Vec<String>,
) -> Result<PrintOutcome, Failure> {
    let tried = task.tried(flow, limits)?;
    let mut outcome = PrintOutcome::new(task, tried, limits, notes);
    outcome.refusal = match &balanced {
        Some(balanced) => balanced.refusal.clone(),
        None if task.options.clip => None,
        None => outcome.clipping(),
    };
    outcome.balanced = balanced;
    if outcome.refusal.is_none() {
        let change = outcome.planned.change.clone();
        task.write(Run {
            flow,
            limits,
            change: Some(&change),
        })?;
        let (obtained, notes) = task.weighed_again()?;
        outcome.read_back(obtained, notes);
        outcome.profile = profile(task, flow)?;
    }
    Ok(outcome)
}

/// What a flow wants along the report's axis.
fn profile(task: &mut Task<'_>, flow: &dyn Flow) -> Result<Option<Bins>, Failure> {
    if task.options.report.is_none() {
        return Ok(None);
    }
    let bounds = &task.part.bounds;
    let binned = BinnedFlow::new(flow, Bins::over(bounds, profile_axis(task.options, bounds)));
    task.tried(&binned, [0.0, f64::INFINITY])?;
    Ok(Some(binned.into_bins()))
}
