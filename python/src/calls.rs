//! The calls: relaxation, figures, energies, cells, and every command of the program.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::Path;

use chebloyd::scene::bindings::{self, CellArrays, CellQuery, scene_at, scene_of};
use chebloyd::scene::method::SceneMethod;
use chebloyd::scene::run::{Points, PointsSoFar, run_until};
use chebloyd::{Bounds, Record, RunEnd};
use nalgebra::Point;
use numpy::{IntoPyArray, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::{flat, numbers, numbers_of, table};
use crate::errors::{failed, refused};
use crate::work::{Flag, Teller, detached};

/// A record as JSON, and its sites where a callback wants them.
type Step = (String, Option<(Vec<f64>, usize)>);

/// The sites, the log as JSON lines, why it ended, and notes.
type Run<'py> = (Bound<'py, PyAny>, Vec<String>, &'static str, Vec<String>);

/// Runs a scene; without `sites` with those that it names. `callback` is given every record as JSON and its
/// sites; its `False` ends the run. Returns the sites, the log as JSON lines, why it ended, and notes.
#[pyfunction]
#[pyo3(signature = (scene, sites=None, threads=None, callback=None))]
pub(crate) fn relax<'py>(
    py: Python<'py>,
    scene: &str,
    sites: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
    callback: Option<Py<PyAny>>,
) -> PyResult<Run<'py>> {
    let scene = of(scene, sites)?;
    let wants_sites = callback.is_some();
    let mut log = Vec::new();
    let work = move |flag: &Flag, teller: &Teller<Step, _>| {
        run_until(&scene, flag, |record, sites| {
            let step = (line(record), wants_sites.then(|| copied(sites)));
            if teller.tell(step) {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        })
    };
    let outcome = detached(py, (threads, false), work, |py, (line, sites): Step| {
        let goes_on = match (&callback, sites) {
            (Some(callback), Some((sites, width))) => {
                let answer = callback.call1(py, (&line, table(py, sites, width)?))?;
                !answer.bind(py).is(pyo3::types::PyBool::new(py, false))
            }
            _ => true,
        };
        log.push(line);
        Ok(goes_on)
    })?;
    let outcome = outcome.map_err(refused)?;
    let ended = match outcome.ended {
        RunEnd::Iterations => "iterations",
        RunEnd::Tolerance => "tolerance",
        _ => "callback",
    };
    let (sites, width) = numbers_of(outcome.sites);
    Ok((table(py, sites, width)?, log, ended, outcome.notes))
}

/// The scene of a JSON text, or of a file's path, with given sites in the place of its own.
fn of(
    scene: &str,
    sites: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<chebloyd::scene::description::Scene> {
    let sites = sites.map(|sites| numbers(&sites)).transpose()?;
    match sites {
        Some((numbers, _)) if scene.starts_with('{') => scene_of(scene, numbers),
        given => scene_at(Path::new(scene), given.map(|(numbers, _)| numbers)),
    }
    .map_err(refused)
}

fn line(record: &Record) -> String {
    serde_json::to_string(record).unwrap_or_default()
}

fn copied(sites: PointsSoFar<'_>) -> (Vec<f64>, usize) {
    match sites {
        Points::Plane(sites) => (flat(sites.to_vec()), 2),
        Points::Space(sites) => (flat(sites.to_vec()), 3),
    }
}

/// Runs what tells of no events.
fn quietly<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce(&Flag) -> T + Send + 'static,
) -> PyResult<T> {
    let work = |flag: &Flag, _: &Teller<Infallible, T>| work(flag);
    detached(py, (threads, false), work, |_, event| match event {})
}

/// The figures of a tessellation as JSON, and arrays per cell by their names in `measure --per-cell`.
#[pyfunction]
#[pyo3(signature = (scene, sites=None, threads=None))]
pub(crate) fn measure<'py>(
    py: Python<'py>,
    scene: &str,
    sites: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
) -> PyResult<(String, Bound<'py, PyDict>, usize, Vec<String>)> {
    let scene = of(scene, sites)?;
    let measured = quietly(py, threads, move |flag| bindings::measure(&scene, flag))?;
    let measured = measured.map_err(refused)?;
    let (of, cells) = (measured.cells, PyDict::new(py));
    let width = of.dimension;
    cells.set_item("volume", of.volumes.into_pyarray(py))?;
    cells.set_item("centroid", table(py, of.centroids, width)?)?;
    cells.set_item("energy", of.energies.into_pyarray(py))?;
    cells.set_item("gradient", table(py, of.gradients, width)?)?;
    cells.set_item("center", table(py, of.centers, width)?)?;
    cells.set_item("center_energy", of.center_energies.into_pyarray(py))?;
    cells.set_item("facets", of.facets.into_pyarray(py))?;
    let metrics = serde_json::to_string(&measured.metrics).map_err(failed)?;
    Ok((metrics, cells, measured.dropped, measured.notes))
}

