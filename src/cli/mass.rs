//! `chebloyd mass`: mass, center of mass and inertia of solids.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;

use crate::domain::density_sign::refused_place;
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::bounds::Bounds;
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mass::sign::negative_place;
use crate::mass::weigh::{bounds, weigh};
use crate::mesh::formats::read::load;
use crate::mesh::validate::Solid;

use crate::cli::failure::{Failure, print};

/// Print mass, center of mass and inertia of solids of any density, exactly
///
/// Several files are parts of one body. Surfaces must be closed; nothing is voxelized or
/// tetrahedralized.
#[derive(Debug, Args)]
pub(crate) struct MassOptions {
    /// Closed surfaces or tetrahedral meshes
    #[arg(required = true, value_name = "MESH")]
    files: Vec<PathBuf>,
    /// A number, a polynomial such as '1 + 2*x - 0.5*y*z', 'linear:axis=z,from=0,to=1' (over the
    /// whole body), 'profile:axis=z,0.2=1,0.8=5' (position=density, constant beyond) or
    /// 'vertex[:NAME]'; once for all parts or once for each
    #[arg(
        long,
        value_name = "D",
        default_value = "1",
        allow_hyphen_values = true
    )]
    density: Vec<String>,
    /// What a part weighs, its density scaled to that; once for each part
    #[arg(long, value_name = "M", value_parser = positive)]
    mass: Vec<f64>,
    /// Also the moment of inertia about the axis through a point along a direction
    #[arg(long, value_name = "PX,PY,PZ,DX,DY,DZ", value_parser = axis, allow_hyphen_values = true)]
    axis: Option<AxisMoment>,
    /// Free text about the units, carried through to the output
    #[arg(long, value_name = "TEXT")]
    units: Option<String>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    json: bool,
}

/// What is printed, in this order.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<String>,
    #[serde(flatten)]
    totals: MassTotals,
    inertia_origin: [[f64; 3]; 3],
    inertia_center: [[f64; 3]; 3],
    principal_moments: [f64; 3],
    /// One axis per row, in the order of the moments.
    principal_axes: [[f64; 3]; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    moment_about_axis: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts: Vec<MassPart>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
struct MassPart {
    file: String,
    #[serde(flatten)]
    totals: MassTotals,
}

/// What parts and the whole have in common.
#[derive(Debug, Serialize)]
struct MassTotals {
    volume: f64,
    surface_area: f64,
    mass: f64,
    center_of_mass: [f64; 3],
}

impl From<&Body> for MassTotals {
    fn from(body: &Body) -> Self {
        Self {
            volume: body.volume,
            surface_area: body.surface_area,
            mass: body.mass,
            center_of_mass: body.center_of_mass().into(),
        }
    }
}

/// A line in space.
#[derive(Clone, Copy, Debug)]
struct AxisMoment {
    through: Point3<f64>,
    along: Vector3<f64>,
}

pub(crate) fn run(options: &MassOptions) -> Result<(), Failure> {
    let densities = one_for_each("density", &options.density, options.files.len())?;
    if !options.mass.is_empty() && options.mass.len() != options.files.len() {
        return Err(miscounted("mass", options.mass.len(), options.files.len()));
    }
    let solids = options
        .files
        .iter()
        .map(|file| load(file).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let extent = extent(&solids);
    let mut bodies = Vec::new();
    for (place, (solid, density)) in solids.iter().zip(&densities).enumerate() {
        let file = options.files[place].display();
        let body = weigh(solid, density, &extent)
            .map_err(|error| Failure::input(format!("{file}: {error}")))?;
        bodies.push(
            options
                .mass
                .get(place)
                .map_or(body, |&mass| body.weighing(mass)),
        );
    }
    let body = Body::combined(&bodies).ok_or_else(|| Failure::run("the parts have no mass"))?;
    let mut report = report(options, &solids, &bodies, &body);
    for (place, (solid, density)) in solids.iter().zip(&densities).enumerate() {
        let file = options.files[place].display();
        let note = negative_note(solid, density, &extent);
        report
            .notes
            .extend(note.map(|note| format!("{file}: {note}")));
    }
    if options.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::run)?;
        return print(text + "\n");
    }
    print(report.table())
}

/// One density per part, from one for all or one each.
fn one_for_each(name: &str, texts: &[String], parts: usize) -> Result<Vec<SolidDensity>, Failure> {
    let densities = texts
        .iter()
        .map(|text| {
            text.parse::<SolidDensity>()
                .map_err(|error| Failure::input(format!("--{name}: {error}")))
        })
        .collect::<Result<Vec<_>, _>>()?;
    match &densities[..] {
        [density] => Ok(vec![density.clone(); parts]),
        all if all.len() == parts => Ok(densities),
        all => Err(miscounted(name, all.len(), parts)),
    }
}

