//! `chebloyd mesh`: the cells of a run as a mesh for solvers, and the quality of any mesh.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::Point3;

use crate::cli::failure::{Failure, print, write_file};
use crate::cli::mesh_cells::{CellMeshing, MeshedCells, mesh_cells, patches_of};
use crate::cli::mesh_elements::{element_columns, elements, file_of, write_elements};
use crate::cli::mesh_pictures::{kinds_and_legend, quality_histograms};
use crate::cli::mesh_report::{MeshLimit, MeshReport};
use crate::cli::mesh_sites::SiteSource;
use crate::cli::options::{Common, edge_length, finite, length, named};
use crate::cli::output::OutputRule;
use crate::complex::element_mesh::ElementMesh;
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::listed_cells::mesh_of;
use crate::complex::quality::MeasuredMesh;
use crate::export::mesh_vtu::{CellColumn, write_faces, write_mesh};
use crate::export::poly_mesh::{MESH_FILES, write_case};
use crate::mesh::formats::open_foam::load_case;
use crate::mesh::formats::unpack::{extension_of, read_unpacked};
use crate::mesh::formats::vtu::read_cells;
use crate::mesh::poly_mesh::PolyMesh;
use crate::plot::histograms::histograms;
use crate::plot::mesh_cutaway::mesh_picture;
use crate::plot::svg::svg;
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::run::energy_spec;

const FORMATS: [(&str, &str); 7] = [
    ("polymesh", "OpenFOAM's constant/polyMesh, in ASCII"),
    ("vtu", "mesh.vtu, for ParaView and all readers of VTK files"),
    (
        "faces",
        "faces.vtu, the faces as polygons with area, owner, neighbor and wall",
    ),
    (
        "msh",
        "mesh.msh, Gmsh's MSH 4.1, patches as physical groups; hexes only",
    ),
    (
        "inp",
        "mesh.inp, for Abaqus and CalculiX, pyramids as degenerate C3D8; hexes only",
    ),
    ("medit", "mesh.mesh, for MEDIT, Mmg and FreeFEM; hexes only"),
    ("su2", "mesh.su2, for SU2, patches as markers; hexes only"),
];

/// The faces with their data, the histograms of quality, the picture.
const FACES: &str = "faces.vtu";
const HISTOGRAMS: &str = "mesh.svg";
const PICTURE: &str = "mesh.png";

/// Edges up to this share of the mean cell's side collapse for hexahedra unless an option says otherwise: from 0.2
/// to 0.3 hexahedra gain 2 to 10 % of the volume and keep their Jacobians (5 % quantile ≥ 0.9); from 0.3 to 0.5 up
/// to 8 % more on curved solids, at the price of the worst.
const HEX_COLLAPSE: f64 = 0.3;

const ELEMENTS: [(&str, &str); 2] = [
    ("cells", "the cells themselves: polyhedra"),
    (
        "hexes",
        "hexahedra with corners at the sites, prisms, pyramids and tetrahedra between them",
    ),
];

const WALLS: [(&str, &str); 2] = [
    (
        "polygons",
        "merged, straightened, cells cut at re-entrant edges, bad ones improved; the report says the volume lost",
    ),
    ("exact", "as the surface is, to rounding"),
];

