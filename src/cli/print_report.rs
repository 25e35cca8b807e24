//! The figures of `chebloyd print`: wanted against obtained, as JSON and as a table.

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::cli::mass_report::{MassProperties, figure};
use crate::cli::print_balance::Balanced;
use crate::cli::print_files::Bins;
use crate::cli::print_task::Task;
use crate::cli::print_weights::{Filling, Weights};
use crate::gcode::modulate::Modulated;
use crate::geometry::moments::Moments;
use crate::mass::body::Body;

/// The written file's volume (a share) and center (mm) may differ so much from what was planned: by the
/// rounding of E.
const ROUNDING: (f64, f64) = (1e-4, 5e-3);

/// What came of a run.
#[derive(Debug)]
pub(crate) struct PrintOutcome {
    input: String,
    output: String,
    infill: Vec<String>,
    pub(crate) planned: Modulated,
    sliced: Weights,
    wanted: Weights,
    /// What was planned, until the written file has been weighed.
    pub(crate) obtained: Weights,
    as_planned: Weights,
    pub(crate) written: bool,
    limits: [f64; 2],
    filling: Filling,
    step: f64,
    pub(crate) balanced: Option<Balanced>,
    pub(crate) notes: Vec<String>,
    pub(crate) refusal: Option<String>,
    /// What was wanted along an axis, where a report is asked for.
    pub(crate) profile: Option<Bins>,
}

impl PrintOutcome {
    pub(crate) fn new(
        task: &Task<'_>,
        planned: Modulated,
        limits: [f64; 2],
        notes: Vec<String>,
    ) -> Self {
        let near = task.near();
        let of = |infill: &Moments| Weights::of(&planned.fixed, infill, &near);
        let has_infill = |name: &&String| task.infill.has(name);
        let as_planned = of(&planned.written);
        let mut outcome = Self {
            input: task.options.file.display().to_string(),
            output: task.options.output.display().to_string(),
            infill: task.part.types.iter().filter(has_infill).cloned().collect(),
            sliced: of(&planned.sliced),
            wanted: of(&planned.wanted),
            obtained: as_planned,
            as_planned,
            written: false,
            limits,
            filling: task.filling,
            step: task.options.step,
            balanced: None,
            notes,
            refusal: None,
            profile: None,
            planned,
        };
        outcome.note_limits();
        outcome
    }

    fn note_limits(&mut self) {
        self.note_widths();
        if let Some([least, most]) = self.planned.speeds {
            self.notes.push(format!(
                "speeds of changed pieces run from {least:.1} to {most:.1} mm/s; the print takes {:+.0} s \
                 (times in comments follow, those of M73 do not)",
                self.planned.change.seconds
            ));
        }
        if self.filling.share.is_none() {
            self.notes
                .push("how full infill fills space is unknown: give --filling".into());
        }
    }

    fn note_widths(&mut self) {
        let [narrow, wide] = self.planned.odd_widths;
        if narrow > 0 {
            self.notes.push(format!(
                "{narrow} of {} pieces are narrower than half the nozzle: they may not hold together",
                self.planned.pieces
            ));
        }
        if wide > 0 {
            self.notes.push(format!(
                "{wide} of {} pieces are wider than two nozzles: they may not be laid evenly",
                self.planned.pieces
            ));
        }
    }

    /// Where full filling clips: what it is known from.
    fn filled_up(&self) -> String {
        let ([_, above], high) = (self.planned.clipped, self.limits[1]);
        if above == 0 || high < self.filling.limit() {
            return String::new();
        }
        let percent = 100.0 / self.filling.limit();
        format!(
            "; above {high:.4} a place would be filled to more than 100 % ({percent:.1} % as sliced, {})",
            self.filling.source
        )
    }

