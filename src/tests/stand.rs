//! Solids that are made to stand: the figures of `density.md` 1.3-1.5 and 5.3, and their properties.

use nalgebra::{Point2, Point3, Vector3};

use crate::balance::conditions::Condition;
use crate::balance::contrast::least_contrast;
use crate::balance::dual::DensityRange;
use crate::balance::solid::SolidBalance;
use crate::balance::solve::{LeastVariance, SolveEnd, least_variance};
use crate::balance::stand::{StandGoal, StandPlan, stand};
use crate::balance::support::{Ground, Support};
use crate::mesh::formats::read::read_surface;
use crate::mesh::shapes::{icosphere, unit_cube};
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
        assert_eq!(least_contrast(&balance).growth, f64::INFINITY, "{target}");
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
        println!("{factor} {iterations} {}", found.solution.evaluations);
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
    close(axis.distance(&native), 0.0655021777, 1e-7, "native");
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
        assert!(axis.distance(&found.center) < 1e-14);
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
        println!("{share} {degrees} {:?}", field.solution.log.len());
        assert!(field.solution.iterations() <= 9);
    }
}
