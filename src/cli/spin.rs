//! `chebloyd spin`: a density with which a solid spins about an axis.

use std::path::PathBuf;

use clap::Args;

use crate::balance::conditions::SpinAxis;
use crate::balance::dual::DensityRange;
use crate::balance::modifiers::of_cells;
use crate::balance::solve::SolveEnd;
use crate::balance::spin::{SpinBody, SpinSolution, SpinState, SpinWish};
use crate::cli::failure::{Failure, print};
use crate::cli::mass_report::{AxisMoment, axis, positive};
use crate::cli::modifiers::{
    ModifiersReport, modifier_count, modifier_files, weigh_bodies, write_modifiers,
};
use crate::cli::options::{Common, length, print_notes};
use crate::cli::output::OutputRule;
use crate::cli::spin_bores::find_bores;
use crate::cli::spin_files::{SpinFiles, spin_files};
use crate::cli::spin_report::{Outcome, SpinReport};
use crate::cli::spin_sine::{self, SineOptions};
use crate::cli::spin_solid::{Basis, SpinElements, SpinSolid};
use crate::complex::assemble::assemble_whole;
use crate::domain::shape::DomainShape;
use crate::geometry::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use crate::voronoi::diagram::Diagram;

/// Without --range the densities' contrast is the least one that suffices times this.
const AMPLE: f64 = 1.5;

/// How often a range is widened for the half-spaces of the cone of --stable.
const MOST_WIDENINGS: usize = 8;

/// By how much --stable makes the axis's moment exceed the others if nothing is said.
const STABLE_SHARE: &str = "0.01";