    /// Why a field is not written without --clip.
    pub(crate) fn clipping(&self) -> Option<String> {
        let [below, above] = self.planned.clipped;
        if below + above == 0 {
            return None;
        }
        let [least, most] = self.planned.extremes.unwrap_or([1.0; 2]);
        let [low, high] = self.limits;
        let center = |weights: &Weights| weights.part.map(|body| body.center_of_mass());
        let off = center(&self.wanted)
            .zip(center(&self.as_planned))
            .map_or(f64::NAN, |(wanted, planned)| (wanted - planned).norm());
        let filled = self.filled_up();
        Some(format!(
            "{} of {} pieces of infill would be clipped: the field runs from {least:.4} to {most:.4}, the \
             limits are {low:.4} and {high:.4}{filled}; the center would be {off:.4} mm off; nothing is \
             written; widen --range, divide by --relative-to, or --clip",
            below + above,
            self.planned.pieces
        ))
    }

    /// Takes what the written file weighs, compared with what was planned.
    pub(crate) fn read_back(&mut self, obtained: Weights, notes: Vec<String>) {
        self.obtained = obtained;
        self.notes.extend(notes);
        self.written = true;
        let (Some(planned), Some(obtained)) = (self.as_planned.part, self.obtained.part) else {
            return;
        };
        let volume = (planned.volume - obtained.volume).abs() / planned.volume;
        let center = (planned.center_of_mass() - obtained.center_of_mass()).norm();
        if volume > ROUNDING.0 || center > ROUNDING.1 {
            self.refusal = Some(format!(
                "{}, read again, weighs {} mm³ and not {}, its center is {center:.4} mm off: do not \
                 print it",
                self.output, obtained.volume, planned.volume
            ));
        }
    }

    /// The distance of two centers (mm).
    fn off(&self) -> Option<f64> {
        let wanted = self.wanted.part?.center_of_mass();
        Some((wanted - self.obtained.part?.center_of_mass()).norm())
    }

    pub(crate) fn json(&self) -> Result<String, Failure> {
        let text = serde_json::to_string_pretty(&PrintJson::of(self)).map_err(Failure::run)?;
        Ok(text + "\n")
    }

    pub(crate) fn table(&self) -> String {
        let mut text = format!(
            "{:<24}{:>20}{:>20}{:>20}\n",
            "", "wanted", "obtained", "as sliced"
        );
        text += &self.line("volume", &|one| Some(one.part?.volume));
        for (axis, name) in ["center of mass x", "y", "z"].iter().enumerate() {
            text += &self.line(name, &|one| Some(one.part?.center_of_mass()[axis]));
        }
        for (place, name) in ["principal moments", "", ""].iter().enumerate() {
            text += &self.line(name, &|one| Some(one.part?.principal().moments[place]));
        }
        text += &self.line("infill volume", &|one| Some(one.infill?.volume));
        for (axis, name) in ["infill center x", "y", "z"].iter().enumerate() {
            text += &self.line(name, &|one| Some(one.infill?.center_of_mass()[axis]));
        }
        text + &self.other_lines()
    }

    /// What is wanted, obtained and sliced of one figure.
    fn line(&self, name: &str, value: &dyn Fn(&Weights) -> Option<f64>) -> String {
        let three = [&self.wanted, &self.obtained, &self.sliced];
        let shown = |weights| value(weights).map_or(format!("{:>20}", "-"), figure);
        let values: String = three.iter().map(|weights| shown(weights)).collect();
        format!("{name:<24}{values}\n")
    }

    /// Figures of the pieces, and of what the print is to do.
    fn figures(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        lines.extend(self.off().map(|off| ("center off by", format!("{off:.6}"))));
        lines.extend(
            self.balanced
                .iter()
                .flat_map(|one| one.lines(&self.obtained)),
        );
        let [least, most] = self.planned.extremes.unwrap_or([1.0; 2]);
        let [low, high] = self.limits;
        let (changed, moves) = (self.planned.changed, self.planned.moves);
        let clipped: usize = self.planned.clipped.iter().sum();
        lines.extend([
            ("multipliers", format!("{least:.4} … {most:.4}")),
            ("limits", format!("{low:.4} … {high:.4}")),
            ("pieces", self.planned.pieces.to_string()),
            ("clipped", clipped.to_string()),
            ("moves changed", format!("{changed} of {moves}")),
        ]);
        lines
    }

