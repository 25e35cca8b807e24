//! Half-spaces and polyhedra: the identities that every clip must keep.

use std::collections::BTreeSet;

use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::{Full, SmallClipScratch};
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

fn cube() -> Polyhedron {
    let corner = Point3::new(1.0, 1.0, 1.0);
    let around = Bounds {
        min: -corner,
        max: corner,
    };
    Polyhedron::cuboid(&around, [100, 101, 102, 103, 104, 105])
}

fn volume(polyhedron: &Polyhedron) -> f64 {
    polyhedron.moments().mass
}

fn opposite(half_space: &HalfSpace) -> HalfSpace {
    HalfSpace {
        normal: -half_space.normal,
        offset: -half_space.offset,
    }
}

/// What must hold of every polyhedron: closed loops, V − E + F = 2, no boundary.
fn check(polyhedron: &Polyhedron) -> Result<(), String> {
    if polyhedron.is_empty() {
        return Ok(());
    }
    let vertices = polyhedron.vertex_count();
    let mut facets = 0;
    let mut sides = 0;
    let mut closure = Vector3::zeros();
    for facet in polyhedron.facets() {
        facets += 1;
        let loop_length = facet.vertex_numbers().take(vertices + 1).count();
        if loop_length > vertices || loop_length < 3 {
            return Err(format!("facet {} has {loop_length} corners", facet.number));
        }
        sides += loop_length;
        closure += facet.area_vector();
        let plane = facet.half_space().normalized();
        let far = facet
            .corners()
            .map(|c| plane.excess(&c).abs())
            .fold(0.0, f64::max);
        if far > 1e-12 {
            return Err(format!("facet {} is {far} off its plane", facet.number));
        }
    }
    if sides != 3 * vertices {
        return Err(format!("{sides} sides at {vertices} vertices"));
    }
    if vertices + facets != sides / 2 + 2 {
        return Err(format!("V {vertices} − E {} + F {facets} ≠ 2", sides / 2));
    }
    if closure.norm() > 1e-13 {
        return Err(format!("the surface does not close: {closure:?}"));
    }
    Ok(())
}

fn half_space() -> impl Strategy<Value = HalfSpace> {
    let part = -1.0..1.0;
    ((part.clone(), part.clone(), part), 0.2..1.5)
        .prop_filter("a direction", |((x, y, z), _)| x * x + y * y + z * z > 1e-3)
        .prop_map(|((x, y, z), distance): ((f64, f64, f64), f64)| {
            HalfSpace::bisector(Vector3::new(x, y, z).normalize() * (2.0 * distance))
        })
}

/// Planes through lattice points: many pass through common vertices and edges.
fn lattice_half_space() -> impl Strategy<Value = HalfSpace> {
    let part = -2..=2i32;
    ((part.clone(), part.clone(), part), -3..=6i32)
        .prop_filter("a direction", |((x, y, z), _)| (x, y, z) != (&0, &0, &0))
        .prop_map(|((x, y, z), offset)| HalfSpace {
            normal: Vector3::new(f64::from(x), f64::from(y), f64::from(z)),
            offset: f64::from(offset) / 2.0,
        })
}

/// Planes at any offset, the center on either side of them.
fn offset_half_space() -> impl Strategy<Value = HalfSpace> {
    (half_space(), -0.6..1.5).prop_map(|(plane, offset)| HalfSpace {
        offset,
        normal: plane.normalized().normal,
    })
}

fn clipped(planes: &[HalfSpace]) -> Polyhedron {
    clipped_in_order(planes.iter().enumerate())
}

/// The cube clipped by planes that are labelled by their numbers.
fn clipped_in_order<'a>(planes: impl Iterator<Item = (usize, &'a HalfSpace)>) -> Polyhedron {
    let mut polyhedron = cube();
    let mut scratch = ClipScratch::default();
    for (label, plane) in planes {
        clip(&mut polyhedron, plane, label as u64, &mut scratch);
    }
    polyhedron
}

/// The labels of all facets, and of those with an area beyond rounding.
fn labels_by_area(polyhedron: &Polyhedron) -> [BTreeSet<u64>; 2] {
    let areas = || {
        polyhedron
            .facets()
            .map(|f| (f.label(), f.area_vector().norm()))
    };
    let all = areas().map(|(label, _)| label).collect();
    let large = areas().filter(|(_, area)| *area > 1e-9);
    [all, large.map(|(label, _)| label).collect()]
}

