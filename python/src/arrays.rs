//! Points from NumPy's arrays and arrays from points.

use chebloyd::scene::run::Points;
use nalgebra::{Point, Point2, Point3};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::errors::refused;

/// The numbers of an (n, 2) or (n, 3) array, row by row, and how many a row has.
pub(crate) fn numbers(sites: &PyReadonlyArray2<'_, f64>) -> PyResult<(Vec<f64>, usize)> {
    let view = sites.as_array();
    let [_, dimension] = *view.shape() else {
        return Err(refused("sites are no table"));
    };
    if !(2..=3).contains(&dimension) {
        let shape = (view.nrows(), dimension);
        return Err(refused(format!(
            "sites have shape {shape:?}; (n, 3) is needed, in the plane (n, 2)"
        )));
    }
    let numbers = match view.as_slice() {
        Some(numbers) => numbers.to_vec(),
        None => view.iter().copied().collect(),
    };
    Ok((numbers, dimension))
}

/// Hands numbers over as a table of `width` columns; nothing is copied.
pub(crate) fn table<'py, T: numpy::Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    width: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = numbers.len() / width;
    let table = Array2::from_shape_vec((rows, width), numbers).map_err(refused)?;
    Ok(table.into_pyarray(py).into_any())
}

/// The coordinates of points, one after the other; the memory stays where it is.
pub(crate) fn flat<const D: usize>(points: Vec<Point<f64, D>>) -> Vec<f64> {
    let rows: Vec<[f64; D]> = points
        .into_iter()
        .map(|point| point.coords.into())
        .collect();
    rows.into_flattened()
}

/// Points of either dimension as numbers, and how many a point has.
pub(crate) fn numbers_of(points: Points<Vec<Point2<f64>>, Vec<Point3<f64>>>) -> (Vec<f64>, usize) {
    match points {
        Points::Plane(points) => (flat(points), 2),
        Points::Space(points) => (flat(points), 3),
    }
}
