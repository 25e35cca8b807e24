//! The energy of order 1 as the polynomial of degree four that it is nearby.
//!
//! As long as no vertex passes from one sector to another and no diagonal from one facet to another,
//! all corners of the subdivision move along lines and in proportion to the center's motion δ. So
//! volumes of fragments are polynomials of degree three in δ, areas of interfaces of degree two, and
//! the energy is one of degree four: value, gradient, Hessian, third and fourth derivative tell
//! it all. FacetKind, what passes is added (`passings`).
//!
//! The area of an interface is a sum of determinants of two marks, the ends of segments, and the
//! determinants of the marks' losses are all of second degree in δ that there is. With the words of
//! [`Found::drift`], β = (δ_l, δ_t) and α = δ_l − δ_r, these losses are
//! - β + α g for a crossing with the drift g,
//! - ε t for a diagonal's mark t, ε = n·δ/h the share by which the height below its facet shrinks.
//!
//! The segments of an interface are joined crossing to crossing from one diagonal to the next, so that
//! terms of first degree in g cancel but for those beside diagonals: the sum is
//! α² Σ det(g_u, g_v) + Σ det(ε t − β, β + α g), over segments between crossings, and over those from
//! a diagonal to a crossing (from there with the other sign), and plain det(ε t_u, ε t_v) between
//! diagonals.

use nalgebra::Vector3;
use wide::{f64x4, i32x4};

use crate::chebyshev::bend::interface_hessian;
use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::endpoints::{Endpoints, Tips};
use crate::chebyshev::family::Family;
use crate::chebyshev::integrand::Integrand;
use crate::chebyshev::interface::Interface;
use crate::chebyshev::pierced::by_diagonal;
use crate::chebyshev::seen::Seen;
use crate::chebyshev::walk::WalkScratch;
use crate::minimize::objective::Ahead;

/// What the last walk of `scratch`, which was one of `piece` for the energy of order 1, tells about
/// where the center is a `step` farther on.
pub(crate) fn ahead(
    piece: &Integrand,
    step: &Vector3<f64>,
    scratch: &mut WalkScratch,
) -> Option<Ahead<3>> {
    let WalkScratch {
        center,
        endpoints,
        slides,
        volume,
        passings,
        ..
    } = scratch;
    let tips = endpoints.tips()?;
    let losses = losses(piece, step, tips);
    let (areas, keeps_shape) = areas(step, (tips, &losses), endpoints, slides);
    let end = *center + step;
    let keeps_shape = keeps_shape && passings.are_none() && do_vertices_stay(piece, [center, &end]);
    let passed = if keeps_shape {
        None
    } else if !piece.at_vertices.are_known() {
        return None;
    } else {
        let seen = Seen { piece, center };
        let passed = passings.follow(&seen, &tips.facets, &end);
        Some(passed.evaluation(&end, (*volume)?)?)
    };
    Some(Ahead {
        fourth: interface_hessian(&areas) * 4.0,
        passed,
    })
}

/// Whether all vertices are in the same sectors as seen from two centers.
#[inline]
fn do_vertices_stay(piece: &Integrand, centers: [&Vector3<f64>; 2]) -> bool {
    let seen = centers.map(|center| Seen { piece, center });
    let moved = piece.vertices.blocks().fold(f64x4::ZERO, |moved, block| {
        let [from, to] = seen.map(|seen| seen.codes(&block));
        moved | from.simd_ne(to)
    });
    moved.to_bitmask() == 0
}

/// By how much the reaches of diagonals shrink: n·δ / n·ρ for the facet of each.
#[inline]
fn losses(piece: &Integrand, step: &Vector3<f64>, tips: &Tips) -> [f64; 8] {
    let step = [step.x, step.y, step.z].map(f64x4::splat);
    by_diagonal(&piece.facets, tips.facets, |[x, y, z, _], along| {
        (x * step[0] + y * step[1] + z * step[2]) / along
    })
}

