//! Properties of clips, diagrams, energies and minimizers on random and on degenerate inputs.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

use crate::domain::cuboid::Cuboid;
use crate::domain::shape::DomainShape;
use crate::energy::center::{CenterSearch, Minimizer, center};
use crate::energy::evaluation::{EnergyScratch, SignedPiece, energy, energy_jet};
use crate::energy::prepared::PreparedPiece;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::diagram::Diagram;

/// Coordinates of a half-space whose numbers are small integers: many of them pass through vertices
/// and edges of a cube of integer corners, or coincide with its facets.
fn half_space(small: bool) -> BoxedStrategy<HalfSpace> {
    let whole = (-2..=2, -2..=2, -2..=2, -2..=4).prop_map(|(x, y, z, d): (i32, i32, i32, i32)| {
        let [x, y, z, d] = [x, y, z, d].map(f64::from);
        (Vector3::new(x, y, z), d)
    });
    let any = (-1.0..1.0, -1.0..1.0, -1.0..1.0, -0.5..1.5)
        .prop_map(|(x, y, z, d): (f64, f64, f64, f64)| (Vector3::new(x, y, z), d));
    let chosen = if small { whole.boxed() } else { any.boxed() };
    chosen
        .prop_filter("a normal", |(normal, _)| normal.norm() > 1e-3)
        .prop_map(|(normal, offset)| HalfSpace { normal, offset })
        .boxed()
}

fn half_spaces() -> impl Strategy<Value = Vec<HalfSpace>> {
    prop_oneof![
        prop::collection::vec(half_space(true), 0..6),
        prop::collection::vec(half_space(false), 0..6),
    ]
}

/// The cube [−1, 1]³ cut by half-spaces; some cuts are tangent, some leave nothing.
fn cut_cube(half_spaces: &[HalfSpace]) -> Polyhedron {
    let corner = Point3::new(1.0, 1.0, 1.0);
    let bounds = Bounds {
        min: -corner,
        max: corner,
    };
    let mut piece = Polyhedron::cuboid(&bounds, [0, 1, 2, 3, 4, 5]);
    let mut scratch = ClipScratch::default();
    for (number, half_space) in half_spaces.iter().enumerate() {
        clip(&mut piece, half_space, 10 + number as u64, &mut scratch);
    }
    piece
}

fn volume(piece: &Polyhedron) -> f64 {
    PreparedPiece::new(piece).volume()
}

fn whole(piece: &Polyhedron) -> [SignedPiece; 1] {
    [SignedPiece {
        sign: 1.0,
        piece: PreparedPiece::new(piece),
    }]
}

/// A sheared, turned or mirrored copy of a piece: its vertices' images are given by `map`, which must
/// take half-spaces to half-spaces by `of_half_space`.
fn mapped(
    half_spaces: &[HalfSpace],
    of_half_space: impl Fn(&HalfSpace) -> HalfSpace,
) -> Polyhedron {
    let mapped: Vec<_> = half_spaces.iter().map(of_half_space).collect();
    cut_cube(&mapped)
}

