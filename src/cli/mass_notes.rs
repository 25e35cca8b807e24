//! Notes about the parts that `chebloyd mass` weighs: repairs, common volume, negative density.

use std::path::PathBuf;

use nalgebra::{Point3, Vector3};

use crate::domain::density_sign::refused_place;
use crate::geometry::bounds::Bounds;
use crate::mass::density::SolidDensity;
use crate::mass::sign::{DensityAt, negative_place};
use crate::mesh::parts::{SharedVolume, shared_volume};
use crate::mesh::report::brief;
use crate::mesh::validate::Solid;
use crate::scene::field::{Field, GivenField, shape};

/// What was found in each part, and what they have in common.
pub(crate) fn notes_of_parts(files: &[PathBuf], solids: &[Solid]) -> Vec<String> {
    let of_parts = files.iter().zip(solids).flat_map(|(file, solid)| {
        let notes = solid.notes().into_iter();
        notes.map(|note| format!("{}: {note}", file.display()))
    });
    let mut notes: Vec<String> = of_parts.collect();
    if let Some(SharedVolume {
        volume,
        place,
        parts,
    }) = shared_volume(solids)
    {
        let names: Vec<_> = parts
            .iter()
            .map(|&part| files[part].display().to_string())
            .collect();
        let [x, y, z] = place.coords.into();
        notes.push(format!(
            "{} overlap: a volume of {} around ({}, {}, {}) counts more than once; cut one of \
             them with a Boolean difference",
            names.join(" and "),
            brief(volume),
            brief(x),
            brief(y),
            brief(z)
        ));
    }
    notes
}

/// Where densities are negative in parts.
pub(crate) fn negative_notes(
    files: &[PathBuf],
    solids: &[&Solid],
    densities: &[&GivenField],
    extent: &Bounds<3>,
) -> Vec<String> {
    let parts = files.iter().zip(solids.iter().zip(densities));
    let notes = parts.filter_map(|(file, (solid, density))| {
        let note = negative_note(solid, &density.field, extent)?;
        Some(format!("{}: {note}", file.display()))
    });
    notes.collect()
}

/// Where the density is negative in a part, if it is.
fn negative_note(solid: &Solid, field: &Field, extent: &Bounds<3>) -> Option<String> {
    let (place, value) = match field {
        Field::Solid(SolidDensity::Polynomial(polynomial)) => {
            let shape = shape(solid).ok()?;
            refused_place(&shape, polynomial).filter(|(_, value)| *value < 0.0)
        }
        Field::Solid(density) => negative_place(solid, density, extent),
        Field::Cells { sites, values } => least(sites, values),
        Field::Vertices(values) => match solid {
            Solid::Surface(..) => None,
            Solid::Tets(sound, _) => least(&sound.mesh().vertices, values),
        },
        Field::Tets(values) => match solid {
            Solid::Surface(..) => None,
            Solid::Tets(sound, _) => {
                let corners = sound.mesh().all_corners();
                let middle = |four: [Point3<f64>; 4]| {
                    Point3::from(
                        four.iter()
                            .map(|corner| corner.coords / 4.0)
                            .sum::<Vector3<f64>>(),
                    )
                };
                least(&corners.map(middle).collect::<Vec<_>>(), values)
            }
        },
        Field::Radial(_) | Field::Formula(_) | Field::Sampled(_) => {
            let density = field.function(solid, extent).ok()?;
            let vertices = match solid {
                Solid::Surface(closed, _) => &closed.mesh().vertices,
                Solid::Tets(sound, _) => &sound.mesh().vertices,
            };
            let values: Vec<f64> = vertices.iter().map(&density).collect();
            least(vertices, &values)
        }
    }?;
    let [x, y, z] = <[f64; 3]>::from(place);
    Some(format!(
        "the density is {value} at ({x}, {y}, {z}) in the body; what is negative counts as negative mass"
    ))
}

/// The place of the least of values, if that is negative.
fn least(places: &[Point3<f64>], values: &[f64]) -> Option<DensityAt> {
    let pairs = places.iter().copied().zip(values.iter().copied());
    let least = pairs.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least.1 < 0.0).then_some(least)
}
