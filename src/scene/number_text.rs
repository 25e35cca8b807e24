//! Coordinates from the text of a site file.

/// The axes as files and messages name them.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// The coordinate along `axis` that `field` says.
///
/// # Errors
/// A sentence about a text that is no finite number.
pub(crate) fn number(field: &str, axis: &str) -> Result<f64, String> {
    match field.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("{axis} is {field}; sites need finite coordinates")),
        Err(_) => Err(format!("{axis} is `{field}`, which is not a number")),
    }
}
