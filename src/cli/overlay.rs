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
    let [Some(_), _, _] = places else {
        return Err(Failure::input(format!(
            "{shown} has no column `iteration`: its first line must name the columns, such as \
             iteration,energy_percent,movement_percent"
        )));
    };
    let mut overlay = Overlay {
        name: path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        ..Overlay::default()
    };
    for (number, line) in lines {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let value = |place: Option<usize>| -> Result<Option<f64>, Failure> {
            let field = place.and_then(|place| fields.get(place)).copied();
            let Some(field) = field.filter(|field| !field.is_empty()) else {
                return Ok(None);
            };
            let value = field.parse::<f64>().ok().filter(|value| value.is_finite());
            value.map(Some).ok_or_else(|| {
                let line = number + 1;
                Failure::input(format!("{shown}:{line}: `{field}` is no finite number"))
            })
        };
        let [iteration, energy, movement] = places.map(value);
        let (iteration, energy, movement) = (iteration?, energy?, movement?);
        let Some(iteration) = iteration.filter(|iteration| *iteration >= 0.0) else {
            let line = number + 1;
            let message = format!("{shown}:{line}: there is no iteration of zero or more");
            return Err(Failure::input(message));
        };
        overlay
            .energy
            .extend(energy.map(|value| (iteration, value)));
        let moved = movement.filter(|value| *value > 0.0);
        overlay
            .movement
            .extend(moved.map(|value| (iteration, value)));
    }
    if overlay.energy.is_empty() && overlay.movement.is_empty() {
        return Err(Failure::input(format!(
            "{shown} holds no energies and no movements: it needs a column `energy_percent` or \
             `movement_percent`"
        )));
    }
    Ok(overlay)
}
