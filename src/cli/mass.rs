//! `chebloyd mass`: mass, center of mass and inertia of solids.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::geometry::bounds::Bounds;
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mass::weigh::bounds;
use crate::mesh::formats::read::load;
use crate::mesh::validate::Solid;
use crate::plot::density_cut::{NATIVE, OBTAINED};
use crate::scene::field::{Field, GivenField};

use crate::cli::density_files::{
    DensityBody, Section, center_mark, coordinate_cut, density_files, widest_cut, write_density,
};
use crate::cli::failure::{Failure, print};
use crate::cli::mass_gcode::{self, Asked, GcodeOptions, is_gcode};
use crate::cli::mass_notes::{negative_notes, notes_of_parts};
use crate::cli::mass_report::{AxisMoment, MassProperties, MassTotals, axis, figure, positive};
use crate::cli::output::OutputRule;

/// The density of parts that are given none.
const DEFAULT_DENSITY: &str = "1";

/// Print mass, center of mass and inertia of solids of any density, or of a sliced print, exactly
///
/// Several files are parts of one body. Surfaces must be closed; nothing is voxelized or
/// tetrahedralized. Of a G-code file, in mm, the part is what is printed without skirt, brim, raft,
/// support, tower, purge and start code; `deposited` is everything.
#[derive(Debug, Args)]
pub(crate) struct MassOptions {
    /// Closed surfaces or tetrahedral meshes, or one G-code file
    #[arg(required = true, value_name = "MESH")]
    files: Vec<PathBuf>,
    /// A number, a polynomial such as '1 + 2*x - 0.5*y*z', 'linear:axis=z,from=0,to=1' (over the
    /// whole body), 'profile:axis=z,0.2=1,0.8=5' (position=density, constant beyond),
    /// 'vertex[:NAME]', or a field file '@field.json'; once for all parts or once for each
    #[arg(
        long,
        value_name = "D",
        default_value = DEFAULT_DENSITY,
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
    /// Also write density.vtu, for ParaView, and section.svg and section.png, a cut colored by density
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The axis across which the section is cut, through the center of mass [default: that along
    /// which the body is thinnest]
    #[arg(long, value_name = "AXIS", value_parser = ["x", "y", "z"], requires = "out")]
    cut: Option<String>,
    /// Replace files that DIR holds
    #[arg(long, requires = "out")]
    force: bool,
    #[command(flatten)]
    gcode: GcodeOptions,
}

/// What is printed, in this order.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<String>,
    #[serde(flatten)]
    properties: MassProperties,
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

pub(crate) fn run(options: &MassOptions) -> Result<(), Failure> {
    if let Some(file) = options.files.iter().find(|file| is_gcode(file)) {
        return run_gcode(file, options);
    }
    if let Some(option) = options.gcode.first_given() {
        return Err(Failure::input(format!("{option} is for G-code files")));
    }
    let (files, mut notes) = parts(&options.files)?;
    let densities = one_for_each("density", &options.density, files.len())?;
    check_output(options, &files, &densities)?;
    if !options.mass.is_empty() && options.mass.len() != files.len() {
        return Err(miscounted("mass", options.mass.len(), files.len()));
    }
    let solids = files
        .iter()
        .map(|file| load(file).map_err(Failure::input))
        .collect::<Result<Vec<_>, _>>()?;
    let extent = extent(&solids);
    let mut bodies = Vec::new();
    for (place, (solid, density)) in solids.iter().zip(&densities).enumerate() {
        let file = files[place].display();
        let body = (density.field.weigh(solid, &extent))
            .map_err(|error| Failure::input(format!("{file}: {error}")))?;
        bodies.push(
            options
                .mass
                .get(place)
                .map_or(body, |&mass| body.weighing(mass)),
        );
    }
    let body = Body::combined(&bodies).ok_or_else(|| Failure::run("the parts have no mass"))?;
    notes.extend(notes_of_parts(&files, &solids));
    notes.extend(densities.iter().filter_map(|density| density.note(&extent)));
    notes.extend(negative_notes(&files, &solids, &densities, &extent));
    write_files(options, &solids, &densities, &body)?;
    let report = report(options, &files, notes, &bodies, &body);
    if options.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::run)?;
        return print(text + "\n");
    }
    print(report.table())
}

/// Refuses files of `--out` that must not be replaced.
fn check_output(
    options: &MassOptions,
    files: &[PathBuf],
    densities: &[GivenField],
) -> Result<(), Failure> {
    let Some(folder) = &options.out else {
        return Ok(());
    };
    let fields = densities.iter().filter_map(|density| density.file.clone());
    let inputs: Vec<PathBuf> = files.iter().cloned().chain(fields).collect();
    let rule = OutputRule {
        inputs: &inputs,
        force: options.force,
        option: "--out",
    };
    rule.check(&density_files(folder))
}

