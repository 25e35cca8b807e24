//! The sites of `chebloyd mesh`: those that a run left, or new ones relaxed in a solid.

use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use serde_json::json;

use crate::cli::failure::Failure;
use crate::cli::options::{Common, SceneOptions, change, given, print_notes, space};
use crate::cli::run::{Bar, RunDescription};
use crate::mesh::overlap::touching_walls;
use crate::relax::record::Record;
use crate::relax::relaxation::Checkpoint;
use crate::relax::relaxation_space::{Norm, RelaxationSpace as _};
use crate::relax::space::Space;
use crate::relax::state::RunState;
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::run::{RunSpace, all_sites, energy_spec, relax};
use crate::scene::site_file;

/// A scene whose sites are still to come.
#[derive(Debug)]
pub(crate) struct SiteSource {
    /// The scene.
    pub(crate) scene: Scene,
    /// The files that it is read from.
    pub(crate) inputs: Vec<PathBuf>,
    /// Sites that are there already.
    sites: Option<Vec<Point3<f64>>>,
}

impl SiteSource {
    /// The run in the directory `from`; or the solid or scene in the file `from`, cells of edge `edge` in it.
    pub(crate) fn of(from: &Path, edge: Option<&str>, weld: Option<f64>) -> Result<Self, Failure> {
        match (from.is_file(), edge) {
            (true, _) => Self::solid(from, edge, weld),
            (false, None) => Self::run(from, weld),
            (false, Some(_)) => Err(Failure::input(format!(
                "{} is no file: --edge is for a mesh file or a scene; a run has its sites",
                from.display()
            ))),
        }
    }

    fn run(from: &Path, weld: Option<f64>) -> Result<Self, Failure> {
        let (mut scene, sites) = read_run(from)?;
        if scene.domain.file().is_some() {
            let weld = Overrides {
                domain: given(json!({ "weld": weld })),
                ..Overrides::default()
            };
            change(&mut scene, &weld)?;
        }
        let mut inputs = scene.files();
        inputs.extend(["run.json", "sites.csv"].map(|name| from.join(name)));
        Ok(Self {
            scene,
            inputs,
            sites: Some(sites),
        })
    }

    fn solid(from: &Path, edge: Option<&str>, weld: Option<f64>) -> Result<Self, Failure> {
        let is_scene = from
            .extension()
            .is_some_and(|name| name.eq_ignore_ascii_case("json"));
        if edge.is_none() && !is_scene {
            return Err(Failure::input(format!(
                "{} is a mesh: say the length of an edge of the cells, --edge L, in its unit",
                from.display()
            )));
        }
        let options = SceneOptions::of_file(from, edge, weld);
        let mut overrides = Overrides::default();
        overrides.set_mesh();
        let mut scene = options.scene(overrides)?;
        check_cells(&scene)?;
        scene.set_mesh_start(None);
        Ok(Self {
            inputs: options.inputs(&scene),
            scene,
            sites: None,
        })
    }

    /// The space of the scene, and the sites: where none are there, new ones that are relaxed first.
    pub(crate) fn sites(self, common: Common) -> Result<(Scene, Space, Vec<Point3<f64>>), Failure> {
        let space = space(&self.scene)?;
        refuse_touching(&space)?;
        let sites = match self.sites {
            Some(sites) => sites,
            None => relaxed(&space, &self.scene, common)?,
        };
        Ok((self.scene, space, sites))
    }
}

/// New sites, moved by the scene's method.
fn relaxed(space: &Space, scene: &Scene, common: Common) -> Result<Vec<Point3<f64>>, Failure> {
    let placed = space.placed(scene).map_err(Failure::input)?;
    print_notes(&placed.notes);
    let fits = space.check_scale(placed.sites.len(), energy_spec(scene));
    fits.map_err(Failure::input)?;
    let mut checkpoint = Checkpoint::at_start(placed.sites);
    let bar = Bar::new(scene.method.iterations(), 0, common);
    let mut observe = |record: &Record, _: &[Point3<f64>], _: &RunState<3>| {
        bar.show(record);
        ControlFlow::Continue(())
    };
    let ended = relax(space, scene, &mut checkpoint, &mut observe);
    bar.finish();
    ended.map_err(Failure::run)?;
    all_sites(space, &checkpoint).map_err(Failure::run)
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
    check_cells(&scene)?;
    let sites = site_file::read::<3>(&run.join("sites.csv")).map_err(Failure::input)?;
    Ok((scene, sites))
}

/// Refuses solids whose parts share a wall.
fn refuse_touching(space: &Space) -> Result<(), Failure> {
    match space.domain().surface_mesh().and_then(touching_walls) {
        None => Ok(()),
        Some(place) => Err(Failure::input(format!(
            "walls of the solid lie on each other at [{:.4}, {:.4}, {:.4}]: a mesh is one region, without \
             zones for parts that touch; mesh every part alone, or unite the parts, in Blender or MeshLab",
            place.x, place.y, place.z
        ))),
    }
}

/// Refuses scenes whose cells make no mesh.
fn check_cells(scene: &Scene) -> Result<(), Failure> {
    if scene.dimension != 3 {
        let message = "meshes are made of cells in space: relax with \"dimension\": 3";
        return Err(Failure::input(message));
    }
    if scene.cells == Norm::Linf {
        let message = "meshes are made of L2 cells, and the run has \"cells\": \"linf\": take its sites.csv \
                       on with --cells l2 --iterations 0";
        return Err(Failure::input(message));
    }
    Ok(())
}