/// Find the density with which a solid spins: its center of mass on an axis, the axis principal
///
/// Of all densities within the range that put the center on the axis and make its products of inertia
/// vanish, the one nearest to a constant is found, exactly for the field that is written: one density for
/// each Voronoi cell of the solid, each vertex of a tetrahedral mesh, or each of many points. The least
/// contrast (greatest density to least) that any density needs is told, and where the range is narrower,
/// exit 1 and a certificate: a polynomial whose integral no density of that range makes zero.
#[derive(Debug, Args)]
pub(crate) struct SpinOptions {
    /// Closed surfaces or tetrahedral meshes, together one solid
    #[arg(required = true, value_name = "SOLID")]
    pub(crate) files: Vec<PathBuf>,
    /// The axis: a point and a direction
    #[arg(long, value_name = "PX,PY,PZ,DX,DY,DZ", value_parser = axis, allow_hyphen_values = true,
          required_unless_present = "find_bores")]
    axis: Option<AxisMoment>,
    /// List the axes of the solid's cylindrical holes, each ready for --axis, and do nothing else
    #[arg(long, conflicts_with = "axis")]
    find_bores: bool,
    /// Also the place of the center along the axis: its distance from the axis's point
    #[arg(long, value_name = "Z", value_parser = finite, allow_hyphen_values = true)]
    center_at: Option<f64>,
    /// Also the axis's moment the largest, by this share of the others at least (without a
    /// number 0.01): the solid then spins without tumbling
    #[arg(long, value_name = "SHARE", num_args = 0..=1, require_equals = true,
          default_missing_value = STABLE_SHARE, value_parser = share)]
    stable: Option<f64>,
    /// The least and the greatest density [default: the least contrast that suffices, times 1.5, from 1]
    #[arg(long, value_name = "LO,HI", value_parser = density_range)]
    range: Option<[f64; 2]>,
    /// The density that the field stays near to [default: the least]
    #[arg(long, value_name = "D0", value_parser = positive)]
    prefer: Option<f64>,
    /// Also the mass; without --range all densities are scaled to it
    #[arg(long, value_name = "M", value_parser = positive)]
    mass: Option<f64>,
    /// Also the moment of inertia about the axis; without --range all densities are scaled to it
    #[arg(long, value_name = "I", value_parser = positive)]
    moment: Option<f64>,
    /// What carries one density each: Voronoi cells, so many (any solid, exact), the vertices of a
    /// tetrahedral mesh (exact, linear in between), or so many points (the field is a formula)
    #[arg(
        long,
        value_name = "cells:N|points:N|vertex",
        default_value = "cells:1000"
    )]
    basis: Basis,
    /// Fit the density sin(k|y − p|) + 1 by p and k instead, from random starts, the solid's own integrals
    /// exact: as the paper does, for comparison
    #[arg(long, value_name = "sine", value_parser = ["sine"], conflicts_with_all = [
        "range", "prefer", "stable", "mass", "moment", "center_at", "modifiers"])]
    field: Option<String>,
    /// How many starts: the best sixteenth of so many places drawn
    #[arg(long, value_name = "N", requires = "field", default_value = "400",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    starts: u32,
    /// The seed of the cells' sites, and of the starts
    #[arg(long, value_name = "S", default_value = "1")]
    seed: u64,
    /// Merge vertices of an open mesh up to L apart, in the file's unit [default: 1e-12 of its box]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
    /// Write the field (field.json), report.json, log.jsonl, density.vtu and the picture of a cut along
    /// the axis there
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Replace files that DIR holds
    #[arg(long)]
    force: bool,
    /// Also write the field there as up to N closed bodies of one density each, for slicers to take as
    /// modifier meshes: STL files, and one 3MF with the part and their fillings (cells only)
    #[arg(long, value_name = "N", requires = "out", value_parser = modifier_count)]
    modifiers: Option<usize>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(options: &SpinOptions, common: Common) -> Result<(), Failure> {
    let range = options.given_range()?;
    options.check_outputs()?;
    let solid = SpinSolid::read(&options.files, options.weld)?;
    let Some(given) = options.axis()? else {
        return find_bores(&solid, options.json, common);
    };
    let axis = given.moved_to(given.height(&solid.domain.bounds().center()));
    let elements = solid.elements(options.basis, options.seed, &axis.through)?;
    let body = SpinBody {
        moments: elements.moments(),
        axis,
    };
    let task = SpinTask {
        options,
        solid: &solid,
        elements: &elements,
        body,
    };
    let native = task.native();
    if options.field.is_some() {
        let wish = options.wish(&axis, true);
        return spin_sine::run(&solid, &elements, &wish, &native, options.sine(), common);
    }
    let outcome = task.outcome(range)?;
    let modifiers = task.write_modifiers(&outcome)?;
    let report = SpinReport::new(&outcome, &native).with(modifiers);
    if let Some(directory) = &options.out {
        let files = SpinFiles {
            directory,
            solid: &solid,
            elements: &elements,
        };
        files.write(&outcome, &native, &report)?;
    }
    if options.json {
        print(report.json()?)?;
    } else if !common.quiet {
        print_notes(&solid.notes);
        print(report.table())?;
    }
    outcome
        .refusal()
        .map_or(Ok(()), |why| Err(Failure::Run(why)))
}

impl SpinOptions {
    fn axis(&self) -> Result<Option<SpinAxis>, Failure> {
        let Some(given) = &self.axis else {
            return Ok(None);
        };
        let axis = SpinAxis::new(&given.through, &given.along);
        let refusal = || Failure::input("--axis: the direction has no length");
        axis.map(Some).ok_or_else(refusal)
    }

