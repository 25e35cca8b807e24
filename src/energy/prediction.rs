//! Prediction of the energy of order 1 a step away, by its polynomial of degree four.
//!
//! As long as no vertex crosses from one sector to another and no diagonal from one facet to another,
//! all corners of the subdivision move along lines and in proportion to the center's motion δ. So
//! volumes of fragments are polynomials of degree three in δ, areas of interfaces of degree two, and
//! the energy is one of degree four: value, gradient, Hessian, third and fourth derivative determine it.
//!
//! The area of an interface is a sum of determinants of two points, the ends of segments, and the
//! determinants of the changes of these points are all of second degree in δ that there is. In the terms
//! of [`crate::energy::sector::SegmentEnd`], β = (δ_l, δ_t) and α = δ_l − δ_r, the points lose
//! - β + α g for a crossing of edge velocity g,
//! - ε t for a diagonal's point t, ε = n·δ/h the share by which the height below its facet shrinks.
//!
//! The segments of an interface are joined crossing to crossing from one diagonal to the next, so that
//! terms of first degree in g cancel but for those beside diagonals: the sum is
//! α² Σ det(g_u, g_v) + Σ det(ε t − β, β + α g), over segments between crossings, and over those from
//! a diagonal to a crossing (from there with the other sign), and plain det(ε t_u, ε t_v) between
//! diagonals.

use nalgebra::Vector3;
use wide::{f64x4, i32x4};

use crate::arrays::MapEach;
use crate::energy::edge_crossings_simd::QuadSectors;
use crate::energy::prepared::{CenteredPiece, PreparedPiece};
use crate::energy::sector::{DIAGONAL_ENDS, Interface, InterfaceEnd, ORIENTATION, PAIRS};
use crate::energy::segments::{DiagonalHits, SegmentEnds, by_diagonal};
use crate::energy::sums_linear::hessian_from_areas;
use crate::minimize::objective::Prediction;

/// The energy's fourth derivative along a `step` of the center from `center`, if the energy of `piece` is
/// one polynomial that far; `ends` and `velocity_determinants` are those of its evaluation there.
pub(crate) fn predict(
    piece: &PreparedPiece,
    [center, step]: [&Vector3<f64>; 2],
    ends: &SegmentEnds,
    velocity_determinants: &[f64; Interface::SLOTS],
) -> Option<Prediction<3>> {
    let hits = ends.hits()?;
    // The most frequent change first.
    if !keep_sectors(piece, [center, &(center + step)]) {
        return None;
    }
    let losses = reach_losses(piece, step, hits);
    let areas = area_changes(step, (hits, &losses), ends, velocity_determinants)?;
    Some(Prediction {
        fourth: hessian_from_areas(&areas) * 4.0,
    })
}

/// Whether all vertices are in the same sectors about two centers.
#[inline]
fn keep_sectors(piece: &PreparedPiece, centers: [&Vector3<f64>; 2]) -> bool {
    let views = centers.map_each(|center| CenteredPiece { piece, center });
    let moved = piece.vertices.blocks().fold(f64x4::ZERO, |moved, block| {
        let [from, to] = views.map_each(|view| QuadSectors::of(&view.displacements(&block)));
        moved | from.differ(&to)
    });
    moved.to_bitmask() == 0
}

/// By how much the reaches of diagonals shrink: n·δ / n·ρ for the facet of each (L).
#[inline]
fn reach_losses(piece: &PreparedPiece, step: &Vector3<f64>, hits: &DiagonalHits) -> [f64; 8] {
    let step = [step.x, step.y, step.z].map_each(f64x4::splat);
    by_diagonal(&piece.facets, hits.facets, |[x, y, z, _], along| {
        (x * step[0] + y * step[1] + z * step[2]) / along
    })
}

/// Per interface the sum of the determinants of losses where the center makes a step, by which
/// diagonals lose `losses`; none if a diagonal crosses an edge. If no vertex crosses from one sector to
/// another, that is a crossing beside the diagonal that it meets.
#[inline]
fn area_changes(
    step: &Vector3<f64>,
    (hits, losses): (&DiagonalHits, &[f64; 8]),
    ends: &SegmentEnds,
    velocity_determinants: &[f64; Interface::SLOTS],
) -> Option<[f64; Interface::SLOTS]> {
    let mut areas = [0.0; Interface::SLOTS];
    let is_inside = losses.iter().zip(&hits.reaches);
    let is_inside = is_inside.fold(true, |all, (loss, reach)| all & (loss < reach));
    let mut stays = f64x4::splat(f64::from_bits(u64::MAX));
    for (first, pair) in (0..).step_by(AxisPair::SIZE).zip(&AXIS_PAIRS) {
        let [left, right, third] = pair.axes.map_each(|axis| f64x4::splat(step[axis % 3]));
        let [left_signs, right_signs] = pair.signs.map_each(f64x4::new);
        let within = [left * left_signs, third];
        let across = within[0] - right * right_signs;
        let at_diagonal = |end: usize| {
            let loss = f64x4::new(pair.diagonals[end].map_each(|diagonal| losses[diagonal % 8]));
            [loss, loss * f64x4::new(pair.along[end])]
        };
        let facets =
            (pair.diagonals).map_each(|quad| quad.map_each(|diagonal| hits.facets[diagonal % 8]));
        let beside = |end: usize| {
            let at = [0, 1, 2, 3].map_each(|lane| {
                let interface = Interface::of_number(first + lane);
                let key = InterfaceEnd::of(interface, end == 0);
                ends.end(facets[end][lane] as usize, key).0
            });
            let [distance, along, velocity, velocity_along] = f64x4::transpose(at);
            let loss = [
                within[0] + across * velocity,
                within[1] + across * velocity_along,
            ];
            let stays = (distance - loss[0]).simd_ge((along - loss[1]).abs());
            (loss, stays)
        };
        let [(u, u_stays), (v, v_stays)] = [beside(0), beside(1)];
        let (start, end) = (at_diagonal(0), at_diagonal(1));
        let joined = determinants(minus(start, within), u) + determinants(v, minus(end, within));
        let velocities = [0, 1, 2, 3]
            .map_each(|lane: usize| velocity_determinants[(first + lane) % Interface::SLOTS]);
        let orientation = f64x4::new(pair.orientation);
        let [one, other] =
            facets.map_each(|quad| f64x4::from(i32x4::new(quad.map_each(|facet| facet as i32))));
        let is_direct = one.simd_eq(other);
        let area = is_direct.select(
            orientation * determinants(start, end),
            across * across * f64x4::new(velocities) + orientation * joined,
        );
        areas[first..first + AxisPair::SIZE].copy_from_slice(&area.to_array());
        stays &= is_direct | (u_stays & v_stays);
    }
    (is_inside && stays.to_bitmask() == 0b1111).then_some(areas)
}

