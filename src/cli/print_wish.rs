//! Wishes of a print: to stand on its contact, over a place, with its center at a target; or spin.

use std::path::Path;

use nalgebra::{Point2, Point3, Vector3};

use crate::balance::conditions::{Condition, SpinAxis};
use crate::balance::spin::SpinState;
use crate::balance::support::{Support, Upright};
use crate::cli::failure::Failure;
use crate::cli::print_options::numbers;
use crate::cli::print_task::Task;
use crate::cli::print_weights::Weights;
use crate::gcode::part::contacts;

/// Distances below this (mm) are met: E is written to 1e-5 mm.
const MET: f64 = 0.01;

/// A violation of --stable below this share of the moment is met.
const CONE_ROUNDING: f64 = 1e-9;

/// What is wanted.
#[derive(Clone, Debug)]
pub(crate) enum Wish {
    /// The center over a polygon, with a margin (mm) and on ground tilted by degrees.
    Stand(Support, [f64; 2]),
    /// The center over a place.
    Over(Upright, Point2<f64>),
    /// The center's coordinates.
    Target([Option<f64>; 3]),
    /// The center on an axis that is principal.
    Spin {
        axis: SpinAxis,
        center_at: Option<f64>,
    },
}

/// How far a part is from what is wanted.
#[derive(Clone, Debug)]
pub(crate) struct WishState {
    /// Whether it does what is wanted, up to rounding.
    pub(crate) holds: bool,
    /// Named figures, in this order.
    pub(crate) figures: Vec<(&'static str, f64)>,
}

impl Wish {
    /// What the options ask for.
    pub(crate) fn of(task: &mut Task<'_>) -> Result<Self, Failure> {
        let options = &task.options.balance;
        if let Some(line) = options.axis.filter(|_| options.spin) {
            let axis = SpinAxis::new(&line.through, &line.along);
            let axis = axis.ok_or_else(|| Failure::input("--axis: the direction has no length"))?;
            let center_at = options.center_at;
            return Ok(Self::Spin { axis, center_at });
        }
        if let Some(target) = options.target {
            return Ok(Self::Target(target));
        }
        let upright = Upright::new(&options.up.unwrap_or_else(Vector3::z));
        let upright = upright.ok_or_else(|| Failure::input("--up: the direction has no length"))?;
        match options.point {
            Some(point) => Ok(Self::Over(upright, point.into())),
            None => Self::stand(task, upright),
        }
    }

    /// On a polygon.
    fn stand(task: &mut Task<'_>, upright: Upright) -> Result<Self, Failure> {
        let options = &task.options.balance;
        let is_bed = upright.up.z >= 1.0;
        let (ground, places) = match (&options.polygon, options.contact) {
            (Some(file), _) => (lowest(task, &upright)?, polygon(file)?),
            (None, None) if is_bed => (task.part.ground, task.part.footprint.clone()),
            (None, share) => touching(task, &upright, share.unwrap_or(0.01))?,
        };
        let support = Support::new(upright, ground, &places).ok_or_else(|| {
            Failure::input(
                "what touches the ground has no area; give --contact a larger share, a --polygon, or a \
                 --point",
            )
        })?;
        let [margin, tilt] = [options.margin, options.tilt].map(Option::unwrap_or_default);
        Ok(Self::Stand(support, [margin, tilt]))
    }

    pub(crate) fn conditions(&self) -> Vec<Condition> {
        match self {
            Self::Stand(support, [margin, tilt]) => support.conditions(*margin, *tilt),
            Self::Over(upright, place) => upright.over(place),
            Self::Target(target) => {
                let fixed = (0..3).filter_map(|place| Some((place, target[place]?)));
                let level = |(place, value): (usize, f64)| {
                    let direction = Vector3::ith(place, 1.0);
                    Condition::center_level(&Point3::from(direction * value), &direction)
                };
                fixed.map(level).collect()
            }
            Self::Spin { axis, center_at } => {
                let mut all = [axis.center_on(), axis.principal()].concat();
                all.extend(center_at.map(|height| axis.center_at(height)));
                all
            }
        }
    }

