//! Solids that are made to stand: the figures of `density.md` 1.3-1.5 and 5.3, and their properties.

use nalgebra::{Point2, Point3, Rotation3, Vector3};

use crate::balance::conditions::Condition;
use crate::balance::contrast::least_contrast;
use crate::balance::dual::DensityRange;
use crate::balance::sensitivity::ClampDerivatives;
use crate::balance::solid::{AffineForm, SolidBalance};
use crate::balance::solve::{LeastVariance, SolveEnd, greatest_product, least_variance};
use crate::balance::stand::{StandGoal, StandPlan, stand};
use crate::balance::support::{Ground, Support, SupportError};
use crate::mass::density::SolidDensity;
use crate::mass::weigh::weigh_surface;
use crate::mesh::formats::read::read_surface;
use crate::mesh::shapes::{bracket, icosphere, torus, unit_cube};
use crate::mesh::surface::SurfaceMesh;
use crate::tests::models::shared_model;

fn close(got: f64, expected: f64, tolerance: f64, what: &str) {
    let off = (got - expected).abs();
    assert!(
        off <= tolerance,
        "{what}: {got}, not {expected}: off by {off:e}"
    );
}

/// The center of mass lies at `target` along each of `axes`.
fn levels(target: [f64; 3], axes: &[Vector3<f64>]) -> Vec<Condition> {
    let target = Point3::from(target);
    let level = |axis: &Vector3<f64>| Condition::center_level(&target, &-axis);
    axes.iter().map(level).collect()
}

fn range(low: f64, high: f64, prefer: f64) -> DensityRange {
    DensityRange { low, high, prefer }
}

/// Gradient, mass, greatest density and center of a solution.
struct Found {
    gradient: Vector3<f64>,
    mass: f64,
    center: Point3<f64>,
    solution: LeastVariance,
}

fn solved(balance: &SolidBalance<'_>, range: &DensityRange) -> Found {
    let solution = least_variance(balance, range);
    assert_eq!(solution.end, SolveEnd::Met, "{solution:?}");
    let form = balance.combined(&solution.multipliers).less(-range.prefer);
    let moments = balance.clamped(&form, range);
    Found {
        gradient: form.gradient,
        mass: moments.mass,
        center: balance.middle + moments.center(),
        solution,
    }
}

#[test]
fn a_cube_needs_the_contrast_of_hand_calculation() {
    let cube = [unit_cube()];
    for (target, contrast) in [(1.0 / 3.0, 4.0), (0.25, 9.0), (0.1, 81.0), (0.5, 1.0)] {
        let balance = SolidBalance::new(&cube, &levels([target, 0.0, 0.0], &[Vector3::x()]));
        let least = least_contrast(&balance);
        close(1.0 + least.growth, contrast, 1e-13 * contrast, "x");
        if contrast > 1.0 {
            let plane = balance
                .combined(&least.multipliers)
                .plane_at(&balance.middle);
            let (point, normal) = plane.expect("it has a gradient");
            close(point.x, target, 1e-13, "plane");
            assert_eq!(normal, -Vector3::x());
        }
    }
    let target = [1.0 / 3.0, 1.0 / 3.0, 0.0];
    let balance = SolidBalance::new(&cube, &levels(target, &[Vector3::x(), Vector3::y()]));
    let least = least_contrast(&balance);
    close(1.0 + least.growth, 7.75, 1e-12, "x and y");
    let gradient = balance.combined(&least.multipliers).gradient.normalize();
    close(gradient.x, -0.5_f64.sqrt(), 1e-12, "normal");
    close(gradient.y, -0.5_f64.sqrt(), 1e-12, "normal");
    // Targets on the surface or outside: no density does it.
    for target in [0.0, -0.2, 1.0, 7.0] {
        let balance = SolidBalance::new(&cube, &levels([target, 0.0, 0.0], &[Vector3::x()]));
        assert!(least_contrast(&balance).growth.is_infinite(), "{target}");
    }
}