    fn other_lines(&self) -> String {
        let mut text = String::new();
        for (name, value) in self.figures() {
            text += &format!("{name:<24}{value:>20}\n");
        }
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        if self.written {
            text += &format!("{}\n", self.output);
        }
        text
    }
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct PrintJson<'a> {
    input: &'a str,
    output: &'a str,
    written: bool,
    wanted: Option<MassProperties>,
    obtained: Option<MassProperties>,
    as_sliced: Option<MassProperties>,
    /// The distance of the centers wanted and obtained.
    center_error: Option<f64>,
    infill: InfillJson<'a>,
    /// The share of the part that does not vary.
    fixed_share: f64,
    multiplier: MultiplierJson,
    filling: Filling,
    #[serde(flatten)]
    balance: Option<serde_json::Map<String, serde_json::Value>>,
    step: f64,
    pieces: usize,
    moves: usize,
    moves_changed: usize,
    clipped: ClippedJson,
    /// mm/s of changed pieces.
    speeds: Option<[f64; 2]>,
    seconds_added: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a str>,
    notes: &'a [String],
}

#[derive(Debug, Serialize)]
struct InfillJson<'a> {
    types: &'a [String],
    wanted: Option<Share>,
    obtained: Option<Share>,
    as_sliced: Option<Share>,
}

#[derive(Debug, Serialize)]
struct Share {
    volume: f64,
    center_of_mass: [f64; 3],
}

#[derive(Debug, Serialize)]
struct MultiplierJson {
    least: Option<f64>,
    greatest: Option<f64>,
    mean: f64,
    /// Infinite is null.
    limits: [Option<f64>; 2],
}

#[derive(Debug, Serialize)]
struct ClippedJson {
    below: usize,
    above: usize,
    added_volume: f64,
    removed_volume: f64,
}

fn properties(body: Option<Body>) -> Option<MassProperties> {
    let mut properties = MassProperties::of(&body?, None);
    properties.totals.surface_area = None;
    Some(properties)
}

fn share(body: Option<Body>) -> Option<Share> {
    body.map(|body| Share {
        volume: body.volume,
        center_of_mass: body.center_of_mass().into(),
    })
}

impl<'a> InfillJson<'a> {
    fn of(outcome: &'a PrintOutcome) -> Self {
        Self {
            types: &outcome.infill,
            wanted: share(outcome.wanted.infill),
            obtained: share(outcome.obtained.infill),
            as_sliced: share(outcome.sliced.infill),
        }
    }
}

impl MultiplierJson {
    fn of(outcome: &PrintOutcome) -> Self {
        let planned = &outcome.planned;
        let [least, greatest] = [0, 1].map(|end| planned.extremes.map(|ends| ends[end]));
        Self {
            least,
            greatest,
            mean: planned.written.mass / planned.sliced.mass,
            limits: outcome.limits.map(|end| end.is_finite().then_some(end)),
        }
    }
}

impl ClippedJson {
    fn of(planned: &Modulated) -> Self {
        let [below, above] = planned.clipped;
        let [added_volume, removed_volume] = planned.clipped_volume;
        Self {
            below,
            above,
            added_volume,
            removed_volume,
        }
    }
}

impl<'a> PrintJson<'a> {
    fn of(outcome: &'a PrintOutcome) -> Self {
        let planned = &outcome.planned;
        let balanced = outcome.balanced.as_ref();
        Self {
            input: &outcome.input,
            output: &outcome.output,
            written: outcome.written,
            wanted: properties(outcome.wanted.part),
            obtained: properties(outcome.obtained.part),
            as_sliced: properties(outcome.sliced.part),
            center_error: outcome.off(),
            infill: InfillJson::of(outcome),
            fixed_share: planned.fixed.mass / (planned.fixed.mass + planned.sliced.mass),
            multiplier: MultiplierJson::of(outcome),
            filling: outcome.filling,
            balance: balanced.map(|one| one.json(&outcome.obtained)),
            step: outcome.step,
            pieces: planned.pieces,
            moves: planned.moves,
            moves_changed: planned.changed,
            clipped: ClippedJson::of(planned),
            speeds: planned.speeds,
            seconds_added: planned.change.seconds,
            error: outcome.refusal.as_deref(),
            notes: &outcome.notes,
        }
    }
}
