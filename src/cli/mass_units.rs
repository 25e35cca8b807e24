//! Units of mass properties: lengths and densities of the input, and SI.

use crate::mass::body::Body;

use crate::cli::failure::Failure;

/// Lengths by their names, in meters.
const LENGTHS: [(&str, f64); 8] = [
    ("m", 1.0),
    ("dm", 0.1),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("nm", 1e-9),
    ("in", 0.0254),
    ("ft", 0.3048),
];

/// Densities by their names, in kg/m³; the pound is 0.45359237 kg.
pub(crate) const DENSITIES: [(&str, f64); 7] = [
    ("kg/m3", 1.0),
    ("g/cm3", 1e3),
    ("g/mm3", 1e6),
    ("kg/mm3", 1e9),
    ("t/mm3", 1e12),
    ("lb/in3", 0.453_592_37 / (0.0254 * 0.0254 * 0.0254)),
    ("lb/ft3", 0.453_592_37 / (0.3048 * 0.3048 * 0.3048)),
];

/// How figures become SI: factors of the file's lengths and of masses in density times volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UnitFactors {
    /// Meters per length of the file.
    pub(crate) length: f64,
    /// Kilograms per density times the third power of the file's length.
    pub(crate) mass: f64,
}

impl UnitFactors {
    /// The factors where SI is asked for, and the sentence about them.
    ///
    /// # Errors
    /// Where the lengths have no known unit.
    pub(crate) fn of(units: Option<&str>, density: &str) -> Result<(Self, String), Failure> {
        let known = LENGTHS.map(|(name, _)| name).join(", ");
        let Some(units) = units else {
            let message = format!("--si needs the unit of the file's lengths: --units {known}");
            return Err(Failure::input(message));
        };
        let length = LENGTHS.iter().find(|(name, _)| *name == units.trim());
        let &(name, length) = length.ok_or_else(|| {
            Failure::input(format!(
                "--si cannot convert from --units `{units}`; it knows {known}"
            ))
        })?;
        let factor = DENSITIES.iter().find(|(name, _)| *name == density);
        let factor = factor.map_or(1.0, |&(_, factor)| factor);
        let mass = factor * length.powi(3);
        let sentence = format!(
            "SI: m, m², m³, kg, kg·m² (lengths of the files in {name}, densities in {density}, masses \
             given in kg)"
        );
        Ok((Self { length, mass }, sentence))
    }

    /// A body in SI.
    pub(crate) fn convert(&self, body: &Body) -> Body {
        body.in_units(self.length, self.mass)
    }
}
