//! Wishes of a print: to stand on its contact, over a place, with its center at a target; or spin.

use nalgebra::{Point2, Point3, Vector3};

use crate::balance::conditions::{Condition, SpinAxis};
use crate::balance::spin::SpinState;
use crate::balance::support::{Ground, Support};
use crate::cli::failure::Failure;
use crate::cli::print_task::Task;
use crate::cli::print_weights::Weights;
use crate::cli::stand_text::polygon_on;
use crate::gcode::part::contacts;

/// Distances below this (mm) are met: E is written to 1e-5 mm.
const MET: f64 = 0.01;

/// A violation of --stable below this share of the moment is met.
const CONE_ROUNDING: f64 = 1e-9;

/// The share of the height that touches the ground where up is not the bed's.
const CONTACT: f64 = 0.01;

/// What is wanted.
#[derive(Clone, Debug)]
pub(crate) enum Wish {
    /// The center over a support or at a target, with a margin (mm) and on ground tilted by degrees.
    Stand {
        ground: Ground,
        support: Support,
        margin: f64,
        tilt: f64,
    },
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
        let wish = Self::stand(task)?;
        if let Self::Stand {
            ground,
            support,
            margin,
            tilt,
        } = &wish
        {
            let demands = support.demands(ground, *margin, tilt.to_radians().tan());
            demands.map_err(Failure::input)?;
        }
        Ok(wish)
    }

    /// On what touches the ground, a polygon, a place; or at a target.
    fn stand(task: &mut Task<'_>) -> Result<Self, Failure> {
        let options = task.options.balance.clone();
        let [margin, tilt] = [options.margin, options.tilt].map(Option::unwrap_or_default);
        let up = options.up.unwrap_or_else(Vector3::z);
        let bed = Point3::new(0.0, 0.0, task.part.ground);
        let mut ground = Ground::below(&up, std::iter::once(&bed)).map_err(Failure::input)?;
        if ground.up.z < 1.0 && options.target.is_none() {
            ground.height = contact(task, &ground, 0.0)?.0;
        }
        let support = match (options.target, options.point, &options.polygon) {
            (Some(target), ..) => Support::Target(target),
            (_, Some(point), _) => Support::Point(point.into()),
            (.., Some(file)) => polygon_on(&ground, file)?,
            _ => {
                let places = if ground.up.z >= 1.0 && options.contact.is_none() {
                    task.part.footprint.clone()
                } else {
                    contact(task, &ground, options.contact.unwrap_or(CONTACT))?.1
                };
                Support::hull(places).map_err(Failure::input)?
            }
        };
        Ok(Self::Stand {
            ground,
            support,
            margin,
            tilt,
        })
    }

    pub(crate) fn conditions(&self) -> Vec<Condition> {
        match self {
            Self::Stand {
                ground,
                support,
                margin,
                tilt,
            } => {
                // What cannot be demanded was refused when the wish was made.
                let demands = support.demands(ground, *margin, tilt.to_radians().tan());
                let demands = demands.unwrap_or_default().into_iter();
                demands.map(|(condition, _)| condition).collect()
            }
            Self::Spin { axis, center_at } => {
                let mut all = [axis.center_on(), axis.principal()].concat();
                all.extend(center_at.map(|height| axis.center_at(height)));
                all
            }
        }
    }

    /// The same on ground tilted by other degrees.
    pub(crate) fn tilted(&self, degrees: f64) -> Self {
        let mut wish = self.clone();
        if let Self::Stand { tilt, .. } = &mut wish {
            *tilt = degrees;
        }
        wish
    }

    pub(crate) fn note(&self) -> Option<String> {
        let Self::Stand {
            ground,
            support: Support::Polygon(corners),
            ..
        } = self
        else {
            return None;
        };
        let first = corners[0];
        let low = corners.iter().fold(first, |low, corner| low.inf(corner));
        let high = corners.iter().fold(first, |high, corner| high.sup(corner));
        Some(format!(
            "it stands on a polygon of {} corners from ({:.3}, {:.3}) to ({:.3}, {:.3}), at the height {:.3}",
            corners.len(),
            low.x,
            low.y,
            high.x,
            high.y,
            ground.height
        ))
    }

    /// How far the part is from it.
    pub(crate) fn state(&self, weights: &Weights) -> Option<WishState> {
        let body = weights.part?;
        let center = body.center_of_mass();
        Some(match self {
            Self::Stand {
                support: Support::Target(target),
                ..
            } => off(distance(&center, target)),
            Self::Stand {
                ground,
                support,
                margin,
                tilt,
            } => standing((ground, support), [*margin, *tilt], &center),
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

/// A center above a support, of which a margin (mm) and a tilt (degrees) are asked.
fn standing(
    (ground, support): (&Ground, &Support),
    [margin, tilt]: [f64; 2],
    center: &Point3<f64>,
) -> WishState {
    let [slack, tangent] = support.slack(ground, center).unwrap_or_default();
    if let Support::Point(_) = support {
        return off(-slack);
    }
    let degrees = tangent.atan().to_degrees();
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

/// The lowest height along up, and the places on the ground of what lies within a share of the part's height
/// above it.
fn contact(
    task: &mut Task<'_>,
    ground: &Ground,
    share: f64,
) -> Result<(f64, Vec<Point2<f64>>), Failure> {
    let infill = task.infill.clone();
    let (file, survey, given) = task.source()?;
    let found = contacts(file, survey, given, &infill, &ground.up, share);
    let (height, points) = found.map_err(Failure::input)?;
    let places = points.iter().map(|point| ground.shadow(point)).collect();
    Ok((height, places))
}

/// How far a place is from a target along the coordinates that this gives.
fn distance(place: &Point3<f64>, target: &[Option<f64>; 3]) -> f64 {
    let squares = (0..3).filter_map(|axis| Some((place[axis] - target[axis]?).powi(2)));
    squares.sum::<f64>().sqrt()
}