/// As [`clipped`], in slots, as far as these suffice.
fn clipped_in_slots(planes: &[HalfSpace]) -> Result<Polyhedron, Full> {
    let mut compact = SmallPolyhedron::default();
    let mut scratch = SmallClipScratch::default();
    // What the memory has held before must not matter.
    for planes in [&planes[planes.len() / 2..], planes] {
        assert!(compact.assign(&cube()));
        for (label, plane) in planes.iter().enumerate() {
            if compact.clip(plane, || label as u64, &mut scratch)? == Clip::Emptied {
                break;
            }
        }
    }
    let mut polyhedron = Polyhedron::default();
    compact.write(&mut polyhedron);
    Ok(polyhedron)
}

fn labels(polyhedron: &Polyhedron) -> Vec<u64> {
    polyhedron.facets().map(|facet| facet.label()).collect()
}

proptest! {
    #[test]
    fn slots_hold_the_same_polyhedra(
        planes in prop::collection::vec(half_space(), 0..30)
    ) {
        let (any_size, in_slots) = (clipped(&planes), clipped_in_slots(&planes));
        let in_slots = in_slots.expect("thirty planes need fewer slots");
        prop_assert_eq!(check(&in_slots), Ok(()));
        prop_assert_eq!(labels(&in_slots), labels(&any_size));
        prop_assert!((volume(&in_slots) - volume(&any_size)).abs() <= 1e-14);
    }

    #[test]
    fn slots_hold_planes_through_common_points_too(
        planes in prop::collection::vec(lattice_half_space(), 0..30)
    ) {
        if let Ok(in_slots) = clipped_in_slots(&planes) {
            prop_assert_eq!(check(&in_slots), Ok(()));
            prop_assert!((volume(&in_slots) - volume(&clipped(&planes))).abs() <= 1e-13);
        }
    }

    #[test]
    fn clips_leave_a_closed_simple_polytope(planes in prop::collection::vec(half_space(), 0..30)) {
        prop_assert_eq!(check(&clipped(&planes)), Ok(()));
    }

    #[test]
    fn planes_through_common_points_do_too(
        planes in prop::collection::vec(lattice_half_space(), 0..30)
    ) {
        prop_assert_eq!(check(&clipped(&planes)), Ok(()));
    }

    #[test]
    fn a_clip_and_its_opposite_share_out_the_volume(
        planes in prop::collection::vec(half_space(), 0..12),
        last in prop_oneof![half_space(), lattice_half_space()],
    ) {
        let whole = clipped(&planes);
        let mut scratch = ClipScratch::default();
        let (mut inside, mut outside) = (whole.clone(), whole.clone());
        clip(&mut inside, &last, 1, &mut scratch);
        clip(&mut outside, &opposite(&last), 1, &mut scratch);
        let sum = volume(&inside) + volume(&outside);
        prop_assert!((sum - volume(&whole)).abs() <= 1e-13, "{} instead of {}", sum, volume(&whole));
    }

    #[test]
    fn the_order_of_clips_does_not_matter(
        planes in prop::collection::vec(prop_oneof![half_space(), lattice_half_space()], 0..12)
    ) {
        let forward = volume(&clipped(&planes));
        let reversed = clipped_in_order(planes.iter().enumerate().rev());
        prop_assert!((forward - volume(&reversed)).abs() <= 1e-13);
    }

    #[test]
    fn the_order_of_clips_does_not_matter_to_labels_either(
        planes in prop::collection::vec(offset_half_space(), 0..12)
    ) {
        let [all, large] = labels_by_area(&clipped(&planes));
        let reversed = clipped_in_order(planes.iter().enumerate().rev());
        let [reversed_all, reversed_large] = labels_by_area(&reversed);
        prop_assert!(large.is_subset(&reversed_all), "{large:?} {reversed_all:?}");
        prop_assert!(reversed_large.is_subset(&all), "{reversed_large:?} {all:?}");
    }

    #[test]
    fn both_clippers_agree_on_planes_at_any_offset(
        planes in prop::collection::vec(offset_half_space(), 0..16)
    ) {
        let (any_size, in_slots) = (clipped(&planes), clipped_in_slots(&planes));
        let in_slots = in_slots.expect("sixteen planes need fewer slots");
        prop_assert_eq!(check(&in_slots), Ok(()));
        prop_assert_eq!(labels(&in_slots), labels(&any_size));
        prop_assert!((volume(&in_slots) - volume(&any_size)).abs() <= 1e-14);
    }

    #[test]
    fn the_same_plane_cuts_once(planes in prop::collection::vec(half_space(), 1..12)) {
        let once = clipped(&planes);
        let mut twice = once.clone();
        let mut scratch = ClipScratch::default();
        for plane in &planes {
            clip(&mut twice, plane, 9, &mut scratch);
        }
        prop_assert!((volume(&once) - volume(&twice)).abs() <= 1e-13);
    }
}