/// The global objective and its gradient, a row per site.
#[pyfunction]
#[pyo3(signature = (scene, sites=None, threads=None))]
pub(crate) fn energy<'py>(
    py: Python<'py>,
    scene: &str,
    sites: Option<PyReadonlyArray2<'py, f64>>,
    threads: Option<usize>,
) -> PyResult<(f64, Bound<'py, PyAny>)> {
    let scene = of(scene, sites)?;
    let width = scene.dimension;
    let value = quietly(py, threads, move |flag| bindings::energy(&scene, flag))?;
    let (energy, gradient) = value.map_err(refused)?;
    Ok((energy, table(py, gradient, width)?))
}

/// The cells of all sites or of those in `select`, as arrays by their names; `known` is the least and the
/// greatest corner of a box in which all sites are given. Notes come second.
#[pyfunction]
#[pyo3(signature = (scene, sites, select=None, known=None, shapes=true, threads=None))]
pub(crate) fn cells<'py>(
    py: Python<'py>,
    scene: &str,
    sites: PyReadonlyArray2<'py, f64>,
    select: Option<PyReadonlyArray1<'py, i64>>,
    known: Option<[[f64; 3]; 2]>,
    shapes: bool,
    threads: Option<usize>,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let scene = of(scene, Some(sites))?;
    let chosen = select.map(|select| chosen(&select)).transpose()?;
    let found = quietly(py, threads, move |flag| {
        let known = known.map(|[min, max]| Bounds {
            min: Point::from(min),
            max: Point::from(max),
        });
        let query = CellQuery {
            chosen: chosen.as_deref(),
            shapes,
            known,
        };
        bindings::cells(&scene, &query, flag)
    })?;
    let (cells, notes) = found.map_err(refused)?;
    Ok((dictionary(py, cells)?, notes))
}

fn chosen(select: &PyReadonlyArray1<'_, i64>) -> PyResult<Vec<usize>> {
    let number = |&site: &i64| {
        let negative = || refused(format!("there is no site {site}; the first is 0"));
        usize::try_from(site).map_err(|_| negative())
    };
    select.as_array().iter().map(number).collect()
}

fn dictionary(py: Python<'_>, cells: CellArrays) -> PyResult<Bound<'_, PyDict>> {
    let (arrays, width) = (PyDict::new(py), cells.dimension);
    arrays.set_item("vertices", table(py, cells.vertices, width)?)?;
    arrays.set_item("vertex_offsets", cells.vertex_offsets.into_pyarray(py))?;
    arrays.set_item("corners", cells.corners.into_pyarray(py))?;
    arrays.set_item("corner_offsets", cells.corner_offsets.into_pyarray(py))?;
    arrays.set_item("facet_offsets", cells.facet_offsets.into_pyarray(py))?;
    arrays.set_item("neighbors", cells.neighbors.into_pyarray(py))?;
    arrays.set_item("images", table(py, cells.images, width)?)?;
    arrays.set_item("areas", cells.areas.into_pyarray(py))?;
    arrays.set_item("normals", table(py, cells.normals, width)?)?;
    arrays.set_item("volumes", cells.volumes.into_pyarray(py))?;
    arrays.set_item("centroids", table(py, cells.centroids, width)?)?;
    arrays.set_item("radii", cells.radii.into_pyarray(py))?;
    arrays.set_item("certified", cells.certified.into_pyarray(py))?;
    Ok(arrays)
}

/// Runs a command of the program: what it printed, its notes, and the sentence of a failure after which it
/// printed its report all the same. A command that ends its files when it is interrupted `is_patient`.
#[pyfunction]
#[pyo3(signature = (arguments, threads=None, is_patient=false))]
pub(crate) fn call(
    py: Python<'_>,
    arguments: Vec<std::ffi::OsString>,
    threads: Option<usize>,
    is_patient: bool,
) -> PyResult<(Py<PyBytes>, Vec<String>, Option<String>)> {
    let work = |flag: &Flag, _: &Teller<Infallible, _>| chebloyd::call(arguments, flag);
    let outcome = detached(py, (threads, is_patient), work, |_, event| match event {})?;
    let failure = match outcome.failure {
        Some((1, message)) if !outcome.output.is_empty() => Some(message),
        Some((_, message)) => return Err(refused(message)),
        None => None,
    };
    let output = PyBytes::new(py, &outcome.output).unbind();
    Ok((output, outcome.notes, failure))
}

/// The scene's `method` of the goals "cubes" and "squares", as JSON.
#[pyfunction]
pub(crate) fn cubes() -> PyResult<String> {
    serde_json::to_string(&SceneMethod::cubes()).map_err(failed)
}

/// The program itself, with this process's arguments (after Python's own), streams and signals; never returns.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> PyResult<u8> {
    py.detach(|| Ok(chebloyd::command_line_of(arguments)))
}
