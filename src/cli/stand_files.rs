//! The files of `chebloyd stand`: the field, the report, the log, and the density's pictures.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::balance::stand::{StandPlan, Standing};
use crate::balance::support::Support;
use crate::cli::density_files::{DensityBody, Section, center_mark, density_files, write_density};
use crate::cli::failure::{Failure, write_file};
use crate::cli::solve_log::solve_log;
use crate::cli::stand_report::{ClampReport, StandReport};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::mass::weigh::bounds;
use crate::mesh::validate::Solid;
use crate::plot::density_cut::{Mark, MarkShape, NATIVE, OBTAINED, WANTED};
use crate::plot::patches::PlaneCut;
use crate::scene::field::Field;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile, FieldFormula};

/// What the command writes besides the density's pictures.
const FILES: [&str; 3] = ["field.json", "report.json", "log.jsonl"];

/// The files of a directory that the command may write.
pub(crate) fn stand_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = density_files(folder);
    files.extend(FILES.map(|name| folder.join(name)));
    files
}

/// What is written of a run, and where.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StandFiles<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) solids: &'a [Solid],
    pub(crate) plan: &'a StandPlan,
    pub(crate) report: &'a StandReport,
}

impl StandFiles<'_> {
    /// Writes the report, and where there is a field, the field, its log and its pictures.
    pub(crate) fn write(&self, standing: &Standing) -> Result<(), Failure> {
        let folder = self.folder.display();
        fs::create_dir_all(self.folder)
            .map_err(|error| Failure::run(format!("cannot make {folder}: {error}")))?;
        self.write_text("log.jsonl", &log_text(standing)?)?;
        if let Some(clamp) = self.report.field() {
            let json = serde_json::to_string_pretty(&self.field_file(clamp));
            self.write_text("field.json", &(json.map_err(Failure::run)? + "\n"))?;
            self.draw(clamp)?;
        }
        self.write_text("report.json", &self.report.json()?)
    }

    fn write_text(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        write_file(&path, |file| file.write_all(text.as_bytes())).map_err(Failure::run)
    }

    /// The box of all solids.
    fn extent(&self) -> Bounds<3> {
        let boxes = self.solids.iter().map(bounds);
        let corners: Vec<_> = boxes.flat_map(|bounds| [bounds.min, bounds.max]).collect();
        Bounds::of(&corners)
    }

    fn field_file(&self, clamp: &ClampReport) -> FieldFile {
        let extent = self.extent();
        FieldFile {
            schema: None,
            density: FieldDensity::Clamp {
                low: clamp.low,
                high: clamp.high,
                of: FieldFormula::Affine {
                    value: clamp.value,
                    gradient: clamp.gradient,
                },
            },
            bounds: Some(FieldBounds {
                min: extent.min.into(),
                max: extent.max.into(),
            }),
        }
    }

    /// Writes `density.vtu` and the picture of the cut through both centers.
    fn draw(&self, clamp: &ClampReport) -> Result<(), Failure> {
        let field = Field::Solid(clamp.density().map_err(Failure::run)?);
        let fields = vec![&field; self.solids.len()];
        let body = DensityBody {
            solids: self.solids,
            fields: &fields,
            extent: &self.extent(),
        };
        write_density(self.folder, body, &self.section(clamp))
    }

    /// The upright plane through the native center along the gradient, or towards the obtained center.
    fn section(&self, clamp: &ClampReport) -> Section {
        let [before, after] = self.report.centers();
        let before = before.unwrap_or_else(Point3::origin);
        let after = after.unwrap_or(before);
        let ground = &self.plan.ground;
        let up = *ground.up.as_ref();
        let normal = across(&up, after - before);
        let normal = normal.or_else(|| across(&up, clamp.gradient.into()));
        let normal = normal.unwrap_or(-ground.across[1]);
        let plane = HalfSpace {
            normal,
            offset: normal.dot(&before.coords),
        };
        Section {
            cut: PlaneCut::with_up(plane, up),
            title: "A density that stands".to_owned(),
            marks: self.marks(&before, &after),
        }
    }

    /// The support, the vertical through the obtained center, and both centers.
    fn marks(&self, before: &Point3<f64>, after: &Point3<f64>) -> Vec<Mark> {
        let ground = &self.plan.ground;
        let support = match &self.plan.support {
            Support::Polygon(corners) => corners.clone(),
            Support::Segment(ends) => ends.to_vec(),
            Support::Point(place) => vec![*place],
            Support::Target(_) => Vec::new(),
        };
        let corners: Vec<_> = support.iter().map(|place| ground.at(place)).collect();
        let shape = match &corners[..] {
            [] => None,
            [only] => Some(MarkShape::Point(*only)),
            _ => Some(MarkShape::Polygon(corners)),
        };
        let mut marks: Vec<Mark> = Vec::new();
        marks.extend(shape.map(|shape| Mark {
            name: "support".to_owned(),
            color: WANTED,
            shape,
        }));
        marks.push(Mark {
            name: String::new(),
            color: OBTAINED,
            shape: MarkShape::Line {
                through: *after,
                along: *ground.up.as_ref(),
                dashed: true,
            },
        });
        marks.push(center_mark("center of volume", NATIVE, before));
        marks.push(center_mark("center of mass", OBTAINED, after));
        marks
    }
}

/// A line of JSON for every step towards the field.
fn log_text(standing: &Standing) -> Result<String, Failure> {
    match &standing.field {
        Ok(field) => solve_log(&field.solution.log),
        Err(_) => Ok(String::new()),
    }
}

/// The level direction across a way, if that is not upright.
fn across(up: &Vector3<f64>, way: Vector3<f64>) -> Option<Vector3<f64>> {
    let level = way - up * up.dot(&way);
    let is_long = level.norm() > 1e-9 * way.norm();
    is_long
        .then(|| up.cross(&level))
        .and_then(|normal| normal.try_normalize(0.0))
}
