//! `chebloyd mass`: mass, center of mass and inertia of solids.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::geometry::bounds::Bounds;
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mass::weigh::{bounds, weigh};
use crate::mesh::formats::read::{LabeledSolid, tetgen_pair};
use crate::mesh::formats::unpack::extension_of;
use crate::mesh::validate::Solid;
use crate::plot::density_cut::{NATIVE, OBTAINED};
use crate::scene::field::{GivenField, Weighed};

use crate::cli::density_files::{
    DensityBody, Section, center_mark, coordinate_cut, density_files, widest_cut, write_density,
};
use crate::cli::failure::{Failure, print_report};
use crate::cli::mass_gcode::{self, Asked, GcodeOptions, is_gcode};
use crate::cli::mass_leaves::{MassAsked, MassLeaf, body_of, known_names};
use crate::cli::mass_notes::{negative_notes, notes_of_parts};
use crate::cli::mass_parts::{ByName, load_placed};
use crate::cli::mass_place::Placement;
use crate::cli::mass_report::{AxisMoment, axis, positive};
use crate::cli::mass_table::MassFigures;
use crate::cli::mass_units::{DENSITIES, UnitFactors};
use crate::cli::options::length;
use crate::cli::output::OutputRule;

/// Print mass, center of mass and inertia of solids of any density, or of a sliced print, exactly
///
/// Several files are parts of one body. Surfaces must be closed; nothing is voxelized or
/// tetrahedralized. Of a G-code file, in mm, the part is what is printed without skirt, brim, raft,
/// support, tower, purge and start code; `deposited` is everything.
#[derive(Debug, Args)]
pub(crate) struct MassOptions {
    /// Closed surfaces or tetrahedral meshes, plain or .gz, - for standard input; or one G-code file
    #[arg(required = true, value_name = "MESH")]
    files: Vec<PathBuf>,
    /// A number, a polynomial such as '1 + 2*x - 0.5*y*z', 'linear:axis=z,from=0,to=1' (over the
    /// whole body), 'profile:axis=z,0.2=1,0.8=5' (position=density, constant beyond),
    /// 'vertex[:NAME]', 'cell:NAME' (one constant per tetrahedron), or a field file '@field.json'; once for all parts or once for each;
    /// NAME=D for the file or the group of that name (groups `g` and `o` of OBJ, solids of STL, Gmsh's
    /// physical names, MEDIT's references) [default: 1]
    #[arg(long, value_name = "[NAME=]D", allow_hyphen_values = true)]
    density: Vec<String>,
    /// What a part weighs, its density scaled to that; once for each part, or NAME=M for a file or a group.
    /// `_` leaves a part to its density
    #[arg(long, value_name = "[NAME=]M", allow_hyphen_values = true)]
    mass: Vec<String>,
    /// Where a file is placed: 16 numbers of a 4×4 matrix, row by row, or a file with them; once for all or
    /// once for each, `_` for a file that stays. Mirrors and scalings are fine; densities are functions of
    /// the placed coordinates
    #[arg(long, value_name = "FILE|16 NUMBERS", allow_hyphen_values = true)]
    place: Vec<String>,
    /// Also the moment of inertia about the axis through a point along a direction
    #[arg(long, value_name = "PX,PY,PZ,DX,DY,DZ", value_parser = axis, allow_hyphen_values = true)]
    axis: Option<AxisMoment>,
    /// Free text about the units, carried through to the output
    #[arg(long, value_name = "TEXT")]
    units: Option<String>,
    /// Print SI units: m, kg. --units is the unit of the files' lengths (m, dm, cm, mm, um, nm, in, ft);
    /// masses are given in kg
    #[arg(long)]
    si: bool,
    /// With --si, the unit of densities
    #[arg(long, value_name = "UNIT", default_value = "kg/m3", requires = "si",
          value_parser = DENSITIES.map(|(name, _)| name))]
    density_units: String,
    /// The largest relative error of mass, center of mass (to the body's extent) and inertia for
    /// formulas that are no polynomials [default: 1e-6; where they use `distance` 1e-4]
    #[arg(long, value_name = "T", value_parser = positive)]
    tolerance: Option<f64>,
    /// Merge vertices of an open mesh up to L apart, in the file's unit [default: 1e-12 of its box]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
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

