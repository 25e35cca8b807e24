//! The figures of `chebloyd spin`, as JSON and as a table.

use serde::Serialize;

use crate::balance::conditions::{Condition, SpinAxis};
use crate::balance::dual::DensityRange;
use crate::balance::solve::SolveEnd;
use crate::balance::spin::{SpinContrast, SpinSolution, SpinState, combined};
use crate::cli::failure::Failure;
use crate::cli::mass_report::{figure, rows};
use crate::cli::modifiers::ModifiersReport;

/// What came of a wish.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// What carries the densities.
    pub(crate) basis: &'static str,
    /// How many.
    pub(crate) count: usize,
    /// Within which the densities are.
    pub(crate) range: DensityRange,
    /// Whether the range was not asked for.
    pub(crate) is_ample: bool,
    /// The least contrast.
    pub(crate) contrast: SpinContrast,
    /// The field.
    pub(crate) solution: SpinSolution,
    /// How the body spins with it.
    pub(crate) state: SpinState,
    /// The same of the formula, where the field is handed on as one.
    pub(crate) formula: Option<SpinState>,
    /// The axis.
    pub(crate) axis: SpinAxis,
}

impl Outcome {
    /// Whether there is a field.
    pub(crate) fn is_met(&self) -> bool {
        self.solution.variance.end == SolveEnd::Met
    }

    /// Multiplies all densities.
    pub(crate) fn scale(&mut self, factor: f64) {
        self.range = DensityRange {
            low: self.range.low * factor,
            high: self.range.high * factor,
            prefer: self.range.prefer * factor,
        };
        self.solution.variance.multipliers *= factor;
        for density in &mut self.solution.densities {
            *density *= factor;
        }
    }

    /// d₀ + Σ λ_k φ_k, which the field clamps.
    pub(crate) fn formula(&self) -> Condition {
        let multipliers = &self.solution.variance.multipliers;
        let sum = combined(&self.solution.conditions, multipliers, &self.axis.through);
        Condition {
            constant: sum.constant + self.range.prefer,
            ..sum
        }
    }

    /// Why there is no field.
    pub(crate) fn refusal(&self) -> Option<String> {
        let DensityRange { low, high, .. } = self.range;
        let least = self.contrast.contrast;
        let needed = needed(least);
        // The least contrast has a proof of its own.
        let is_refuted = self.solution.variance.end == SolveEnd::Refuted || least * low > high;
        if self.is_met() {
            None
        } else if is_refuted {
            Some(format!(
                "no density between {low} and {high} does this; {needed}; widen --range"
            ))
        } else {
            Some(format!(
                "no density was found between {low} and {high}; {needed}, which the range's contrast \
                 {:.6} is too near; widen --range",
                high / low
            ))
        }
    }
}

/// What is printed, in this order.
#[derive(Debug, Serialize)]
pub(crate) struct SpinReport {
    feasible: bool,
    /// The center from the axis.
    distance: f64,
    angle_degrees: f64,
    mass: f64,
    center_of_mass: [f64; 3],
    inertia_center: [[f64; 3]; 3],
    principal_moments: [f64; 3],
    moment_about_axis: f64,
    /// The place of the axis's moment among the principal ones.
    axis_moment: &'static str,
    /// Infinite is null.
    least_contrast: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    certificate: Option<Certificate>,
    range: [Option<f64>; 2],
    range_chosen: bool,
    prefer: f64,
    mean_density: f64,
    nearest_axis: NearestAxis,
    native: Native,
    #[serde(skip_serializing_if = "Option::is_none")]
    formula: Option<FormulaReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    modifiers: Option<SpinModifiers>,
    basis: BasisReport,
    multipliers: Vec<f64>,
    iterations: usize,
    evaluations: usize,
}

/// ∫ d polynomial < 0 for every density within the range.
#[derive(Debug, Serialize)]
struct Certificate {
    polynomial: String,
}

/// The principal axes nearest to the axis.
#[derive(Debug, Serialize)]
struct NearestAxis {
    before: [f64; 3],
    after: [f64; 3],
}

/// The solid at density 1.
#[derive(Debug, Serialize)]
struct Native {
    volume: f64,
    distance: f64,
    angle_degrees: f64,
    center_of_mass: [f64; 3],
}

/// The field as the formula that it is written as, by eight times the points.
#[derive(Debug, Serialize)]
struct FormulaReport {
    distance: f64,
    angle_degrees: f64,
}

/// The field as bodies for slicers.
#[derive(Debug, Serialize)]
struct SpinModifiers {
    #[serde(flatten)]
    bodies: ModifiersReport,
    distance: f64,
    angle_degrees: f64,
}

