//! `chebloyd mesh`: the cells of a run as a mesh for solvers, and the quality of any mesh.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Point3;

use crate::cli::failure::{Failure, print, print_note, write_file};
use crate::cli::mesh_report::{MeshLimit, MeshReport};
use crate::cli::options::{Common, change, finite, given, length, named, space};
use crate::cli::output::OutputRule;
use crate::cli::run::RunDescription;
use crate::complex::assemble::assemble;
use crate::complex::collapse::{collapse, straighten_edges};
use crate::complex::edit_mesh::EditMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::wall_patches::WallPatches;
use crate::export::mesh_vtu::{CellColumn, write_mesh};
use crate::export::poly_mesh::{MESH_FILES, write_case};
use crate::mesh::formats::open_foam::load_case;
use crate::mesh::poly_mesh::PolyMesh;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::domain::SceneDomain;
use crate::scene::overrides::Overrides;
use crate::scene::run::energy_spec;
use crate::scene::site_file;
use crate::voronoi::diagram::Diagram;

const FORMATS: [(&str, &str); 2] = [
    ("polymesh", "OpenFOAM's constant/polyMesh, in ASCII"),
    ("vtu", "mesh.vtu, for ParaView and all readers of VTK files"),
];

/// Write the cells of a run as a conforming mesh, or measure a mesh
///
/// Cells share points, edges and faces. OUT becomes a case of OpenFOAM, with mesh.json: counts by kind
/// and quality by the definitions of checkMesh.
#[derive(Debug, Args)]
pub(crate) struct MeshOptions {
    /// The directory of a run, as `relax --out` left it
    #[arg(value_name = "RUN_DIR", required_unless_present = "check")]
    run: Option<PathBuf>,
    /// The directory to write into
    #[arg(long, short, value_name = "OUT", required_unless_present = "check")]
    output: Option<PathBuf>,
    /// Measure the polyMesh (ASCII or binary, plain or .gz) in PATH instead
    #[arg(long, value_name = "PATH", conflicts_with_all = ["run", "output", "to", "scale", "feature_angle", "collapse"])]
    check: Option<PathBuf>,
    /// Formats to write
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "polymesh", value_parser = named(&FORMATS))]
    to: Vec<String>,
    /// Fail where a measure is above its limit: nonorth=70,skew=4,pyramids=0,aspect=…,concave=…,open=0
    #[arg(long, value_name = "NAME=MOST", value_delimiter = ',')]
    limit: Vec<MeshLimit>,
    /// Part the walls of a solid into patches along edges where they turn by more than A degrees
    #[arg(long, value_name = "A", value_parser = finite, default_value = "40")]
    feature_angle: f64,
    /// Collapse edges shorter than E sides of the mean cell where quality allows it, up to 0.5
    #[arg(long, value_name = "E", value_parser = finite, default_value = "0")]
    collapse: f64,
    /// Merge vertices of the run's mesh up to L apart, as `relax --weld` [default: as the run did]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
    /// Multiply all coordinates by F
    #[arg(long, value_name = "F", value_parser = finite, default_value = "1")]
    scale: f64,
    /// Print the report as one JSON object
    #[arg(long)]
    json: bool,
    /// Replace a mesh that OUT holds
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(options: &MeshOptions, common: Common) -> Result<(), Failure> {
    let report = match (&options.check, &options.run, &options.output) {
        (Some(path), ..) => check(path)?,
        (None, Some(run), Some(output)) => make(options, run, output)?,
        _ => return Err(Failure::input("name a run and --output, or --check a mesh")),
    };
    if options.json {
        print(json(&report)?)?;
    } else if !common.quiet {
        print(report.table())?;
    }
    let passed = report.beyond(&options.limit);
    match passed.is_empty() {
        true => Ok(()),
        false => Err(Failure::run(format!(
            "limits are passed: {}",
            passed.join("; ")
        ))),
    }
}

