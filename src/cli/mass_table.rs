//! Report of solids by `chebloyd mass`: properties, parts, groups, errors.

use std::path::PathBuf;

use serde::Serialize;

use crate::mass::body::Body;
use crate::mass::numeric::BodyErrors;

use crate::cli::mass_leaves::MassLeaf;
use crate::cli::mass_report::{AxisMoment, MassProperties, MassTotals, figure};
use crate::cli::mass_units::UnitFactors;

/// What is printed, in this order.
#[derive(Debug, Serialize)]
pub(crate) struct SolidReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<String>,
    #[serde(flatten)]
    properties: MassProperties,
    /// The largest of `error_estimates` as shares of mass, extent and the tensor's largest entry; only
    /// where a density has no closed integral.
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimate: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error_estimates: Option<ErrorEstimates>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts: Vec<MassPart>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
}

/// Bounds of the errors of properties.
#[derive(Debug, Serialize)]
struct ErrorEstimates {
    mass: f64,
    center_of_mass: f64,
    inertia_center: f64,
}

impl From<BodyErrors> for ErrorEstimates {
    fn from(errors: BodyErrors) -> Self {
        Self {
            mass: errors.mass,
            center_of_mass: errors.center,
            inertia_center: errors.inertia,
        }
    }
}

#[derive(Debug, Serialize)]
struct MassPart {
    file: String,
    /// Where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    density: Option<String>,
    #[serde(flatten)]
    totals: MassTotals,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    groups: Vec<MassGroup>,
}

#[derive(Debug, Serialize)]
struct MassGroup {
    name: String,
    density: String,
    #[serde(flatten)]
    totals: MassTotals,
}

/// Everything that is reported.
pub(crate) struct MassFigures<'a> {
    pub(crate) files: &'a [PathBuf],
    pub(crate) leaves: &'a [MassLeaf],
    pub(crate) bodies: &'a [Body],
    pub(crate) body: &'a Body,
    /// Per file its groups: name, density, body.
    pub(crate) rows: Vec<Vec<(String, String, Body)>>,
    pub(crate) errors: Option<BodyErrors>,
}

impl MassFigures<'_> {
    pub(crate) fn report(
        self,
        asked: (Option<AxisMoment>, Option<&str>),
        notes: Vec<String>,
        units: Option<(UnitFactors, String)>,
    ) -> SolidReport {
        let factors = units.as_ref().map(|(factors, _)| *factors);
        let shown = |body: &Body| factors.map_or(*body, |factors| factors.convert(body));
        let axis = asked.0.map(|axis| match factors {
            Some(factors) => axis.scaled(factors.length),
            None => axis,
        });
        let has_groups = self.rows.iter().any(|rows| !rows.is_empty());
        let are_parts = self.bodies.len() > 1 || has_groups;
        let parts = self
            .files
            .iter()
            .zip(self.bodies)
            .zip(&self.rows)
            .enumerate();
        let parts = parts.map(|(part, ((file, body), rows))| MassPart {
            file: file.display().to_string(),
            density: self.density_of(part),
            totals: (&shown(body)).into(),
            groups: (rows.iter())
                .map(|(name, density, body)| MassGroup {
                    name: name.clone(),
                    density: density.clone(),
                    totals: (&shown(body)).into(),
                })
                .collect(),
        });
        let errors = self.errors.map(|errors| match factors {
            Some(factors) => errors.in_units(factors.length, factors.mass),
            None => errors,
        });
        SolidReport {
            units: units.map_or_else(
                || asked.1.map(str::to_owned),
                |(_, sentence)| Some(sentence),
            ),
            properties: MassProperties::of(&shown(self.body), axis),
            error_estimate: errors.map(|errors| errors.relative),
            error_estimates: errors.map(ErrorEstimates::from),
            parts: if are_parts {
                parts.collect()
            } else {
                Vec::new()
            },
            notes,
        }
    }

    /// The density of a file that is one leaf.
    fn density_of(&self, part: usize) -> Option<String> {
        let mut leaves = self.leaves.iter().filter(|leaf| leaf.part == part);
        let only = leaves.next().filter(|leaf| leaf.group.is_none())?;
        Some(only.text.clone())
    }
}

impl SolidReport {
    pub(crate) fn table(&self) -> String {
        let mut text = self.properties.table();
        if let (Some(relative), Some(errors)) = (self.error_estimate, &self.error_estimates) {
            let relative = figure(relative);
            text += &format!("{:<24}{relative} (relative)\n", "error estimate");
            for (name, error) in [
                ("… of the mass", errors.mass),
                ("… of the center", errors.center_of_mass),
                ("… of the inertia", errors.inertia_center),
            ] {
                text += &format!("{name:<24}{}\n", figure(error));
            }
        }
        if let Some(units) = &self.units {
            text += &format!("{:<24}  {units}\n", "units");
        }
        text += &self.parts_table();
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}

impl SolidReport {
    /// A line for every part and every group; nothing where there is one part.
    fn parts_table(&self) -> String {
        let rows = self.part_rows();
        let widths = rows.iter().map(|(name, _)| name.chars().count());
        let Some(width) = widths.max().map(|widest| widest.max(24)) else {
            return String::new();
        };
        let mut text = format!(
            "{:<width$}{:>20}{:>20}{:>20}{:>60}  density\n",
            "part", "volume", "surface area", "mass", "center of mass"
        );
        for (name, figures) in rows {
            text += &format!("{name:<width$}{figures}\n");
        }
        text
    }

    /// The names of the parts and their groups, each with its figures.
    fn part_rows(&self) -> Vec<(String, String)> {
        let mut rows = Vec::new();
        for part in &self.parts {
            let density = part.density.as_deref().unwrap_or("(by groups)");
            rows.push((part.file.clone(), row(&part.totals, density)));
            for group in &part.groups {
                let name = format!("  {}", group.name);
                rows.push((name, row(&group.totals, &group.density)));
            }
        }
        rows
    }
}

/// A line of the table of parts and groups without its name.
fn row(totals: &MassTotals, density: &str) -> String {
    let area = totals.surface_area.map_or(String::new(), figure);
    let [volume, mass] = [totals.volume, totals.mass].map(figure);
    let center = totals.center_of_mass.map(figure).concat();
    format!("{volume}{area:>20}{mass}{center}  {density}")
}