#[test]
fn a_clip_says_what_it_did() {
    let mut scratch = ClipScratch::default();
    let normal = Vector3::new(1.0, 0.0, 0.0);
    let mut polyhedron = cube();
    let at = |offset| HalfSpace { normal, offset };
    // The wall itself is not crossed.
    assert_eq!(
        clip(&mut polyhedron, &at(1.0), 1, &mut scratch),
        Clip::Unchanged
    );
    assert_eq!(clip(&mut polyhedron, &at(0.5), 1, &mut scratch), Clip::Cut);
    assert!((volume(&polyhedron) - 6.0).abs() < 1e-15);
    assert_eq!(
        clip(&mut polyhedron, &at(-2.0), 1, &mut scratch),
        Clip::Emptied
    );
    assert!(polyhedron.is_empty());
    assert!(volume(&polyhedron).abs() < f64::MIN_POSITIVE);
}

#[test]
fn what_does_not_fit_in_slots_stays_as_it_was() {
    let mut compact = SmallPolyhedron::default();
    let mut scratch = SmallClipScratch::default();
    assert!(compact.assign(&cube()));
    // A dome of ever more facets.
    let plane = |k: u32| {
        let (sine, cosine) = (f64::from(k) * 2.4).sin_cos();
        let height = 1.0 - f64::from(k) / 60.0;
        let width = (1.0 - height * height).sqrt();
        HalfSpace {
            normal: Vector3::new(width * cosine, width * sine, height),
            offset: 0.9,
        }
    };
    let refused = (0..120).find(|&k| compact.clip(&plane(k), || 0, &mut scratch).is_err());
    let fitting: Vec<_> = (0..refused.expect("64 slots")).map(plane).collect();
    let mut polyhedron = Polyhedron::default();
    compact.write(&mut polyhedron);
    assert_eq!(check(&polyhedron), Ok(()));
    assert!((volume(&polyhedron) - volume(&clipped(&fitting))).abs() < 1e-13);
    assert!(!compact.assign(&clipped(&(0..120).map(plane).collect::<Vec<_>>())));
}

#[test]
fn labels_stay_with_their_facets() {
    let corner = HalfSpace {
        normal: Vector3::new(1.0, 1.0, 1.0),
        offset: 2.5,
    };
    let polyhedron = clipped(&[corner]);
    let labels: Vec<_> = polyhedron.facets().map(|facet| facet.label()).collect();
    assert_eq!(labels, [100, 101, 102, 103, 104, 105, 0]);
    let cut = polyhedron.facets().last().unwrap();
    assert_eq!(cut.corners().count(), 3);
    assert_eq!(cut.half_space(), corner);
}

#[test]
fn a_tetrahedron_has_the_moments_of_the_textbook() {
    // The corner x, y, z ≥ 0 with x + y/2 + z/3 ≤ 1, of which the cube's walls cut nothing.
    let sides = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    let sides = sides.map(|normal| (normal, 0.0)).into_iter();
    let mut tetrahedron = Polyhedron::cuboid(
        &Bounds {
            min: Point3::new(-4.0, -4.0, -4.0),
            max: Point3::new(4.0, 4.0, 4.0),
        },
        [9; 6],
    );
    let mut scratch = ClipScratch::default();
    for (label, (normal, offset)) in sides.chain([([6.0, 3.0, 2.0], 6.0)]).enumerate() {
        let normal = Vector3::from(normal);
        let plane = HalfSpace { normal, offset };
        clip(&mut tetrahedron, &plane, label as u64, &mut scratch);
    }
    assert_eq!(check(&tetrahedron), Ok(()));
    assert_eq!(labels(&tetrahedron), [0, 1, 2, 3]);
    let moments = tetrahedron.moments();
    assert!((moments.mass - 1.0).abs() < 1e-14);
    assert!((moments.centroid() - Point3::new(0.25, 0.5, 0.75)).norm() < 1e-14);
    // ∫ x² = V 1²/10 and ∫ x y = V 1·2/20 over it, and so on.
    let second = [0.1, 0.4, 0.9, 0.1, 0.3, 0.15];
    for (value, expected) in moments.ten()[4..].iter().zip(second) {
        assert!((value - expected).abs() < 1e-14, "{value} {expected}");
    }
}

#[test]
fn moments_follow_the_parallel_axis_relation() {
    let moments = cube().moments();
    assert!((moments.second.trace() - 8.0).abs() < 1e-14);
    // About a corner: 8 + 8 · 3.
    assert!((moments.second_about(&Point3::new(1.0, 1.0, 1.0)) - 32.0).abs() < 1e-13);
}
