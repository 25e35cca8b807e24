//! The weight of a print, its infill apart, and how full that is.

use nalgebra::Point3;
use serde::Serialize;

use crate::gcode::infill::InfillTypes;
use crate::gcode::labels::is_part;
use crate::gcode::weigh::Weighed;
use crate::geometry::moments::Moments;
use crate::mass::body::Body;

/// The share of space that infill fills, and where it is known from.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Filling {
    pub(crate) share: Option<f64>,
    pub(crate) source: &'static str,
}

impl Filling {
    /// What is given stands above what the file says, and that above what was measured.
    pub(crate) fn of(given: Option<f64>, said: Option<f64>, measured: Option<f64>) -> Self {
        let known = [
            (given, "by --filling"),
            (said, "by the file's settings"),
            (measured, "as measured"),
        ];
        let found = known.into_iter().find(|(share, _)| share.is_some());
        let (share, source) = found.unwrap_or((None, "unknown"));
        Self { share, source }
    }

    /// The multiplier that fills all space.
    pub(crate) fn limit(&self) -> f64 {
        self.share.map_or(f64::INFINITY, |share| 1.0 / share)
    }
}

/// The part, and its infill alone; `None` without volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Weights {
    pub(crate) part: Option<Body>,
    pub(crate) infill: Option<Body>,
}

impl Weights {
    /// Of moments measured from `near`.
    pub(crate) fn of(fixed: &Moments, infill: &Moments, near: &Point3<f64>) -> Self {
        let body = |moments: Moments| {
            (moments.mass > 0.0).then(|| Body::from_moments(moments.mass, 0.0, &moments, near))
        };
        Self {
            part: body(*fixed + *infill),
            infill: body(*infill),
        }
    }

    /// Of a file that was weighed.
    pub(crate) fn read_back(weighed: &Weighed, types: &InfillTypes, near: &Point3<f64>) -> Self {
        let (mut fixed, mut infill) = (Moments::default(), Moments::default());
        let to_near = weighed.near - near;
        for deposit in &weighed.deposits {
            let name = &weighed.types.list()[deposit.kind];
            let moments = deposit.moments.translated(&to_near);
            if types.has(name) {
                infill += moments;
            } else if is_part(name) {
                fixed += moments;
            }
        }
        Self::of(&fixed, &infill, near)
    }
}
