//! A site file by its extension.

use std::path::Path;

use nalgebra::Point;

use crate::scene::error::Error;
use crate::scene::site_file::{json, npy, text};

/// Reads the sites in `path`: `.csv`, `.npy`, `.xyz`, `.txt` or `.json`.
///
/// # Errors
/// [`Error::UnknownFormat`], [`Error::Read`], or what is wrong with the file and where.
pub fn sites<const D: usize>(path: &Path) -> Result<Vec<Point<f64, D>>, Error> {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.to_str() {
        Some("csv") => text::parse_csv::<D>,
        Some("xyz" | "txt") => text::parse_words::<D>,
        Some("json") => json::parse::<D>,
        Some("npy") => npy::parse::<D>,
        _ => {
            return Err(Error::UnknownFormat {
                path: path.to_owned(),
            });
        }
    };
    let bytes = std::fs::read(path).map_err(|source| Error::Read {
        path: path.to_owned(),
        source,
    })?;
    let sites = parse(&bytes, path)?;
    if sites.is_empty() {
        return Err(Error::File {
            path: path.to_owned(),
            message: "holds no sites".to_owned(),
        });
    }
    Ok(sites)
}
