//! The six fragments of a piece about a center, as polyhedra (\[BL\] section 3.5, Fig. 12).
//!
//! Integrals do not need them; pictures and tests do.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::energy::sector::Sector;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// Cuts `piece` into its fragments about `center`, in the order of [`Sector::ALL`]; a fragment may
/// be empty. The facets on interfaces carry the label `interface`.
#[must_use]
pub(crate) fn fragments(piece: &Polyhedron, center: &Point3<f64>, interface: Label) -> [Polyhedron; 6] {
    fragments_in_frame(piece, center, &Rotation3::identity(), interface)
}

/// As [`fragments`], for distances along the axes of space turned by `frame`.
#[must_use]
pub(crate) fn fragments_in_frame(
    piece: &Polyhedron,
    center: &Point3<f64>,
    frame: &Rotation3<f64>,
    interface: Label,
) -> [Polyhedron; 6] {
    Sector::ALL.map(|sector| fragment(piece, center, frame, sector, interface))
}

fn fragment(
    piece: &Polyhedron,
    center: &Point3<f64>,
    frame: &Rotation3<f64>,
    sector: Sector,
    interface: Label,
) -> Polyhedron {
    let mut fragment = piece.clone();
    let mut scratch = ClipScratch::default();
    for other in sector.adjacent() {
        let mut normal = Vector3::zeros();
        normal[other.axis()] = other.sign();
        normal[sector.axis()] = -sector.sign();
        let normal = frame * normal;
        let offset = normal.dot(&center.coords);
        let border = HalfSpace { normal, offset };
        clip(&mut fragment, &border, interface, &mut scratch);
    }
    fragment
}

/// The tetrahedra of a fragment: `center` with the fan triangles of every facet (\[BL\] section
/// 3.5). Those on facets through the center are flat.
pub(crate) fn tetrahedra<'a>(
    fragment: &'a Polyhedron,
    center: &'a Point3<f64>,
) -> impl Iterator<Item = [Point3<f64>; 4]> + 'a {
    fragment.facets().flat_map(move |facet| {
        let mut corners = facet.corners();
        let anchor = corners.next();
        let rest: Vec<_> = corners.collect();
        let fan = move |(a, b): (Point3<f64>, Point3<f64>)| anchor.map(|q| [*center, q, a, b]);
        let pairs: Vec<_> = rest
            .iter()
            .copied()
            .zip(rest.iter().copied().skip(1))
            .collect();
        pairs.into_iter().filter_map(fan)
    })
}