fn miscounted(name: &str, given: usize, parts: usize) -> Failure {
    let times = if given == 1 {
        "once"
    } else {
        &format!("{given} times")
    };
    let plural = if parts == 1 { "" } else { "s" };
    Failure::input(format!(
        "--{name} is given {times}; this body has {parts} part{plural}: give it once for each"
    ))
}

fn extent(solids: &[Solid]) -> Bounds<3> {
    let mut extent = Bounds::empty();
    for part in solids.iter().map(bounds) {
        extent.include(&part.min);
        extent.include(&part.max);
    }
    extent
}

fn report(options: &MassOptions, solids: &[Solid], bodies: &[Body], body: &Body) -> Report {
    let principal = body.principal();
    let named = |file: &Path| file.display().to_string();
    let parts = options
        .files
        .iter()
        .zip(bodies)
        .map(|(file, body)| MassPart {
            file: named(file),
            totals: body.into(),
        });
    let notes = options.files.iter().zip(solids).flat_map(|(file, solid)| {
        let notes = solid.notes().into_iter();
        notes.map(|note| format!("{}: {note}", named(file)))
    });
    Report {
        units: options.units.clone(),
        totals: body.into(),
        inertia_origin: rows(&body.inertia_origin()),
        inertia_center: rows(&body.inertia_center()),
        principal_moments: principal.moments.into(),
        principal_axes: principal.axes.map(Into::into),
        moment_about_axis: options
            .axis
            .map(|axis| body.moment_about_axis(&axis.through, &axis.along)),
        parts: if bodies.len() > 1 {
            parts.collect()
        } else {
            Vec::new()
        },
        notes: notes.collect(),
    }
}

/// Where the density is negative in a part, if it is.
fn negative_note(solid: &Solid, density: &SolidDensity, extent: &Bounds<3>) -> Option<String> {
    let (place, value) = match density {
        SolidDensity::Polynomial(polynomial) => {
            let shape = match solid {
                Solid::Surface(closed, _) => SurfaceSolid::new(closed).ok()?,
                Solid::Tets(sound, _) => TetSolid::new(sound).ok()?.into_boundary(),
            };
            refused_place(&shape, polynomial).filter(|(_, value)| *value < 0.0)
        }
        _ => negative_place(solid, density, extent),
    }?;
    let [x, y, z] = <[f64; 3]>::from(place);
    Some(format!(
        "the density is {value} at ({x}, {y}, {z}) in the body; what is negative counts as negative mass"
    ))
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
}

impl Report {
    fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, numbers: &[f64]| {
            let numbers: String = numbers.iter().map(|&number| figure(number)).collect();
            text += &format!("{name:<24}{numbers}\n");
        };
        let totals = &self.totals;
        line("volume", &[totals.volume]);
        line("surface area", &[totals.surface_area]);
        line("mass", &[totals.mass]);
        line("center of mass", &totals.center_of_mass);
        let tensors = [
            ("inertia about origin", &self.inertia_origin),
            ("inertia about center", &self.inertia_center),
        ];
        for (name, [first, second, third]) in tensors {
            line(name, first);
            line("", second);
            line("", third);
        }
        line("principal moments", &self.principal_moments);
        for (name, axis) in ["principal axes", "", ""].iter().zip(&self.principal_axes) {
            line(name, axis);
        }
        if let Some(moment) = self.moment_about_axis {
            line("moment about the axis", &[moment]);
        }
        if let Some(units) = &self.units {
            text += &format!("{:<24}  {units}\n", "units");
        }
        for part in &self.parts {
            let [x, y, z] = part.totals.center_of_mass.map(figure);
            let mass = figure(part.totals.mass);
            text += &format!("part {}: mass{mass}, center{x}{y}{z}\n", part.file);
        }
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}

/// A number in 20 columns, ten digits of it.
fn figure(number: f64) -> String {
    let size = number.abs();
    let shown = if size > 0.0 && !(1e-3..1e9).contains(&size) {
        format!("{number:.9e}")
    } else {
        let leading = if size > 0.0 {
            size.log10().floor()
        } else {
            0.0
        };
        format!("{number:.*}", (9.0 - leading) as usize)
    };
    format!("{shown:>20}")
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("a positive number is needed".into()),
    }
}

fn axis(text: &str) -> Result<AxisMoment, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| {
            number
                .trim()
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
        })
        .collect::<Option<_>>()
        .ok_or("six numbers separated by commas are needed")?;
    let &[px, py, pz, dx, dy, dz] = &numbers[..] else {
        return Err(format!("six numbers are needed, not {}", numbers.len()));
    };
    let (through, along) = (Point3::new(px, py, pz), Vector3::new(dx, dy, dz));
    if along.norm() > 0.0 && along.norm().is_finite() {
        Ok(AxisMoment { through, along })
    } else {
        Err("the direction (the last three numbers) has no length".into())
    }
}
