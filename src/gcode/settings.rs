//! Filament's diameter and density, tool by tool, from the settings that slicers leave in comments.
//!
//! PrusaSlicer, OrcaSlicer and Bambu Studio list one value per tool (`; filament_diameter = 1.75,2.85`,
//! in headers with a colon). Cura writes the settings that were changed as one JSON text cut into lines
//! `;SETTING_3 …`, in which a tool's profile says its `position` and maybe `material_diameter = 2.85`,
//! and marks by `;FLAVOR:` the firmwares whose E counts mm³.

use std::f64::consts::PI;

use crate::gcode::comments::after;

/// The usual diameter (mm), where nothing else is said.
pub(crate) const USUAL_DIAMETER: f64 = 1.75;

/// Cura's settings are kept up to this many bytes.
const LONGEST: usize = 1 << 22;

/// One value per tool; a single one holds for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PerTool(Vec<Option<f64>>);

impl PerTool {
    /// Values above zero count as given.
    pub(crate) fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let given = |value: f64| (value > 0.0 && value.is_finite()).then_some(value);
        Self(values.into_iter().map(given).collect())
    }

    /// The value of tool `tool`.
    pub(crate) fn get(&self, tool: u32) -> Option<f64> {
        match &self.0[..] {
            [all] => *all,
            each => each.get(tool as usize).copied().flatten(),
        }
    }

    fn set(&mut self, tool: usize, value: f64) {
        if self.0.len() <= tool {
            self.0.resize(tool + 1, None);
        }
        self.0[tool] = (value > 0.0).then_some(value);
    }

    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Filament as the file, or the caller, says.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Filament {
    /// Diameters (mm).
    pub(crate) diameters: PerTool,
    /// Densities (g/cm³).
    pub(crate) densities: PerTool,
}

impl Filament {
    /// These values, and those of `other` for what has none.
    pub(crate) fn or(self, other: Self) -> Self {
        let or = |one: PerTool, other| if one.is_empty() { other } else { one };
        Self {
            diameters: or(self.diameters, other.diameters),
            densities: or(self.densities, other.densities),
        }
    }

    /// The cross-section of the filament of tool `tool` (mm²).
    pub(crate) fn section(&self, tool: u32) -> f64 {
        let diameter = self.diameters.get(tool).unwrap_or(USUAL_DIAMETER);
        PI * diameter * diameter / 4.0
    }
}

/// What the comments of a whole file say.
#[derive(Clone, Debug, Default)]
pub(crate) struct Settings {
    pub(crate) filament: Filament,
    /// Whether E counts mm³ from the start.
    pub(crate) volumetric: bool,
    /// Nozzles' diameters (mm).
    pub(crate) nozzles: PerTool,
    /// The share of space that sparse infill fills.
    pub(crate) filling: Option<f64>,
    /// Cura's settings, joined.
    cura: Vec<u8>,
}

impl Settings {
    /// Takes notice of a comment, given without its semicolon.
    pub(crate) fn notice(&mut self, comment: &[u8]) {
        let comment = comment.trim_ascii();
        if let Some(part) = comment.strip_prefix(b"SETTING_3 ") {
            if self.cura.len() + part.len() <= LONGEST {
                self.cura.extend_from_slice(part);
            }
        } else if let Some(flavor) = after(comment, "FLAVOR:") {
            self.volumetric |= matches!(flavor, b"UltiGCode" | b"Marlin(Volumetric)");
        } else if let Some(values) = setting(comment, "filament_diameter") {
            self.filament.diameters = list(values);
        } else if let Some(values) = setting(comment, "filament_density") {
            self.filament.densities = list(values);
        } else if let Some(value) = setting(comment, "use_volumetric_e") {
            self.volumetric |= value == b"1";
        } else if let Some(values) = setting(comment, "nozzle_diameter") {
            self.nozzles = list(values);
        } else if let Some(value) =
            setting(comment, "fill_density").or_else(|| setting(comment, "sparse_infill_density"))
        {
            self.filling = percent(&String::from_utf8_lossy(value));
        }
    }

    /// Reads Cura's settings, once all of the file has been seen.
    pub(crate) fn finish(&mut self) {
        let text = String::from_utf8_lossy(&self.cura).into_owned();
        self.cura = Vec::new();
        for profile in text.split("[general]").skip(1) {
            let value = |key: &str| -> Option<&str> {
                let rest = profile.split(&format!("{key} = ")).nth(1)?;
                rest.split(['\\', '"']).next()
            };
            if let Some(filling) = value("infill_sparse_density").and_then(percent) {
                self.filling = Some(self.filling.unwrap_or(0.0).max(filling));
            }
            let Some(diameter) = value("material_diameter").and_then(|text| text.parse().ok())
            else {
                continue;
            };
            match value("position").and_then(|text| text.parse::<usize>().ok()) {
                Some(tool) if tool < 64 => self.filament.diameters.set(tool, diameter),
                _ => self.filament.diameters = PerTool::new([diameter]),
            }
        }
    }
}

/// A share above zero, given in percent.
fn percent(text: &str) -> Option<f64> {
    let number: f64 = text.trim().trim_end_matches('%').parse().ok()?;
    let share = number / 100.0;
    (share > 0.0 && share <= 1.0).then_some(share)
}

/// The value of `key = value` or `key: value`.
fn setting<'a>(comment: &'a [u8], key: &str) -> Option<&'a [u8]> {
    let rest = after(comment, key)?;
    let value = rest.strip_prefix(b"=").or(rest.strip_prefix(b":"))?;
    Some(value.trim_ascii())
}

/// Numbers separated by commas or semicolons; what is no number counts as not given.
fn list(values: &[u8]) -> PerTool {
    let values = String::from_utf8_lossy(values);
    let number = |word: &str| word.trim().trim_matches('"').parse().unwrap_or(0.0);
    PerTool::new(values.split([',', ';']).map(number))
}
