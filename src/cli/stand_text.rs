//! Directions, places and polygon files as `chebloyd stand` takes them.

use std::fs;
use std::path::Path;

use nalgebra::{Point2, Point3, Vector3};

use crate::balance::support::{Ground, Support};
use crate::cli::failure::Failure;

/// Two or three coordinates.
pub(crate) type Coordinates = Vec<f64>;

/// An axis with its sign, or three numbers.
pub(crate) fn up(text: &str) -> Result<Vector3<f64>, String> {
    let (sign, name) = match text.strip_prefix('-') {
        Some(name) => (-1.0, name),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    let axis = ["x", "y", "z"]
        .iter()
        .position(|axis| name.eq_ignore_ascii_case(axis));
    if let Some(axis) = axis {
        return Ok(Vector3::ith(axis, sign));
    }
    match numbers(text).as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().any(|part| part.abs() > 0.0) => {
            Ok(Vector3::new(x, y, z))
        }
        Some([_, _, _]) => Err("a direction has a length".to_owned()),
        _ => Err("x, -x, y, -y, z, -z or three numbers X,Y,Z are needed".to_owned()),
    }
}

/// Two or three numbers.
pub(crate) fn point(text: &str) -> Result<Coordinates, String> {
    let numbers = numbers(text).filter(|numbers| matches!(numbers.len(), 2 | 3));
    numbers.ok_or_else(|| "two numbers X,Y are needed, or three".to_owned())
}

/// Three numbers, of which `_` is free.
pub(crate) fn target(text: &str) -> Result<[Option<f64>; 3], String> {
    let parts: Vec<_> = text.split(',').map(str::trim).collect();
    let coordinate = |part: &&str| match *part {
        "_" => Some(None),
        number => finite(number).map(Some),
    };
    let coordinates: Option<Vec<_>> = parts.iter().map(coordinate).collect();
    let coordinates = coordinates.and_then(|numbers| <[Option<f64>; 3]>::try_from(numbers).ok());
    match coordinates {
        Some([None, None, None]) => Err("a target gives at least one coordinate".to_owned()),
        Some(coordinates) => Ok(coordinates),
        None => Err("X,Y,Z are needed, each a number or _ (free)".to_owned()),
    }
}

/// The points of a polygon file: two or three numbers a line, between commas or spaces; `#` begins a comment,
/// and a first line without numbers is a header.
fn polygon(path: &Path) -> Result<Vec<Coordinates>, Failure> {
    let name = path.display();
    let text = fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("cannot read {name}: {error}")))?;
    let mut points: Vec<Coordinates> = Vec::new();
    let mut is_first = true;
    for (line, text) in text.lines().enumerate() {
        let text = text.split('#').next().unwrap_or_default().trim();
        if text.is_empty() {
            continue;
        }
        let parts = text.split(|c: char| c == ',' || c == ';' || c.is_whitespace());
        let parts: Vec<_> = parts.filter(|part| !part.is_empty()).collect();
        let numbers: Option<Coordinates> = parts.iter().map(|part| finite(part)).collect();
        let is_header = is_first && parts.iter().all(|part| part.parse::<f64>().is_err());
        is_first = false;
        match numbers {
            _ if is_header => {}
            Some(numbers) if matches!(numbers.len(), 2 | 3) => points.push(numbers),
            _ => {
                let line = line + 1;
                let message = format!(
                    "{name}, line {line}: `{text}` is no point; it takes two or three finite numbers"
                );
                return Err(Failure::input(message));
            }
        }
    }
    let columns = points.first().map_or(0, Vec::len);
    match points.iter().position(|point| point.len() != columns) {
        _ if points.is_empty() => Err(Failure::input(format!("{name} holds no points"))),
        Some(place) => Err(Failure::input(format!(
            "{name}: point {} has {} coordinates and the first has {columns}",
            place + 1,
            points[place].len()
        ))),
        None => Ok(points),
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|part| finite(part.trim())).collect()
}

fn finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

/// The hull of the points of a polygon file, on the ground.
pub(crate) fn polygon_on(ground: &Ground, file: &Path) -> Result<Support, Failure> {
    let points = polygon(file)?;
    let points = points.iter().map(|point| ground_point(ground, point));
    let points: Result<Vec<_>, _> = points.collect();
    let at_file = |why: String| Failure::input(format!("{}: {why}", file.display()));
    let points = points.map_err(at_file)?;
    Support::hull(points).map_err(|error| at_file(error.to_string()))
}

/// Coordinates as a point of the ground.
pub(crate) fn ground_point(ground: &Ground, numbers: &[f64]) -> Result<Point2<f64>, String> {
    match *numbers {
        [x, y, z] => Ok(ground.shadow(&Point3::new(x, y, z))),
        [first, second] if ground.is_along_axis() => Ok(Point2::new(first, second)),
        [_, _] => Err("up is no axis, so a point of the ground takes three coordinates".to_owned()),
        _ => Err(format!(
            "a point has two or three coordinates, not {}",
            numbers.len()
        )),
    }
}