#[test]
fn a_cube_has_the_least_variance_of_hand_calculation() {
    let cube = [unit_cube()];
    let at = |c: f64| SolidBalance::new(&cube, &levels([c, 0.0, 0.0], &[Vector3::x()]));
    let balance = at(1.0 / 3.0);
    // One-sided: slope 3 (½ − c)/c³ below x = c.
    let found = solved(&balance, &range(1.0, f64::INFINITY, 1.0));
    close(found.gradient.x, -13.5, 1e-12, "slope");
    close(found.mass, 1.75, 1e-13, "mass");
    close(found.center.x, 1.0 / 3.0, 1e-14, "center");
    let highest = 1.0 + 13.5 / 3.0;
    close(highest, 5.5, 1e-13, "highest");
    // Both bounds inactive: d = 1.5 − 1.5 x.
    let found = solved(&balance, &range(1e-9, f64::INFINITY, 1.0));
    close(found.gradient.x, -1.5, 1e-7, "slope");
    let found = solved(&balance, &range(-9.0, 9.0, 1.0));
    close(found.gradient.x, -1.5, 1e-13, "slope");
    close(found.mass, 0.75, 1e-13, "mass");
    let found = solved(&balance, &range(1.0, 4.5, 1.0));
    close(found.gradient.x, -16.039014932345435, 1e-10, "slope");
    close(found.mass, 1.78478535875368, 1e-10, "mass");
    assert!(found.solution.iterations() <= 7, "{:?}", found.solution.log);
}

/// Three spheres of diameter 1, each leaning over the one below.
fn spheres(lean: f64) -> Vec<SurfaceMesh> {
    let rise = (1.0 - lean * lean).sqrt();
    let sphere = |level: u32| {
        let mut mesh = icosphere(4);
        let level = f64::from(level);
        for vertex in &mut mesh.vertices {
            *vertex = Point3::from(vertex.coords * 0.5 + Vector3::new(lean, 0.0, rise) * level);
        }
        mesh
    };
    (0..3).map(sphere).collect()
}

#[test]
fn three_spheres_stand_over_the_lowest_ones_axis() {
    let solids = spheres(0.25);
    let over_axis = levels([0.0; 3], &[Vector3::x(), Vector3::y()]);
    let balance = SolidBalance::new(&solids, &over_axis);
    let least = least_contrast(&balance);
    let contrast = 1.0 + least.growth;
    close(contrast, 7.988676, 1e-6, "spheres");
    // The table of 1.3: iterations at 1.01, 1.2, 1.5 and 2 times the least contrast.
    for (factor, most) in [(1.01, 10), (1.2, 7), (1.5, 6), (2.0, 4)] {
        let found = solved(&balance, &range(1.0, factor * contrast, 1.0));
        let iterations = found.solution.iterations();
        assert!(iterations <= most + 1, "{factor}: {iterations}");
        assert!(found.center.x.abs() < 1e-13 && found.center.y.abs() < 1e-13);
    }
}

/// The 24-gon of the spheres' foot, one edge across the lean.
fn foot() -> Support {
    let corner = |k: u32| {
        let angle = (f64::from(k) + 0.5) * std::f64::consts::PI / 12.0;
        Point2::new(0.15 * angle.cos(), 0.15 * angle.sin())
    };
    Support::hull((0..24).map(corner).collect()).expect("24 corners")
}

#[test]
fn three_spheres_stand_on_their_foot() {
    let solids = spheres(0.25);
    let body = SolidBalance::new(&solids, &[]);
    let vertices = solids.iter().flat_map(|mesh| &mesh.vertices);
    let mut ground = Ground::below(&Vector3::z(), vertices).expect("up has a length");
    ground.height = -0.5;
    for (degrees, contrast) in [(0.0_f64, 2.682214), (5.0, 5.809565)] {
        let tilt = degrees.to_radians().tan();
        let plan = plan(ground, foot(), 0.02, tilt);
        let standing = stand(&body, &plan).expect("it has a polygon");
        close(1.0 + standing.contrast.growth, contrast, 1e-6, "foot");
        let field = standing.field.expect("it is reachable");
        let iterations = field.solution.iterations();
        assert!((1..=9).contains(&iterations), "{iterations}");
        let moments = body.clamped(&field.form, &field.range);
        let center = body.middle + moments.center();
        let [_, steepest] = foot().slack(&ground, &center).expect("a polygon");
        assert!(steepest > tilt, "{steepest}");
    }
}

fn plan(ground: Ground, support: Support, margin: f64, tilt: f64) -> StandPlan {
    StandPlan {
        ground,
        support,
        margin,
        tilt,
        range: None,
        prefer: None,
        mass: None,
        goal: StandGoal::LeastVariance,
    }
}

