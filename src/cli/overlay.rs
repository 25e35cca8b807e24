//! Points to be drawn upon curves: CSV files of iterations, energies and movements.

use std::path::Path;

use crate::cli::failure::Failure;
use crate::plot::series::Overlay;

/// The columns that an overlay may have.
const COLUMNS: [&str; 3] = ["iteration", "energy_percent", "movement_percent"];

/// The points of a CSV file whose header names its columns; empty fields are no points.
pub(crate) fn read_overlay(path: &Path) -> Result<Overlay, Failure> {
    let shown = path.display();
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("cannot read {shown}: {error}")))?;
    let lines = text.lines().enumerate();
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let header = lines.next().map_or("", |(_, line)| line);
    let places = COLUMNS.map(|column| header.split(',').position(|name| name.trim() == column));
    if places[0].is_none() {
        return Err(Failure::input(format!(
            "{shown} has no column `iteration`: its first line must name the columns, such as {}",
            COLUMNS.join(",")
        )));
    }
    let stem = path.file_stem().unwrap_or_default();
    let mut overlay = Overlay {
        name: stem.to_string_lossy().into_owned(),
        ..Overlay::default()
    };
    for (number, line) in lines {
        let added = add_line(&mut overlay, places, line);
        added.map_err(|fault| Failure::input(format!("{shown}:{}: {fault}", number + 1)))?;
    }
    if overlay.energy.is_empty() && overlay.movement.is_empty() {
        return Err(Failure::input(format!(
            "{shown} holds no energies and no movements: it needs a column `energy_percent` or \
             `movement_percent`"
        )));
    }
    Ok(overlay)
}

/// Adds the points of a line whose columns are at `places`.
fn add_line(overlay: &mut Overlay, places: [Option<usize>; 3], line: &str) -> Result<(), String> {
    let fields: Vec<&str> = line.split(',').map(str::trim).collect();
    let value = |place: Option<usize>| -> Result<Option<f64>, String> {
        let field = place.and_then(|place| fields.get(place)).copied();
        let Some(field) = field.filter(|field| !field.is_empty()) else {
            return Ok(None);
        };
        let value = field.parse::<f64>().ok().filter(|value| value.is_finite());
        let refused = || format!("`{field}` is no finite number");
        value.map(Some).ok_or_else(refused)
    };
    let [iteration, energy, movement] = places.map(value);
    let (iteration, energy, movement) = (iteration?, energy?, movement?);
    let iteration = iteration.filter(|iteration| *iteration >= 0.0);
    let iteration = iteration.ok_or("there is no iteration of zero or more")?;
    overlay
        .energy
        .extend(energy.map(|value| (iteration, value)));
    let moved = movement.filter(|value| *value > 0.0);
    overlay
        .movement
        .extend(moved.map(|value| (iteration, value)));
    Ok(())
}