/// Writes the files of `--out`.
fn write_files(
    options: &MassOptions,
    solids: &[Solid],
    densities: &[GivenField],
    body: &Body,
) -> Result<(), Failure> {
    let Some(folder) = &options.out else {
        return Ok(());
    };
    let (extent, center) = (extent(solids), body.center_of_mass());
    let fields: Vec<_> = densities.iter().map(|density| &density.field).collect();
    let cut = match options.cut.as_deref() {
        Some(axis) => coordinate_cut(
            ["x", "y", "z"].iter().position(|a| *a == axis).unwrap_or(2),
            &center,
        ),
        None => widest_cut(&extent, &center),
    };
    let plain = Field::Solid(SolidDensity::Constant(1.0));
    let plain: Vec<Body> = (solids.iter().map(|solid| plain.weigh(solid, &extent)))
        .collect::<Result<_, _>>()
        .map_err(Failure::input)?;
    let mut marks = Vec::new();
    if let Some(plain) = Body::combined(&plain) {
        marks.push(center_mark(
            "center of volume",
            NATIVE,
            &plain.center_of_mass(),
        ));
    }
    marks.push(center_mark("center of mass", OBTAINED, &center));
    let section = Section {
        cut,
        title: format!("Density {}", options.density.join(", ")),
        marks,
    };
    let weighed = DensityBody {
        solids,
        fields: &fields,
        extent: &extent,
    };
    write_density(folder, weighed, &section)
}

/// One G-code file, which cannot stand beside others.
fn run_gcode(file: &Path, options: &MassOptions) -> Result<(), Failure> {
    let name = file.display();
    if options.files.len() > 1 {
        let message = format!("{name}: a G-code file is weighed alone, one at a time");
        return Err(Failure::input(message));
    }
    if options.density != [DEFAULT_DENSITY] {
        let message = "--density is for solids; for G-code there is --material-density";
        return Err(Failure::input(format!("{name}: {message}")));
    }
    if options.mass.len() > 1 {
        return Err(miscounted("mass", options.mass.len(), 1));
    }
    let asked = Asked {
        mass: options.mass.first().copied(),
        axis: options.axis,
        units: options.units.as_deref(),
        json: options.json,
    };
    mass_gcode::run(file, &options.gcode, asked)
}

/// The files that are parts, each once. TetGen's two files are one mesh, read by either name; a file
/// that is named twice is refused, since its volume would count twice.
fn parts(files: &[PathBuf]) -> Result<(Vec<PathBuf>, Vec<String>), Failure> {
    let (mut parts, mut notes): (Vec<PathBuf>, _) = (Vec::new(), Vec::new());
    for file in files {
        let Some(earlier) = parts.iter().find(|part| mesh_of(part) == mesh_of(file)) else {
            parts.push(file.clone());
            continue;
        };
        let (one, other) = (earlier.display(), file.display());
        if earlier.extension() == file.extension() {
            return Err(Failure::input(format!(
                "{other} is the same file as {one} and would count twice; name every part once"
            )));
        }
        notes.push(format!("{one} and {other} are one mesh and count once"));
    }
    Ok((parts, notes))
}

/// The file that tells meshes apart: of TetGen's pair the elements.
fn mesh_of(file: &Path) -> PathBuf {
    let is_nodes = file
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("node"));
    let file = if is_nodes {
        &file.with_extension("ele")
    } else {
        file
    };
    file.canonicalize().unwrap_or_else(|_| file.to_path_buf())
}

/// One density per part, from one for all or one each.
fn one_for_each(name: &str, texts: &[String], parts: usize) -> Result<Vec<GivenField>, Failure> {
    let densities = texts
        .iter()
        .map(|text| {
            GivenField::read(text).map_err(|error| Failure::input(format!("--{name}: {error}")))
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

fn report(
    options: &MassOptions,
    files: &[PathBuf],
    notes: Vec<String>,
    bodies: &[Body],
    body: &Body,
) -> Report {
    let named = |file: &Path| file.display().to_string();
    let several = if bodies.len() > 1 { files } else { &[] };
    let parts = several.iter().zip(bodies).map(|(file, body)| MassPart {
        file: named(file),
        totals: body.into(),
    });
    Report {
        units: options.units.clone(),
        properties: MassProperties::of(body, options.axis),
        parts: parts.collect(),
        notes,
    }
}

impl Report {
    fn table(&self) -> String {
        let mut text = self.properties.table();
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