// ------------------------------------------------------------- the shared models

fn model(name: &str) -> SurfaceMesh {
    read_surface(&shared_model(name)).expect("the model is there")
}

/// Over a vertex of the solid, free along `up`.
fn over_vertex(mesh: &SurfaceMesh, vertex: usize, axes: [Vector3<f64>; 2]) -> Vec<Condition> {
    levels(mesh.vertices[vertex].into(), &axes)
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_rocker_arm_stands_on_its_lowest_vertex() {
    let arm = [model("rocker-arm.obj")];
    let conditions = over_vertex(&arm[0], 10_036, [Vector3::x(), Vector3::y()]);
    let balance = SolidBalance::new(&arm, &conditions);
    let least = least_contrast(&balance);
    let contrast = 1.0 + least.growth;
    close(contrast, 7.021670586863, 1e-9, "contrast");
    let normal = balance.combined(&least.multipliers).gradient.normalize();
    close(
        (normal - Vector3::new(0.902625536, -0.430426696, 0.0)).amax(),
        0.0,
        1e-9,
        "normal",
    );
    let found = solved(&balance, &range(1.0, 10.0, 1.0));
    let expected = Vector3::new(102.12274549, -51.66644137, 0.0);
    close((found.gradient - expected).amax(), 0.0, 1e-8, "gradient");
    close(found.mass, 0.08544359009589, 1e-9 * found.mass, "mass");
    close(found.center.z, 0.015264909043, 1e-9, "center");
    iterations(&balance, contrast, [10, 7, 6, 5]);
}

/// Newton steps at 1.01, 1.2, 1.5 and 2 times the least contrast, at most one more than `most`.
fn iterations(balance: &SolidBalance<'_>, contrast: f64, most: [usize; 4]) {
    for (factor, most) in [1.01, 1.2, 1.5, 2.0].into_iter().zip(most) {
        let found = solved(balance, &range(1.0, factor * contrast, 1.0));
        let iterations = found.solution.iterations();
        assert!(iterations <= most + 1, "{factor}: {iterations}");
    }
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_rocker_arms_center_comes_to_its_bore() {
    let arm = [model("rocker-arm.obj")];
    let axis = crate::balance::conditions::SpinAxis::new(
        &Point3::new(0.0, 0.0671794, 0.0849169),
        &Vector3::new(0.99997285, -0.00727018, 0.00120118),
    );
    let axis = axis.expect("a direction");
    let balance = SolidBalance::new(&arm, &axis.center_on());
    let native = balance.middle + balance.whole.center();
    let distance = |point: &Point3<f64>| {
        let [first, second] = axis
            .across
            .map(|across| across.dot(&(point - axis.through)));
        first.hypot(second)
    };
    close(distance(&native), 0.0655021777, 1e-7, "native");
    close(
        1.0 + least_contrast(&balance).growth,
        2.15166032,
        1e-7,
        "contrast",
    );
    for (high, slope, mean) in [
        (2.2, 13.606733712, 1.376279943),
        (4.0, 8.037289665, 1.338929908),
    ] {
        let found = solved(&balance, &range(1.0, high, 1.0));
        close(found.gradient.norm(), slope, 1e-8 * slope, "slope");
        close(found.mass / balance.whole.mass, mean, 1e-8, "mean");
        assert!(distance(&found.center) < 1e-14);
    }
    assert!(solved(&balance, &range(1.0, 9.0, 1.0)).mass / balance.whole.mass - 1.338929908 < 1e-8);
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_bunny_stands_on_its_head() {
    let bunny = [model("bunny.off")];
    let top = &bunny[0].vertices[1271];
    assert!(bunny[0].vertices.iter().all(|vertex| vertex.y <= top.y));
    let conditions = over_vertex(&bunny[0], 1271, [Vector3::x(), Vector3::z()]);
    let balance = SolidBalance::new(&bunny, &conditions);
    let contrast = 1.0 + least_contrast(&balance).growth;
    close(contrast, 70.532991308, 1e-8, "contrast");
    iterations(&balance, contrast, [11, 7, 6, 6]);
    // On what touches the ground instead: the table of 1.5, to the digits printed there.
    let body = SolidBalance::new(&bunny, &[]);
    let ground = Ground::below(&-Vector3::y(), bunny[0].vertices.iter()).expect("up");
    for (share, degrees, expected, digit) in [
        (0.01, 0.0_f64, 27.6310, 1e-4),
        (0.05, 0.0, 10.4898, 1e-4),
        (0.01, 5.0, 15494.8, 0.1),
        (0.05, 5.0, 43.9434, 1e-4),
    ] {
        let support = ground
            .contact(bunny[0].vertices.iter(), share)
            .expect("contact");
        let tilt = degrees.to_radians().tan();
        let standing = stand(&body, &plan(ground, support, 0.0, tilt)).expect("a polygon");
        close(1.0 + standing.contrast.growth, expected, digit, "contact");
        let field = standing.field.expect("reachable");
        assert!(field.solution.iterations() <= 10);
    }
}

// ------------------------------------------------------------- properties

/// Solids with planes of no special kind, small.
fn bodies() -> Vec<(SurfaceMesh, [f64; 3])> {
    let mut torus = torus(1.0, 0.4, 16, 8);
    for vertex in &mut torus.vertices {
        vertex.x += 0.2 * vertex.y * vertex.z;
    }
    vec![
        (torus, [0.2, -0.15, 0.05]),
        (bracket(3), [0.1, 0.08, 0.02]),
        (icosphere(2), [0.1, 0.2, 0.3]),
    ]
}

/// Three conditions: the native center moved by `shift`.
fn moved_center(mesh: &SurfaceMesh, shift: [f64; 3]) -> Vec<Condition> {
    let solids = std::slice::from_ref(mesh);
    let body = SolidBalance::new(solids, &[]);
    let native = body.middle + body.whole.center();
    let scale = mesh.bounds().extent().amax() * 0.5;
    let target = native + Vector3::from(shift) * scale;
    levels(target.into(), &[Vector3::x(), Vector3::y(), Vector3::z()])
}

#[test]
fn the_least_contrast_is_reached_from_above_and_refuted_from_below() {
    for (mesh, shift) in bodies() {
        let solids = [mesh];
        let balance = SolidBalance::new(&solids, &moved_center(&solids[0], shift));
        let least = least_contrast(&balance);
        let contrast = 1.0 + least.growth;
        // The step that its plane makes reaches the target: contrast and center at once.
        let form = balance.combined(&least.multipliers);
        let step = balance.whole + balance.above(&form) * least.growth;
        let missed = balance.rows(&step).amax() / step.mass;
        assert!(missed < 1e-8, "{missed:e}");
        // Its multipliers refute every smaller contrast, and no larger one.
        for (factor, is_refuted) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
            let narrow = range(1.0, 1.0 + least.growth * factor, 1.0);
            let (most, _) = greatest_product(&balance, &narrow, &least.multipliers);
            assert_eq!(most < 0.0, is_refuted, "{factor}: {most:e}");
        }
        // κ* ≤ the contrast of every field that does it; Newton refutes on its own below.
        for factor in [1.0001, 1.01, 1.3, 3.0] {
            let found = solved(&balance, &range(1.0, factor * contrast, 1.0));
            let form = balance.combined(&found.solution.multipliers).less(-1.0);
            let values = solids[0].vertices.iter().map(|vertex| {
                let value = form.value + form.gradient.dot(&(vertex - balance.middle));
                value.clamp(1.0, factor * contrast)
            });
            let [low, high] = values.fold([f64::INFINITY, 0.0], |[low, high], value| {
                [f64::min(low, value), f64::max(high, value)]
            });
            assert!(high / low >= contrast, "{factor}");
        }
        let below = least_variance(&balance, &range(1.0, 0.99 * contrast, 1.0));
        assert_eq!(below.end, SolveEnd::Refuted);
    }
}

#[test]
fn densities_scale_with_the_range_and_move_with_the_body() {
    for (mesh, shift) in bodies() {
        let conditions = moved_center(&mesh, shift);
        let solids = [mesh];
        let balance = SolidBalance::new(&solids, &conditions);
        let high = 1.4 * (1.0 + least_contrast(&balance).growth);
        let one = solved(&balance, &range(1.0, high, 1.2));
        let thrice = solved(&balance, &range(3.0, 3.0 * high, 3.6));
        close(thrice.mass, 3.0 * one.mass, 1e-12 * one.mass, "scaled mass");
        let off = (thrice.gradient - one.gradient * 3.0).norm() / one.gradient.norm();
        assert!(off < 1e-9, "{off:e}");
        let turn = Rotation3::new(Vector3::new(0.7, -0.3, 1.1));
        let way = Vector3::new(5.0, -2.0, 3.0);
        let mut moved = solids.clone();
        for vertex in &mut moved[0].vertices {
            *vertex = turn * *vertex + way;
        }
        let carried = conditions.iter().map(|condition| {
            let about = turn * condition.about + way;
            Condition::center_level(&about, &(turn * condition.gradient))
        });
        let carried: Vec<_> = carried.collect();
        let there = SolidBalance::new(&moved, &carried);
        let found = solved(&there, &range(1.0, high, 1.2));
        close(found.mass, one.mass, 1e-11 * one.mass, "moved mass");
        let off = (found.gradient - turn * one.gradient).norm() / one.gradient.norm();
        assert!(off < 1e-8, "{off:e}");
        let off = (found.center - (turn * one.center + way)).norm();
        assert!(off < 1e-12, "{off:e}");
    }
}

#[test]
fn clamps_change_with_their_parameters_as_their_derivatives_say() {
    let (mesh, _) = bodies().swap_remove(0);
    let solids = [mesh];
    let body = SolidBalance::new(&solids, &[]);
    // low, high, value at the middle, gradient.
    let at = [1.0, 4.0, 2.2, 1.5, -2.0, 3.0];
    let weigh = |[low, high, value, x, y, z]: [f64; 6]| {
        let gradient = Vector3::new(x, y, z);
        let value = value - gradient.dot(&body.middle.coords);
        let density = SolidDensity::clamp(low, high, value, &gradient).expect("a range");
        let weighed = weigh_surface(&solids[0], &density, &solids[0].bounds());
        let weighed = weighed.expect("it has a mass");
        let first = (weighed.center_of_mass() - body.middle) * weighed.mass;
        let second = weighed.inertia_about(&body.middle);
        (weighed.mass, first, second)
    };
    let form = AffineForm {
        value: at[2],
        gradient: Vector3::new(at[3], at[4], at[5]),
    };
    let found = ClampDerivatives::of(&body, &form, &range(at[0], at[1], 1.0));
    let [x, y, z] = found.gradient;
    for (place, expected) in [found.low, found.high, found.value, x, y, z]
        .iter()
        .enumerate()
    {
        let step = 1e-5;
        let shifted = |step: f64| {
            let mut at = at;
            at[place] += step;
            weigh(at)
        };
        let (low, high) = (shifted(-step), shifted(step));
        let scale = body.whole.mass;
        close(
            (high.0 - low.0) / (2.0 * step),
            expected.mass,
            1e-8 * scale,
            "mass",
        );
        let first = (high.1 - low.1) / (2.0 * step) - expected.first;
        let inertia = (high.2 - low.2) / (2.0 * step) - expected.inertia();
        assert!(
            first.amax() < 1e-8 * scale && inertia.amax() < 1e-8 * scale,
            "{place}"
        );
    }
}

#[test]
fn the_nearest_center_is_that_of_a_search_over_directions() {
    for (mesh, shift) in bodies() {
        let solids = [mesh];
        let body = SolidBalance::new(&solids, &[]);
        let native = body.middle + body.whole.center();
        let extent = solids[0].bounds().extent().amax();
        let ground = Ground::below(&Vector3::z(), solids[0].vertices.iter()).expect("up");
        let wanted = ground.shadow(&(native + Vector3::from(shift) * extent));
        let mut plan = plan(ground, Support::Point(wanted), 0.0, 0.0);
        plan.range = Some([1.0, 1.3]);
        let refusal = stand(&body, &plan)
            .expect("a point")
            .field
            .expect_err("a narrow range");
        let nearest = refusal.nearest.expect("there is one");
        // How far the wanted place lies beyond the reachable centers, along a direction.
        let beyond = |angle: f64| {
            let way = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let mut level = way.dot(&native.coords);
            loop {
                let form = AffineForm {
                    value: way.dot(&body.middle.coords) - level,
                    gradient: way,
                };
                let step = body.whole + body.above(&form) * 0.3;
                let next = way.dot(&(body.middle + step.center()).coords);
                if next <= level + 1e-15 {
                    break;
                }
                level = next;
            }
            way.x * wanted.x + way.y * wanted.y - level
        };
        let (mut middle, mut span) = (0.0, std::f64::consts::PI);
        let mut distance = f64::NEG_INFINITY;
        for _ in 0..6 {
            let angles = (-12..=12).map(|k| middle + span * f64::from(k) / 12.0);
            let best = angles.max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)));
            middle = best.expect("some");
            distance = distance.max(beyond(middle));
            span /= 10.0;
        }
        close(nearest.distance, distance, 1e-6 * extent, "distance");
        let off = (ground.shadow(&nearest.center) - wanted).norm();
        close(
            off,
            nearest.distance,
            1e-8 * extent,
            "the center's own distance",
        );
    }
}