fn json(report: &MeshReport) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(report).map_err(Failure::run)?;
    Ok(text + "\n")
}

/// The report of a mesh that is there.
fn check(path: &Path) -> Result<MeshReport, Failure> {
    let mesh = load_case(path).map_err(Failure::input)?;
    mesh.check_closed()
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    let geometry = MeshGeometry::of(&mesh, &mesh.cell_faces());
    Ok(MeshReport::new(&mesh, &geometry, None))
}

/// Writes the mesh of a run.
fn make(options: &MeshOptions, run: &Path, output: &Path) -> Result<MeshReport, Failure> {
    if options.scale <= 0.0 {
        return Err(Failure::input(format!(
            "--scale {} is not positive",
            options.scale
        )));
    }
    if !(0.0..=0.5).contains(&options.collapse) {
        return Err(Failure::input(format!(
            "--collapse {} is not between 0 and 0.5",
            options.collapse
        )));
    }
    let outputs = output_files(output, &options.to);
    if !options.force {
        refuse_existing(&outputs)?;
    }
    let (mut scene, sites) = read_run(run)?;
    let weld = Overrides {
        domain: given(serde_json::json!({ "weld": options.weld })),
        ..Overrides::default()
    };
    if scene.domain.file().is_some() {
        change(&mut scene, &weld)?;
    }
    refuse_inputs(run, &scene, &outputs)?;
    let space = space(&scene)?;
    let mut mesh = mesh_of(&space, &scene, &sites, options.feature_angle)?;
    if options.collapse > 0.0 {
        mesh = collapsed(&mesh, space.domain().volume(), options.collapse)?;
    }
    let factor = place_back(&mut mesh, &scene, options.scale)?;
    let geometry = MeshGeometry::of(&mesh, &mesh.cell_faces());
    let volume = space.domain().volume() * factor.powi(3);
    let report = MeshReport::new(&mesh, &geometry, Some(volume));
    if options.to.iter().any(|format| format == "polymesh") {
        write_case(output, &mesh).map_err(Failure::run)?;
    }
    if options.to.iter().any(|format| format == "vtu") {
        let columns = columns(&space, &scene, (&sites, &mesh.sites), &geometry)?;
        let path = output.join("mesh.vtu");
        fs::create_dir_all(output)
            .map_err(|error| Failure::run(format!("cannot make {}: {error}", output.display())))?;
        write_mesh(&path, &mesh, &columns, true)
            .map_err(|error| Failure::run(format!("cannot write {}: {error}", path.display())))?;
    }
    let text = json(&report)?;
    write_file(&output.join("mesh.json"), |file| {
        std::io::Write::write_all(file, text.as_bytes())
    })
    .map_err(Failure::run)?;
    Ok(report)
}

/// The mesh without edges shorter than `share` sides of the mean cell, as far as quality allows it.
fn collapsed(mesh: &PolyMesh, volume: f64, share: f64) -> Result<PolyMesh, Failure> {
    if mesh.patches.iter().any(|patch| patch.partner.is_some()) {
        let message = "edges across a period are not collapsed: leave out --collapse";
        return Err(Failure::input(message));
    }
    let side = (volume / mesh.cell_count as f64).cbrt();
    let mut edited = EditMesh::of(mesh);
    collapse(&mut edited, share * side, side);
    straighten_edges(&mut edited, 0.5 * share * side);
    let mesh = edited.finish();
    mesh.check_closed().map_err(Failure::run)?;
    Ok(mesh)
}

/// Gives a mesh the coordinates of the domain's own file, times `scale`; returns the factor on lengths.
fn place_back(mesh: &mut PolyMesh, scene: &Scene, scale: f64) -> Result<f64, Failure> {
    let similarity = scene.domain.similarity().map_err(Failure::input)?;
    let origin = Point3::origin();
    let (factor, from, to) = match similarity {
        None => (scale, origin, origin),
        Some(map) => (scale / map.scale, map.to, map.from * scale),
    };
    mesh.transform(factor, &from, &to);
    Ok(factor)
}

