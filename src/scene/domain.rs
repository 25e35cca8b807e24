//! The scene's `domain`: where the sites live.
//!
//! Plain numbers in the scene's dimension, judged by `validate`; the domain floor makes
//! walls of them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::error::Error;
use crate::scene::validate::{all_finite, dimensions_match};

/// A domain by its scene key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Domain {
    /// An axis-aligned box, periodic along any of its axes.
    Box(BoxDomain),
    /// The intersection of half-spaces `[n_x, n_y, n_z, d]`: the points y with n·y ≤ d
    /// (in the plane `[n_x, n_y, d]`).
    HalfSpaces(Vec<Vec<f64>>),
    /// The corners of a convex polygon in order, either way round (in the plane only).
    Polygon(Vec<Vec<f64>>),
}

/// An axis-aligned box. Lists left out are those of the unit box without periodic axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxDomain {
    /// The corner with the least coordinates; the origin unless told.
    #[serde(default)]
    pub min: Vec<f64>,
    /// The corner with the greatest coordinates; (1, 1, 1) unless told.
    #[serde(default)]
    pub max: Vec<f64>,
    /// Along which axes the box repeats itself; none unless told.
    #[serde(default)]
    pub periodic: Vec<bool>,
}

impl Default for Domain {
    fn default() -> Self {
        Self::Box(BoxDomain::default())
    }
}

impl Domain {
    pub(crate) fn fill_defaults(&mut self, dimension: usize) {
        if let Self::Box(domain) = self {
            fill(&mut domain.min, 0.0, dimension);
            fill(&mut domain.max, 1.0, dimension);
            fill(&mut domain.periodic, false, dimension);
        }
    }

    /// Judges the numbers as far as they can be judged one by one.
    pub(crate) fn validate(&self, dimension: usize) -> Result<(), Error> {
        match self {
            Self::Box(domain) => domain.validate(dimension),
            Self::HalfSpaces(rows) => validate_half_spaces(rows, dimension),
            Self::Polygon(corners) => validate_polygon(corners, dimension),
        }
    }

    /// Along which of the `D` axes the domain repeats itself.
    #[must_use]
    pub fn periodic<const D: usize>(&self) -> [bool; D] {
        let mut axes = [false; D];
        if let Self::Box(domain) = self {
            for (axis, &periodic) in axes.iter_mut().zip(&domain.periodic) {
                *axis = periodic;
            }
        }
        axes
    }
}

impl BoxDomain {
    fn validate(&self, dimension: usize) -> Result<(), Error> {
        dimensions_match("domain.box.min", self.min.len(), dimension)?;
        dimensions_match("domain.box.max", self.max.len(), dimension)?;
        dimensions_match("domain.box.periodic", self.periodic.len(), dimension)?;
        all_finite("domain.box.min", &self.min)?;
        all_finite("domain.box.max", &self.max)?;
        for (axis, (min, max)) in self.min.iter().zip(&self.max).enumerate() {
            if min >= max {
                return Err(Error::value(
                    "domain.box",
                    format!(
                        "the box has no volume: min {min:?} is not below max {max:?} along axis {axis}"
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn fill<T: Clone>(list: &mut Vec<T>, value: T, dimension: usize) {
    if list.is_empty() {
        list.resize(dimension, value);
    }
}

fn validate_half_spaces(rows: &[Vec<f64>], dimension: usize) -> Result<(), Error> {
    for (index, row) in rows.iter().enumerate() {
        let key = format!("domain.half_spaces[{index}]");
        if row.len() != dimension + 1 {
            let message = format!(
                "{} numbers where a normal of {dimension} and an offset are needed",
                row.len()
            );
            return Err(Error::value(key, message));
        }
        all_finite(&key, row)?;
        if row[..dimension].iter().all(|&n| n == 0.0) {
            return Err(Error::value(key, "the normal is zero"));
        }
    }
    if rows.len() <= dimension {
        let message = format!(
            "{} half-spaces bound no volume in {dimension} dimensions; give at least {}",
            rows.len(),
            dimension + 1
        );
        return Err(Error::value("domain.half_spaces", message));
    }
    Ok(())
}

fn validate_polygon(corners: &[Vec<f64>], dimension: usize) -> Result<(), Error> {
    const KEY: &str = "domain.polygon";
    if dimension != 2 {
        return Err(Error::value(
            KEY,
            "a polygon needs \"dimension\": 2 in the scene",
        ));
    }
    for (index, corner) in corners.iter().enumerate() {
        let key = format!("{KEY}[{index}]");
        dimensions_match(&key, corner.len(), 2)?;
        all_finite(&key, corner)?;
    }
    if corners.len() < 3 {
        return Err(Error::value(
            KEY,
            format!("{} corners bound no area", corners.len()),
        ));
    }
    let turns: Vec<f64> = (0..corners.len()).map(|at| turn(corners, at)).collect();
    if turns.iter().all(|&turn| turn == 0.0) {
        return Err(Error::value(
            KEY,
            "the polygon has no area: its corners lie on a line",
        ));
    }
    if let Some(at) = reflex_corner(&turns) {
        let message = format!(
            "the polygon is not convex at corner {at} {:?}; give the corners of its hull in order",
            corners[at]
        );
        return Err(Error::value(KEY, message));
    }
    Ok(())
}

/// Twice the signed area of corner `at` and its two neighbors.
fn turn(corners: &[Vec<f64>], at: usize) -> f64 {
    let count = corners.len();
    let (a, b, c) = (
        &corners[(at + count - 1) % count],
        &corners[at],
        &corners[(at + 1) % count],
    );
    (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
}

/// The first corner that turns against the first turn there is.
fn reflex_corner(turns: &[f64]) -> Option<usize> {
    let way = turns.iter().find(|&&turn| turn != 0.0)?.signum();
    turns.iter().position(|&turn| turn * way < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(corners: &[[f64; 2]]) -> Result<(), Error> {
        let corners = corners.iter().map(|corner| corner.to_vec()).collect();
        Domain::Polygon(corners).validate(2)
    }

    #[test]
    fn a_box_without_numbers_is_the_unit_box() {
        let mut domain = Domain::default();
        domain.fill_defaults(2);
        let expected = BoxDomain {
            min: vec![0.0, 0.0],
            max: vec![1.0, 1.0],
            periodic: vec![false, false],
        };
        assert_eq!(domain, Domain::Box(expected));
    }

    #[test]
    fn convex_polygons_pass_either_way_round() {
        polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]])
            .expect("counter-clockwise");
        polygon(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]).expect("clockwise");
    }

    #[test]
    fn a_polygon_with_a_dent_or_on_a_line_is_refused() {
        let dent = polygon(&[[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]]).unwrap_err();
        assert!(
            dent.to_string().contains("not convex at corner 2"),
            "{dent}"
        );
        let line = polygon(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]).unwrap_err();
        assert!(line.to_string().contains("no area"), "{line}");
    }

    #[test]
    fn a_flat_box_is_refused_with_its_axis() {
        let flat = BoxDomain {
            min: vec![0.0, 0.0, 0.0],
            max: vec![1.0, 0.0, 1.0],
            periodic: vec![false; 3],
        };
        let error = Domain::Box(flat).validate(3).unwrap_err().to_string();
        assert!(
            error.contains("no volume") && error.contains("axis 1"),
            "{error}"
        );
    }
}