    pub(crate) fn note(&self) -> Option<String> {
        let Self::Stand(support, _) = self else {
            return None;
        };
        let corners = support.corners.iter();
        let low = corners
            .clone()
            .fold(support.corners[0], |low, corner| low.inf(corner));
        let high = corners.fold(support.corners[0], |high, corner| high.sup(corner));
        Some(format!(
            "it stands on a polygon of {} corners from ({:.3}, {:.3}) to ({:.3}, {:.3}), at the height {:.3}",
            support.corners.len(),
            low.x,
            low.y,
            high.x,
            high.y,
            support.ground
        ))
    }

    /// How far the part is from it.
    pub(crate) fn state(&self, weights: &Weights) -> Option<WishState> {
        let body = weights.part?;
        let center = body.center_of_mass();
        Some(match self {
            Self::Stand(support, wanted) => standing(support, *wanted, &center),
            Self::Over(upright, place) => off(((upright.flat(&center)) - place).norm()),
            Self::Target(target) => {
                let squares =
                    (0..3).filter_map(|axis| Some((center[axis] - target[axis]?).powi(2)));
                off(squares.sum::<f64>().sqrt())
            }
            Self::Spin { axis, center_at } => {
                let height = center_at.map_or(0.0, |height| axis.height(&center) - height);
                spinning(&SpinState::about(body, axis), height)
            }
        })
    }

    /// The half-space of the cone of --stable that the part violates most: the axis's moment exceeds all
    /// others by `share` of them.
    pub(crate) fn cut(&self, weights: &Weights, share: f64) -> Option<Condition> {
        let (Self::Spin { axis, .. }, body) = (self, weights.part?) else {
            return None;
        };
        let (excess, angle) = SpinState::about(body, axis).instability(axis, share);
        let there = axis.moved_to(axis.height(&body.center_of_mass()));
        (excess > CONE_ROUNDING).then(|| there.stable_against(angle, share))
    }
}

/// A center above a polygon, of which a margin (mm) and a tilt (degrees) are asked.
fn standing(support: &Support, [margin, tilt]: [f64; 2], center: &Point3<f64>) -> WishState {
    let [slack, degrees] = support.slack(center);
    WishState {
        holds: slack >= margin - MET && (tilt <= 0.0 || degrees >= tilt - MET),
        figures: vec![("slack", slack), ("tilt degrees", degrees)],
    }
}

/// A part that spins, its center `height` (mm) beyond where it should be on the axis.
fn spinning(state: &SpinState, height: f64) -> WishState {
    let (distance, angle) = (state.distance, state.angle_degrees);
    WishState {
        holds: distance <= MET && angle <= MET && height.abs() <= MET,
        figures: vec![("distance", distance), ("angle degrees", angle)],
    }
}

/// A center so far from where it should be.
fn off(distance: f64) -> WishState {
    WishState {
        holds: distance <= MET,
        figures: vec![("distance", distance)],
    }
}

/// The lowest place of the part.
fn lowest(task: &mut Task<'_>, upright: &Upright) -> Result<f64, Failure> {
    Ok(touching(task, upright, 0.0)?.0)
}

/// The ground, and the places of what lies within a share of the height above it.
fn touching(
    task: &mut Task<'_>,
    upright: &Upright,
    share: f64,
) -> Result<(f64, Vec<Point2<f64>>), Failure> {
    let infill = task.infill.clone();
    let (file, survey, given) = task.source()?;
    let found = contacts(file, survey, given, &infill, &upright.up, share);
    let (ground, points) = found.map_err(Failure::input)?;
    Ok((
        ground,
        points.iter().map(|point| upright.flat(point)).collect(),
    ))
}

/// `x,y` lines; a first line without numbers names the columns.
fn polygon(file: &Path) -> Result<Vec<Point2<f64>>, Failure> {
    let path = file.display();
    let text = std::fs::read_to_string(file)
        .map_err(|error| Failure::input(format!("{path}: cannot be read: {error}")))?;
    let mut places = Vec::new();
    for (line, text) in text.lines().enumerate() {
        if text.trim().is_empty() || text.trim_start().starts_with('#') {
            continue;
        }
        match numbers(text).as_deref() {
            Ok([x, y, ..]) => places.push(Point2::new(*x, *y)),
            _ if line == 0 => {}
            _ => {
                let line = line + 1;
                return Err(Failure::input(format!(
                    "{path}: line {line}: `x,y` is needed"
                )));
            }
        }
    }
    if places.len() < 3 {
        return Err(Failure::input(format!(
            "{path}: a polygon needs three corners"
        )));
    }
    Ok(places)
}