/// The files that a mesh in these formats is written to.
fn output_files(output: &Path, formats: &[String]) -> Vec<PathBuf> {
    let mut names = vec!["mesh.json"];
    for format in formats {
        match format.as_str() {
            "polymesh" => names.extend(MESH_FILES),
            _ => names.push("mesh.vtu"),
        }
    }
    names.into_iter().map(|name| output.join(name)).collect()
}

/// Refuses to replace files.
fn refuse_existing(outputs: &[PathBuf]) -> Result<(), Failure> {
    match outputs.iter().find(|path| path.exists()) {
        None => Ok(()),
        Some(path) => Err(Failure::input(format!(
            "{} exists; --force replaces the mesh, or name another directory",
            path.display()
        ))),
    }
}

/// Refuses to replace what the run is read from, whatever is forced.
fn refuse_inputs(run: &Path, scene: &Scene, outputs: &[PathBuf]) -> Result<(), Failure> {
    let mut inputs = scene.files();
    inputs.extend(["run.json", "sites.csv"].map(|name| run.join(name)));
    let rule = OutputRule {
        inputs: &inputs,
        force: true,
        option: "-o",
    };
    rule.check(outputs)
}

/// The scene and the sites that a run left.
fn read_run(run: &Path) -> Result<(Scene, Vec<Point3<f64>>), Failure> {
    let path = run.join("run.json");
    let text = fs::read(&path).map_err(|error| {
        Failure::input(format!(
            "{} holds no run ({error}); make one: chebloyd relax --out {}",
            run.display(),
            run.display()
        ))
    })?;
    let description: RunDescription = serde_json::from_slice(&text)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    let scene = description.scene;
    if scene.dimension != 3 {
        let message = "meshes are made of cells in space: relax with \"dimension\": 3";
        return Err(Failure::input(message));
    }
    let sites = site_file::read::<3>(&run.join("sites.csv")).map_err(Failure::input)?;
    Ok((scene, sites))
}

fn mesh_of(
    space: &Space,
    scene: &Scene,
    sites: &[Point3<f64>],
    angle: f64,
) -> Result<PolyMesh, Failure> {
    let domain = space.domain();
    let patches = match (&scene.domain, domain.surface_mesh()) {
        (SceneDomain::Box(_), _) => WallPatches::Box,
        (_, Some(surface)) => WallPatches::by_features(surface, angle),
        (_, None) => WallPatches::Each,
    };
    let diagram = Diagram::new(domain, sites).map_err(Failure::input)?;
    let mesh = assemble(&diagram, &patches).map_err(Failure::run)?;
    let not_balls = mesh.check_closed().map_err(Failure::run)?;
    if let Some(first) = not_balls.first() {
        let count = not_balls.len();
        print_note(format!(
            "{count} cells are no balls, the first: {first}; more sites mend that"
        ));
    }
    Ok(mesh)
}

/// The data of every cell.
fn columns(
    space: &Space,
    scene: &Scene,
    (sites, of_cells): (&[Point3<f64>], &[u32]),
    geometry: &MeshGeometry,
) -> Result<Vec<(&'static str, CellColumn)>, Failure> {
    let cells = space
        .metrics(sites, energy_spec(scene))
        .map_err(Failure::input)?;
    let of_cells = of_cells.iter().map(|&site| site as usize);
    let energies = of_cells.clone().map(|site| cells[site].energy).collect();
    let cubeness = of_cells.clone().map(|site| cells[site].cubeness).collect();
    Ok(vec![
        (
            "site",
            CellColumn::Integers(of_cells.map(|site| site as i64).collect()),
        ),
        ("volume", CellColumn::Reals(geometry.cell_volumes.clone())),
        ("energy", CellColumn::Reals(energies)),
        ("cubeness", CellColumn::Reals(cubeness)),
    ])
}
