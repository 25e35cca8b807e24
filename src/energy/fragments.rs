//! The six fragments of a piece about a center, as polyhedra (\[BL\] section 3.5, Fig. 12).
//!
//! Integrals do not need them; pictures and tests do.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::energy::sector::Sector;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// Cuts `piece` into its fragments about `center`, for distances along the axes of space turned by
/// `frame`, in the order of [`Sector::ALL`]; a fragment may be empty. The facets on interfaces carry the
/// label `interface`.
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
