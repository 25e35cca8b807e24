//! `chebloyd stand`: a density with which a solid stands.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use nalgebra::Vector3;

use crate::balance::dual::DensityRange;
use crate::balance::modifiers::of_ramp;
use crate::balance::solid::SolidBalance;
use crate::balance::stand::{StandGoal, StandPlan, stand};
use crate::balance::support::{Ground, Support};
use crate::cli::failure::{Failure, print};
use crate::cli::mass_notes::notes_of_parts;
use crate::cli::mass_report::positive;
use crate::cli::modifiers::{ModifiersReport, modifier_count, modifier_files, write_modifiers};
use crate::cli::options::{Common, length, print_notes};
use crate::cli::output::OutputRule;
use crate::cli::spin::density_range;
use crate::cli::stand_files::{StandFiles, stand_files};
use crate::cli::stand_report::{StandBody, StandReport};
use crate::cli::stand_text::{Coordinates, ground_point, point, polygon_on, target, up};
use crate::mesh::formats::read::load_within;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::Solid;

/// Find the density with which a solid stands: its center of mass over its support
///
/// Of all densities within the range that put the center of mass over the support, the one nearest to a
/// constant is a clamped ramp; it is found by some Newton steps, from the surface alone. The least contrast
/// (greatest density to least) that any density needs is told; where the range is narrower, exit 1 with a
/// plane that proves it (hi on one side of it and lo on the other is the best that there is, and does not
/// do) and the nearest center that can be reached.
#[derive(Debug, Args)]
pub(crate) struct StandOptions {
    /// Closed surfaces or tetrahedral meshes, parts of one body
    #[arg(required = true, value_name = "SOLID")]
    files: Vec<PathBuf>,
    /// Away from the ground: x, -x, y, -y, z, -z or a direction
    #[arg(long, value_name = "X,Y,Z", default_value = "z", value_parser = up, allow_hyphen_values = true)]
    up: Vector3<f64>,
    /// What touches the ground: the vertices up to this share of the height
    #[arg(long, value_name = "SHARE", default_value = "0.01", value_parser = share, allow_hyphen_values = true,
          conflicts_with_all = ["polygon", "point", "target"])]
    contact: f64,
    /// Stand on the convex hull of the points in this file: two coordinates across up a line, or three
    #[arg(long, value_name = "FILE", conflicts_with_all = ["point", "target"])]
    polygon: Option<PathBuf>,
    /// Stand on, or hang from, one point: two coordinates across up, or three
    #[arg(long, value_name = "X,Y", value_parser = point, conflicts_with = "target", allow_hyphen_values = true)]
    point: Option<Coordinates>,
    /// Put the center of mass here; _ frees a coordinate, as in 0.25,_,_
    #[arg(long, value_name = "X,Y,Z", value_parser = target, allow_hyphen_values = true)]
    target: Option<[Option<f64>; 3]>,
    /// How far inside the support's edges the center stays
    #[arg(long, value_name = "L", default_value = "0", value_parser = not_negative, allow_hyphen_values = true)]
    margin: f64,
    /// Stand on ground tilted so far in any direction
    #[arg(long, value_name = "DEGREES", default_value = "0", value_parser = degrees, allow_hyphen_values = true)]
    tilt: f64,
    /// The least and the greatest density; HI may be inf [default: 1 to the least contrast times 1.5]
    #[arg(long, value_name = "LO,HI", value_parser = density_range, allow_hyphen_values = true)]
    range: Option<[f64; 2]>,
    /// The density that the field stays near to [default: LO]
    #[arg(long, value_name = "D0", value_parser = positive, allow_hyphen_values = true)]
    prefer: Option<f64>,
    /// Also the mass; without --range all densities are scaled to it
    #[arg(long, value_name = "M", value_parser = positive, allow_hyphen_values = true)]
    mass: Option<f64>,
    /// Which of the densities that stand
    #[arg(long, value_enum, default_value = "least-variance")]
    goal: Goal,
    /// Merge vertices of an open mesh up to L apart, in the file's unit [default: 1e-12 of its box]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
    /// Write field.json, report.json, log.jsonl, density.vtu and a picture of a cut there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Also write the field there as up to N closed slabs of one density each, for slicers to take as
    /// modifier meshes: STL files, and one 3MF with the part and their fillings
    #[arg(long, value_name = "N", requires = "out", value_parser = modifier_count)]
    modifiers: Option<usize>,
    /// Replace files that DIR holds
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Goal {
    /// As near to a constant as can be
    LeastVariance,
    /// The least ratio of densities: one plane parts high from low
    LeastContrast,
    /// The largest tilt of the ground that the range allows
    MostStable,
}

impl From<Goal> for StandGoal {
    fn from(goal: Goal) -> Self {
        match goal {
            Goal::LeastVariance => Self::LeastVariance,
            Goal::LeastContrast => Self::LeastContrast,
            Goal::MostStable => Self::MostStable,
        }
    }
}

