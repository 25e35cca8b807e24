//! `chebloyd spin --field sine`: p and k of sin(k|y − p|) + 1 with which a solid spins.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use nalgebra::Point3;
use serde::Serialize;

use crate::balance::sine_fit::{SineField, SineFit, SineProblem};
use crate::balance::spin::{SpinState, SpinWish};
use crate::cli::failure::{Failure, print, write_file};
use crate::cli::mass_report::{figure, rows};
use crate::cli::options::Common;
use crate::cli::spin_files::draw;
use crate::cli::spin_solid::{SpinElements, SpinSolid};
use crate::domain::shape::DomainShape;
use crate::geometry::moments::Moments;
use crate::integrals::adaptive::{halved, longest_edge};
use crate::integrals::sine_jet::sine_jet;
use crate::mesh::surface::SurfaceMesh;
use crate::scene::field_file::{FieldBounds, FieldDensity, FieldFile};

/// Gauss nodes along a triangle for the figures that are printed.
const NODES: usize = 5;

/// Surfaces are split to edges of this share of the solid's diagonal: with 5 nodes along an edge the fastest
/// sine that is tried has its integrals to 1e-12.
const EDGE_SHARE: f64 = 1.0 / 40.0;

/// How the command was called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SineOptions<'a> {
    pub(crate) starts: usize,
    pub(crate) seed: u64,
    pub(crate) out: Option<&'a Path>,
    pub(crate) json: bool,
}

#[derive(Debug, Serialize)]
struct SineReport {
    feasible: bool,
    #[serde(flatten)]
    found: Option<SineFound>,
    native: SineNative,
    starts: usize,
    /// How many of them met the conditions.
    met: usize,
    evaluations: usize,
    /// Those with exact integrals.
    evaluations_exact: usize,
}

#[derive(Debug, Serialize)]
struct SineFound {
    distance: f64,
    angle_degrees: f64,
    mass: f64,
    mean_density: f64,
    center_of_mass: [f64; 3],
    inertia_center: [[f64; 3]; 3],
    point: [f64; 3],
    k: f64,
    /// For --density.
    density: String,
}

#[derive(Debug, Serialize)]
struct SineNative {
    distance: f64,
    angle_degrees: f64,
}

/// Fits and reports.
pub(crate) fn run(
    solid: &SpinSolid,
    elements: &SpinElements,
    wish: &SpinWish,
    native: &SpinState,
    options: SineOptions<'_>,
    common: Common,
) -> Result<(), Failure> {
    let (axis, conditions) = (wish.axis, wish.conditions());
    let surface = split(solid.domain.surface());
    let problem = SineProblem {
        surface: &surface,
        moments: elements.moments(),
        origin: axis.through,
        conditions: &conditions,
    };
    let fit = problem.fit(options.starts, options.seed);
    let state = fit.field.map(|field| {
        let moments = weigh(&surface, &field, &axis.through);
        SpinState::of(&moments, solid.domain.volume(), 1.0, &axis)
    });
    let report = SineReport::new(&fit, state.as_ref(), native, options.starts);
    let text = serde_json::to_string_pretty(&report).map_err(Failure::run)? + "\n";
    if let Some(directory) = options.out {
        write(directory, solid, &fit, &text)?;
        if let (Some(field), Some(state)) = (&fit.field, &state) {
            draw(
                directory,
                solid,
                field_file(field, solid),
                &axis,
                [native, state],
            )?;
        }
    }
    if options.json {
        print(text)?;
    } else if !common.quiet {
        print(report.table())?;
    }
    match fit.field {
        Some(_) => Ok(()),
        None => Err(Failure::run(format!(
            "none of {} starts led to a sine that does this; give more --starts or another --seed, or \
             leave out --field: a clamped quadratic is found whenever any density does it",
            options.starts
        ))),
    }
}

/// The same surface, of triangles that are small against any sine.
fn split(surface: &SurfaceMesh) -> SurfaceMesh {
    let most = (EDGE_SHARE * surface.bounds().extent().norm()).powi(2);
    let mut triangles: Vec<_> = surface.all_corners().collect();
    let mut fine = SurfaceMesh::default();
    while let Some(corners) = triangles.pop() {
        if longest_edge(&corners).1 > most {
            triangles.extend(halved(&corners));
            continue;
        }
        let first = fine.vertices.len() as u32;
        fine.vertices.extend(corners);
        fine.triangles.push([first, first + 1, first + 2]);
    }
    fine
}

/// The moments of a field, measured from `origin`.
fn weigh(surface: &SurfaceMesh, field: &SineField, origin: &Point3<f64>) -> Moments {
    let (vertices, triangles) = (&surface.vertices, &surface.triangles);
    let jet = sine_jet(vertices, triangles, &field.point, field.k, NODES);
    jet.volume.translated(&(field.point - origin))
}

/// Writes the report and, where there is one, the field's file.
fn write(directory: &Path, solid: &SpinSolid, fit: &SineFit, report: &str) -> Result<(), Failure> {
    fs::create_dir_all(directory)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", directory.display())))?;
    let write = |name: &str, text: &str| {
        write_file(&directory.join(name), |file| {
            file.write_all(text.as_bytes())
        })
        .map_err(Failure::run)
    };
    if let Some(field) = fit.field {
        let file = field_file(&field, solid);
        let json = serde_json::to_string_pretty(&file).map_err(Failure::run)?;
        write("field.json", &(json + "\n"))?;
    }
    write("report.json", report)
}

fn field_file(field: &SineField, solid: &SpinSolid) -> FieldFile {
    let bounds = solid.domain.bounds();
    FieldFile {
        schema: None,
        density: FieldDensity::Text(field.text()),
        bounds: Some(FieldBounds {
            min: bounds.min.into(),
            max: bounds.max.into(),
        }),
    }
}

impl SineReport {
    fn new(fit: &SineFit, state: Option<&SpinState>, native: &SpinState, starts: usize) -> Self {
        let found = fit.field.zip(state).map(|(field, state)| SineFound {
            distance: state.distance,
            angle_degrees: state.angle_degrees,
            mass: state.body.mass,
            mean_density: state.body.mass / state.body.volume,
            center_of_mass: state.body.center_of_mass().into(),
            inertia_center: rows(&state.body.inertia_center()),
            point: field.point.into(),
            k: field.k,
            density: field.text(),
        });
        Self {
            feasible: found.is_some(),
            found,
            native: SineNative::of(native),
            starts,
            met: fit.met,
            evaluations: fit.evaluations[0] + fit.evaluations[1],
            evaluations_exact: fit.evaluations[1],
        }
    }

    fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, numbers: &[f64]| {
            let numbers: String = numbers.iter().map(|&number| figure(number)).collect();
            text += &format!("{name:<24}{numbers}\n");
        };
        line("distance before", &[self.native.distance]);
        line("angle before (degrees)", &[self.native.angle_degrees]);
        if let Some(found) = &self.found {
            line("distance", &[found.distance]);
            line("angle (degrees)", &[found.angle_degrees]);
            line("mass", &[found.mass]);
            line("mean density", &[found.mean_density]);
            line("center of mass", &found.center_of_mass);
            text += &format!("{:<26}{}\n", "density", found.density);
            text += "note: this density is zero where the sine is -1; no printer prints that\n";
        }
        text + &format!(
            "{} of {} starts met it; {} evaluations, {} of them exact\n",
            self.met, self.starts, self.evaluations, self.evaluations_exact
        )
    }
}

impl SineNative {
    fn of(state: &SpinState) -> Self {
        Self {
            distance: state.distance,
            angle_degrees: state.angle_degrees,
        }
    }
}
