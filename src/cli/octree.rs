//! `chebloyd octree`: the errors of octrees beside exact mass properties.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use crate::export::octree_vtu::write_octree;
use crate::geometry::bounds::Bounds;
use crate::mass::body::Body;
use crate::mass::density::{Ramp, SolidDensity};
use crate::mass::octree_error::{OctreeError, weigh_octree};
use crate::mass::weigh::weigh_surface;
use crate::mesh::formats::read::load;
use crate::mesh::octree::{DEEPEST, Octree};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::Solid;
use crate::plot::octrees::{CaptionedTree, error_curves, octrees};
use crate::plot::svg;

use crate::cli::failure::{Failure, print_report, write_file};
use crate::cli::octree_report::{ModelReport, OctreesReport, TreeReport};
use crate::cli::options::named;
use crate::cli::output::OutputRule;

/// The axes by name.
const AXES: [(&str, &str); 3] = [("x", ""), ("y", ""), ("z", "")];

/// Print how far octrees of several depths are off exact mass properties, beside the paper's Table 3
///
/// As there, every solid is scaled to unit height, its density grows from 0 at the bottom to 1 at the top,
/// and the tree halves the bounding box wherever the surface touches a node. The paper leaves open which
/// axis points up, which nodes it counts, and which touched leaves are solid: here --axis, those that are
/// touched or inside on all levels, and those whose middle is inside.
#[derive(Debug, Args)]
pub(crate) struct OctreeOptions {
    /// Closed surfaces or tetrahedral meshes
    #[arg(required = true, value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// The axis along which the height is measured and the density grows
    #[arg(long, value_name = "AXIS", default_value = "y", value_parser = named(&AXES))]
    axis: String,
    /// The depths of the trees
    #[arg(long, value_name = "FROM-TO", default_value = "2-8", value_parser = depths)]
    depths: (u32, u32),
    /// Also write, into this directory, the errors over the sizes as octree.svg (Fig. 14), and of every
    /// model the trees as NAME-octrees.png (Fig. 15) and NAME-octree-DEPTH.vtu
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace files that are there
    #[arg(long)]
    force: bool,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

/// `2-8`, or one depth.
fn depths(text: &str) -> Result<(u32, u32), String> {
    let (from, to) = text.split_once('-').unwrap_or((text, text));
    match (from.trim().parse::<u32>(), to.trim().parse::<u32>()) {
        (Ok(from), Ok(to)) if from <= to && to <= DEEPEST => Ok((from, to)),
        _ => Err(format!(
            "two depths from 0 to {DEEPEST} are needed, such as 2-8"
        )),
    }
}

pub(crate) fn run(options: &OctreeOptions) -> Result<(), Failure> {
    let axis = AXES.iter().position(|(name, _)| *name == options.axis);
    let axis = axis.unwrap_or(1);
    let surfaces = options.models.iter().map(|model| surface(model));
    let surfaces = surfaces.collect::<Result<Vec<_>, _>>()?;
    let names = names(&options.models)?;
    if let Some(out) = &options.out {
        check_outputs(options, out, &names)?;
    }
    let mut models = Vec::new();
    for (name, surface) in names.iter().zip(surfaces) {
        models.push(compare(options, name, surface, axis)?);
    }
    let report = OctreesReport { models };
    if let Some(out) = &options.out {
        let figure = svg::svg(&error_curves(&report.curves()));
        write_bytes(&out.join(PLOT), figure.as_bytes())?;
    }
    print_report(&report, options.json, || report.table())
}

const PLOT: &str = "octree.svg";

/// The surface of a solid.
fn surface(path: &Path) -> Result<SurfaceMesh, Failure> {
    Ok(match load(path).map_err(Failure::input)? {
        Solid::Surface(closed, _) => closed.into_mesh(),
        Solid::Tets(sound, _) => sound.mesh().boundary(),
    })
}

/// The models' names without folder and extension, each once.
fn names(models: &[PathBuf]) -> Result<Vec<String>, Failure> {
    let mut names: Vec<String> = Vec::new();
    for model in models {
        let stem = model.file_stem().unwrap_or_default();
        let name = stem.to_string_lossy().into_owned();
        if names.contains(&name) {
            let message = format!("two models are called {name}; name one of them differently");
            return Err(Failure::input(message));
        }
        names.push(name);
    }
    Ok(names)
}

fn check_outputs(options: &OctreeOptions, out: &Path, names: &[String]) -> Result<(), Failure> {
    let (from, to) = options.depths;
    let mut outputs = vec![out.join(PLOT)];
    for name in names {
        outputs.push(out.join(format!("{name}-octrees.png")));
        outputs.extend((from..=to).map(|depth| vtu_path(out, name, depth)));
    }
    let rule = OutputRule {
        inputs: &options.models,
        force: options.force,
        option: "--out",
    };
    rule.check(&outputs)?;
    let made = std::fs::create_dir_all(out);
    made.map_err(|error| Failure::input(format!("cannot make {}: {error}", out.display())))
}

fn vtu_path(out: &Path, name: &str, depth: u32) -> PathBuf {
    out.join(format!("{name}-octree-{depth}.vtu"))
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_file(path, |file| file.write_all(bytes)).map_err(Failure::run)
}

/// The trees of one model beside its exact mass properties.
fn compare(
    options: &OctreeOptions,
    name: &str,
    mut surface: SurfaceMesh,
    axis: usize,
) -> Result<ModelReport, Failure> {
    Similarity::to_unit_height(&surface.bounds(), axis).move_all(&mut surface.vertices);
    let bounds = surface.bounds();
    let (from, to) = (0.0, 1.0);
    let ramp = Ramp { axis, from, to };
    let start = Instant::now();
    let exact = weigh_surface(&surface, &SolidDensity::Ramp(ramp), &bounds)
        .map_err(|error| Failure::input(format!("{name}: {error}")))?;
    let seconds = start.elapsed().as_secs_f64();
    let mut model = ModelReport::new(name, &surface, &exact, seconds);
    let mut trees = Vec::new();
    for depth in options.depths.0..=options.depths.1 {
        let (tree, report) = measure(&surface, depth, &ramp, &bounds, &exact);
        model.push(report);
        if let Some(out) = &options.out {
            let path = vtu_path(out, name, depth);
            let written = write_octree(&path, &tree);
            written.map_err(|error| {
                Failure::run(format!("cannot write {}: {error}", path.display()))
            })?;
            trees.push(tree);
        }
    }
    if let Some(out) = &options.out {
        let captioned = trees.iter().map(|tree| CaptionedTree {
            caption: format!("depth {}: {} nodes", tree.depth, tree.nodes),
            tree,
        });
        let picture = octrees(&captioned.collect::<Vec<_>>(), axis).map_err(Failure::run)?;
        write_bytes(&out.join(format!("{name}-octrees.png")), &picture)?;
    }
    Ok(model)
}

/// A tree, with its errors and the time that it took to build and weigh.
fn measure(
    surface: &SurfaceMesh,
    depth: u32,
    ramp: &Ramp,
    bounds: &Bounds<3>,
    exact: &Body,
) -> (Octree, TreeReport) {
    let start = Instant::now();
    let tree = Octree::new(surface, depth);
    let density = ramp.over(bounds, &bounds.min);
    let body = weigh_octree(&tree, &density, &bounds.min);
    let seconds = start.elapsed().as_secs_f64();
    let error = OctreeError::of(&body, exact);
    let report = TreeReport::new(&tree, &error, seconds);
    (tree, report)
}
