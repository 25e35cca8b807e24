//! A scene's run, figures, energies and cells for sites that a program hands over: what bindings call.
//!
//! The scene's text has no `sites`; [`scene_of`] puts the program's in their place. Work ends in an error soon
//! after another thread has raised the flag that it was given.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nalgebra::{Point2, Point3};
use serde_json::{Map, Value, json};

pub use crate::voronoi::cell_arrays::{CellArrays, CellQuery};

use crate::relax::metrics::{CellMetrics, Metrics};
use crate::relax::relaxation_space::RelaxationSpace;
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::read::{parse, unchecked};
use crate::scene::run::{RunSpace, energy_spec, plane, space};
use crate::scene::sites::Sites;
use crate::voronoi::diagram::Diagram;

/// What messages call a scene that a program hands over.
const NAME: &str = "the arguments";

/// The figures of a tessellation and of its cells.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Measured {
    /// Those of all cells together.
    pub metrics: Metrics,
    /// Those of each.
    pub cells: CellColumns,
    /// How many sites outside the domain were left out.
    pub dropped: usize,
    /// What was repaired in the scene's mesh, one sentence each.
    pub notes: Vec<String>,
}

/// The figures of every cell, in site order. Points and vectors have `dimension` numbers each.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CellColumns {
    /// 3 in space, 2 in the plane.
    pub dimension: usize,
    /// Volumes (L³; in the plane areas, L²).
    pub volumes: Vec<f64>,
    /// Mass centers.
    pub centroids: Vec<f64>,
    /// Energies at the sites, in the scene's norm and order.
    pub energies: Vec<f64>,
    /// Their gradients there.
    pub gradients: Vec<f64>,
    /// Minimizers of the energies.
    pub centers: Vec<f64>,
    /// The energies there.
    pub center_energies: Vec<f64>,
    /// How many facets count (those larger than 5 % of V^(2/3)).
    pub facets: Vec<u32>,
}

impl CellColumns {
    fn of<const D: usize>(cells: &[CellMetrics<D>]) -> Self {
        let all = |of: &dyn Fn(&CellMetrics<D>) -> [f64; D]| cells.iter().flat_map(of).collect();
        Self {
            dimension: D,
            volumes: cells.iter().map(|cell| cell.volume).collect(),
            centroids: all(&|cell| cell.centroid.coords.into()),
            energies: cells.iter().map(|cell| cell.energy).collect(),
            gradients: all(&|cell| cell.gradient.into()),
            centers: all(&|cell| cell.center.coords.into()),
            center_energies: cells.iter().map(|cell| cell.center_energy).collect(),
            facets: cells.iter().map(|cell| cell.facets).collect(),
        }
    }
}

/// The validated scene of a file, with sites that are given, if they are, one after the other in the place of
/// those that it names.
///
/// # Errors
/// As [`read::scene`](crate::scene::read::scene()), and when the numbers are no points of the scene's dimension.
pub fn scene_at(path: &Path, sites: Option<Vec<f64>>) -> Result<Scene, Error> {
    let mut scene = unchecked(path)?;
    if let Some(sites) = sites {
        (scene.sites, scene.sites_format) = (Sites::Given(sites.into()), None);
    }
    scene.validate()?;
    Ok(scene)
}

/// The validated scene of a text without `sites`, with those that are given one after the other.
///
/// # Errors
/// As [`scene_at`].
pub fn scene_of(text: &str, sites: Vec<f64>) -> Result<Scene, Error> {
    let mut keys: Map<String, Value> =
        serde_json::from_str(text).map_err(|error| Error::value("scene", error.to_string()))?;
    keys.insert("sites".to_owned(), json!({ "random": { "count": 1 } }));
    let mut scene = parse(&Value::Object(keys).to_string(), Path::new(NAME))?;
    scene.sites = Sites::Given(sites.into());
    scene.validate()?;
    Ok(scene)
}

/// The figures of a scene's tessellation.
///
/// # Errors
/// When the scene has no domain, or its sites no cells there.
pub fn measure(scene: &Scene, flag: &Arc<AtomicBool>) -> Result<Measured, Error> {
    if scene.dimension == 2 {
        return figures(&plane(scene)?, scene, Vec::new());
    }
    let (space, notes) = space(scene)?;
    figures(&space.stop_by(flag), scene, notes)
}

fn figures<const D: usize>(
    space: &impl RunSpace<D>,
    scene: &Scene,
    mut notes: Vec<String>,
) -> Result<Measured, Error> {
    let placed = space.placed(scene)?;
    notes.extend(placed.notes);
    let spec = energy_spec(scene);
    let cells = space.cells(&placed.sites, spec).map_err(relaxing)?;
    let metrics = space.figures(&placed.sites, &cells).map_err(relaxing)?;
    Ok(Measured {
        metrics: metrics.checked(0).map_err(relaxing)?,
        cells: CellColumns::of(&cells),
        dropped: placed.dropped,
        notes,
    })
}

/// The global objective of a scene's sites, the sum of its cells' Chebyshev energies (L^(D+p)), and its exact
/// gradient, `dimension` numbers per site.
///
/// # Errors
/// As [`measure`].
pub fn energy(scene: &Scene, flag: &Arc<AtomicBool>) -> Result<(f64, Vec<f64>), Error> {
    if scene.dimension == 2 {
        return objective(&plane(scene)?, scene);
    }
    objective(&space(scene)?.0.stop_by(flag), scene)
}

fn objective<const D: usize>(
    space: &impl RunSpace<D>,
    scene: &Scene,
) -> Result<(f64, Vec<f64>), Error> {
    let sites = space.place(scene)?;
    let value = RelaxationSpace::objective(space, &sites, scene.order).map_err(relaxing)?;
    let gradient = value
        .gradient
        .iter()
        .flat_map(|along| along.iter().copied());
    Ok((value.energy, gradient.collect()))
}

/// The L2 cells of a scene's given sites as arrays, and what was repaired in its mesh. Sites that share a place
/// are found where cells are asked for.
///
/// # Errors
/// As [`measure`], and when a site is chosen that is not there.
pub fn cells(
    scene: &Scene,
    query: &CellQuery<'_>,
    flag: &Arc<AtomicBool>,
) -> Result<(CellArrays, Vec<String>), Error> {
    let Sites::Given(numbers) = &scene.sites else {
        return Err(Error::value("sites", "cells are those of given sites"));
    };
    if scene.dimension == 2 {
        let rows = numbers.as_chunks::<2>().0;
        let sites: Vec<_> = rows.iter().copied().map(Point2::from).collect();
        let cells = CellArrays::in_plane(&scene.plane()?, &sites, query)?;
        return Ok((cells, Vec::new()));
    }
    let (domain, notes) = scene.domain.solid()?;
    let rows = numbers.as_chunks::<3>().0;
    let sites: Vec<_> = rows.iter().copied().map(Point3::from).collect();
    let diagram = Diagram::borrowed(domain.as_ref(), &sites)?.stop_by(flag);
    Ok((CellArrays::in_space(&diagram, query)?, notes))
}

fn relaxing(error: impl std::error::Error + Send + Sync + 'static) -> Error {
    Error::Relax(Box::new(error))
}