/// Write the cells of a run or in a solid as a conforming mesh, or measure a mesh
///
/// Cells share points, edges and faces. OUT becomes a case of OpenFOAM, with mesh.json: counts by kind
/// and quality by the definitions of checkMesh. A case that is there gets the mesh; its system stays.
#[derive(Debug, Args)]
pub(crate) struct MeshOptions {
    /// The directory of a run, as `relax --out` left it; or a solid's mesh file or a scene, in which sites
    /// are first relaxed as by `relax SOLID --edge L --goal mesh`
    #[arg(value_name = "RUN_DIR|SOLID", required_unless_present = "check")]
    run: Option<PathBuf>,
    /// The length of an edge of the cells in SOLID, in its unit: a number, or a formula or @field.json for one
    /// that varies
    #[arg(long, value_name = "L", value_parser = edge_length, allow_hyphen_values = true)]
    edge: Option<String>,
    /// The directory to write into
    #[arg(long, short, value_name = "OUT", required_unless_present = "check")]
    output: Option<PathBuf>,
    /// Measure the polyMesh (ASCII or binary, plain or .gz) in the folder PATH, or the cells of a .vtu file,
    /// instead
    #[arg(long, value_name = "PATH", conflicts_with_all = ["run", "edge", "output", "to", "scale", "feature_angle", "walls", "collapse", "picture"])]
    check: Option<PathBuf>,
    /// Formats to write
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "polymesh", value_parser = named(&FORMATS))]
    to: Vec<String>,
    /// Elements of the mesh
    #[arg(long, value_name = "KIND", default_value = "cells", value_parser = named(&ELEMENTS))]
    elements: String,
    /// Fail where a measure is above its limit: nonorth=70,skew=4,pyramids=0,aspect=…,concave=…,open=0
    #[arg(long, value_name = "NAME=MOST", value_delimiter = ',')]
    limit: Vec<MeshLimit>,
    /// Part the walls of a solid into patches along edges where they turn by more than A degrees
    #[arg(long, value_name = "A", value_parser = finite, default_value = "40")]
    feature_angle: f64,
    /// Walls of a solid: few polygons a cell with corners on the surface, or all its triangles
    #[arg(long, value_name = "WALLS", default_value = "polygons", value_parser = named(&WALLS))]
    walls: String,
    /// Collapse edges shorter than E sides of the mean cell where quality allows it, up to 0.5 [default:
    /// 0.1 with polygons on walls, otherwise 0]
    #[arg(long, value_name = "E", value_parser = finite)]
    collapse: Option<f64>,
    /// Merge vertices of the run's mesh up to L apart, as `relax --weld` [default: as the run did]
    #[arg(long, value_name = "L", value_parser = length)]
    weld: Option<f64>,
    /// Draw the mesh too, a part taken away, cells colored by kind: mesh.png
    #[arg(long)]
    picture: bool,
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
    let (report, complaint) = match (&options.check, &options.run, &options.output) {
        (Some(path), ..) => (check(path)?, None),
        (None, Some(run), Some(output)) => make(options, common, [run, output])?,
        _ => {
            let message = "name a run or a solid and --output, or --check a mesh";
            return Err(Failure::input(message));
        }
    };
    if options.json {
        print(json(&report)?)?;
    } else if !common.quiet {
        print(report.table())?;
    }
    let passed = report.beyond(&options.limit);
    match (complaint, passed.is_empty()) {
        (None, true) => Ok(()),
        (Some(complaint), true) => Err(Failure::run(complaint)),
        (complaint, false) => Err(Failure::run(format!(
            "limits are passed: {}",
            passed
                .into_iter()
                .chain(complaint)
                .collect::<Vec<_>>()
                .join("; ")
        ))),
    }
}

fn json(report: &MeshReport) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(report).map_err(Failure::run)?;
    Ok(text + "\n")
}

/// The report of a mesh that is there.
fn check(path: &Path) -> Result<MeshReport, Failure> {
    let mesh = match path.is_file() {
        true => listed(path)?,
        false => load_case(path).map_err(Failure::input)?,
    };
    mesh.check_closed()
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    Ok(MeshReport::new(&MeasuredMesh::new(&mesh), None))
}

/// The mesh in a VTU file.
fn listed(path: &Path) -> Result<PolyMesh, Failure> {
    let at = |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", path.display()));
    if extension_of(path) != "vtu" {
        return Err(at(
            &"--check takes a case of OpenFOAM, its polyMesh folder or a .vtu file",
        ));
    }
    let bytes = read_unpacked(path).map_err(|error| at(&error))?;
    let cells = read_cells(&bytes).map_err(|error| at(&error))?;
    mesh_of(&cells).map_err(|error| at(&error))
}

/// Writes a mesh of a run or a solid; returns its report, and what is wrong with it.
fn make(
    options: &MeshOptions,
    common: Common,
    [run, output]: [&Path; 2],
) -> Result<(MeshReport, Option<String>), Failure> {
    if options.scale <= 0.0 {
        return Err(Failure::input(format!(
            "--scale {} is not positive",
            options.scale
        )));
    }
    let is_beyond = |share: &f64| !(0.0..=0.5).contains(share);
    if let Some(share) = options.collapse.filter(is_beyond) {
        let message = format!("--collapse {share} is not between 0 and 0.5");
        return Err(Failure::input(message));
    }
    refuse_formats(options)?;
    let outputs = output_files(output, &options.to, options.picture);
    if !options.force {
        refuse_existing(&outputs)?;
    }
    let source = SiteSource::of(run, options.edge.as_deref(), options.weld)?;
    refuse_inputs(&source.inputs, &outputs)?;
    let (scene, space, sites) = source.sites(common)?;
    let made = MadeMesh::new(options, &space, &scene, &sites)?;
    let mesh = &made.mesh;
    let measured = MeasuredMesh::new(mesh);
    let geometry = &measured.geometry;
    let volume = space.domain().volume() * made.factor.powi(3);
    let report = MeshReport::new(&measured, Some(volume));
    for format in &options.to {
        match (format.as_str(), &made.elements) {
            ("polymesh", _) => write_case(output, mesh).map_err(Failure::run)?,
            ("vtu", None) => {
                let columns = columns(&space, &scene, (&sites, &mesh.sites), geometry)?;
                write_vtu(output, mesh, &columns)?;
            }
            ("faces", _) => write_face_file(output, mesh, geometry)?,
            ("vtu", Some(_)) => write_vtu(output, mesh, &element_columns(mesh, geometry))?,
            (_, Some(elements)) => write_elements(output, format, elements)?,
            (_, None) => {}
        }
    }
    let text = json(&report)?;
    leave(output, "mesh.json", text.as_bytes())?;
    let figure = svg(&histograms(&quality_histograms(&measured)));
    leave(output, HISTOGRAMS, figure.as_bytes())?;
    if options.picture {
        let (kinds, legend) = kinds_and_legend(&measured, &report);
        let picture = mesh_picture(mesh, &kinds, &legend).map_err(Failure::run)?;
        leave(output, PICTURE, &picture)?;
    }
    Ok((report, made.complaint))
}