    fn sine(&self) -> SineOptions<'_> {
        SineOptions {
            starts: self.starts as usize,
            seed: self.seed,
            out: self.out.as_deref(),
            json: self.json,
        }
    }

    /// The range asked for.
    fn given_range(&self) -> Result<Option<DensityRange>, Failure> {
        let Some([low, high]) = self.range else {
            return Ok(None);
        };
        let prefer = self.prefer.unwrap_or(low);
        if !(low..=high).contains(&prefer) {
            return Err(Failure::input(format!(
                "--prefer {prefer} lies outside --range {low},{high}"
            )));
        }
        Ok(Some(DensityRange { low, high, prefer }))
    }

    /// Refuses to replace what must not be.
    fn check_outputs(&self) -> Result<(), Failure> {
        if self.modifiers.is_some() && !matches!(self.basis, Basis::Cells(_)) {
            return Err(Failure::input("--modifiers needs --basis cells:N"));
        }
        let Some(directory) = &self.out else {
            return Ok(());
        };
        let rule = OutputRule {
            inputs: &self.files,
            force: self.force,
            option: "--out",
        };
        let mut files = spin_files(directory);
        if let Some(count) = self.modifiers {
            files.extend(modifier_files(directory, count));
        }
        rule.check(&files)
    }

    /// What is wanted, heights measured from `axis`'s point; `scaled` leaves out what a factor on all
    /// densities brings about.
    fn wish(&self, axis: &SpinAxis, scaled: bool) -> SpinWish {
        let given = self.axis.map(|given| axis.height(&given.through));
        let from = given.unwrap_or_default();
        let ratio = self
            .moment
            .zip(self.mass)
            .map(|(moment, mass)| moment / mass);
        SpinWish {
            axis: *axis,
            principal: true,
            center_at: self.center_at.map(|height| height + from),
            stable: self.stable,
            moment: self.moment.filter(|_| !scaled),
            mass: self.mass.filter(|_| !scaled),
            gyration_squared: ratio.filter(|_| scaled),
        }
    }
}

/// One call of the command.
struct SpinTask<'a> {
    options: &'a SpinOptions,
    solid: &'a SpinSolid,
    elements: &'a SpinElements,
    body: SpinBody<'a>,
}

