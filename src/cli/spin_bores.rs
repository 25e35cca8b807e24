//! `chebloyd spin --find-bores`: the axes of a solid's cylindrical holes.

use serde::Serialize;

use crate::cli::failure::{Failure, print};
use crate::cli::options::Common;
use crate::cli::spin_solid::SpinSolid;
use crate::mesh::bores::{Bore, bores};

/// A hole as JSON.
#[derive(Debug, Serialize)]
struct BoreReport {
    point: [f64; 3],
    direction: [f64; 3],
    radius: f64,
    rms: f64,
    length: f64,
    /// The share of the circle.
    covered: f64,
    triangles: usize,
    /// For --axis.
    axis: String,
}

#[derive(Debug, Serialize)]
struct BoresReport {
    bores: Vec<BoreReport>,
}

impl From<&Bore> for BoreReport {
    fn from(bore: &Bore) -> Self {
        let (point, direction) = (bore.point, bore.direction);
        let numbers = point.iter().chain(&direction).map(f64::to_string);
        Self {
            point: point.into(),
            direction: direction.into(),
            radius: bore.radius,
            rms: bore.rms,
            length: bore.length,
            covered: bore.covered,
            triangles: bore.triangles,
            axis: numbers.collect::<Vec<_>>().join(","),
        }
    }
}

/// Prints the holes.
pub(crate) fn find_bores(solid: &SpinSolid, json: bool, common: Common) -> Result<(), Failure> {
    let found = bores(solid.domain.surface());
    let report = BoresReport {
        bores: found.iter().map(BoreReport::from).collect(),
    };
    if json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::run)?;
        return print(text + "\n");
    }
    if common.quiet {
        return Ok(());
    }
    if report.bores.is_empty() {
        return print("no cylindrical holes were found\n");
    }
    print(report.bores.iter().map(line).collect::<String>())
}

fn line(bore: &BoreReport) -> String {
    format!(
        "radius {:.6}, rms {:.1e}, length {:.6}, {:.0} % of the circle, {} triangles\n    --axis {}\n",
        bore.radius,
        bore.rms,
        bore.length,
        100.0 * bore.covered,
        bore.triangles,
        bore.axis
    )
}
