//! The files of `chebloyd spin`: the field, the report, the log.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::balance::conditions::SpinAxis;
use crate::balance::spin::SpinState;
use crate::cli::density_files::{DensityBody, Section, center_mark, density_files, write_density};
use crate::cli::failure::{Failure, write_file};
use crate::cli::solve_log::solve_log;
use crate::cli::spin_report::{Outcome, SpinReport};
use crate::cli::spin_solid::{SpinElements, SpinSolid};
use crate::domain::shape::DomainShape;
use crate::geometry::half_space::HalfSpace;
use crate::mesh::surface::SurfaceMesh;
use crate::plot::color::Color;
use crate::plot::density_cut::{Mark, MarkShape, NATIVE, OBTAINED, WANTED};
use crate::plot::patches::PlaneCut;
use crate::scene::domain::SceneDomain;
use crate::scene::field::Field;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile, FieldFormula};
use crate::scene::mesh_domain::MeshDomain;

/// The solid of several files as one.
const SOLID: &str = "solid.off";

/// What the command writes.
const FILES: [&str; 4] = ["field.json", "report.json", "log.jsonl", SOLID];

/// Principal axes nearer to the axis than this (degrees) span no plane with it worth showing.
const LEAST_TILT: f64 = 0.1;

/// The files of a directory that the command may write.
pub(crate) fn spin_files(directory: &Path) -> Vec<PathBuf> {
    let mut files = density_files(directory);
    files.extend(FILES.map(|name| directory.join(name)));
    files
}

/// What is written of a run, and where.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpinFiles<'a> {
    pub(crate) directory: &'a Path,
    pub(crate) solid: &'a SpinSolid,
    pub(crate) elements: &'a SpinElements,
}

impl SpinFiles<'_> {
    /// Writes the report and the log, and where there is a field, the field and its pictures.
    pub(crate) fn write(
        &self,
        outcome: &Outcome,
        native: &SpinState,
        report: &SpinReport,
    ) -> Result<(), Failure> {
        let directory = self.directory.display();
        fs::create_dir_all(self.directory)
            .map_err(|error| Failure::run(format!("cannot make {directory}: {error}")))?;
        self.write_text("log.jsonl", &solve_log(&outcome.solution.variance.log)?)?;
        if outcome.is_met() {
            let field = field(self.solid, self.elements, outcome, self.domain()?);
            let json = serde_json::to_string_pretty(&field).map_err(Failure::run)?;
            self.write_text("field.json", &(json + "\n"))?;
            let states = [native, &outcome.state];
            draw(self.directory, self.solid, field, &outcome.axis, states)?;
        }
        self.write_text("report.json", &report.json()?)
    }

    fn write_text(&self, name: &str, text: &str) -> Result<(), Failure> {
        let path = self.directory.join(name);
        write_file(&path, |file| file.write_all(text.as_bytes())).map_err(Failure::run)
    }

    /// The domain for the field file; several files become one beside it.
    fn domain(&self) -> Result<SceneDomain, Failure> {
        if let Some(domain) = &self.solid.scene_domain {
            return Ok(domain.clone());
        }
        self.write_text(SOLID, &off(self.solid.domain.surface()))?;
        Ok(SceneDomain::Surface(MeshDomain {
            file: SOLID.into(),
            scale_to: None,
            weld: None,
        }))
    }
}

/// Writes `density.vtu` and the picture of a cut along the axis; how the solid spins before and after.
pub(crate) fn draw(
    directory: &Path,
    solid: &SpinSolid,
    field: FieldFile,
    axis: &SpinAxis,
    states: [&SpinState; 2],
) -> Result<(), Failure> {
    let field = Field::of_file(field.density).map_err(Failure::run)?;
    let extent = solid.domain.bounds();
    let body = DensityBody {
        solids: std::slice::from_ref(&solid.solid),
        fields: &[&field],
        extent: &extent,
    };
    write_density(directory, body, &section(axis, states))
}

/// The cut along the axis and the principal axis nearest to it before.
fn section(axis: &SpinAxis, states: [&SpinState; 2]) -> Section {
    let [native, state] = states;
    let [before, after] = states.map(|state| state.body.center_of_mass());
    let tilt = axis.along.cross(&native.nearest_axis);
    let lift = axis.along.cross(&(before - axis.through));
    let normal = if native.angle_degrees > LEAST_TILT {
        tilt
    } else {
        lift
    };
    let normal = normal.try_normalize(0.0).unwrap_or(axis.across[0]);
    let line = |name: &str, color, through, along, dashed| Mark {
        name: name.to_owned(),
        color,
        shape: MarkShape::Line {
            through,
            along,
            dashed,
        },
    };
    let angle = format!(
        "nearest principal axis before, {:.3}° off",
        native.angle_degrees
    );
    let wanted = *axis.along.as_ref();
    let obtained = state.nearest_axis;
    Section {
        cut: PlaneCut::new(HalfSpace {
            normal,
            offset: normal.dot(&axis.through.coords),
        }),
        title: "A density that spins about the axis".to_owned(),
        marks: vec![
            line("axis", WANTED, axis.through, wanted, false),
            line(&angle, Color::INK, before, native.nearest_axis, true),
            line(
                "nearest principal axis after",
                OBTAINED,
                after,
                obtained,
                true,
            ),
            center_mark("center of volume", NATIVE, &before),
            center_mark("center of mass", OBTAINED, &after),
        ],
    }
}

/// The field as a file.
fn field(
    solid: &SpinSolid,
    elements: &SpinElements,
    outcome: &Outcome,
    domain: SceneDomain,
) -> FieldFile {
    let values = outcome.solution.densities.clone();
    let density = match elements {
        SpinElements::Cells(sites, _) => FieldDensity::Cells {
            sites: sites.iter().map(|&site| site.into()).collect(),
            values,
            domain,
        },
        SpinElements::Vertices(_) => FieldDensity::Vertices { values },
        SpinElements::Points(..) => FieldDensity::Clamp {
            low: outcome.range.low,
            high: Some(outcome.range.high).filter(|high| high.is_finite()),
            of: FieldFormula::Polynomial(outcome.formula().text()),
        },
    };
    let bounds = solid.domain.bounds();
    FieldFile {
        schema: None,
        density,
        bounds: Some(FieldBounds {
            min: bounds.min.into(),
            max: bounds.max.into(),
        }),
    }
}

/// A surface as an OFF file, every coordinate to the last bit.
fn off(surface: &SurfaceMesh) -> String {
    let (vertices, triangles) = (&surface.vertices, &surface.triangles);
    let mut text = format!("OFF\n{} {} 0\n", vertices.len(), triangles.len());
    for vertex in vertices {
        text += &format!("{} {} {}\n", vertex.x, vertex.y, vertex.z);
    }
    for [a, b, c] in triangles {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}