#[derive(Debug, Serialize)]
struct BasisReport {
    kind: &'static str,
    count: usize,
}

impl SpinReport {
    pub(crate) fn new(outcome: &Outcome, native: &SpinState) -> Self {
        let (state, axis) = (&outcome.state, &outcome.axis);
        let body = &state.body;
        let finite = |number: f64| number.is_finite().then_some(number);
        let is_met = outcome.is_met();
        let certificate = (!is_met).then(|| Certificate {
            polynomial: outcome.contrast.certificate.text(),
        });
        Self {
            feasible: is_met,
            distance: state.distance,
            angle_degrees: state.angle_degrees,
            mass: body.mass,
            center_of_mass: body.center_of_mass().into(),
            inertia_center: rows(&body.inertia_center()),
            principal_moments: body.principal().moments.into(),
            moment_about_axis: body.moment_about_axis(&axis.through, &axis.along),
            axis_moment: ["least", "middle", "largest"][state.moment_rank],
            least_contrast: finite(outcome.contrast.contrast),
            certificate,
            range: [outcome.range.low, outcome.range.high].map(finite),
            range_chosen: outcome.is_ample,
            prefer: outcome.range.prefer,
            mean_density: body.mass / body.volume,
            nearest_axis: NearestAxis {
                before: native.nearest_axis.into(),
                after: state.nearest_axis.into(),
            },
            native: Native {
                volume: native.body.volume,
                distance: native.distance,
                angle_degrees: native.angle_degrees,
                center_of_mass: native.body.center_of_mass().into(),
            },
            formula: outcome.formula.map(|state| FormulaReport {
                distance: state.distance,
                angle_degrees: state.angle_degrees,
            }),
            modifiers: None,
            basis: BasisReport {
                kind: outcome.basis,
                count: outcome.count,
            },
            multipliers: outcome.solution.variance.multipliers.as_slice().to_vec(),
            iterations: outcome.solution.iterations,
            evaluations: outcome.solution.evaluations + outcome.contrast.evaluations,
        }
    }

    /// With the bodies that were written.
    pub(crate) fn with(self, modifiers: Option<(ModifiersReport, SpinState)>) -> Self {
        let modifiers = modifiers.map(|(bodies, state)| SpinModifiers {
            bodies,
            distance: state.distance,
            angle_degrees: state.angle_degrees,
        });
        Self { modifiers, ..self }
    }

    pub(crate) fn json(&self) -> Result<String, Failure> {
        let text = serde_json::to_string_pretty(self).map_err(Failure::run)?;
        Ok(text + "\n")
    }

    /// A line for every figure.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, numbers: &[f64]| {
            let numbers: String = numbers.iter().map(|&number| figure(number)).collect();
            text += &format!("{name:<24}{numbers}\n");
        };
        line("distance before", &[self.native.distance]);
        line("angle before (degrees)", &[self.native.angle_degrees]);
        line(
            "least contrast",
            &[self.least_contrast.unwrap_or(f64::INFINITY)],
        );
        let range = self.range.map(|bound| bound.unwrap_or(f64::INFINITY));
        line("range", &range);
        if self.feasible {
            line("distance", &[self.distance]);
            line("angle (degrees)", &[self.angle_degrees]);
            line("mass", &[self.mass]);
            line("mean density", &[self.mean_density]);
            line("center of mass", &self.center_of_mass);
            line("principal moments", &self.principal_moments);
            line("moment about the axis", &[self.moment_about_axis]);
        }
        if let Some(formula) = &self.formula {
            line("formula's distance", &[formula.distance]);
            line("formula's angle", &[formula.angle_degrees]);
        }
        if let Some(modifiers) = &self.modifiers {
            line("modifiers' distance", &[modifiers.distance]);
            line("modifiers' angle", &[modifiers.angle_degrees]);
            text += &modifiers.bodies.table();
        }
        if let Some(certificate) = &self.certificate {
            text += &format!("{:<26}{}\n", "certificate", certificate.polynomial);
        }
        if self.range_chosen && self.feasible {
            text += "note: no --range was given: the range is 1.5 times the least contrast\n";
        }
        let (count, kind) = (self.basis.count, self.basis.kind);
        let (iterations, evaluations) = (self.iterations, self.evaluations);
        text + &format!(
            "{count} {kind}, {iterations} iterations, {evaluations} evaluations; of the principal \
             moments the axis's is the {}\n",
            self.axis_moment
        )
    }
}

/// The least contrast that suffices, in words.
fn needed(least: f64) -> String {
    if least.is_finite() {
        format!("it takes a contrast of {least:.6} (greatest density to least)")
    } else {
        "no contrast suffices: the solid lies on one side of what is asked".to_owned()
    }
}
