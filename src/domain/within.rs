//! Parts of a whole domain within a box.

use nalgebra::{Point3, Vector3};

use crate::domain::beyond::Beyond;
use crate::domain::space::{Domain, PieceScratch};
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::mesh_moments::of_piece;
use crate::integrals::polynomial::Polynomial;

/// A point and the convex polyhedron around the domain from which its cell would be cut, relative
/// to it.
pub(crate) type Start = (Point3<f64>, Polyhedron);

/// The start of the cell of the middle of the domain's bounds.
pub(crate) fn start_of_all(domain: &dyn Domain) -> Start {
    let (middle, mut start) = (domain.bounds().center(), Polyhedron::default());
    domain.start(&middle, 0, &mut start);
    (middle, start)
}

/// Clips `part`, in coordinates relative to `site`, to the box, whose infinite sides cut nothing,
/// and says whether anything is left.
pub(crate) fn clip_to_box(
    part: &mut Polyhedron,
    site: &Point3<f64>,
    bounds: &Bounds<3>,
    scratch: &mut ClipScratch,
) -> bool {
    for axis in 0..3 {
        let mut normal = Vector3::zeros();
        normal[axis] = 1.0;
        let upper = bounds.max[axis] - site[axis];
        let lower = site[axis] - bounds.min[axis];
        for (normal, offset) in [(normal, upper), (-normal, lower)] {
            let side = HalfSpace { normal, offset };
            if offset.is_finite()
                && clip(part, &side, Beyond::Inner.label(), scratch) == Clip::Emptied
            {
                return false;
            }
        }
    }
    true
}

/// ∫ density over what the domain and the box have in common.
pub(crate) fn mass_within(
    domain: &dyn Domain,
    (middle, start): &Start,
    bounds: &Bounds<3>,
    density: &Polynomial,
) -> f64 {
    let mut scratch = PieceScratch::default();
    let mut part = start.clone();
    if !clip_to_box(&mut part, middle, bounds, &mut scratch.clip) {
        return 0.0;
    }
    let density = density.seen_from(middle);
    let mut mass = 0.0;
    domain.pieces_within(middle, &part, &mut scratch, &mut |sign, piece| {
        mass += sign * of_piece(piece, &density).mass;
    });
    mass
}

/// Whether the domain fills a part of the box, however small beyond rounding.
pub(crate) fn holds_some(domain: &dyn Domain, start: &Start, bounds: &Bounds<3>) -> bool {
    let volume = mass_within(domain, start, bounds, &Polynomial::constant(1.0));
    let rounding = f64::EPSILON * domain.bounds().volume();
    volume > rounding
}
