//! The files of `chebloyd spin`: the field, the report, the log.

use std::fs;
use std::io::Write;
use std::path::Path;

use serde::Serialize;

use crate::cli::failure::{Failure, write_file};
use crate::cli::spin_report::{Outcome, SpinReport};
use crate::cli::spin_solid::{SpinElements, SpinSolid};
use crate::domain::shape::DomainShape;
use crate::mesh::surface::SurfaceMesh;
use crate::scene::domain::SceneDomain;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile, FieldFormula};
use crate::scene::mesh_domain::MeshDomain;

/// The solid of several files as one.
const SOLID: &str = "solid.off";

/// What the command writes.
pub(crate) const FILES: [&str; 4] = ["field.json", "report.json", "log.jsonl", SOLID];

/// A line of the log.
#[derive(Debug, Serialize)]
struct LogLine {
    iteration: usize,
    residual: f64,
    dual_value: f64,
}

/// Writes the report and the log, and where there is a field, the field.
pub(crate) fn write(
    directory: &Path,
    solid: &SpinSolid,
    elements: &SpinElements,
    outcome: &Outcome,
    report: &SpinReport,
) -> Result<(), Failure> {
    fs::create_dir_all(directory)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", directory.display())))?;
    let text = |name: &str, text: String| {
        let path = directory.join(name);
        write_file(&path, |file| file.write_all(text.as_bytes())).map_err(Failure::run)
    };
    let log = outcome.solution.variance.log.iter().map(|step| {
        serde_json::to_string(&LogLine {
            iteration: step.iteration,
            residual: step.residual,
            dual_value: step.value,
        })
    });
    let log: Vec<String> = log.collect::<Result<_, _>>().map_err(Failure::run)?;
    text("log.jsonl", log.join("\n") + "\n")?;
    if outcome.is_met() {
        let domain = match &solid.scene_domain {
            Some(domain) => domain.clone(),
            None => {
                text(SOLID, off(solid.domain.surface()))?;
                SceneDomain::Surface(MeshDomain {
                    file: SOLID.into(),
                    scale_to: None,
                })
            }
        };
        let field = field(solid, elements, outcome, domain);
        let json = serde_json::to_string_pretty(&field).map_err(Failure::run)?;
        text("field.json", json + "\n")?;
    }
    text("report.json", report.json()?)
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
