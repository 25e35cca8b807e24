//! `mesh.json`: what a mesh holds and how good it is, as an object, as a table, against limits.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use crate::complex::element::{CellElement, KINDS};
use crate::complex::face_geometry::MeshGeometry;
use crate::complex::quality::{MeasuredMesh, MeshQuality};

/// How many cells are of a kind, and their volume (L³).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(crate) struct KindShare {
    count: usize,
    volume: f64,
}

/// The object that `mesh.json` holds and `--json` prints.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct MeshReport {
    points: usize,
    faces: usize,
    cells: usize,
    patches: BTreeMap<String, usize>,
    kinds: BTreeMap<&'static str, KindShare>,
    volume: f64,
    non_orthogonality_max: f64,
    non_orthogonality_mean: f64,
    skewness_max: f64,
    skewness_wall_max: f64,
    bad_pyramids: usize,
    aspect_max: f64,
    flatness_min: f64,
    concave_cells: usize,
    edge_min: f64,
    face_min: f64,
    solid_volume: Option<f64>,
    scaled_jacobian_min: Option<f64>,
    scaled_jacobian_p5: Option<f64>,
    open_cells: usize,
    /// The definitions of quality.
    definitions: &'static str,
}

impl MeshReport {
    /// The report of a sound mesh that fills a solid of a known volume (L³), or an unknown one.
    #[must_use]
    pub(crate) fn new(measured: &MeasuredMesh<'_>, solid_volume: Option<f64>) -> Self {
        let mesh = measured.mesh;
        let quality = MeshQuality::of(measured);
        let jacobians = measured.scaled_jacobians();
        let patches = mesh.patches.iter();
        Self {
            points: mesh.points.len(),
            faces: mesh.face_count(),
            cells: mesh.cell_count,
            patches: patches
                .map(|patch| (patch.name.clone(), patch.count))
                .collect(),
            kinds: kinds(&measured.elements, &measured.geometry),
            volume: quality.volume,
            non_orthogonality_max: quality.non_orthogonality_max,
            non_orthogonality_mean: quality.non_orthogonality_mean,
            skewness_max: quality.skewness_max,
            skewness_wall_max: quality.skewness_wall_max,
            bad_pyramids: quality.bad_pyramids,
            aspect_max: quality.aspect_max,
            flatness_min: quality.flatness_min,
            concave_cells: quality.concave_cells,
            edge_min: quality.edge_min,
            face_min: quality.face_min,
            solid_volume,
            scaled_jacobian_min: jacobians.first().copied(),
            scaled_jacobian_p5: quantile(&jacobians, 0.05),
            open_cells: quality.open_cells,
            definitions: "OpenFOAM v1912 checkMesh",
        }
    }

    /// How many cells are of a kind, and their share of the volume (%).
    #[must_use]
    pub(crate) fn share(&self, kind: &str) -> (usize, f64) {
        let share = self.kinds.get(kind).copied().unwrap_or_default();
        (share.count, 100.0 * share.volume / self.volume)
    }

    /// The limits that are passed, one sentence each.
    #[must_use]
    pub(crate) fn beyond(&self, limits: &[MeshLimit]) -> Vec<String> {
        let measured = |limit: &MeshLimit| match limit.name {
            "nonorth" => self.non_orthogonality_max,
            "skew" => self.skewness_max,
            "pyramids" => self.bad_pyramids as f64,
            "aspect" => self.aspect_max,
            "concave" => self.concave_cells as f64,
            _ => self.open_cells as f64,
        };
        let passed = limits.iter().filter(|limit| measured(limit) > limit.most);
        let sentence = |limit: &MeshLimit| {
            format!(
                "{} is {}, above {}",
                limit.name,
                measured(limit),
                limit.most
            )
        };
        passed.map(sentence).collect()
    }

    /// The scaled Jacobians in words.
    fn jacobians(&self) -> String {
        match (self.scaled_jacobian_min, self.scaled_jacobian_p5) {
            (Some(least), Some(low)) => format!("{least:.3} min, {low:.3} at 5 %"),
            _ => "no hexahedra".to_owned(),
        }
    }