pub(crate) fn run(options: &MassOptions) -> Result<(), Failure> {
    if let Some(file) = options.files.iter().find(|file| is_gcode(file)) {
        return run_gcode(file, options);
    }
    if let Some(option) = options.gcode.first_given() {
        return Err(Failure::input(format!("{option} is for G-code files")));
    }
    let (files, mut notes) = parts(&options.files)?;
    let units = units(options)?;
    let wholes = load_all(options, &files)?;
    let areas: Vec<f64> = wholes.iter().map(|whole| area(&whole.solid)).collect();
    let solids: Vec<Solid> = wholes.iter().map(|whole| whole.solid.clone()).collect();
    let known = known_names(&files, &wholes);
    let asked = MassAsked {
        files: &files,
        densities: ByName::of("density", &options.density, &known)?,
        masses: ByName::of("mass", &options.mass, &known)?,
        mass_unit: units.as_ref().map_or(1.0, |(factors, _)| factors.mass),
    };
    check_counts(&asked, files.len())?;
    let mut leaves = Vec::new();
    for (part, whole) in wholes.into_iter().enumerate() {
        leaves.push(asked.leaves(part, whole)?);
    }
    check_output(options, &files, &leaves)?;
    let extent = extent(&solids);
    let (mut weighed, mut bodies, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for (part, leaves) in leaves.iter().enumerate() {
        let weigh = |leaf: &MassLeaf| leaf.weigh(&extent, options.tolerance);
        let of_leaves = leaves.iter().map(weigh).collect::<Result<Vec<_>, _>>()?;
        let of_leaves = asked.scaled(part, leaves, of_leaves)?;
        let body = body_of(&of_leaves, areas[part])?;
        rows.push(group_rows(&asked, leaves, &of_leaves, &extent)?);
        bodies.push(body);
        weighed.extend(of_leaves);
    }
    let body = Body::combined(&bodies).ok_or_else(|| Failure::run("the parts have no mass"))?;
    let leaves: Vec<MassLeaf> = leaves.into_iter().flatten().collect();
    notes.extend(notes_of_parts(&files, &solids));
    notes.extend(notes_of_leaves(&leaves, &extent));
    write_files(options, &leaves, &body, &extent)?;
    let errors = Weighed::errors_of(&weighed, &body, extent.extent().norm());
    let report = MassFigures {
        files: &files,
        leaves: &leaves,
        bodies: &bodies,
        body: &body,
        rows,
        errors,
    };
    let report = report.report((options.axis, options.units.as_deref()), notes, units);
    print_report(&report, options.json, || report.table())?;
    let missed = weighed.iter().find_map(|part| part.missed);
    missed.map_or(Ok(()), |missed| Err(Failure::run(missed)))
}

/// The factors to SI and the sentence about them, where SI is asked for.
fn units(options: &MassOptions) -> Result<Option<(UnitFactors, String)>, Failure> {
    let factors = || UnitFactors::of(options.units.as_deref(), &options.density_units);
    options.si.then(factors).transpose()
}

/// The files where they are placed.
fn load_all(options: &MassOptions, files: &[PathBuf]) -> Result<Vec<LabeledSolid>, Failure> {
    let placements = options.place.iter().map(|text| Placement::read(text));
    let placements: Vec<Placement> = placements
        .collect::<Result<_, _>>()
        .map_err(Failure::input)?;
    if placements.len() > 1 && placements.len() != files.len() {
        return Err(miscounted("place", placements.len(), files.len()));
    }
    let placement = |part: usize| match &placements[..] {
        [one] => Some(one),
        all => all.get(part),
    };
    let loaded = files.iter().enumerate();
    loaded
        .map(|(part, file)| load_placed(file, placement(part), options.weld.unwrap_or(0.0)))
        .collect()
}

/// Refuses more or fewer densities and masses than there are files.
fn check_counts(asked: &MassAsked<'_>, files: usize) -> Result<(), Failure> {
    let densities = asked.densities.plain.len();
    if densities > 1 && densities != files {
        return Err(miscounted("density", densities, files));
    }
    let masses = asked.masses.plain.len();
    if masses > 0 && masses != files {
        return Err(miscounted("mass", masses, files));
    }
    Ok(())
}

/// The groups of a file with their bodies: its leaves, or the groups of its only one.
fn group_rows(
    asked: &MassAsked<'_>,
    leaves: &[MassLeaf],
    weighed: &[Weighed],
    extent: &Bounds<3>,
) -> Result<Vec<(String, String, Body)>, Failure> {
    let row = |leaf: &MassLeaf, body: Body| {
        let name = leaf.group.clone().unwrap_or_default();
        (name, leaf.text.clone(), body)
    };
    let [only] = leaves else {
        let pairs = leaves.iter().zip(weighed);
        return Ok(pairs
            .map(|(leaf, weighed)| row(leaf, weighed.body))
            .collect());
    };
    let groups = asked.groups_of(only)?;
    let bodies = groups
        .iter()
        .map(|group| Ok(group.weigh(extent, None)?.body));
    // A group without mass of its own gets no row.
    let bodies: Vec<Option<Body>> = bodies
        .map(|body: Result<Body, Failure>| body.ok())
        .collect();
    let sum: f64 = bodies.iter().flatten().map(|body| body.mass).sum();
    let rows = groups.iter().zip(&bodies).filter_map(|(group, body)| {
        let body = (*body)?;
        let share = weighed[0].body.mass * (body.mass / sum);
        // Scaled where the file's mass is given.
        let is_same = (share - body.mass).abs() <= 1e-9 * body.mass;
        Some(row(
            group,
            if is_same { body } else { body.weighing(share) },
        ))
    });
    Ok(rows.collect())
}

/// Notes about the densities of leaves.
fn notes_of_leaves(leaves: &[MassLeaf], extent: &Bounds<3>) -> Vec<String> {
    let mut notes: Vec<String> = (leaves.iter())
        .filter_map(|leaf| leaf.density.note(extent))
        .collect();
    notes.dedup();
    let names: Vec<PathBuf> = leaves.iter().map(|leaf| leaf.name.clone()).collect();
    let solids: Vec<&Solid> = leaves.iter().map(|leaf| &leaf.labeled.solid).collect();
    let densities: Vec<&GivenField> = leaves.iter().map(|leaf| &leaf.density).collect();
    notes.extend(negative_notes(&names, &solids, &densities, extent));
    notes
}

/// The area of a solid's surface.
fn area(solid: &Solid) -> f64 {
    match solid {
        Solid::Surface(closed, _) => closed.mesh().area(),
        Solid::Tets(sound, _) => sound.mesh().boundary().area(),
    }
}

/// Refuses files of `--out` that must not be replaced.
fn check_output(
    options: &MassOptions,
    files: &[PathBuf],
    leaves: &[Vec<MassLeaf>],
) -> Result<(), Failure> {
    let Some(folder) = &options.out else {
        return Ok(());
    };
    let fields = (leaves.iter().flatten()).filter_map(|leaf| leaf.density.file.clone());
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
    leaves: &[MassLeaf],
    body: &Body,
    extent: &Bounds<3>,
) -> Result<(), Failure> {
    let Some(folder) = &options.out else {
        return Ok(());
    };
    let center = body.center_of_mass();
    let solids: Vec<Solid> = (leaves.iter().map(|leaf| leaf.labeled.solid.clone())).collect();
    let fields: Vec<_> = leaves.iter().map(|leaf| &leaf.density.field).collect();
    let cut = match options.cut.as_deref() {
        Some(axis) => coordinate_cut(
            ["x", "y", "z"].iter().position(|a| *a == axis).unwrap_or(2),
            &center,
        ),
        None => widest_cut(extent, &center),
    };
    let plain = SolidDensity::Constant(1.0);
    let plain: Vec<Body> = (solids.iter().map(|solid| weigh(solid, &plain, extent)))
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
        solids: &solids,
        fields: &fields,
        extent,
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
    if !options.density.is_empty() {
        let message = "--density is for solids; for G-code there is --material-density";
        return Err(Failure::input(format!("{name}: {message}")));
    }
    if options.si || !options.place.is_empty() {
        let message = "--place and --si are for solids; a print is in mm where its file puts it";
        return Err(Failure::input(format!("{name}: {message}")));
    }
    if options.mass.len() > 1 {
        return Err(miscounted("mass", options.mass.len(), 1));
    }
    let asked = Asked {
        mass: options
            .mass
            .first()
            .map(|mass| gcode_mass(mass))
            .transpose()?,
        axis: options.axis,
        units: options.units.as_deref(),
        json: options.json,
    };
    mass_gcode::run(file, &options.gcode, asked)
}

/// What a print weighs.
fn gcode_mass(text: &str) -> Result<f64, Failure> {
    positive(text).map_err(|fault| Failure::input(format!("--mass {text}: {fault}")))
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
        if extension_of(earlier) == extension_of(file) {
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
    let [_, elements] = tetgen_pair(file);
    let is_nodes = extension_of(file) == "node";
    let file = if is_nodes { &elements } else { file };
    file.canonicalize().unwrap_or_else(|_| file.to_path_buf())
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
