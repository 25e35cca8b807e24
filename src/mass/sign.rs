//! Places in a body at which a density that is linear between vertices is negative.
//!
//! Ramps and vertex data are least at a vertex, profiles at a vertex or where an edge passes a break.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::geometry::bounds::Bounds;
use crate::mass::density::SolidDensity;
use crate::mass::linear_pieces::field;
use crate::mass::profile::Profile;
use crate::mesh::validate::Solid;

/// A place of the body and the density there.
pub(crate) type DensityAt = (Point3<f64>, f64);

/// The place of the least density if that is negative; `extent` is the whole body's box, over which
/// ramps run. None for polynomials, which may be least anywhere.
pub(crate) fn negative_place(
    solid: &Solid,
    density: &SolidDensity,
    extent: &Bounds<3>,
) -> Option<DensityAt> {
    let vertices = match solid {
        Solid::Surface(closed, _) => &closed.mesh().vertices,
        Solid::Tets(sound, _) => &sound.mesh().vertices,
    };
    let first = *vertices.first()?;
    match density {
        SolidDensity::Constant(value) => negative([(first, *value)].into_iter()),
        SolidDensity::Polynomial(_) => None,
        SolidDensity::Ramp(ramp) => {
            let linear = ramp.over(extent, &first);
            let at = |vertex: &Point3<f64>| linear.value + linear.gradient.dot(&(vertex - first));
            negative(vertices.iter().map(|vertex| (*vertex, at(vertex))))
        }
        SolidDensity::Profile(profile) => {
            let at_vertices = vertices.iter().map(|it| (*it, profile.at_point(it)));
            let simplices: Vec<&[u32]> = match solid {
                Solid::Surface(closed, _) => {
                    closed.mesh().triangles.iter().map(|t| &t[..]).collect()
                }
                Solid::Tets(sound, _) => sound.mesh().tets.iter().map(|t| &t[..]).collect(),
            };
            let edges = simplices.into_iter().flat_map(|corners| {
                let pairs = (0..corners.len()).flat_map(move |j| (0..j).map(move |i| [i, j]));
                pairs.map(|pair| pair.map(|corner| vertices[corners[corner] as usize]))
            });
            let at_breaks = edges.flat_map(|edge| on_breaks(profile, &edge));
            negative(at_vertices.chain(at_breaks))
        }
        SolidDensity::VertexRamp(ramp) => match solid {
            Solid::Surface(..) => None,
            Solid::Tets(sound, _) => {
                // The ramp is monotonic, so a vertex has its least density where it has any below zero.
                let values = field(sound.mesh(), ramp.name.as_deref()).ok()?;
                let densities = values.iter().map(|value| ramp.at(*value));
                negative(vertices.iter().copied().zip(densities))
            }
        },
        SolidDensity::Vertex(name) => match solid {
            Solid::Surface(..) => None,
            Solid::Tets(sound, _) => {
                let values = field(sound.mesh(), name.as_deref()).ok()?;
                negative(vertices.iter().copied().zip(values.iter().copied()))
            }
        },
    }
}

/// Where an edge passes the breaks of a profile, and the densities there.
fn on_breaks(profile: &Profile, [from, to]: &[Point3<f64>; 2]) -> Vec<DensityAt> {
    let [start, end] = [from, to].map_each(|point| profile.along(point));
    let inner = profile.breaks().iter().filter(|[s, _]| {
        let (low, high) = (start.min(end), start.max(end));
        low < *s && *s < high
    });
    let place = |&[s, density]: &[f64; 2]| {
        let share = (s - start) / (end - start);
        (from + (to - from) * share, density)
    };
    inner.map(place).collect()
}

/// The least of places, if it is negative.
fn negative(places: impl Iterator<Item = DensityAt>) -> Option<DensityAt> {
    let least = places.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least.1 < 0.0).then_some(least)
}