/// Per interface the sum of the determinants of losses where the center makes a step, by which
/// diagonals lose `losses`; and whether no diagonal passes over an edge, if no vertex passes from one
/// sector to another: then it is a crossing beside the diagonal that it meets.
#[inline]
fn areas(
    step: &Vector3<f64>,
    (tips, losses): (&Tips, &[f64; 8]),
    endpoints: &Endpoints,
    slides: &[f64; Interface::SLOTS],
) -> ([f64; Interface::SLOTS], bool) {
    let mut areas = [0.0; Interface::SLOTS];
    let lasting = losses.iter().zip(&tips.reaches);
    let lasts = lasting.fold(true, |all, (loss, reach)| all & (loss < reach));
    let mut stays = f64x4::splat(f64::from_bits(u64::MAX));
    for (first, family) in Family::all() {
        let [left, right, third] = family.axes.map(|axis| f64x4::splat(step[axis % 3]));
        let [left_signs, right_signs] = family.signs.map(f64x4::new);
        let within = [left * left_signs, third];
        let across = within[0] - right * right_signs;
        let of_diagonals = |all: &[f64; 8], end: usize| {
            f64x4::new(family.diagonals[end].map(|diagonal| all[diagonal % 8]))
        };
        let tip = |end: usize| {
            let loss = of_diagonals(losses, end);
            [loss, loss * f64x4::new(family.along[end])]
        };
        let facets = family
            .diagonals
            .map(|four| four.map(|diagonal| tips.facets[diagonal % 8]));
        let beside = |end: usize| {
            let found = [0, 1, 2, 3].map(|lane| {
                let interface = Interface::of_number(first + lane);
                let endpoint = Endpoint::of(interface, end == 0);
                endpoints.found(facets[end][lane] as usize, endpoint)
            });
            let [distance, along, slide, slide_along] = f64x4::transpose(found);
            let slid = [within[0] + across * slide, within[1] + across * slide_along];
            let stays = (distance - slid[0]).simd_ge((along - slid[1]).abs());
            (slid, stays)
        };
        let [(u, u_stays), (v, v_stays)] = [beside(0), beside(1)];
        let (start, end) = (tip(0), tip(1));
        let joined = determinants(less(start, within), u) + determinants(v, less(end, within));
        let slides = f64x4::new([0, 1, 2, 3].map(|lane| slides[(first + lane) % slides.len()]));
        let turns = f64x4::new(family.turns);
        let [one, other] =
            facets.map(|four| f64x4::from(i32x4::new(four.map(|facet| facet as i32))));
        let is_direct = one.simd_eq(other);
        let area = is_direct.select(
            turns * determinants(start, end),
            across * across * slides + turns * joined,
        );
        areas[first..first + Family::SIZE].copy_from_slice(&area.to_array());
        stays &= is_direct | (u_stays & v_stays);
    }
    (areas, lasts && stays.to_bitmask() == 0b1111)
}

/// The differences of two lists of marks.
#[inline(always)]
fn less(one: [f64x4; 2], other: [f64x4; 2]) -> [f64x4; 2] {
    [one[0] - other[0], one[1] - other[1]]
}

/// The determinants of marks, but for the interfaces' turns.
#[inline(always)]
fn determinants(u: [f64x4; 2], v: [f64x4; 2]) -> f64x4 {
    u[0] * v[1] - u[1] * v[0]
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
    use crate::minimize::problem::Jet;

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
    fn the_energy_is_what_lies_ahead() {
        let piece = [SignedPiece {
            sign: 1.0,
            integrand: Integrand::new(&piece()),
        }];
        let scratch = &mut WalkScratch::default();
        let (mut known, mut passed) = ([0; 3], [0; 3]);
        for number in 0..300 {
            let turn = f64::from(number);
            let center = Vector3::new(turn.sin(), (1.3 * turn).cos(), (2.1 * turn).sin()) * 0.2;
            let step = Vector3::new((0.7 * turn).cos(), turn.cos(), (1.7 * turn).sin());
            let size = number as usize % 3;
            let step = step * [1e-3, 0.02, 0.5][size];
            let Jet { evaluation, third } = energy_jet(&piece, &center, 1, scratch);
            let third = third.expect("it is known for p = 1");
            // A way goes on from where it has come to, and may come back.
            let ways = [step, step * 1.2 + step.yzx() * 0.3, step * -0.4, step];
            let known_ahead = ways.map(|way| (way, ahead(&piece[0].integrand, &way, scratch)));
            let Some((_, Some(first))) = known_ahead.first() else {
                continue;
            };
            known[size] += 1;
            passed[size] += usize::from(first.passed.is_some());
            for (way, ahead) in known_ahead {
                let Some(ahead) = ahead else {
                    continue;
                };
                let found = ahead.at_end(&evaluation, &third, &way);
                let end = energy_jet(&piece, &(center + way), 1, scratch).evaluation;
                assert!((found.value - end.value).abs() < 1e-13, "{number}");
                assert!((found.gradient - end.gradient).amax() < 1e-13, "{number}");
                assert!((found.hessian - end.hessian).amax() < 1e-12, "{number}");
            }
        }
        // On long steps diagonals pass over several edges, or the center leaves the piece.
        assert!(known[0] > 95 && known[1] > 95 && known[2] > 15, "{known:?}");
        assert!(passed[0] < 20 && passed[1] > 15, "{passed:?}");
    }
}
