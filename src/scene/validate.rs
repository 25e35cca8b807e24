//! Whether a scene's numbers make sense, before anything is computed.

use crate::scene::description::Scene;
use crate::scene::error::Error;

/// The largest order p: beyond it d∞^p underflows for cells of a thousandth of the domain.
const LARGEST_ORDER: u32 = 64;

/// Judges every number of a scene whose defaults are filled in.
///
/// # Errors
/// [`Error::Value`] with the key of the first one that makes no sense.
pub fn scene(scene: &Scene) -> Result<(), Error> {
    if !(2..=3).contains(&scene.dimension) {
        let message = format!("{} is neither 2 nor 3", scene.dimension);
        return Err(Error::value("dimension", message));
    }
    if !(1..=LARGEST_ORDER).contains(&scene.order) {
        let message = format!("{} is not between 1 and {LARGEST_ORDER}", scene.order);
        return Err(Error::value("order", message));
    }
    if scene.density.is_some() && scene.dimension != 3 {
        let message = "only domains in space have one; leave it out or set \"dimension\": 3";
        return Err(Error::value("density", message));
    }
    scene.domain.validate(scene.dimension)?;
    scene.sites.validate(scene.dimension)?;
    if let Some(frames) = &scene.frames {
        frames.validate(scene.dimension)?;
        if frames.is_per_site() && scene.coarse_to_fine.is_some_and(|levels| levels > 0) {
            let message = "every site has its own frame, so their number must not change; give 0";
            return Err(Error::value("coarse_to_fine", message));
        }
    }
    scene.method.validate(scene)
}

pub(crate) fn dimensions_match(key: &str, length: usize, dimension: usize) -> Result<(), Error> {
    if length == dimension {
        return Ok(());
    }
    let other = match length {
        2 | 3 => format!(" (or \"dimension\": {length} in the scene)"),
        _ => String::new(),
    };
    Err(Error::value(
        key,
        format!("{length} values where {dimension} are needed{other}"),
    ))
}

pub(crate) fn all_finite(key: &str, values: &[f64]) -> Result<(), Error> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(Error::value(key, format!("{value:?} is not finite"))),
        None => Ok(()),
    }
}