#[test]
fn supports_degenerate_to_lines_and_points() {
    let at = |points: &[[f64; 2]]| Support::hull(points.iter().map(|&p| p.into()).collect());
    assert_eq!(at(&[]), Err(SupportError::NoContact));
    assert!(matches!(
        at(&[[1.0, 2.0], [1.0, 2.0]]),
        Ok(Support::Point(_))
    ));
    let line = at(&[[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [0.3, 0.3]]).expect("a line");
    assert!(
        matches!(line, Support::Segment([a, b]) if a.x.abs() < 1e-15 && (b.x - 1.0).abs() < 1e-15)
    );
    let square = [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.5, 0.5],
        [1.0, 1.0],
        [0.0, 1.0],
        [0.5, 0.0],
    ];
    let Ok(Support::Polygon(corners)) = at(&square) else {
        panic!("a square")
    };
    assert_eq!(corners.len(), 4);
    let cube = [unit_cube()];
    let body = SolidBalance::new(&cube, &[]);
    let ground = Ground::below(&Vector3::z(), cube[0].vertices.iter()).expect("up");
    let diagonal = at(&[[0.0, 0.5], [0.4, 0.1]]).expect("a line");
    for (margin, tilt) in [(0.01, 0.0), (0.0, 0.01)] {
        let refused = stand(&body, &plan(ground, diagonal.clone(), margin, tilt));
        assert!(refused.expect_err("no room").is_of_input());
    }
    let standing = stand(&body, &plan(ground, diagonal.clone(), 0.0, 0.0)).expect("a line");
    assert!(!standing.stands);
    let field = standing.field.expect("reachable");
    let center = body.middle + body.clamped(&field.form, &field.range).center();
    close(center.x + center.y, 0.5, 1e-12, "on the line");
    assert!((-1e-12..=0.4).contains(&center.x));
    let mut stable = plan(ground, diagonal, 0.0, 0.0);
    stable.goal = StandGoal::MostStable;
    assert!(stand(&body, &stable).is_err());
    assert!(Ground::below(&Vector3::zeros(), cube[0].vertices.iter()).is_err());
}