/// Writes a file of the mesh's directory.
fn leave(output: &Path, name: &str, bytes: &[u8]) -> Result<(), Failure> {
    fs::create_dir_all(output)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", output.display())))?;
    let path = output.join(name);
    write_file(&path, |file| std::io::Write::write_all(file, bytes)).map_err(Failure::run)
}

/// Writes `faces.vtu`.
fn write_face_file(output: &Path, mesh: &PolyMesh, geometry: &MeshGeometry) -> Result<(), Failure> {
    let areas = geometry.face_areas.iter().map(|area| area.norm());
    let path = output.join(FACES);
    fs::create_dir_all(output)
        .and_then(|()| write_faces(&path, mesh, areas.collect()))
        .map_err(|error| Failure::run(format!("cannot write {}: {error}", path.display())))
}

/// A mesh in the coordinates of the domain's own file.
struct MadeMesh {
    mesh: PolyMesh,
    /// The same as elements, where these were asked for.
    elements: Option<ElementMesh>,
    /// How much longer its lengths are than the scene's.
    factor: f64,
    /// What is wrong with its cells still.
    complaint: Option<String>,
}

impl MadeMesh {
    fn new(
        options: &MeshOptions,
        space: &Space,
        scene: &Scene,
        sites: &[Point3<f64>],
    ) -> Result<Self, Failure> {
        let is_hexes = options.elements == "hexes";
        let meshing = CellMeshing {
            is_exact: options.walls == "exact",
            angle: options.feature_angle,
            is_for_dual: is_hexes,
            collapse: options.collapse.or(is_hexes.then_some(HEX_COLLAPSE)),
        };
        let MeshedCells {
            mut mesh,
            complaint,
        } = mesh_cells(space, scene, sites, meshing)?;
        let (factor, from, to) = placement(scene, options.scale)?;
        if !is_hexes {
            mesh.transform(factor, &from, &to);
            return Ok(Self {
                mesh,
                elements: None,
                factor,
                complaint,
            });
        }
        let patches = patches_of(space, scene, options.feature_angle);
        let domain = (space.domain().shape(), &patches, options.feature_angle);
        let mut elements = elements(&mesh, sites, domain)?;
        for point in &mut elements.points {
            *point = to + factor * (*point - from);
        }
        let mesh = elements.by_faces();
        mesh.check_closed().map_err(Failure::run)?;
        Ok(Self {
            mesh,
            elements: Some(elements),
            factor,
            complaint: None,
        })
    }
}

/// The map to the coordinates of the domain's own file, times `scale`: a factor, a place, and where it goes.
fn placement(scene: &Scene, scale: f64) -> Result<(f64, Point3<f64>, Point3<f64>), Failure> {
    let similarity = scene.domain.similarity().map_err(Failure::input)?;
    let origin = Point3::origin();
    Ok(match similarity {
        None => (scale, origin, origin),
        Some(map) => (scale / map.scale, map.to, map.from * scale),
    })
}

/// Writes `mesh.vtu` with the data of every cell.
fn write_vtu(
    output: &Path,
    mesh: &PolyMesh,
    columns: &[(&'static str, CellColumn)],
) -> Result<(), Failure> {
    let path = output.join("mesh.vtu");
    fs::create_dir_all(output)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", output.display())))?;
    write_mesh(&path, mesh, columns, true)
        .map_err(|error| Failure::run(format!("cannot write {}: {error}", path.display())))
}

/// Refuses formats that do not take the elements asked for.
fn refuse_formats(options: &MeshOptions) -> Result<(), Failure> {
    let of_elements = |format: &&String| file_of(format).is_some();
    match options.to.iter().find(of_elements) {
        Some(format) if options.elements == "cells" => Err(Failure::input(format!(
            "--to {format} takes no polyhedra: add --elements hexes, or write --to polymesh,vtu"
        ))),
        _ => Ok(()),
    }
}

/// The files that a mesh in these formats is written to.
fn output_files(output: &Path, formats: &[String], picture: bool) -> Vec<PathBuf> {
    let mut names = vec!["mesh.json", HISTOGRAMS];
    names.extend(picture.then_some(PICTURE));
    for format in formats {
        match format.as_str() {
            "polymesh" => names.extend(MESH_FILES),
            "faces" => names.push(FACES),
            _ => names.push(file_of(format).unwrap_or("mesh.vtu")),
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

/// Refuses to replace what is read, whatever is forced.
fn refuse_inputs(inputs: &[PathBuf], outputs: &[PathBuf]) -> Result<(), Failure> {
    let rule = OutputRule {
        inputs,
        force: true,
        option: "-o",
    };
    rule.check(outputs)
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