pub(crate) fn run(options: &StandOptions, common: Common) -> Result<(), Failure> {
    options.check_prefer()?;
    let solids = options
        .files
        .iter()
        .map(|file| load_within(file, options.weld.unwrap_or(0.0)).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let surfaces: Vec<SurfaceMesh> = solids.iter().map(boundary).collect();
    let plan = options.plan(&surfaces)?;
    options.check_outputs()?;
    let balance = SolidBalance::new(&surfaces, &[]);
    if balance.whole.mass.is_nan() || balance.whole.mass <= 0.0 {
        return Err(Failure::input("the solids have no volume"));
    }
    let watch = Instant::now();
    let standing = stand(&balance, &plan).map_err(|error| match error.is_of_input() {
        true => Failure::input(error),
        false => Failure::run(error),
    })?;
    let body = StandBody {
        surfaces: &surfaces,
        balance: &balance,
    };
    let seconds = watch.elapsed().as_secs_f64();
    let report = StandReport::new(body, &plan, &standing, seconds)?;
    let modifiers = options.write_modifiers(&surfaces, &report)?;
    let report = report.with(modifiers);
    if let Some(folder) = &options.out {
        let files = StandFiles {
            folder,
            solids: &solids,
            plan: &plan,
            report: &report,
        };
        files.write(&standing)?;
    }
    if options.json {
        print(report.json()?)?;
    } else if !common.quiet {
        print_notes(&notes_of_parts(&options.files, &solids));
        print(report.table())?;
    }
    report
        .refusal()
        .map_or(Ok(()), |why| Err(Failure::Run(why)))
}

impl StandOptions {
    fn check_prefer(&self) -> Result<(), Failure> {
        match (self.prefer, self.range) {
            (Some(prefer), Some([low, high])) if !(low..=high).contains(&prefer) => {
                Err(Failure::input(format!(
                    "--prefer {prefer} lies outside --range {low},{high}"
                )))
            }
            _ => Ok(()),
        }
    }

    /// Refuses to replace what must not be.
    fn check_outputs(&self) -> Result<(), Failure> {
        let Some(folder) = &self.out else {
            return Ok(());
        };
        let inputs: Vec<_> = self.files.iter().chain(&self.polygon).cloned().collect();
        let rule = OutputRule {
            inputs: &inputs,
            force: self.force,
            option: "--out",
        };
        let mut files = stand_files(folder);
        if let Some(count) = self.modifiers {
            files.extend(modifier_files(folder, count));
        }
        rule.check(&files)
    }

    /// Writes the field as slabs.
    fn write_modifiers(
        &self,
        surfaces: &[SurfaceMesh],
        report: &StandReport,
    ) -> Result<Option<ModifiersReport>, Failure> {
        let (Some(folder), Some(count), Some(field)) = (&self.out, self.modifiers, report.field())
        else {
            return Ok(None);
        };
        let part = joined(surfaces);
        let range = DensityRange {
            low: field.low,
            high: field.high.unwrap_or(f64::INFINITY),
            prefer: field.low,
        };
        let bodies = of_ramp(&part, &range, field.value, &field.gradient.into(), count);
        let greatest = bodies.iter().map(|body| body.density).fold(0.0, f64::max);
        let solid_density = field.high.unwrap_or(greatest);
        write_modifiers(folder, &part, &bodies, solid_density).map(Some)
    }

    fn plan(&self, surfaces: &[SurfaceMesh]) -> Result<StandPlan, Failure> {
        let vertices = surfaces.iter().flat_map(|mesh| &mesh.vertices);
        let ground = Ground::below(&self.up, vertices).map_err(Failure::input)?;
        Ok(StandPlan {
            support: self.support(&ground, surfaces)?,
            ground,
            margin: self.margin,
            tilt: self.tilt.to_radians().tan(),
            range: self.range,
            prefer: self.prefer,
            mass: self.mass,
            goal: self.goal.into(),
        })
    }

    fn support(&self, ground: &Ground, surfaces: &[SurfaceMesh]) -> Result<Support, Failure> {
        if let Some(target) = self.target {
            return Ok(Support::Target(target));
        }
        if let Some(point) = &self.point {
            return Ok(Support::Point(
                ground_point(ground, point)
                    .map_err(|why| Failure::input(format!("--point: {why}")))?,
            ));
        }
        if let Some(file) = &self.polygon {
            return polygon_on(ground, file);
        }
        let vertices = surfaces.iter().flat_map(|mesh| &mesh.vertices);
        ground
            .contact(vertices, self.contact)
            .map_err(Failure::input)
    }
}

/// The surface that bounds a solid.
fn boundary(solid: &Solid) -> SurfaceMesh {
    match solid {
        Solid::Surface(closed, _) => closed.mesh().clone(),
        Solid::Tets(sound, _) => sound.mesh().boundary(),
    }
}

/// A share between 0 and 1.
fn share(text: &str) -> Result<f64, String> {
    not_negative(text)
        .ok()
        .filter(|share| *share <= 1.0)
        .ok_or_else(|| "a share of the height is between 0 and 1".to_owned())
}

fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let number = number.filter(|number| *number >= 0.0 && number.is_finite());
    number.ok_or_else(|| "a number that is not negative is needed".to_owned())
}

fn degrees(text: &str) -> Result<f64, String> {
    let angle = not_negative(text)?;
    let is_tilt = angle < 90.0;
    is_tilt
        .then_some(angle)
        .ok_or_else(|| "a tilt is less than 90 degrees".to_owned())
}

fn joined(surfaces: &[SurfaceMesh]) -> SurfaceMesh {
    let mut all = SurfaceMesh::default();
    for surface in surfaces {
        all.append(surface);
    }
    all
}
