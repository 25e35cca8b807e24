//! Mass properties as `chebloyd mass` prints them, for solids and for prints.

use nalgebra::{Matrix3, Point3, Vector3};
use serde::Serialize;

use crate::mass::body::Body;

/// What parts and the whole have in common.
#[derive(Debug, Serialize)]
pub(crate) struct MassTotals {
    pub(crate) volume: f64,
    /// Of prints none is known.
    pub(crate) surface_area: Option<f64>,
    pub(crate) mass: f64,
    pub(crate) center_of_mass: [f64; 3],
}

impl From<&Body> for MassTotals {
    fn from(body: &Body) -> Self {
        Self {
            volume: body.volume,
            surface_area: Some(body.surface_area),
            mass: body.mass,
            center_of_mass: body.center_of_mass().into(),
        }
    }
}

/// Mass, center of mass and inertia.
#[derive(Debug, Serialize)]
pub(crate) struct MassProperties {
    #[serde(flatten)]
    pub(crate) totals: MassTotals,
    inertia_origin: [[f64; 3]; 3],
    inertia_center: [[f64; 3]; 3],
    principal_moments: [f64; 3],
    /// One axis per row, in the order of the moments.
    principal_axes: [[f64; 3]; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    moment_about_axis: Option<f64>,
}

/// A line in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisMoment {
    pub(crate) through: Point3<f64>,
    pub(crate) along: Vector3<f64>,
}

impl MassProperties {
    /// Of `body`, and its moment about `axis`.
    pub(crate) fn of(body: &Body, axis: Option<AxisMoment>) -> Self {
        let principal = body.principal();
        Self {
            totals: body.into(),
            inertia_origin: rows(&body.inertia_origin()),
            inertia_center: rows(&body.inertia_center()),
            principal_moments: principal.moments.into(),
            principal_axes: principal.axes.map(Into::into),
            moment_about_axis: axis.map(|axis| body.moment_about_axis(&axis.through, &axis.along)),
        }
    }

    /// A line for every property.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, numbers: &[f64]| {
            let numbers: String = numbers.iter().map(|&number| figure(number)).collect();
            text += &format!("{name:<24}{numbers}\n");
        };
        let totals = &self.totals;
        line("volume", &[totals.volume]);
        if let Some(area) = totals.surface_area {
            line("surface area", &[area]);
        }
        line("mass", &[totals.mass]);
        line("center of mass", &totals.center_of_mass);
        let tensors = [
            ("inertia about origin", &self.inertia_origin),
            ("inertia about center", &self.inertia_center),
        ];
        for (name, [first, second, third]) in tensors {
            line(name, first);
            line("", second);
            line("", third);
        }
        line("principal moments", &self.principal_moments);
        for (name, axis) in ["principal axes", "", ""].iter().zip(&self.principal_axes) {
            line(name, axis);
        }
        if let Some(moment) = self.moment_about_axis {
            line("moment about the axis", &[moment]);
        }
        text
    }
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
}

/// A number in 20 columns, ten digits of it.
pub(crate) fn figure(number: f64) -> String {
    let size = number.abs();
    let shown = if size > 0.0 && !(1e-3..1e9).contains(&size) {
        format!("{number:.9e}")
    } else {
        let leading = if size > 0.0 {
            size.log10().floor()
        } else {
            0.0
        };
        format!("{number:.*}", (9.0 - leading) as usize)
    };
    format!("{shown:>20}")
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("a positive number is needed".into()),
    }
}

pub(crate) fn axis(text: &str) -> Result<AxisMoment, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| {
            number
                .trim()
                .parse::<f64>()
                .ok()
                .filter(|number| number.is_finite())
        })
        .collect::<Option<_>>()
        .ok_or("six numbers separated by commas are needed")?;
    let &[px, py, pz, dx, dy, dz] = &numbers[..] else {
        return Err(format!("six numbers are needed, not {}", numbers.len()));
    };
    let (through, along) = (Point3::new(px, py, pz), Vector3::new(dx, dy, dz));
    if along.norm() > 0.0 && along.norm().is_finite() {
        Ok(AxisMoment { through, along })
    } else {
        Err("the direction (the last three numbers) has no length".into())
    }
}