/// The differences of two lists of points of interfaces.
#[inline(always)]
fn minus(one: [f64x4; 2], other: [f64x4; 2]) -> [f64x4; 2] {
    [one[0] - other[0], one[1] - other[1]]
}

/// The determinants of points of interfaces, but for the orientations.
#[inline(always)]
fn determinants(u: [f64x4; 2], v: [f64x4; 2]) -> f64x4 {
    u[0] * v[1] - u[1] * v[0]
}

/// The four interfaces between the sectors of two axes, side by side.
#[derive(Clone, Copy)]
struct AxisPair {
    /// The axes of their first and of their second sectors, and the third axis.
    axes: [usize; 3],
    /// The signs of their first and of their second sectors.
    signs: [[f64; 4]; 2],
    /// Their orientations ([`ORIENTATION`]).
    orientation: [f64; 4],
    /// The diagonals at the start and at the end of their segments on a surface about the center.
    diagonals: [[usize; 4]; 2],
    /// The signs of these along the third axis.
    along: [[f64; 4]; 2],
}

impl AxisPair {
    /// How many interfaces it has.
    const SIZE: usize = 4;
}

/// The pairs of axes in the order of [`PAIRS`].
static AXIS_PAIRS: [AxisPair; PAIRS.len()] = axis_pairs_table();

const fn axis_pairs_table() -> [AxisPair; PAIRS.len()] {
    let none = AxisPair {
        axes: [0; 3],
        signs: [[0.0; 4]; 2],
        orientation: [0.0; 4],
        diagonals: [[0; 4]; 2],
        along: [[0.0; 4]; 2],
    };
    let mut table = [none; PAIRS.len()];
    let mut interface = 0;
    while interface < Interface::COUNT {
        let (pair, place) = (interface / AxisPair::SIZE, interface % AxisPair::SIZE);
        let (i, j) = PAIRS[pair];
        table[pair].axes = [i, j, 3 - i - j];
        table[pair].signs[0][place] = 1.0 - 2.0 * (place >> 1) as f64;
        table[pair].signs[1][place] = 1.0 - 2.0 * (place & 1) as f64;
        table[pair].orientation[place] = ORIENTATION[interface];
        interface += 1;
    }
    let mut entry = 0;
    while entry < 24 {
        let (key, sign) = DIAGONAL_ENDS[1][entry / 3].ends[entry % 3];
        let interface = key.number() % Interface::SLOTS;
        let (pair, place) = (interface / AxisPair::SIZE, interface % AxisPair::SIZE);
        let end = key.number() / Interface::SLOTS;
        table[pair].diagonals[end][place] = entry / 3;
        table[pair].along[end][place] = sign;
        entry += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;
    use crate::energy::evaluation::{EnergyScratch, SignedPiece, energy_jet};
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
    fn the_energy_is_predicted_where_its_polynomial_holds() {
        let piece = [SignedPiece {
            sign: 1.0,
            piece: PreparedPiece::new(&piece()),
        }];
        let scratch = &mut EnergyScratch::default();
        let mut known = [0; 3];
        for number in 0..300 {
            let turn = f64::from(number);
            let center = Vector3::new(turn.sin(), (1.3 * turn).cos(), (2.1 * turn).sin()) * 0.2;
            let step = Vector3::new((0.7 * turn).cos(), turn.cos(), (1.7 * turn).sin());
            let size = number as usize % 3;
            let step = step * [1e-3, 0.02, 0.5][size];
            let Jet { evaluation, third } = energy_jet(&piece, &center, 1, scratch);
            let third = third.expect("it is known for p = 1");
            let steps = [step, step * 1.2 + step.yzx() * 0.3, step * -0.4, step];
            let predictions = steps.map(|step| {
                let ends = &scratch.surface.ends;
                let determinants = &scratch.velocity_determinants;
                (
                    step,
                    predict(&piece[0].piece, [&center, &step], ends, determinants),
                )
            });
            known[size] += usize::from(predictions[0].1.is_some());
            for (step, prediction) in predictions {
                let Some(prediction) = prediction else {
                    continue;
                };
                let predicted = prediction.at_end(&evaluation, &third, &step);
                let end = energy_jet(&piece, &(center + step), 1, scratch).evaluation;
                assert!((predicted.value - end.value).abs() < 1e-13, "{number}");
                assert!(
                    (predicted.gradient - end.gradient).amax() < 1e-13,
                    "{number}"
                );
                assert!((predicted.hessian - end.hessian).amax() < 1e-12, "{number}");
            }
        }
        // On longer steps some vertex crosses into another sector.
        assert!(known[0] > 90 && known[1] > 60 && known[2] < 10, "{known:?}");
    }
}