/// Sites on a lattice of k³ points in the unit cube, each kept or not: coplanar, collinear, cospherical;
/// and whether they reach the walls.
fn lattice_sites() -> impl Strategy<Value = (Vec<Point3<f64>>, bool)> {
    let noise = prop_oneof![Just(0.0), Just(1e-16), Just(1e-12), Just(1e-9), Just(0.1)];
    (2_usize..5, noise, any::<bool>(), any::<u64>()).prop_map(|(k, noise, on_walls, seed)| {
        let mut random = crate::geometry::random::Random::new(seed);
        let mut sites = Vec::new();
        for n in 0..k * k * k {
            let is_kept = random.uniform() < 0.7;
            let at = Vector3::new((n % k) as f64, (n / k % k) as f64, (n / k / k) as f64);
            let at = if on_walls {
                at / (k - 1) as f64
            } else {
                at.add_scalar(0.5) / k as f64
            };
            let moved =
                at.map(|x| (x + noise * (random.uniform() - 0.5) / k as f64).clamp(0.0, 1.0));
            if is_kept || n == 0 {
                sites.push(Point3::from(moved));
            }
        }
        (sites, on_walls)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_cut_parts_volume_and_keeps_eulers_formula(cuts in half_spaces(), last in half_space(true)) {
        let piece = cut_cube(&cuts);
        let other = HalfSpace { normal: -last.normal, offset: -last.offset };
        let mut scratch = ClipScratch::default();
        let mut parts = 0.0;
        for half_space in [last, other] {
            let mut part = piece.clone();
            clip(&mut part, &half_space, 99, &mut scratch);
            parts += volume(&part);
            if !part.is_empty() {
                let facets = part.facets().count();
                let sides: usize = part.facets().map(|facet| facet.corners().count()).sum();
                prop_assert_eq!(part.vertex_count() + facets, sides / 2 + 2);
            }
        }
        prop_assert!((parts - volume(&piece)).abs() <= 1e-13, "{parts} of {}", volume(&piece));
    }

    #[test]
    fn lattice_subsets_have_a_diagram(
        (sites, on_walls) in lattice_sites(),
        axes in any::<[bool; 3]>(),
    ) {
        let unit = Cuboid::unit().bounds();
        // On walls of a periodic box sites may be images of each other, but for rounding.
        let axes = if on_walls { [false; 3] } else { axes };
        for periodic in [[false; 3], axes] {
            let domain = Cuboid::new(unit, periodic).unwrap();
            let diagram = Diagram::new(&domain, &sites).unwrap();
            if let Err(error) = diagram.check() {
                prop_assert!(false, "{error}");
            }
        }
    }

    #[test]
    fn energy_is_additive_over_a_cut(
        cuts in half_spaces(),
        last in half_space(true),
        at in prop::array::uniform3(-1.0..1.0_f64),
        order in 1_u32..4,
    ) {
        let (piece, about, mut scratch) = (cut_cube(&cuts), Vector3::from(at), EnergyScratch::default());
        let whole_energy = energy(&whole(&piece), &about, order, &mut scratch).value;
        let mut clips = ClipScratch::default();
        let mut parts = 0.0;
        for sign in [1.0, -1.0] {
            let mut part = piece.clone();
            let half_space = HalfSpace { normal: last.normal * sign, offset: last.offset * sign };
            clip(&mut part, &half_space, 99, &mut clips);
            if !part.is_empty() {
                parts += energy(&whole(&part), &about, order, &mut scratch).value;
            }
        }
        prop_assert!((parts - whole_energy).abs() <= 1e-12 * (1.0 + whole_energy));
    }

    #[test]
    fn energy_scales_with_the_power_of_length(
        cuts in half_spaces(),
        at in prop::array::uniform3(-1.0..1.0_f64),
        order in 1_u32..4,
        exponent in -3_i32..4,
    ) {
        let (scale, mut scratch) = (2_f64.powi(exponent), EnergyScratch::default());
        let piece = cut_cube(&cuts);
        let bounds = Bounds {
            min: Point3::new(-scale, -scale, -scale),
            max: Point3::new(scale, scale, scale),
        };
        let mut scaled = Polyhedron::cuboid(&bounds, [0, 1, 2, 3, 4, 5]);
        let mut clips = ClipScratch::default();
        for half_space in &cuts {
            let half_space = HalfSpace { normal: half_space.normal, offset: scale * half_space.offset };
            clip(&mut scaled, &half_space, 10, &mut clips);
        }
        let about = Vector3::from(at);
        let one = energy(&whole(&piece), &about, order, &mut scratch).value;
        let other = energy(&whole(&scaled), &(about * scale), order, &mut scratch).value;
        let expected = one * scale.powi(3 + order as i32);
        prop_assert!((other - expected).abs() <= 1e-12 * expected.abs().max(1e-300));
    }

    #[test]
    fn energy_does_not_tell_axes_apart(
        cuts in half_spaces(),
        at in prop::array::uniform3(-1.0..1.0_f64),
        signs in prop::array::uniform3(any::<bool>()),
        turn in 0_usize..3,
    ) {
        let mut scratch = EnergyScratch::default();
        let sign = |axis: usize| if signs[axis] { -1.0 } else { 1.0 };
        let image = |v: &Vector3<f64>| Vector3::from_fn(|axis, _| sign(axis) * v[(axis + turn) % 3]);
        let turned = mapped(&cuts, |half_space| HalfSpace {
            normal: image(&half_space.normal),
            offset: half_space.offset,
        });
        let (piece, about) = (cut_cube(&cuts), Vector3::from(at));
        for order in [1, 2] {
            let one = energy(&whole(&piece), &about, order, &mut scratch);
            let other = energy(&whole(&turned), &image(&about), order, &mut scratch);
            prop_assert!((one.value - other.value).abs() <= 1e-12 * (1.0 + one.value));
            prop_assert!((image(&one.gradient) - other.gradient).norm() <= 1e-11);
        }
    }

    #[test]
    fn no_place_is_lower_than_the_center(
        cuts in half_spaces(),
        trials in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 20),
    ) {
        let piece = cut_cube(&cuts);
        prop_assume!(!piece.is_empty() && volume(&piece) > 1e-3);
        let (pieces, mut scratch) = (whole(&piece), EnergyScratch::default());
        let first = energy_jet(&pieces, &Vector3::zeros(), 1, &mut scratch);
        let volume = volume(&piece);
        let search = CenterSearch {
            minimizer: Minimizer::Newton,
            order: 1,
            volume,
            mass: volume,
            bounds: piece.bounds(),
        };
        let found = center(&pieces, &search, &first, &mut scratch);
        let least = energy(&pieces, &found.point, 1, &mut scratch);
        let bounds = piece.bounds();
        for trial in trials {
            let extent = bounds.extent();
            let at = bounds.center().coords + extent.component_mul(&Vector3::from(trial)) * 0.5;
            let value = energy(&pieces, &at, 1, &mut scratch).value;
            prop_assert!(least.value <= value + 1e-12, "{} at {at:?}, {}", value, least.value);
        }
        // Where no bound is active the gradient vanishes: E is convex, so this is its least value.
        let scale = volume.powf(1.0 / 3.0);
        let is_inside = (0..3).all(|axis| {
            let margin = 1e-3 * scale;
            bounds.min[axis] + margin < found.point[axis] && found.point[axis] < bounds.max[axis] - margin
        });
        if is_inside {
            prop_assert!(least.gradient.norm() <= 1e-6 * volume, "{:?}", least.gradient);
        }
    }
}
