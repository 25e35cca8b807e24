//! The energy of order 1 as the polynomial of degree four that it is nearby.
//!
//! As long as no vertex passes from one sector to another and no diagonal from one facet to another,
//! all corners of the subdivision move along lines and in proportion to the center's motion δ. So
//! volumes of fragments are polynomials of degree three in δ, areas of interfaces of degree two, and
//! the energy is one of degree four: value, gradient, Hessian, third and fourth derivative tell
//! it all.
//!
//! The area of an interface is a sum of determinants of two marks, each linear in δ:
//! - a crossing's, which slides along its edge, by its [`Drift`](crate::chebyshev::mark::Drift);
//! - a diagonal's, which is proportional to the center's height below the facet.
//!
//! The determinants of the marks' changes are all of second degree in δ that there is.

use nalgebra::{Matrix3, Vector3};
use wide::f64x2;

use crate::chebyshev::endpoints::Found;
use crate::chebyshev::energy::interface_hessian;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::{Endpoint, Interface};
use crate::chebyshev::mark::Mark;
use crate::chebyshev::sight::Sight;
use crate::chebyshev::walk::WalkScratch;

/// The fourth derivative (1), applied twice to `step`, of the energy of order 1 that the last walk of
/// `scratch`, which was one of `piece`, has summed up, if the subdivision keeps its shape all along
/// the step.
pub(crate) fn fourth(
    piece: &Integrand,
    step: &Vector3<f64>,
    scratch: &mut WalkScratch,
) -> Option<Matrix3<f64>> {
    let WalkScratch {
        panorama,
        endpoints,
        segments,
        lowerings,
        ..
    } = scratch;
    let from = Sight::of(step);
    if endpoints.are_rounded || !panorama.stays(piece, (step, &from), lowerings) {
        return None;
    }
    let ways = ways(&from);
    let (mut areas, mut is_sound) = ([0.0; Interface::SLOTS], true);
    for (facet, interface) in segments.all() {
        let (way, lowering) = (&ways[interface.number()], f64x2::splat(lowerings[facet]));
        let [(start, u), (_, v)] = [false, true].map(|ends| {
            let found = endpoints.found(facet, Endpoint::of(interface, ends));
            (&found.mark, way.retreat(found, lowering))
        });
        // What ends here starts on the next facet, or it is at a diagonal.
        is_sound &= is_on_interface(start, &u);
        areas[interface.number()] += interface.determinant(&u, &v);
    }
    is_sound.then(|| interface_hessian(&areas) * 4.0)
}

/// The center's step as an interface sees it.
#[derive(Clone, Copy, Default)]
struct Way {
    /// Along the first sector and along the third axis.
    within: f64x2,
    /// Along the first sector less that along the second, in both lanes.
    across: f64x2,
}

fn ways(step: &Sight) -> [Way; Interface::SLOTS] {
    let mut ways = [Way::default(); Interface::SLOTS];
    for interface in Interface::all() {
        let (left, right) = interface.sectors();
        let [along, third] = [step.distance(left), step.along(interface.third_axis())];
        ways[interface.number()] = Way {
            within: f64x2::new([along, third]),
            across: f64x2::splat(along - step.distance(right)),
        };
    }
    ways
}

impl Way {
    /// By how much the mark of an endpoint shrinks by the center's step, which lowers the center's
    /// height below the facet by the share `lowering`.
    #[inline]
    fn retreat(&self, found: &Found, lowering: f64x2) -> Mark {
        let Found { mark, drift } = found;
        let slid = self.within + self.across * f64x2::new([drift.distance, drift.third]);
        let lowered = lowering * f64x2::new([mark.distance, mark.third]);
        // A diagonal has no drift.
        let [distance, third] = slid.is_nan().select(lowered, slid).to_array();
        Mark { distance, third }
    }
}

/// Whether a point is still on its interface, and not beyond a diagonal, after its mark has shrunk.
#[inline]
fn is_on_interface(mark: &Mark, retreat: &Mark) -> bool {
    mark.distance - retreat.distance >= (mark.third - retreat.third).abs()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::chebyshev::energy::{SignedPiece, energy_jet};
    use crate::geometry::bounds::Bounds;
    use crate::geometry::clip::{ClipScratch, clip};
    use crate::geometry::half_space::HalfSpace;
    use crate::geometry::polyhedron::Polyhedron;

    /// A cube cut by the bisectors of points about the origin.
    fn piece() -> Polyhedron {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut piece = Polyhedron::cuboid(&bounds, [0; 6]);
        for number in 1..15 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let bisector = HalfSpace::bisector(away.normalize() * (1.2 + 0.05 * turn));
            clip(&mut piece, &bisector, 0, &mut ClipScratch::default());
        }
        piece
    }

    #[test]
    fn the_energy_is_that_polynomial_wherever_it_is_said_to_be() {
        let piece = [SignedPiece {
            sign: 1.0,
            integrand: Integrand::new(&piece()),
        }];
        let scratch = &mut WalkScratch::default();
        let mut known = [0; 3];
        for number in 0..300 {
            let turn = f64::from(number);
            let center = Vector3::new(turn.sin(), (1.3 * turn).cos(), (2.1 * turn).sin()) * 0.2;
            let step = Vector3::new((0.7 * turn).cos(), turn.cos(), (1.7 * turn).sin());
            let size = number as usize % 3;
            let step = step * [1e-3, 0.02, 0.5][size];
            let start = energy_jet(&piece, &center, 1, scratch);
            let Some(fourth) = fourth(&piece[0].integrand, &step, scratch) else {
                continue;
            };
            known[size] += 1;
            let third = start.third.expect("it is known for p = 1");
            let third = third[0] * step.x + third[1] * step.y + third[2] * step.z;
            let slope = start.evaluation.hessian + third / 2.0 + fourth / 6.0;
            let end = energy_jet(&piece, &(center + step), 1, scratch).evaluation;
            let gradient = start.evaluation.gradient + slope * step;
            assert!((gradient - end.gradient).amax() < 1e-13, "{number}");
            let hessian = start.evaluation.hessian + third + fourth / 2.0;
            assert!((hessian - end.hessian).amax() < 1e-12, "{number}");
        }
        // Short steps mostly keep the subdivision's shape, long ones hardly ever do.
        assert!(known[0] > 80 && known[1] > 10 && known[2] < 10, "{known:?}");
    }
}
