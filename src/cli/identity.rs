//! The identity of a run: checksums of its scene with the files that it names, and of its first sites.
//!
//! `run.json` and the checkpoint hold it, so that no run goes on with another one's files. How many moves
//! a run makes at most and when it stops may change from one resumption to the next; all else may not.

use nalgebra::{Point, Point3};
use serde_json::Value;

use crate::cli::failure::Failure;
use crate::export::run::checksum::Checksum;
use crate::relax::ranks::Ranks;
use crate::scene::description::Scene;

/// Keys of a method that `--resume` may change.
const CHANGEABLE: [&str; 2] = ["iterations", "tolerance"];

/// The identity of a run of `scene` that begins with `sites`: two sums of 16 hexadecimal digits.
pub(crate) fn identity<const D: usize>(
    scene: &Scene,
    sites: &[Point<f64, D>],
) -> Result<String, Failure> {
    Ok(format!("{}-{}", of_scene(scene)?, of_sites(sites)))
}

/// The part of an identity that tells scenes apart, with the content of the files that they name but
/// for the sites'.
pub(crate) fn of_scene(scene: &Scene) -> Result<String, Failure> {
    let mut value = serde_json::to_value(scene).map_err(Failure::run)?;
    let methods = value.get_mut("method").and_then(Value::as_object_mut);
    for method in methods.into_iter().flat_map(|methods| methods.values_mut()) {
        if let Some(keys) = method.as_object_mut() {
            keys.retain(|key, _| !CHANGEABLE.contains(&key.as_str()));
        }
    }
    // How pictures are colored, and how often a run is kept, makes no other run.
    if let Some(output) = value.get_mut("output").and_then(Value::as_object_mut) {
        output.remove("range");
        output.remove("checkpoint");
    }
    let mut checksum = Checksum::default();
    checksum.add_bytes(value.to_string().as_bytes());
    for file in scene.domain_files() {
        let bytes = std::fs::read(&file)
            .map_err(|error| Failure::input(format!("cannot read {}: {error}", file.display())))?;
        checksum.add(bytes.len() as u64);
        checksum.add_bytes(&bytes);
    }
    Ok(format!("{:016x}", checksum.sum()))
}

/// The part of an identity that tells first sites apart.
pub(crate) fn of_sites<const D: usize>(sites: &[Point<f64, D>]) -> String {
    let mut checksum = Checksum::default();
    checksum.add(sites.len() as u64);
    for coordinate in sites.iter().flat_map(|site| site.iter()) {
        checksum.add(coordinate.to_bits());
    }
    format!("{:016x}", checksum.sum())
}

/// The same of sites of which every rank has a part, in the order of the ranks.
pub(crate) fn of_parts(ranks: &dyn Ranks, count: usize, own: &[Point3<f64>]) -> String {
    let mut checksum = Checksum::default();
    checksum.add(count as u64);
    for rank in 0..ranks.size() {
        let mut sum = checksum;
        if rank == ranks.rank() {
            let coordinates = own.iter().flat_map(|site| site.iter());
            coordinates.for_each(|coordinate| sum.add(coordinate.to_bits()));
        }
        let sums = ranks.share(vec![sum.sum()]);
        checksum = Checksum::going_on(sums[rank].first().copied().unwrap_or_default());
    }
    format!("{:016x}", checksum.sum())
}