    /// The report as a table.
    #[must_use]
    pub(crate) fn table(&self) -> String {
        let mut text = format!(
            "{} cells, {} faces, {} points, volume {:.6e}\n",
            self.cells, self.faces, self.points, self.volume
        );
        for name in KINDS {
            let (count, percent) = self.share(name);
            if count > 0 {
                // Writing to a string does not fail.
                let _ = writeln!(
                    text,
                    "  {name:<12} {count:>9}  {percent:6.2} % of the volume"
                );
            }
        }
        let rows = [
            (
                "non-orthogonality (degrees)",
                format!(
                    "{:.3} max, {:.3} mean",
                    self.non_orthogonality_max, self.non_orthogonality_mean
                ),
            ),
            (
                "skewness",
                format!(
                    "{:.3} max, {:.3} at walls",
                    self.skewness_max, self.skewness_wall_max
                ),
            ),
            ("aspect ratio", format!("{:.3} max", self.aspect_max)),
            ("flatness of faces", format!("{:.6} min", self.flatness_min)),
            (
                "shortest edge, smallest face",
                format!("{:.3e}, {:.3e}", self.edge_min, self.face_min),
            ),
            ("scaled Jacobian of hexahedra", self.jacobians()),
            ("bad pyramids", self.bad_pyramids.to_string()),
            ("concave cells", self.concave_cells.to_string()),
            ("open cells", self.open_cells.to_string()),
        ];
        for (name, value) in rows {
            let _ = writeln!(text, "  {name:<29} {value}");
        }
        text
    }
}

fn kinds(elements: &[CellElement], geometry: &MeshGeometry) -> BTreeMap<&'static str, KindShare> {
    let mut kinds: BTreeMap<_, _> = KINDS.map(|name| (name, KindShare::default())).into();
    for (element, volume) in elements.iter().zip(&geometry.cell_volumes) {
        let share = kinds.entry(KINDS[element.kind()]).or_default();
        share.count += 1;
        share.volume += volume;
    }
    kinds
}

/// The quantile of ascending numbers, linear between them.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share * sorted.len().saturating_sub(1) as f64;
    let (low, rest) = (place.floor() as usize, place.fract());
    let first = *sorted.get(low)?;
    let second = sorted.get(low + 1).copied().unwrap_or(first);
    Some(first + rest * (second - first))
}

/// A limit on a measure of quality.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MeshLimit {
    name: &'static str,
    most: f64,
}

/// The names of limits.
const LIMITS: [&str; 6] = ["nonorth", "skew", "pyramids", "aspect", "concave", "open"];

impl std::str::FromStr for MeshLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, number) = text.split_once('=').unwrap_or((text, ""));
        let known = LIMITS.into_iter().find(|known| *known == name.trim());
        let most = number
            .trim()
            .parse::<f64>()
            .ok()
            .filter(|most| !most.is_nan());
        match (known, most) {
            (Some(name), Some(most)) => Ok(Self { name, most }),
            (None, _) => Err(format!("`{name}` is none of {}", LIMITS.join(", "))),
            (Some(name), None) => Err(format!("write a number: {name}=4")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_names_with_numbers() {
        let limit: MeshLimit = "skew=4".parse().expect("a limit");
        assert_eq!((limit.name, limit.most), ("skew", 4.0));
        assert!(
            "skewness=4"
                .parse::<MeshLimit>()
                .unwrap_err()
                .contains("skew,")
        );
        assert!("skew".parse::<MeshLimit>().unwrap_err().contains("skew=4"));
    }

    #[test]
    fn quantiles_lie_between_the_numbers() {
        assert_eq!(quantile(&[], 0.05), None);
        assert_eq!(quantile(&[2.0], 0.05), Some(2.0));
        assert_eq!(quantile(&[0.0, 1.0, 2.0], 0.25), Some(0.5));
    }
}