#[test]
fn the_most_stable_cube_has_its_weight_as_low_as_the_range_allows() {
    let cube = [unit_cube()];
    let body = SolidBalance::new(&cube, &[]);
    let ground = Ground::below(&Vector3::z(), cube[0].vertices.iter()).expect("up");
    let support = ground
        .contact(cube[0].vertices.iter(), 0.01)
        .expect("contact");
    let mut plan = plan(ground, support, 0.0, 0.0);
    plan.range = Some([1.0, 9.0]);
    plan.goal = StandGoal::MostStable;
    let field = stand(&body, &plan)
        .expect("a polygon")
        .field
        .expect("reachable");
    // The lowest center of contrast 9 is at ¼: it stands atan(½ / ¼).
    close(field.tilt, 2.0, 1e-5, "tilt");
    plan.goal = StandGoal::LeastContrast;
    plan.support = Support::Target([Some(0.3), Some(0.4), None]);
    plan.mass = Some(2.0);
    let field = stand(&body, &plan)
        .expect("a target")
        .field
        .expect("reachable");
    let moments = body.clamped(&field.form, &field.range);
    close(moments.mass, 2.0, 1e-12, "mass");
    assert!(field.range.high < 9.0);
    let center = body.middle + moments.center();
    close(center.x, 0.3, 1e-13, "x");
    close(center.y, 0.4, 1e-13, "y");
}