impl SpinTask<'_> {
    /// The solid at density 1.
    fn native(&self) -> SpinState {
        let moments = self.solid.moments(&self.body.axis.through);
        self.state(&moments)
    }

    fn state(&self, moments: &Moments) -> SpinState {
        let surface = self.solid.domain.surface();
        SpinState::of(
            moments,
            self.solid.domain.volume(),
            surface.area(),
            &self.body.axis,
        )
    }

    /// What comes of a range, or of an ample one.
    fn outcome(&self, range: Option<DensityRange>) -> Result<Outcome, Failure> {
        let wish = self.options.wish(&self.body.axis, range.is_none());
        let (range, solution) = match range {
            Some(range) => (range, self.body.spin(&wish, &range)),
            None => self.ample(&wish)?,
        };
        let contrast = self.body.least_contrast(&solution.conditions, range.low);
        let moments = self.body.weigh(|element| solution.densities[element]);
        let mut outcome = Outcome {
            basis: self.elements.kind(),
            count: self.body.moments.len(),
            range,
            is_ample: self.options.range.is_none(),
            contrast,
            state: self.state(&moments),
            axis: self.body.axis,
            formula: None,
            solution,
        };
        if self.options.range.is_none() && outcome.is_met() {
            outcome.scale(self.factor(&outcome.state));
            let moments = self
                .body
                .weigh(|element| outcome.solution.densities[element]);
            outcome.state = self.state(&moments);
        }
        outcome.formula = self.as_formula(&outcome);
        Ok(outcome)
    }

    /// The factor on all densities that a mass or a moment asks for.
    fn factor(&self, state: &SpinState) -> f64 {
        let axis = &self.body.axis;
        let moment = state.body.moment_about_axis(&axis.through, &axis.along);
        let by_moment = self.options.moment.map(|wanted| wanted / moment);
        let by_mass = self.options.mass.map(|wanted| wanted / state.body.mass);
        by_mass.or(by_moment).unwrap_or(1.0)
    }

    /// The field within the least range that suffices, widened.
    fn ample(&self, wish: &SpinWish) -> Result<(DensityRange, SpinSolution), Failure> {
        let mut conditions = wish.conditions();
        let mut widest = 1.0;
        loop {
            let contrast = self.body.least_contrast(&conditions, 1.0).contrast;
            let (low, high) = (1.0, f64::max(AMPLE * contrast, widest));
            let prefer = self.options.prefer.unwrap_or(low);
            if !(low..=high).contains(&prefer) {
                return Err(Failure::input(format!(
                    "--prefer {prefer} lies outside the densities 1 to {high}; give --range too"
                )));
            }
            let range = DensityRange { low, high, prefer };
            let solution = self.body.spin(wish, &range);
            let is_done = solution.variance.end == SolveEnd::Met || !contrast.is_finite();
            widest *= AMPLE;
            if is_done || widest > AMPLE.powi(MOST_WIDENINGS as i32) {
                return Ok((range, solution));
            }
            conditions = solution.conditions;
        }
    }

    /// Writes the field as bodies; how the solid spins with them.
    fn write_modifiers(
        &self,
        outcome: &Outcome,
    ) -> Result<Option<(ModifiersReport, SpinState)>, Failure> {
        let (SpinElements::Cells(sites, moments), Some(count), Some(directory), true) = (
            self.elements,
            self.options.modifiers,
            &self.options.out,
            outcome.is_met(),
        ) else {
            return Ok(None);
        };
        let diagram = Diagram::new(&self.solid.domain, sites).map_err(Failure::run)?;
        let mesh = assemble_whole(&diagram).map_err(Failure::run)?;
        let origin = self.body.axis.through;
        let bodies = of_cells(&mesh, &outcome.solution.densities, moments, &origin, count);
        let surface = self.solid.domain.surface();
        let solid_density = greatest_density(outcome);
        let report = write_modifiers(directory, surface, &bodies, solid_density)?;
        let state = self.state(&weigh_bodies(&bodies, &origin));
        Ok(Some((report, state)))
    }

    /// A field of points is handed on as a formula: the formula's own moments, by eight times the points.
    fn as_formula(&self, outcome: &Outcome) -> Option<SpinState> {
        let finer = self.elements.finer();
        if finer.is_empty() || !outcome.is_met() {
            return None;
        }
        let formula = outcome.formula();
        let origin = self.body.axis.through;
        let moments = sum_by_halves(finer.len(), &|range| {
            let parts = finer[range].iter();
            let weighed = parts.map(|point| {
                let density = outcome.range.clamp(formula.at(&point.position));
                point.moments(&origin) * density
            });
            weighed.fold(Moments::default(), |sum, part| sum + part)
        });
        Some(self.state(&moments))
    }
}

/// A finite number.
fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "a number is needed".to_owned())
}

/// A number that is not negative.
fn share(text: &str) -> Result<f64, String> {
    finite(text).and_then(|number| match number >= 0.0 {
        true => Ok(number),
        false => Err("a share is not negative".to_owned()),
    })
}

/// LO,HI with 0 < LO ≤ HI; HI may be `inf`.
pub(crate) fn density_range(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse::<f64>())
        .collect::<Result<_, _>>()
        .map_err(|_| "two numbers LO,HI are needed; HI may be inf")?;
    match numbers[..] {
        [low, high] if low > 0.0 && low.is_finite() && high >= low => Ok([low, high]),
        [low, high] if high < low => Err(format!("LO {low} is above HI {high}")),
        [_, _] => Err("LO must be positive: air is not printed".to_owned()),
        _ => Err(format!("two numbers are needed, not {}", numbers.len())),
    }
}

/// The range's upper end; where it has none, the greatest density of the field.
fn greatest_density(outcome: &Outcome) -> f64 {
    let densities = outcome.solution.densities.iter();
    let greatest = densities.copied().fold(0.0, f64::max);
    let high = Some(outcome.range.high).filter(|high| high.is_finite());
    high.unwrap_or(greatest)
}
